"""Firmware, legs and MuJoCo over several physics steps in one compiled call.

The same kernels, in the same order, as ``World`` and ``Plant`` call them one at a time, so the result is
the same bit for bit (``tests/sim_hw/test_step_kernel.py``); only the way between them through Python is
saved. MuJoCo's own step is called by its address in the library that the bindings have loaded, without the
profiler that the bindings put into it: that reads a clock twenty times a step.
"""

import ctypes
from typing import Any

import mujoco
import numpy as np

from model.compiled import (
    COUNT,
    FLAG,
    NUMBER,
    compile_for,
    compiled,
    compiles,
    given,
    in_place,
    out,
)
from model.values.arrays import BoolArray, FloatArray, IntArray
from sim_hw.dynamixel.firmware import SERVO, FirmwareBank, firmware_duties
from sim_hw.plant.leg_kernel import CURRENT, LEG_NUMBERS, STATE_NUMBERS, turn_legs
from sim_hw.plant.leg_path import KIND
from sim_hw.plant.motor import MOTOR_NUMBERS
from sim_hw.plant.plant import Plant

# Rows of ``scratch``: what firmware and motors are given and give in a step.
GOAL, TICKS, RATE, AMPERE, DUTY = range(5)
SCRATCH_ROWS = 5
GEOMETRY_NUMBERS = KIND + 1  # of a leg


def mujoco_library() -> ctypes.CDLL:
    """Return MuJoCo's library as its bindings have loaded it."""
    return ctypes.CDLL(mujoco._functions.__file__)


if compiles():
    import numba
    from numba import types
    from numba.core import cgutils
    from numba.extending import intrinsic

    def _mj_step(typing_context: Any, step: Any, model: Any, data: Any) -> Any:
        """Call ``mj_step(model, data)``, all three given by their addresses."""

        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            ir = cgutils.ir  # type: ignore[attr-defined]  # has no types
            pointer = ir.IntType(8).as_pointer()
            kind = ir.FunctionType(ir.VoidType(), [pointer, pointer])
            function = builder.inttoptr(arguments[0], kind.as_pointer())
            builder.call(function, [builder.inttoptr(one, pointer) for one in arguments[1:]])
            return context.get_dummy_value()

        return types.void(types.int64, types.int64, types.int64), generate

    def _pointer(typing_context: Any, address: Any) -> Any:
        """Return an address as a pointer."""

        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return builder.inttoptr(arguments[0], cgutils.voidptr_t)

        return types.voidptr(types.int64), generate

    mj_step: Any = intrinsic(_mj_step)
    pointer: Any = intrinsic(_pointer)
    carray: Any = numba.carray  # type: ignore[attr-defined]  # has no types


@in_place
@compiled
def run_steps(
    count: int,
    step: int,
    addresses: IntArray,
    dt_s: float,
    substeps: int,
    servo_substeps: int,
    servos: Any,
    mounting: FloatArray,
    columns: IntArray,
    motors: FloatArray,
    geometry: FloatArray,
    rows: FloatArray,
    state: FloatArray,
    foot_q: IntArray,
    foot_v: IntArray,
    roll_v: IntArray,
    qpos: FloatArray,
    qvel: FloatArray,
    applied: FloatArray,
    constraint: FloatArray,
    scratch: FloatArray,
    driven: BoolArray,
    forces: FloatArray,
) -> None:
    """Take physics steps.

    Args:
        count: How many.
        step: Number of the last step before them.
        addresses: Of ``mj_step``, MuJoCo's model and its state, (3,).
        dt_s: A step.
        substeps: MuJoCo's steps in it.
        servo_substeps: Steps of the legs in one of MuJoCo's.
        servos: Records of the firmware, (N,); changed.
        mounting: Zeros [ticks], ticks a radian, signs, (3, N).
        columns: Of the angle and the speed in ``state`` that the firmware has, (2,).
        motors: Of ``turn_legs``, as all up to ``applied``.
        geometry: Of ``turn_legs``.
        rows: Of ``turn_legs``.
        state: Of ``turn_legs``; changed.
        foot_q: Of ``turn_legs``.
        foot_v: Of ``turn_legs``.
        roll_v: Of ``turn_legs``.
        qpos: Of ``turn_legs``; changed.
        qvel: Of ``turn_legs``; changed.
        applied: Of ``turn_legs``; changed.
        constraint: MuJoCo's ``qfrc_constraint``.
        scratch: (5, N); changed.
        driven: (N,); changed.
        forces: Ring of the ground's forces on the feet, a row a step, (K, N, 3) [N]; changed.
    """
    feet = len(foot_v)
    for at in range(step + 1, step + 1 + count):
        for k in range(len(servos)):
            scratch[GOAL, k] = servos[k].goal_position
            scratch[TICKS, k] = mounting[0, k] + mounting[1, k] * state[k, columns[0]]
            scratch[RATE, k] = mounting[2, k] * state[k, columns[1]]
            scratch[AMPERE, k] = mounting[2, k] * state[k, CURRENT]
            driven[k] = servos[k].torque
        firmware_duties(
            servos,
            scratch[GOAL],
            scratch[TICKS],
            scratch[RATE],
            scratch[AMPERE],
            dt_s,
            scratch[DUTY],
        )
        for k in range(len(servos)):
            scratch[DUTY, k] *= mounting[2, k]
        force = forces[at % len(forces)]
        force[:] = 0.0
        for _ in range(substeps):
            turn_legs(
                dt_s / substeps, servo_substeps, motors, geometry, rows, state, scratch[DUTY], driven,
                foot_q, foot_v, roll_v, qpos, qvel, applied,
            )  # fmt: skip
            mj_step(addresses[0], addresses[1], addresses[2])
            for k in range(feet):
                for axis in range(3):
                    force[k, axis] += constraint[foot_v[k, axis]]
        for k in range(feet):
            for axis in range(3):
                force[k, axis] /= substeps


@compiled
def run_steps_at(
    count: int,
    step: int,
    dt_s: float,
    sizes: IntArray,
    addresses: IntArray,
    forces: FloatArray,
) -> None:
    """Take physics steps of arrays that are given by their addresses, without MuJoCo's profiler.

    To hand over an array costs a tenth of a microsecond: for all of them that is as long as a step of
    MuJoCo, in every call.

    Args:
        count: Of ``run_steps``, as ``step``, ``dt_s`` and ``forces``.
        step: Number.
        dt_s: A step.
        sizes: Legs; numbers in ``qpos`` and ``qvel``; ``substeps``, ``servo_substeps``; (5,).
        addresses: Of ``mj_step``, model and state, of the arrays from ``servos`` to ``driven``, and of the
            profiler's clock, (20,).
        forces: Ring; changed.
    """
    legs, q, v = sizes[0], sizes[1], sizes[2]
    profiler = carray(pointer(addresses[19]), 1, np.int64)
    clock, profiler[0] = profiler[0], 0
    run_steps(
        count, step, addresses, dt_s, sizes[3], sizes[4],
        carray(pointer(addresses[3]), legs, SERVO),
        carray(pointer(addresses[4]), (3, legs), np.float64),
        carray(pointer(addresses[5]), 2, np.int64),
        carray(pointer(addresses[6]), (legs, MOTOR_NUMBERS), np.float64),
        carray(pointer(addresses[7]), (legs, GEOMETRY_NUMBERS), np.float64),
        carray(pointer(addresses[8]), (legs, LEG_NUMBERS), np.float64),
        carray(pointer(addresses[9]), (legs, STATE_NUMBERS), np.float64),
        carray(pointer(addresses[10]), (legs, 3), np.int64),
        carray(pointer(addresses[11]), (legs, 3), np.int64),
        carray(pointer(addresses[12]), legs, np.int64),
        carray(pointer(addresses[13]), q, np.float64),
        carray(pointer(addresses[14]), v, np.float64),
        carray(pointer(addresses[15]), v, np.float64),
        carray(pointer(addresses[16]), v, np.float64),
        carray(pointer(addresses[17]), (SCRATCH_ROWS, legs), np.float64),
        carray(pointer(addresses[18]), legs, np.bool_),
        forces,
    )  # fmt: skip
    profiler[0] = clock


class CompiledSteps:
    """Steps of one plant with one firmware.

    Args:
        plant: The plant.
        firmware: Its servos' firmware.
        mounting: Zeros [ticks], ticks a radian, signs, (3, N).
        columns: Of the angle and the speed in the legs' state that the firmware has.
    """

    def __init__(
        self, plant: Plant, firmware: FirmwareBank, mounting: FloatArray, columns: tuple[int, int]
    ) -> None:
        prepare()
        self._firmware = firmware
        library = mujoco_library()
        step_address = ctypes.cast(library.mj_step, ctypes.c_void_p).value
        clock_address = ctypes.addressof(ctypes.c_void_p.in_dll(library, "mjcb_time"))
        p, data, legs = plant.parameters, plant.data, plant.parameters.legs
        self._arrays = (  # kept: their addresses are handed over
            firmware.servos, mounting, np.array(columns), *plant.leg_arguments(),
            data.qfrc_constraint, np.empty((SCRATCH_ROWS, legs)), np.empty(legs, dtype=np.bool_),
        )  # fmt: skip
        assert all(one.flags.c_contiguous for one in self._arrays), "rows one behind the other"
        mujocos = [step_address, plant.model._address, data._address]
        self._before = (
            p.time_step_s,
            np.array([legs, plant.model.nq, plant.model.nv, p.substeps, p.servo_substeps]),
            np.array([*mujocos, *(one.ctypes.data for one in self._arrays), clock_address]),
        )

    @property
    def fits(self) -> bool:
        """Whether goals reach the servos' loops as they were sent."""
        return self._firmware.goal_path is None

    def run(self, count: int, step: int, forces: FloatArray) -> None:
        """Take steps; arguments as for ``run_steps``."""
        run_steps_at(count, step, *self._before, forces)


def prepare() -> None:
    """Load or make the machine code, so that no step waits for it."""
    if compiles():
        compile_for(
            run_steps, COUNT, COUNT, *given(1, kind=COUNT), NUMBER, COUNT, COUNT,
            np.zeros(1, dtype=SERVO), *given(2), *given(1, kind=COUNT), *given(2, 2, 2), *out(2),
            *given(2, 2, 1, kind=COUNT), *given(1, 1), *out(1), *given(1), *out(2),
            *out(1, kind=FLAG), *out(3),
        )  # fmt: skip
        compile_for(
            run_steps_at, COUNT, COUNT, NUMBER, *given(1, 1, kind=COUNT), *out(3),
        )  # fmt: skip
