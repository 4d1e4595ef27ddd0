"""Passes through the stages of a walk, until what a pass takes as given is what it finds.

Loads move shafts, and shafts decide loads; drag and inertia shift the loads that the ground answers them
with. A pass answers with one of them given. How far the next pass goes towards what the last one found
comes from how two residuals in a row differ: Aitken's relaxation, as of coupled flow and structure, with
which three to seven passes do (Kuettler and Wall 2008, doi:10.1007/s00466-008-0255-5). Where a change
grows, the next step is half as long.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from gap.machines.legged.walk_truth import Walk, finite, foot_forces
from model.effects.gear_play import Strut
from model.effects.ground import Sliding
from model.values.arrays import FloatArray

PASSES = 30
STALLED = 12  # passes without a change of half the least: a foot hops between two answers
CONVERGED = 1e-7  # change from pass to pass of shafts [rad] and places [m]
LEAST_SHARE, MOST_SHARE = 1 / 8, 2.0  # of the way to what a pass found, that the next one goes


@dataclass(frozen=True, slots=True, eq=False)
class Flanks:
    """What a walk without play says of shafts with play.

    Attributes:
        force_n: Forces on the feet that decide against which flank a shaft lies, (W, N, 3).
        strut: What the ground lets shafts do between them.
    """

    force_n: FloatArray
    strut: Strut


@dataclass(frozen=True, slots=True, eq=False)
class PassStart:
    """What a pass takes as given.

    Attributes:
        force_n: Forces on the feet that act about the shafts, (W, N, 3).
        flanks: What decides against which flank a shaft with play lies; the forces if None.
        world: Place of the body, x, y [m], yaw [rad], (W, 3).
        velocity_B: Measured velocity of the body, (W, 3), where an effect looks at it; else None.
        moving_B: Velocity that drag and inertia shift loads by, (W, 3); None where it is not known yet.
    """

    force_n: FloatArray
    flanks: Flanks | None
    world: FloatArray
    velocity_B: FloatArray | None  # noqa: N815 - frame suffix
    moving_B: FloatArray | None  # noqa: N815

    def answered(self, walk: Walk, forces_known: bool, place_known: bool) -> "PassStart":
        """Return what a pass from here answered to what it was given."""
        moving = self.velocity_B
        if moving is None:
            moving = finite(walk.sliding.velocity_B)
        return replace(
            self, force_n=self.force_n if forces_known else foot_forces(walk),
            world=self.world if place_known else walk.world, moving_B=moving,
        )  # fmt: skip

    def towards(self, answer: "PassStart", share: float) -> "PassStart":
        """Return what the next pass takes as given: a share of the way to what the last one found."""
        if share == 1.0:
            return answer
        moving = answer.moving_B
        if moving is not None and self.moving_B is not None:
            moving = _between(self.moving_B, moving, share)
        return replace(
            self, force_n=_between(self.force_n, answer.force_n, share),
            world=_between(self.world, answer.world, share), moving_B=moving,
        )  # fmt: skip

    def short_of(self, answer: "PassStart") -> tuple[FloatArray, ...]:
        """Return how far what was given is from what was found, each kind of quantity by itself."""
        moving = self.moving_B
        if moving is None or answer.moving_B is None:
            return (answer.force_n - self.force_n, answer.world - self.world)
        return (answer.force_n - self.force_n, answer.world - self.world, answer.moving_B - moving)


def settled(
    run: Callable[[PassStart, Sliding], Walk],
    start: PassStart,
    walk: Walk,
    *,
    forces_known: bool,
    place_known: bool,
) -> Walk:
    """Run passes after the one that a start gave, until nothing changes, and return the last.

    Args:
        run: A pass, with an answer near which its balances start.
        start: What the first pass took as given.
        walk: What it gave.
        forces_known: Whether forces are measured, so that no pass changes them.
        place_known: The same of the body's place.
    """
    share, most, last = 1.0, MOST_SHARE, np.inf
    least, since = np.inf, 0
    before: tuple[FloatArray, ...] = ()
    for _ in range(PASSES):
        answer = start.answered(walk, forces_known, place_known)
        short = start.short_of(answer)
        if len(before) == len(short):
            share = float(np.clip(_next_share(share, before, short), LEAST_SHARE, most))
        start, before = start.towards(answer, share), short
        following = run(start, walk.sliding)
        change = _change(walk, following) / share
        walk = following
        least, since = (change, 0) if change < least / 2 else (least, since + 1)
        if change <= CONVERGED or since == STALLED:
            break
        if not change < last:  # it went too far
            most = share = max(share / 2, LEAST_SHARE)
        last = change
    return walk


def _next_share(share: float, before: tuple[FloatArray, ...], now: tuple[FloatArray, ...]) -> float:
    """Share that would have left nothing, were answers linear; kinds of quantities count alike."""
    along = across = 0.0
    for one, other in zip(before, now, strict=True):
        size = float(np.sum(one**2))
        if size > 0.0:
            change = other - one
            along -= float(np.sum(one * change)) / size
            across += float(np.sum(change**2)) / size
    return share * along / across if across > 0.0 else share


def _between(given: FloatArray, solved: FloatArray, share: float) -> FloatArray:
    between: FloatArray = given + share * (solved - given)
    return between


def _change(before: Walk, after: Walk) -> float:
    shaft = np.abs(after.shaft_rad - before.shaft_rad)
    place = np.abs(after.world - before.world)
    return float(max(np.nanmax(shaft, initial=0.0), np.nanmax(place, initial=0.0)))
