"""A campaign: which cases, what is wrong in each, how each is walked; drawn from a scenario file.

    [campaign]
    seed = 1                                # everything random follows from it, unless sealed
    seconds = 30.0
    begin_within_s = 10.0                   # runs are recorded from a time on that is drawn up to this (0)
    robots = ["bigant.toml"]                # beside this file
    [conditions]                            # the trials of every case: all gaits at all frequencies
    gaits = ["tripod", "metachronal"]       # of the robot file; also FILE.py beside this file
    frequencies_hz = [0.1, 0.15]
    steer = [0.0, 0.0, 0.2, -0.2]           # one a trial, over and over
    [references]                            # runs of the healthy robot
    count = 6
    [cases]
    controls = 20                           # cases with nothing wrong
    effects = ["*"]                         # names, or * for all known ones that the robots can have
    severities = [[0.0, 0.3], [0.7, 1.0]]   # 0 mild to 1 strong; one case an effect and range
    repeats = 1
    pairs = 25                              # cases with two effects of different stages
    outside = 15                            # cases with an effect that no catalogue has
    singles = 30                            # so many of the single-effect cases, drawn; all without the key

Legs, signs, sizes and days are drawn; names of cases say nothing.
"""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from model.effects.leg_kinds import why_not
from model.errors import ConfigError, RecordError
from model.parameters.tables import parse_table
from model.parameters.toml_table import Table
from record.json_text import read_json
from record.toml_file import reading
from robot.config.gait_file import with_gait
from robot.config.robot_file import RobotConfig, load_robot
from robot.console.json_output import json_text
from robot.virtual.reality_robot import robot_in
from robot.virtual.twin_run import WalkPlan, plan_of
from sim_hw.realities.catalogue import USUAL, find_reality, why_not_in
from sim_hw.realities.reality import Reality
from sim_hw.twin.catalog import EFFECTS
from sim_hw.twin.effects import LEG, EffectKind, EffectParameter, TwinEffect, find_kind

ID_LETTERS = 10
REALITY_NAME = "reality.json"
CAMPAIGN_PAGE = "docs/twin.md#a-campaign"  # for a mistake in a scenario file
OF_FORCE_SENSORS = "force_"  # how the names of their effects begin


@dataclass(frozen=True, slots=True)
class CampaignScenario:
    """A scenario file, read: its keys as above, with the walks of a case and of the references planned.

    Without ``begin_within_s`` all runs are recorded from the first tick of walking on. ``skipped`` are
    effects that the reality cannot have, each with the reason in words.
    """

    seed: int
    robots: tuple[Path, ...]
    plans: tuple[WalkPlan, ...]
    references: tuple[WalkPlan, ...]
    controls: int
    effects: tuple[str, ...]
    severities: tuple[tuple[float, float], ...]
    repeats: int
    pairs: int
    outside: int
    singles: int | None = None
    reality: Reality = USUAL
    skipped: tuple[tuple[str, str], ...] = ()
    begin_within_s: float = 0.0

    def config(self, number: int) -> RobotConfig:
        """Return the robot of a number in the scenario's reality.

        Raises:
            ConfigError: Its file cannot be used.
        """
        return robot_in(self.reality, load_robot(self.robots[number]))


@dataclass(frozen=True, slots=True)
class CampaignCase:
    """One case of a kind: control, single, pair or outside.

    Its name, that of its folder, says nothing; its robot is the number of the file; a seed a trial stands
    for day and noise.
    """

    name: str
    robot: int
    kind: str
    effects: tuple[TwinEffect, ...]
    seeds: tuple[int, ...]


def read_scenario(path: Path, reality: Reality = USUAL) -> CampaignScenario:
    """Read a scenario file for robots that are built as in a reality.

    Raises:
        ConfigError: It cannot be read, or asks for what cannot be.
    """
    with reading(path, "the scenario", CAMPAIGN_PAGE) as text:
        return _scenario(path, parse_table(text, "scenario"), reality)


def reality_text(scenario: CampaignScenario) -> str:
    """Return what a campaign's folder says of its reality: nothing of what is wrong in its cases."""
    reality = scenario.reality
    words = {"reality": reality.name, "differs": reality.differs, "skipped": dict(scenario.skipped)}
    return json_text(words, indent=1) + "\n"


def campaign_reality(folder: Path) -> Reality:
    """Return the reality of a campaign; the usual one without a word of it.

    Raises:
        RecordError: The file that names it is damaged.
    """
    path = folder / REALITY_NAME
    if not path.is_file():
        return USUAL
    try:
        return find_reality(str(read_json(path)["reality"]))
    except (OSError, ValueError, KeyError, TypeError, ConfigError) as error:
        raise RecordError(f"{path} names no reality ({error}); make the campaign again") from error


def _scenario(path: Path, top: Table, reality: Reality) -> CampaignScenario:
    campaign = top.table("campaign")
    robots = tuple(path.parent / name for name in campaign.texts("robots"))
    configs = [robot_in(reality, load_robot(robot)) for robot in robots]
    config = configs[0]
    seconds = campaign.number("seconds", above=0)
    conditions = _conditions(top.table("conditions"), config, seconds, path.parent)
    cases = top.table("cases")
    names = _effect_names(cases, configs)
    every = {**dict.fromkeys(names), **{k.name: None for k in EFFECTS if not k.catalogued}}
    skipped = tuple((name, why) for name in every if (why := why_not_in(reality, name)))
    scenario = CampaignScenario(
        seed=campaign.integer("seed", minimum=0, maximum=2**31),
        robots=robots,
        plans=conditions,
        references=_references(top.table("references"), config, seconds, path.parent, conditions),
        controls=cases.integer("controls", minimum=0, maximum=100000),
        effects=tuple(name for name in names if not why_not_in(reality, name)),
        severities=_severities(cases),
        repeats=cases.integer("repeats", minimum=1, maximum=1000),
        pairs=cases.integer("pairs", minimum=0, maximum=100000),
        outside=cases.integer("outside", minimum=0, maximum=100000),
        singles=(
            cases.integer("singles", minimum=0, maximum=100000) if cases.has("singles") else None
        ),
        reality=reality,
        skipped=skipped,
        begin_within_s=campaign.number("begin_within_s", minimum=0, maximum=1000, otherwise=0.0),
    )
    for table in (campaign, cases, top):
        table.done()
    return scenario


def _conditions(
    table: Table, config: RobotConfig, seconds: float, folder: Path
) -> tuple[WalkPlan, ...]:
    gaits = table.texts("gaits")
    names = []
    for gait in gaits:
        named = str(folder / gait) if gait.endswith(".py") else gait
        try:
            config, name = with_gait(config, named)
        except ConfigError as error:
            raise ConfigError(table.name("gaits"), f"{error}") from error
        names.append(name)
    frequencies = _numbers(table, "frequencies_hz")
    steers = _numbers(table, "steer")
    if min(frequencies) <= 0 or max(abs(s) for s in steers) > 1:
        raise ConfigError(table.name("steer"), "must be from -1 to 1, and frequencies positive")
    table.done()
    grid = [(gait, frequency) for gait in names for frequency in frequencies]
    return tuple(
        plan_of(config, gait, frequency, seconds, steers[at % len(steers)])
        for at, (gait, frequency) in enumerate(grid)
    )


def _references(
    table: Table,
    config: RobotConfig,
    seconds: float,
    folder: Path,
    conditions: tuple[WalkPlan, ...],
) -> tuple[WalkPlan, ...]:
    count = table.integer("count", minimum=0, maximum=1000)
    own = _conditions(table, config, seconds, folder) if table.has("gaits") else conditions
    table.done()
    return tuple(own[at % len(own)] for at in range(count))


def _numbers(table: Table, key: str) -> tuple[float, ...]:
    value = table.raw(key)
    if not isinstance(value, list) or not value:
        raise ConfigError(table.name(key), f"must be a list of numbers, not {value!r}")
    return tuple(table.numbers(key, (len(value),)).tolist())


def _effect_names(table: Table, configs: Sequence[RobotConfig]) -> tuple[str, ...]:
    names = table.texts("effects")
    if names == ("*",):
        switched = (k.name for k in EFFECTS if k.catalogued and k.apply is not None)
        return tuple(name for name in switched if not _why_not(name, configs))
    for name in names:
        if why := _why_not(name, configs):
            raise ConfigError(table.name("effects"), f"{name} cannot be: {why}")
        if find_kind(name, EFFECTS).apply is None:
            raise ConfigError(
                table.name("effects"), f"{name} cannot be switched: every twin has it"
            )
    return names


def _why_not(effect: str, configs: Sequence[RobotConfig]) -> str:
    """Why one of the robots cannot have an effect, in words; empty if all can."""
    for config in configs:
        if why := why_not(effect, config.parameters.leg):
            return why
        if effect.startswith(OF_FORCE_SENSORS) and not config.force_sensor.any:
            return f"{config.name} has no force sensors"
    return ""


def _severities(table: Table) -> tuple[tuple[float, float], ...]:
    value = table.raw("severities")
    pairs = isinstance(value, list) and all(isinstance(v, list) and len(v) == 2 for v in value)
    spans = table.numbers("severities", (len(value), 2)).tolist() if pairs else []
    if not spans or any(low > high for low, high in spans):
        raise ConfigError(
            table.name("severities"), f"must be a list of ranges such as [0.0, 0.3], not {value!r}"
        )
    return tuple((low, high) for low, high in spans)


def draw_cases(scenario: CampaignScenario, entropy: bytes) -> tuple[CampaignCase, ...]:
    """Draw the cases, sorted by their names; everything random follows from the entropy."""
    random = np.random.default_rng(list(entropy))
    legs = load_robot(scenario.robots[0]).parameters.legs.names
    inside = [find_kind(name, EFFECTS) for name in scenario.effects]
    outside = [
        kind
        for kind in EFFECTS
        if not kind.catalogued and not why_not_in(scenario.reality, kind.name)
    ]
    wrong: list[tuple[str, tuple[TwinEffect, ...]]] = [("control", ())] * scenario.controls
    single = [
        (kind, span)
        for kind in inside
        for span in scenario.severities
        for _ in range(scenario.repeats)
    ]
    if scenario.singles is not None:
        order = random.permutation(len(single))[: scenario.singles]
        single = [single[number] for number in order]
    wrong.extend(("single", (_draw(kind, span, legs, random),)) for kind, span in single)
    whole = (scenario.severities[0][0], scenario.severities[-1][1])
    for _ in range(scenario.pairs):
        first, second = _two_stages(inside, random)
        pair = (_draw(first, whole, legs, random), _draw(second, whole, legs, random))
        wrong.append(("pair", pair))
    start = 0 if scenario.reality == USUAL else int(random.integers(len(outside)))
    for at in range(scenario.outside):
        kind = outside[(start + at) % len(outside)]
        wrong.append(("outside", (_draw(kind, whole, legs, random),)))
    cases = []
    for number, (label, effects) in enumerate(wrong):
        digest = hashlib.sha256(entropy + number.to_bytes(8, "big")).hexdigest()
        seeds = tuple(int(s) for s in random.integers(0, 2**31, len(scenario.plans)))
        robot = number % len(scenario.robots)
        cases.append(CampaignCase(digest[:ID_LETTERS], robot, label, effects, seeds))
    return tuple(sorted(cases, key=lambda case: case.name))


def reference_seeds(scenario: CampaignScenario, entropy: bytes) -> tuple[int, ...]:
    """Return the seeds of the reference runs."""
    random = np.random.default_rng([*entropy, 1])
    return tuple(int(s) for s in random.integers(0, 2**31, len(scenario.references)))


def _two_stages(
    kinds: list[EffectKind], random: np.random.Generator
) -> tuple[EffectKind, EffectKind]:
    first = kinds[int(random.integers(len(kinds)))]
    others = [kind for kind in kinds if kind.stage != first.stage]
    if not others:
        raise ConfigError("cases.pairs", "need effects of two stages at least", CAMPAIGN_PAGE)
    return first, others[int(random.integers(len(others)))]


def _draw(
    kind: EffectKind, span: tuple[float, float], legs: tuple[str, ...], random: np.random.Generator
) -> TwinEffect:
    share = float(random.uniform(*span))
    leg = legs[int(random.integers(len(legs)))] if kind.scope == LEG else ""
    values = tuple(_size(parameter, share, random) for parameter in kind.parameters)
    return TwinEffect(kind.name, leg, values)


def _size(p: EffectParameter, share: float, random: np.random.Generator) -> float:
    value = p.mild + share * (p.strong - p.mild)
    if p.low == -p.high and p.neutral == 0.0 and random.random() < 0.5:
        value = -value
    return float(np.clip(value, p.low, p.high))
