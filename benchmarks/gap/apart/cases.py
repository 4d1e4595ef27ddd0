"""The 31 blind cases: what is wrong in each, what the diagnosis would call it, and its seeds.

Their order was drawn by lot before the first diagnosis. The thirteen cases of the second round (d) were
drawn after the answers to the first, some of them again.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from benchmarks.gap.apart.fault import HEALTHY, Brownout, Fault, MarkerJump, Payload

PERIODS_S = {"A": 1.6, "B": 2.4}  # of the two gaits; runs take turns
REFERENCES, RUNS_OF_A_CASE = 6, 4
REFERENCE_SEED, FIRST_ROUND_SEED, SECOND_ROUND_SEED = 5000, 5006, 9000


@dataclass(frozen=True, slots=True)
class PlannedRun:
    """A run to be made; ``gait`` is a key of ``PERIODS_S``."""

    name: str
    gait: str
    seed: int
    fault: Fault


@dataclass(frozen=True, slots=True)
class Case:
    """A robot with one fault, or none, and its four runs.

    Attributes:
        name: Such as ``c01``.
        words: What is wrong.
        effect: What the catalogue of legged robots calls it, or a name that is not there; empty for a
            healthy robot.
        fault: The same, as the simulator has it; its place is that of the effect.
        first_seed: Of the first run; each has the next.
    """

    name: str
    words: str
    effect: str
    fault: Fault
    first_seed: int

    @property
    def runs(self) -> tuple[PlannedRun, ...]:
        """Its runs, with both gaits in turn."""
        return tuple(_runs(f"{self.name}_", self.first_seed, RUNS_OF_A_CASE, self.fault))


_Wrong = tuple[str, str, Fault]
_HEALTHY: _Wrong = ("healthy", "", HEALTHY)
_LONGER: _Wrong = ("leg 6 mm longer", "leg_length", Fault("L1", leg_length_m=0.006))
_SOFT: _Wrong = (
    "position gain times 0.4", "servo_compliance", Fault("R3_lift", position_gain_ratio=0.4)
)  # fmt: skip
_ZERO: _Wrong = (
    "joint's zero 0.05 rad",
    "shaft_zero_offset",
    Fault("R2_lift", joint_zero_rad=0.05),
)
_PAYLOAD: _Wrong = ("payload 0.8 kg", "payload", Fault(payload=Payload(0.8, 0.09, -0.04)))

_FIRST_ROUND: tuple[_Wrong, ...] = (
    ("lag 0.07 s", "servo_lag", Fault("L3_yaw", servo_lag_s=0.07)),
    _LONGER,
    _HEALTHY,
    ("hip (+12, -8) mm", "hip_mount_offset", Fault("R1", hip_offset_m=(0.012, -0.008))),
    _SOFT,
    _ZERO,
    ("suction 6 N", "suction", Fault("L2", suction_n=6.0)),
    _HEALTHY,
    ("encoder times 1.08", "encoder_scale", Fault("L2_yaw", encoder_ratio=1.08)),
    ("friction times 0.6", "friction_level", Fault(foot_friction_ratio=0.6)),
    ("pose 0.05 s late", "pose_delay", Fault(pose_delay_s=0.05)),
    _PAYLOAD,
    ("dry friction 0.8 N m", "joint_friction", Fault("L1_yaw", dry_friction_nm=0.8)),
    ("friction times 0.45", "foot_friction", Fault("R1", foot_friction_ratio=0.45)),
    ("force times 0.8", "force_gain", Fault("L2", force_ratio=0.8)),
    ("commands 0.06 s late", "command_delay", Fault(command_delay_s=0.06)),
    ("weak 0.25 of 2.3 s", "brownout", Fault("R2_lift", brownout=Brownout(2.3, 0.25))),
    ("markers jump 15 mm", "marker_jump", Fault(marker_jump=MarkerJump(6.0, 0.015, 0.035))),
)
_SECOND_ROUND: tuple[_Wrong, ...] = (
    ("joint's zero -0.04 rad", "shaft_zero_offset", Fault("L3_lift", joint_zero_rad=-0.04)),
    ("dry friction 0.8 N m", "joint_friction", Fault("R2_lift", dry_friction_nm=0.8)),
    _HEALTHY,
    ("shank's stiffness times 0.4", "leg_stiffness", Fault("L3", shank_stiffness_ratio=0.4)),
    ("markers turned 0.06 rad", "pose_yaw_offset", Fault(marker_yaw_rad=0.06)),
    _PAYLOAD,
    _HEALTHY,
    ("joint's zero 0.06 rad", "shaft_zero_offset", Fault("L1_yaw", joint_zero_rad=0.06)),
    ("leg 5 mm shorter", "leg_length", Fault("R2", leg_length_m=-0.005)),
    _LONGER,
    _SOFT,
    _ZERO,
    ("payload 1.2 kg", "payload", Fault(payload=Payload(1.2, -0.08, 0.02))),
)
# diagnosed once more, without references
WITHOUT_REFERENCES = ("c01", "c12", "c16")


def _runs(prefix: str, first_seed: int, count: int, fault: Fault) -> Iterator[PlannedRun]:
    for i, gait in zip(range(count), "AB" * count, strict=False):
        yield PlannedRun(f"{prefix}{i + 1}_{gait}", gait, first_seed + i, fault)


def _cases(round_name: str, wrong: Sequence[_Wrong], first_seed: int) -> Iterator[Case]:
    for i, (words, effect, fault) in enumerate(wrong):
        seed = first_seed + RUNS_OF_A_CASE * i
        yield Case(f"{round_name}{i + 1:02d}", words, effect, fault, seed)


REFERENCE_RUNS = tuple(_runs("ref", REFERENCE_SEED, REFERENCES, HEALTHY))
CASES = (
    *_cases("c", _FIRST_ROUND, FIRST_ROUND_SEED),
    *_cases("d", _SECOND_ROUND, SECOND_ROUND_SEED),
)
