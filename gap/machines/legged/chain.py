"""The legged chain: commands to sensor readings through all stages, with whatever is added.

Command drive: every stage is fed by the one before; where loads act back on shafts, or effects are
bound to places, the chain is run until nothing changes. Measured drive: shafts, loads, foot forces and
pose come from the sensors (made good for what the causes say of the sensors), where they were measured.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache, partial
from typing import NamedTuple

import numpy as np

from gap.data.columns import runs
from gap.interfaces import Drive
from gap.machines.legged.inputs import LeggedInputs
from gap.machines.legged.passes import Flanks, PassStart, settled
from gap.machines.legged.solved import SolvedOnArrays, SolvedTraction
from gap.machines.legged.walk_truth import MARKER_SHARE, Walk, finite, foot_forces, truth_of
from model.effects.catalogue import EFFECTS
from model.effects.gear_play import (
    LOOSE_PUSH,
    PLAYS,
    UNSEEN_PLAY,
    ZERO_OFF_N,
    foot_weight_torque,
    in_play,
    strut_of,
)
from model.effects.grid import LONGEST_HOLE_S, Grid, body_velocity
from model.effects.ground import Sliding, Standing, foot_slip, slide, stand, stands_on
from model.effects.machine import LeggedMachine
from model.effects.pushes import Scene, change_of, resists_motion
from model.effects.sensing import read_sensors, true_signals
from model.effects.settings import Settings
from model.effects.shafts import (
    GIVES,
    UNSEEN_GIVE,
    Feet,
    Loads,
    feels_loads,
    feet,
    load_torque,
    moves_feet,
    moves_shafts,
    shaft_give,
    shafts,
    springing,
)
from model.effects.signals import SensorSignals
from model.motion.se2 import integrate
from model.traction.frames import near_answers
from model.values.arrays import BoolArray, FloatArray

REMEMBERED = 24
BOUND_TO_PLACES = ("ground_step", "friction_patch", "ground_slope", "tether_force")


class WalkReading(NamedTuple):
    """What sensors read, the truth that they read, and how its feet slide."""

    signals: SensorSignals
    truth: SensorSignals
    sliding: Sliding


class LeggedChain:
    """The chain of one machine; stages that several predictions share are solved once."""

    def __init__(self, machine: LeggedMachine) -> None:
        self._machine = machine
        # settings compare by value, inputs by identity: what was solved before is found again
        self._plain_walk = lru_cache(maxsize=REMEMBERED)(self._walk)
        # apart, as walks that are needed once would push out these, which many need
        self._lawful = lru_cache(maxsize=REMEMBERED)(self._with_laws)
        self._commanded = lru_cache(maxsize=REMEMBERED)(self._walk_on_commands)
        self._known_shafts, self._known_feet = SolvedOnArrays(), SolvedOnArrays()
        self._known_standing, self._known_world = SolvedOnArrays(), SolvedOnArrays()
        self._known_velocity, self._known_change = SolvedOnArrays(), SolvedOnArrays()
        self._perfect = lru_cache(maxsize=REMEMBERED)(_as_perfect)
        self._measured_world = lru_cache(maxsize=REMEMBERED)(_measured_world)
        self._traction, self._known_starts = SolvedTraction(), SolvedOnArrays()

    def read(self, inputs: LeggedInputs, settings: Settings, drive: Drive) -> SensorSignals:
        """Return what the sensors would read."""
        return self.reading(inputs, settings, drive).signals

    def reading(self, inputs: LeggedInputs, settings: Settings, drive: Drive) -> WalkReading:
        """Return what the sensors would read, and of what."""
        known = inputs
        if drive is Drive.MEASURED:
            known = self._perfect(inputs, _of_sensors(settings))
        walk = self.walk(known, settings, drive, self._near(inputs, settings, drive))
        truth = truth_of(self._machine, known, walk, settings, drive)
        seen = known if drive is Drive.MEASURED else None
        return WalkReading(read_sensors(inputs.grid, truth, settings, seen), truth, walk.sliding)

    def _near(self, inputs: LeggedInputs, settings: Settings, drive: Drive) -> Sliding | None:
        """Return the answer from which searches of this trial start: with laws, without other causes.

        None of it depends on what was asked before, and so none of what is found from it. The viscous
        ansatz settles as fast from the frames before.
        """
        laws = _laws_of(settings, drive)
        if settings == laws or not settings.has("coulomb_friction"):
            return None
        return self._lawful(inputs, laws, drive)

    def _with_laws(self, inputs: LeggedInputs, laws: Settings, drive: Drive) -> Sliding:
        """Answer of a trial with laws alone."""
        known = self._perfect(inputs, _of_sensors(laws)) if drive is Drive.MEASURED else inputs
        return self.walk(known, laws, drive).sliding

    def walk(
        self,
        known: LeggedInputs,
        settings: Settings,
        drive: Drive,
        near: Sliding | None = None,
    ) -> Walk:
        """Run all stages before the sensors, or remember them; the inputs are those of perfect sensors.

        ``near`` is an answer from which balances start; it moves no more than the last digits.
        """
        acting = tuple(one for one in settings.acting if EFFECTS[one[0]].stage != "sensing")
        added = tuple(one for one in settings.added if one.user.effect.stage != "sensing")
        return self._plain_walk(known, replace(settings, acting=acting, added=added), drive, near)

    def _walk(
        self, known: LeggedInputs, settings: Settings, drive: Drive, near: Sliding | None
    ) -> Walk:
        measured = drive is Drive.MEASURED
        world = self._measured_world(known) if measured else None
        velocity = None
        resists = resists_motion(settings)
        slips = settings.has("stiction") and _always_seen(known)
        if world is not None and (resists or slips):
            velocity = self._velocity(known.grid, world)
        place = np.tile(known.start_pose, (known.grid.frames, 1)) if world is None else world
        force = known.force_n if measured else np.zeros_like(known.force_n)
        felt, plain = measured and bool(np.isfinite(force).any()), settings
        if measured and not felt and feels_loads(settings):
            # without force sensors shafts feel the loads that are predicted without their give
            added = tuple(one for one in settings.added if one.user.effect.stage != "actuation")
            plain = replace(settings.without(*GIVES), added=added)
            force = foot_forces(self._plain_walk(known, plain.without(*PLAYS), drive, near))
        flanks = None
        if settings.has(*PLAYS) and (felt or not measured):
            flanks = self._flanks(
                known, plain, lambda tight: self._plain_walk(known, tight, drive, near),
                force if felt else None,
            )  # fmt: skip
        elif settings.has(*PLAYS):  # measured shafts have the play in them: feet on them stand
            flanks = self._flanks(known, plain, lambda tight: self._commanded(known, tight), None)
        start = PassStart(force, flanks, place, velocity, velocity if resists else None)
        walk = self._pass(known, settings, drive, start, near)
        if not _acts_back(settings, drive, world is None):
            return walk
        return settled(
            lambda given, alike: self._pass(known, settings, drive, given, alike),
            start, walk, forces_known=measured, place_known=world is not None,
        )  # fmt: skip

    def _flanks(
        self,
        known: LeggedInputs,
        settings: Settings,
        walk: Callable[[Settings], Walk],
        felt_n: FloatArray | None,
    ) -> Flanks:
        """What walks without play say of shafts with it, with the slip of feet that follow commands.

        Loads decide against which flank a shaft lies: measured ones (``felt_n``, (W, N, 3)), or those of
        such a walk. Where none are measured, the body moves as while the shaft is between its flanks.
        """
        tight = walk(settings.without(*PLAYS))
        load = tight.standing.load_n
        if felt_n is None:
            loose = walk(self._loosened(settings))
            force = foot_forces(tight)
        else:
            loose, force = tight, _without_zeros(felt_n, load)
        walked = feet(self._machine, known.grid, tight.shaft_rad, settings)
        slip = foot_slip(walked.signals.position_m, walked.rate_m_s, loose.sliding.velocity_B)
        return Flanks(force, strut_of(walked.signals, slip, load, measured=felt_n is not None))

    def _walk_on_commands(self, known: LeggedInputs, settings: Settings) -> Walk:
        """Walk whose shafts follow commands, where the body was measured: one pass tells all of it."""
        world = self._measured_world(known)
        if world is None:
            return self._plain_walk(known, settings, Drive.COMMAND, None)
        moving = self._velocity(known.grid, world) if resists_motion(settings) else None
        start = PassStart(np.zeros_like(known.force_n), None, world, moving, moving)
        return self._pass(known, settings, Drive.COMMAND, start, None)

    def _loosened(self, settings: Settings) -> Settings:
        """Return settings without play, in which legs that have it hardly push the body."""
        tight = settings.without(*PLAYS)
        if not self._machine.names.one_joint_a_leg:
            return tight
        loose = np.any([settings.each(one)[0] > 0.0 for one in PLAYS], axis=0)
        return tight.times("foot_friction", np.where(loose, LOOSE_PUSH, 1.0))

    def _pass(
        self,
        known: LeggedInputs,
        settings: Settings,
        drive: Drive,
        start: PassStart,
        alike: Sliding | None,
    ) -> Walk:
        """One pass through the stages."""
        machine, grid = self._machine, known.grid
        force, velocity = start.force_n, start.velocity_B
        measured = drive is Drive.MEASURED
        loads, give, sprung, unseen = None, None, None, None
        if feels_loads(settings):
            # the lever is that of the shaft where it nearly is
            near = known.shaft_rad if measured else known.command_rad
            lever = feet(machine, grid, near, settings).signals
            torque = load_torque(lever, force)
            flank, strut = torque, None
            if start.flanks is not None:
                flank = load_torque(lever, start.flanks.force_n)
                strut = start.flanks.strut
            loads = Loads(torque, flank + foot_weight_torque(lever), strut)
            if settings.has(UNSEEN_GIVE):
                unseen = settings.each(UNSEEN_GIVE)[0] * torque
            if settings.has(UNSEEN_PLAY):
                width = settings.each(UNSEEN_PLAY)[0]
                place = in_play(grid, loads.flank_nm, width, strut)
                unseen = place if unseen is None else unseen + place
            if not measured:
                # a shaft that gives under friction is a foot that gives: too stiff for a loop of passes
                compliance = sum(settings.each(one)[0] for one in GIVES)
                give = shaft_give(lever, compliance)
                sprung = springing(lever, compliance, finite(force[..., 0]))
        late = known.delayed_command(*settings.whole("command_delay"))
        own = self._shafts(known, late, settings, loads)
        angles = np.where(np.isfinite(known.shaft_rad), known.shaft_rad, own) if measured else own
        if unseen is not None:
            angles = angles + finite(unseen)
        if unseen is None and measured and np.isfinite(known.shaft_rad).all():
            walked = self._measured_feet(known, settings)
        else:
            walked = feet(machine, grid, angles, settings)
        solve = partial(self._traction, near=None if alike is None else self._start_of(alike))
        change_seen = velocity is not None and bool(np.isfinite(known.force_n).any())
        scene = Scene(machine, grid, settings, start.world, solve, change_seen, self._change)
        standing = self._stand(scene, walked, start.moving_B)
        load = standing.load_n
        if measured:
            seen = known.force_n[..., 2]
            load = np.where(np.isfinite(seen), np.maximum(seen, 0.0), load)
        held = walked
        if sprung is not None and sprung.any():
            held = feet(machine, grid, angles - sprung, settings)
        sliding = slide(scene, held, standing, load, give, velocity)
        return Walk(own, walked, standing, sliding, self._integrated(known, sliding))

    def _stand(self, scene: Scene, walked: Feet, moving_B: FloatArray | None) -> Standing:  # noqa: N803
        """Loads and pose; most effects of friction and sensors share them."""
        looked_at = stands_on(scene.settings)
        bare = replace(scene, settings=looked_at)
        arrays = (walked.signals.position_m, scene.world)
        return self._known_standing.of(
            arrays if moving_B is None else (*arrays, moving_B),
            looked_at,
            lambda: stand(bare, walked, moving_B),
        )

    def _velocity(self, grid: Grid, world: FloatArray) -> FloatArray:
        """Velocity of a measured place, (W, 3); whatever is the same array is solved once."""
        return self._known_velocity.of((world,), grid, lambda: body_velocity(grid, world))

    def _change(self, grid: Grid, velocity: FloatArray, smoothed: bool) -> FloatArray:
        """How fast a velocity changes, (W, 3)."""
        return self._known_change.of(
            (velocity,), (grid, smoothed), lambda: change_of(grid, velocity, smoothed)
        )

    def _start_of(self, near: Sliding) -> FloatArray:
        """Where balances start that are near an answer; most predictions share it."""
        velocity, force = near.velocity_B, near.force_xy_n
        return self._known_starts.of((velocity, force), None, lambda: near_answers(velocity, force))

    def _integrated(self, known: LeggedInputs, sliding: Sliding) -> FloatArray:
        """Place of the point below the body's origin, (W, 3), from where the trial began."""
        velocity, start = sliding.velocity_B, known.start_pose
        return self._known_world.of((velocity,), tuple(start), lambda: _integrated(known, velocity))

    def _shafts(
        self, known: LeggedInputs, late_rad: FloatArray, settings: Settings, loads: Loads | None
    ) -> FloatArray:
        """Where commands and loads put the shafts; without loads most effects share them."""
        grid, command, start_rad = known.grid, known.command_rad, known.shaft_rad[0]
        if loads is not None:
            return shafts(grid, command, late_rad, settings, loads, start_rad)
        looked_at = moves_shafts(settings)
        return self._known_shafts.of(
            (command, known.shaft_rad), looked_at,
            lambda: shafts(grid, command, late_rad, looked_at, None, start_rad),
        )  # fmt: skip

    def _measured_feet(self, known: LeggedInputs, settings: Settings) -> Feet:
        """Feet on measured shafts: most effects of other stages share them."""
        angles, looked_at = known.shaft_rad, moves_feet(settings)
        return self._known_feet.of(
            (angles,), looked_at, lambda: feet(self._machine, known.grid, angles, looked_at)
        )


def _without_zeros(force_n: FloatArray, load_n: FloatArray) -> FloatArray:
    """Measured forces, (W, N, 3), without the zeros that load cells read of feet in the air.

    These are feet with neither a predicted load, (W, N), nor a force that is more than a zero.
    """
    zero = (load_n <= 0.0) & (np.linalg.norm(force_n, axis=2) < ZERO_OFF_N)
    return np.where(zero[..., None], 0.0, force_n)


def _as_perfect(inputs: LeggedInputs, settings: Settings) -> LeggedInputs:
    return true_signals(inputs.grid, inputs, settings)


def _of_sensors(settings: Settings) -> Settings:
    """Return the part of settings that sensors have, all else neutral."""
    # where markers sit changes no reading that a stage takes over
    acting = tuple(
        one
        for one in settings.acting
        if EFFECTS[one[0]].stage == "sensing" and one[0] != MARKER_SHARE
    )
    return replace(settings, acting=acting, added=())


def _laws_of(settings: Settings, drive: Drive) -> Settings:
    """Return the laws of settings and how feet give: what decides how feet answer slip.

    And what resists the body's velocity where that is measured, so that it takes no passes.
    """
    kept = ("leg_flex", *(("inertia_lag", "drag") if drive is Drive.MEASURED else ()))
    acting = tuple(
        one for one in settings.acting if one[0] in kept or not EFFECTS[one[0]].parameters
    )
    return replace(settings, acting=acting, added=())


def _acts_back(settings: Settings, drive: Drive, place_unknown: bool) -> bool:
    loads = settings.has(*GIVES) or bool(settings.at("actuation"))
    places = resists_motion(settings) or settings.has(*BOUND_TO_PLACES)
    return (loads and drive is Drive.COMMAND) or (places and place_unknown)


def _always_seen(known: LeggedInputs) -> bool:
    """Whether the body's pose was measured in all frames but a few lone ones."""
    missing: BoolArray = ~np.all(np.isfinite(_read_world(known)), axis=1)
    longest = max((last - first for first, last in runs(missing).tolist()), default=0)
    return longest * known.grid.period_s <= LONGEST_HOLE_S


def _read_world(known: LeggedInputs) -> FloatArray:
    """Place of the body as it was read, x, y, yaw, (W, 3); NaN where it was not."""
    return np.column_stack([known.body_m[:, :2], known.body_rad[:, 2]])


def _measured_world(known: LeggedInputs) -> FloatArray | None:
    world = _read_world(known)
    complete = np.isfinite(world).all(axis=1)
    if not complete.any():
        return None
    time_s = known.grid.time_s
    return np.stack([np.interp(time_s, time_s[complete], c[complete]) for c in world.T], axis=1)


def _integrated(known: LeggedInputs, velocity: FloatArray) -> FloatArray:
    """Place of the point below the body's origin, (W, 3), from where the trial began."""
    held = np.where(np.isfinite(velocity), velocity, 0.0)
    return integrate((held[:-1] + held[1:]) / 2, known.grid.period_s, known.start_pose)
