"""Names of legs against their places, left against right, servo signs against each other."""

import re
from collections.abc import Iterator, Sequence

import numpy as np

from model.values.arrays import FloatArray, IntArray
from robot.design.concern import Concern, note, warning

FRONT, MIDDLE, HIND = 1, 0, -1
LEFT, RIGHT = 1, -1
SIDES = {LEFT: "left", RIGHT: "right"}
ENDS = {FRONT: "front", HIND: "hind"}
WORDS = {
    "left": ("side", LEFT), "right": ("side", RIGHT),
    "front": ("end", FRONT), "fore": ("end", FRONT), "middle": ("end", MIDDLE), "mid": ("end", MIDDLE),
    "centre": ("end", MIDDLE), "center": ("end", MIDDLE),
    "hind": ("end", HIND), "rear": ("end", HIND), "back": ("end", HIND),
}  # fmt: skip
# Two letters, one for the end and one for the side; R is rear where it stands with a side behind it.
LETTERS = re.compile(r"(?:(?P<end>[FMHRB])(?P<side>[LR])|(?P<side2>[LR])(?P<end2>[FMHB]))\d*")
SIDE_NUMBER = re.compile(r"(?P<side>[LR])_?\d+")
END_OF = {"F": FRONT, "M": MIDDLE, "H": HIND, "R": HIND, "B": HIND}
SIDE_OF = {"L": LEFT, "R": RIGHT}
SAME_PLACE = 0.05  # of the robot's width and length


def named_place(name: str) -> tuple[int | None, int | None]:
    """Return the end (front 1, middle 0, hind -1) and the side (left 1, right -1) that a name says."""
    if match := LETTERS.fullmatch(name.upper()):
        end = match["end"] or match["end2"]
        side = match["side"] or match["side2"]
        return END_OF[end], SIDE_OF[side]
    if match := SIDE_NUMBER.fullmatch(name.upper()):
        return None, SIDE_OF[match["side"]]
    marks: dict[str, int] = {}
    for word in re.findall(r"[a-z]+", re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name).lower()):
        if word in WORDS:
            kind, value = WORDS[word]
            marks.setdefault(kind, value)
    return marks.get("end"), marks.get("side")


def place_concerns(names: Sequence[str], shaft_m: FloatArray) -> Iterator[Concern]:
    """Yield legs that are not where their names say, and left sides that are no mirror of the right.

    Args:
        names: Leg names.
        shaft_m: Where each leg is in the body frame, x forward, y left, (N, 3) [m].
    """
    wrong = list(_wrong_sides(names, shaft_m)) + list(_wrong_ends(names, shaft_m))
    yield from wrong
    if not wrong:
        yield from _mirror(names, shaft_m)


def _wrong_sides(names: Sequence[str], shaft_m: FloatArray) -> Iterator[Concern]:
    swapped = []
    for name, y in zip(names, shaft_m[:, 1].tolist(), strict=True):
        side = named_place(name)[1]
        if side is not None and side * y < 0:
            swapped.append((name, SIDES[side], SIDES[-side]))
    if swapped:
        name, meant, there = swapped[0]
        more = f" (and {', '.join(one[0] for one in swapped[1:])})" if len(swapped) > 1 else ""
        yield warning(
            "names", "legs.order",
            f"leg {name}{more} is {meant} by its name and on the {there} by its shaft_position",
            "y points to the left: put names and places in the same order, or change the sign of y",
        )  # fmt: skip


def _wrong_ends(names: Sequence[str], shaft_m: FloatArray) -> Iterator[Concern]:
    for side in (LEFT, RIGHT, None):
        legs = [
            (end, x, name)
            for name, x in zip(names, shaft_m[:, 0].tolist(), strict=True)
            for end, own in (named_place(name),)
            if end is not None and own == side
        ]
        for end, x, name in legs:
            for other_end, other_x, other in legs:
                if end > other_end and x < other_x:
                    yield warning(
                        "names", "legs.order",
                        f"leg {name} should be ahead of {other} by its name and is "
                        f"{(other_x - x) * 1e3:.0f} mm behind it by its shaft_position",
                        "x points forward: put names and places in the same order, or change the sign of x",
                    )  # fmt: skip
                    return


def _mirror(names: Sequence[str], shaft_m: FloatArray) -> Iterator[Concern]:
    """A left side that is nearly the mirror of the right has a leg out of place."""
    size = float(np.ptp(shaft_m[:, :2], axis=0).max())
    beside = np.abs(shaft_m[:, 1]) > SAME_PLACE * size
    if size <= 0 or not beside.any():
        return
    mirrored = shaft_m * [1, -1, 1]
    apart = np.sqrt(((shaft_m[:, None] - mirrored[None]) ** 2).sum(-1))
    lonely = [int(k) for k in np.flatnonzero(beside) if apart[k].min() > SAME_PLACE * size]
    count = int(beside.sum())
    if len(lonely) == 0:
        return
    sides = np.sign(shaft_m[beside, 1])
    if abs(sides.sum()) == count:
        yield warning(
            "asymmetric", "legs.shaft_position", f"all legs are on the {SIDES[int(sides[0])]}",
            "y points to the left and is negative on the right",
        )  # fmt: skip
        return
    if len(lonely) <= count // 2:
        k = lonely[0]
        x, y = shaft_m[k, :2] * 1e3
        more = f" (nor have {', '.join(names[i] for i in lonely[1:])})" if len(lonely) > 1 else ""
        yield warning(
            "asymmetric", "legs.shaft_position",
            f"leg {names[k]} at x {x:.0f}, y {y:.0f} mm has no mirror image on the other side{more}, "
            "though most legs have", "check its x, y and z",
        )  # fmt: skip
    elif count % 2 == 0:
        yield note(
            "asymmetric", "legs.shaft_position", "the left side is no mirror image of the right",
        )  # fmt: skip


def sign_concerns(names: Sequence[str], shaft_m: FloatArray, signs: IntArray) -> Iterator[Concern]:
    """Yield servos that turn unlike the others of their side.

    Args:
        names: Leg names.
        shaft_m: Shafts, (N, 3) [m].
        signs: ``legs.servo_sign``, (N,).
    """
    for side in (LEFT, RIGHT):
        own = np.flatnonzero(np.sign(shaft_m[:, 1]) == side)
        other = np.flatnonzero(np.sign(shaft_m[:, 1]) == -side)
        total = int(signs[own].sum())
        # where the side itself is undecided, the other side's sign decides
        usual = int(np.sign(total)) or -int(np.sign(signs[other].sum()))
        odd = [names[int(k)] for k in own if usual and signs[k] != usual]
        if odd:
            yield warning(
                "signs", "legs.servo_sign",
                f"{', '.join(odd)}: not the sign of the other legs on the {SIDES[side]}; if the servos of "
                "a side are mounted alike, that leg walks backward",
                "look with bigant servo jog --leg "
                f"{odd[0]}: increasing angle moves a standing foot backward",
            )  # fmt: skip
    if len(signs) > 1 and (signs == signs[0]).all() and len({*np.sign(shaft_m[:, 1])} - {0.0}) == 2:
        yield note(
            "signs", "legs.servo_sign",
            "is the same on both sides; servos that are mounted as mirror images need opposite signs",
            "look with bigant servo jog",
        )  # fmt: skip
