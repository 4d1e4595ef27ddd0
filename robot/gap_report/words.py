"""What the page and the terminal both say of a diagnosis."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

from gap.detectable import Detectable
from gap.diagnosis.alternatives.probability import RivalCause
from gap.diagnosis.answer.findings import DATA_FIRST, Diagnosis, TrialFaults, Verdict
from gap.diagnosis.answer.named_cause import NamedCause
from gap.diagnosis.comparison.how_far import HowFar
from gap.experiments.next_run import NextRun
from gap.interfaces import Cause, DataFault, Effect, place_words
from gap.rounding import fixed, percent_words, value_words
from gap.search.fit import ENOUGH_SEPARATION
from model.parameters.toml_table import parse_toml
from record.trial.header import SERVO_BENCH
from record.trial.trial import Trial
from robot.console.table import Column, table_lines

HEADLINES = {
    Verdict.EXPLAINED: "Explained",
    Verdict.AMBIGUOUS: "Found, but ambiguous",
    Verdict.UNEXPLAINED: "Not explained",
    Verdict.NO_GAP: "No gap",
}
LEAST_CLOSED = 0.05  # of the gap: of a cause that closes less, nobody asks in which stage it shows
LIKELY = 1e-3
LEAST_CHANGE = 1e-3  # of the baseline: a channel that changes less is not shown
SHOWN_CAUSES = 2
WHY_APART = (
    "the share of a stage is of its own output, fed with the measurements before it; what a cause explains "
    "is counted end to end, where it shows in other stages too"
)
LEGGED_SIMULATORS = frozenset({"legged", "mujoco"})
NOT_LEGGED = "one with another load or another speed"
CHANNELS = (
    Column(""), Column("", ".3g"), Column(""), Column("", ".3g"), Column(""), Column(""),
    Column("", ".3g"),
)  # fmt: skip
BOUND = " (on its bound)"
AGAIN = "then import these runs and diagnose again"
DATA_REMEDIES = MappingProxyType({
    "unit": "give its unit in the column map of the import",
    "sign": "give it sign = -1 in the column map of the import",
    "swapped": "exchange the columns in the column map of the import (or the cables on the machine)",
    "wrap": "unwrap the angle before the import",
    "magnitude_only": "record it with its sign",
    "frozen": "check the sensor and its cable; leave out the runs in which it stands still",
    "gap": "record again without lost samples",
    "spikes": "check the sensor's cable; remove the lone samples",
    "clock_offset": "align the clocks of what was recorded apart",
    "saturated": "record again with a larger range of the sensor",
    "other_machine": "give references and trials of one machine, or correct the file of those that name it",
})  # fmt: skip
ENOUGH = f"{ENOUGH_SEPARATION:.0f}"


def verdict_words(d: Diagnosis) -> str:
    """The verdict in few words; or that the data come first."""
    return DATA_FIRST if d.severe_channels else HEADLINES[d.verdict]


def headline(d: Diagnosis) -> str:
    """Verdict and causes in few words; no cause where the data cannot be trusted."""
    if d.severe_channels:
        return f"{DATA_FIRST}: {few(d.severe_channels, SHOWN_CAUSES)}"
    causes = d.sure if d.verdict is Verdict.EXPLAINED else d.causes
    places = [place_words(one.effect, one.joints) for one in causes]
    names = few(places, SHOWN_CAUSES, " and ")
    named = names and d.verdict in {Verdict.EXPLAINED, Verdict.AMBIGUOUS}
    return f"{HEADLINES[d.verdict]}: {names}" if named else HEADLINES[d.verdict]


def why_a_gap(d: Diagnosis) -> str:
    """Say which test says that there is a gap; empty where no references judge, or there is none."""
    return d.detection.why_words if d.detection is not None and d.detection.below else ""


def stage_note(d: Diagnosis) -> str:
    """Say why a cause closes much of a gap of which its stage has little; empty if none does."""
    stages = {one.stage: one for one in d.where.stages}
    notes, apart = [], []
    for one in d.causes:
        place, stage = place_words(one.effect, one.joints), stages.get(one.stage)
        if stage is None or not one.shrink >= LEAST_CLOSED:
            continue
        if math.isnan(stage.own):
            notes.append(f"{place} acts in the stage {one.stage}, which has no channel of its own: it "
                         "shows in the others")  # fmt: skip
        elif stage.share < 0.5 * one.shrink:
            apart.append(f"{place} explains {percent_words(one.shrink)}, its stage {one.stage} has "
                         f"{percent_words(stage.share)}")  # fmt: skip
    if apart:
        notes.append(f"{'; '.join(apart)}: {WHY_APART}")
    return "; ".join(notes)


def joint_sizes(one: NamedCause) -> tuple[list[str], list[list[str]]]:
    """Head and rows of a table of a cause at every joint, the largest first; no rows for another cause."""
    each = one.by_joint
    names = [f"{v.name} [{v.unit}]" if v.unit else v.name for v in next(iter(each.values()), ())]
    rows = [
        [joint, *(value_words(v.value, v.error) + BOUND * v.on_bound for v in values)]
        for joint, values in each.items()
    ]
    return ["joint", *names], rows


def size_words(one: Detectable) -> str:
    """Say at which values an effect would have shown."""
    unit = f" {one.unit}" if one.unit else ""
    if not math.isfinite(one.size) or not one.size > 0.0:
        return "these runs cannot show it"
    if not one.values:
        return f"not detectable within its bounds ({one.lower:.3g} to {one.upper:.3g}{unit})"
    if one.neutral == 0.0:
        sign = "+-" if len(one.values) > 1 else "-" if one.values[0] < 0.0 else ""
        return f"{sign}{one.size:.3g}{unit}"
    decimals = max(0, 1 - math.floor(math.log10(one.size)))
    return " or ".join(fixed(value, decimals) for value in one.values) + unit


def rms_words(value: float, form: str = ".3g") -> str:
    """Write an RMS; in words where the simulation broke down."""
    return "not known" if math.isnan(value) else f"{value:{form}}"


def whole_words(d: Diagnosis) -> str:
    """Name all causes together."""
    return "the named cause" if len(d.causes) == 1 else "the named causes"


def likely_rivals(d: Diagnosis) -> list[RivalCause]:
    """What could replace a cause, the likeliest first; the named causes themselves cannot."""
    named = {(one.effect, one.joints) for one in d.causes}
    others = [r for r in d.rivals if (r.effect, r.joints) not in named and r.probability > LIKELY]
    return sorted(others, key=lambda one: -one.probability)


def common_pair(runs: Sequence[NextRun]) -> str:
    """What every run tells apart, in words; empty if they differ in it."""
    pairs = {one.pair for one in runs}
    return pair_words(runs[0]) if len(pairs) == 1 else ""


def pair_words(one: NextRun) -> str:
    """What a run tells apart."""
    return f"{one.pair[0]} from {one.pair[1]}"


def parameters_of(cause: Cause, effects: Mapping[str, Effect]) -> dict[str, float]:
    """The numbers of a cause by name; ``effects`` is the catalogue."""
    return effects[cause.effect].named(cause.values)


def changed_channels(far: HowFar, most: int) -> list[str]:
    """The channels that the causes change most, before and after, as lines."""
    changed = [c for c in far.channels if abs(c.before - c.after) > LEAST_CHANGE * c.floor]
    changed.sort(key=lambda c: -abs(c.before - c.after) / max(c.floor, 1e-12))
    rows = [
        (f"{c.channel} {c.joint}".strip(), c.before, "->", c.after, c.unit, "baseline", c.floor)
        for c in changed[:most]
    ]
    return table_lines(CHANNELS, rows, "  ")


def machine_words(trial: Trial) -> str:
    """Name the machine of a trial, with its joints where each is a machine of its own."""
    header = trial.header
    toml = header.robot_text if Path(header.robot_file).suffix == ".toml" else ""  # not an MJCF
    name = parse_toml(toml, header.robot_file).get("name")
    known = name if isinstance(name, str) else Path(header.robot_file).stem
    machine = known or header.kind.replace("_", " ")
    if header.kind != SERVO_BENCH:
        return machine
    return (
        f"{machine}, {'joint' if len(header.joints) == 1 else 'joints'} {', '.join(header.joints)}"
    )


def held_out_words(d: Diagnosis, paths: Sequence[Path], most: int) -> str:
    """Name the runs that judge, or the part of the runs where all are fitted to."""
    names = few([paths[i].name for i in d.held_out_trials], most)
    return f"{d.held_out} ({names})" if judged_by_parts(d) else names


def judged_by_parts(d: Diagnosis) -> bool:
    """Whether a part of each run is fitted to, and the rest of it judges."""
    return bool(set(d.fitted_trials) & set(d.held_out_trials))


def file_words(paths: Sequence[Path]) -> str:
    """Name the first few files, and say how many more there are."""
    return few([path.name for path in paths], 3)


def few(names: Sequence[str], most: int, joint: str = ", ") -> str:
    """The first few names, and how many more there are."""
    shown = joint.join(names[:most])
    return f"{shown} and {len(names) - most} more" if len(names) > most else shown


class FaultGroup(NamedTuple):
    """One kind of fault in one channel: in which files, and the evidence in the first (severe) one."""

    kind: str
    channel: str
    severe: bool
    files: tuple[str, ...]
    evidence: str

    @property
    def where(self) -> str:
        """Which files, in few words."""
        return few(self.files, 2)

    @property
    def remedy(self) -> str:
        """What to do about it; empty for one that does not make an answer worthless."""
        return DATA_REMEDIES.get(self.kind, "correct it in the data") if self.severe else ""


def fault_groups(faults: Sequence[TrialFaults], paths: Sequence[Path]) -> tuple[FaultGroup, ...]:
    """Return the groups of the faults of all ``paths``: severe ones first, then those in most files."""
    by_channel: dict[tuple[str, str], list[tuple[str, DataFault]]] = {}
    for one in faults:
        for fault in one.faults:
            same = by_channel.setdefault((fault.kind, fault.channel), [])
            same.append((paths[one.trial].name, fault))
    groups = [
        FaultGroup(
            kind,
            channel,
            any(fault.severe for _, fault in same),
            tuple(dict.fromkeys(name for name, _ in same)),
            max(same, key=lambda named: named[1].severe)[1].evidence,
        )
        for (kind, channel), same in by_channel.items()
    ]
    return tuple(sorted(groups, key=lambda group: (not group.severe, -len(group.files))))
