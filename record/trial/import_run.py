"""Bringing a run in from wherever it lies: tables of one file, or topics of a ROS 2 bag, put together."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from model.errors import RecordError
from record.topics import TICK_TOPIC
from record.trial.clock_alignment import Predicted, align
from record.trial.column_map import ColumnMap, OtherFile, Source
from record.trial.cut import Cut
from record.trial.derive import with_speeds
from record.trial.header import LEGGED, TrialHeader
from record.trial.import_table import Imported, completed, import_part, import_tables
from record.trial.joined import joined
from record.trial.ros_bag import (
    IMU_MESSAGE,
    JOINT_STATE,
    POSES,
    READ,
    WRENCH,
    Bag,
    BagMap,
    bag_columns,
    chosen_topics,
    is_bag,
    joints_on,
    open_bag,
)
from record.trial.source_tables import ARRAYS, SourceTable, open_tables
from record.trial.table_check import TableFinding
from record.trial.table_file import DataTable
from record.trial.trial import trial_table

STAMP = "{}:stamp"
EARLIEST_UNIX_S = (
    1e8  # times as large as this are UNIX time, of which a trial keeps what has passed
)


def import_run(
    path: Path,
    given: ColumnMap,
    tell: Callable[[float], None] = lambda _: None,
    predicted: Predicted | None = None,
) -> Iterator[Imported]:
    """Read every trial that a file or a bag holds.

    Args:
        path: As for ``import_tables``, or a ROS 2 bag.
        given: Which of its columns or topics is which.
        tell: Told which share of it has been taken.
        predicted: What the model of the run's machine makes of its shafts, to align other files' clocks.

    Raises:
        RecordError: It cannot be read, nothing in it is known, or a clock cannot be aligned.
    """
    if not is_bag(path) and not given.files:
        yield from import_tables(path, given, tell)
        return
    if is_bag(path):
        with open_bag(path) as bag:
            _refuse_own_log(bag, given)
            one = _import_bag(bag, given, tell)
    else:
        (one,) = _parts(path, given, tell)
    for other in given.files:
        one = _with_file(one, other, predicted)
    yield completed(one)


def _refuse_own_log(bag: Bag, given: ColumnMap) -> None:
    """Refuse a log of ours, whose topics hold less than it does, unless a map asks for topics."""
    own = any(topic.name == TICK_TOPIC for topic in bag.topics)
    if own and given.bag == BagMap():
        raise RecordError(
            f"{bag.path} is a log already: show, odom and gap take it as it is, and "
            "bigant log export --format trial makes a table of it; --topics takes topics of it anyway"
        )


def _parts(path: Path, given: ColumnMap, tell: Callable[[float], None]) -> tuple[Imported, ...]:
    if path.suffix != ARRAYS:
        path = trial_table(path)
    with open_tables(path, given) as tables:
        if len(tables) > 1:
            raise RecordError(f"{path} holds several tables; [file] of a map is for one")
        return tuple(import_part(path, one, given, tell) for one in tables)


def _with_file(one: Imported, other: OtherFile, predicted: Predicted | None) -> Imported:
    """Return a run with what another file of it measured, on the run's clock."""
    if one.trial is None:
        return one
    path = one.report.path.parent / other.path.replace("{name}", one.report.path.stem)
    given = replace(other.columns, header=one.trial.header)
    (part,) = _parts(path, given, lambda _: None)
    if part.trial is None:
        return one
    with_rates, _ = with_speeds(one.trial)
    clock = align(with_rates, part.trial, other.clock, predicted)
    finding = TableFinding("clock", other.name, part.report.kept, 0, f"{path.name}: {clock.words}")
    part = replace(part, report=replace(part.report, name=other.name))
    whole = together(one, part, clock.later_s)
    assert whole.trial is not None, "both have one"
    header = whole.trial.header
    derived = (*header.derived, f"clock of {other.name}: {clock.words}")
    trial = replace(whole.trial, header=replace(header, derived=derived))
    return Imported(trial, replace(whole.report, findings=(finding, *whole.report.findings)))


def _import_bag(bag: Bag, given: ColumnMap, tell: Callable[[float], None]) -> Imported:
    header = given.header or TrialHeader(LEGGED, ())
    topics = chosen_topics(bag, given.bag, header.names.legs)
    tables: dict[str, DataTable] = {}
    if not header.joints and topics.joints:  # no machine's file: the bag names its joints
        tables[topics.joints] = bag.table(bag.topic(topics.joints, (JOINT_STATE,)))
        ours = {theirs: joint for joint, theirs in topics.names.items()}
        joints = tuple(ours.get(name, name) for name in joints_on(tables[topics.joints]))
        header = replace(header, joints=joints)
        topics = chosen_topics(bag, topics, header.names.legs)
    named = (source.theirs.partition(":")[0] for source in given.sources)
    all_topics = (
        topics.joints,
        topics.commands,
        topics.pose,
        topics.imu,
        *topics.forces.values(),
        *named,
    )
    wanted = [name for name in dict.fromkeys(all_topics) if name]
    if not wanted:
        raise RecordError(
            f"nothing in {bag.path} says what it is: name topics in the map's [bag]; {bag.listing()}"
        )
    kinds = {
        **dict.fromkeys(topics.forces.values(), (WRENCH,)),
        **dict.fromkeys((topics.joints, topics.commands), (JOINT_STATE,)),
        topics.pose: POSES,
        topics.imu: (IMU_MESSAGE,),
    }
    for number, name in enumerate(wanted):
        tell(0.8 * number / len(wanted))
        if name not in tables:
            frames = topics.frames if name == topics.pose else ()
            tables[name] = bag.table(bag.topic(name, kinds.get(name, READ)), frames)
    parts = _topic_sources(tables, topics, given, header)
    base = max(parts, key=lambda name: (name == topics.joints, tables[name].rows))
    order = sorted(parts, key=lambda name: name != base)
    whole: Imported | None = None
    for name in order:
        source = SourceTable(name, tables[name])
        part = replace(given, header=header, sources=tuple(parts[name]), cut=Cut())
        one = import_part(bag.path, source, part, lambda _: None)
        whole = one if whole is None else together(whole, one)
    assert whole is not None, "there is at least one topic"
    findings = (*_listed(bag, parts), *whole.report.findings)
    return Imported(whole.trial, replace(whole.report, name="", findings=findings))


def _topic_sources(
    tables: Mapping[str, DataTable], topics: BagMap, given: ColumnMap, header: TrialHeader
) -> dict[str, list[Source]]:
    """Return what each topic gives; what [columns] names goes before what [bag] names."""
    mapped = {source.ours for source in given.sources}
    chosen = [
        Source(ours, theirs)
        for ours, theirs in bag_columns(tables, topics, header.joints)
        if ours not in mapped
    ]
    parts: dict[str, list[Source]] = {}
    for source in (*given.sources, *chosen):
        parts.setdefault(source.theirs.partition(":")[0], []).append(source)
    if topics.joints and topics.joints not in parts:
        has = ", ".join(joints_on(tables[topics.joints]))
        raise RecordError(
            f"no joint on {topics.joints} is called as ours ({', '.join(header.joints)}); it has {has}: "
            "say which is which in the map's [bag.names]"
        )
    for name, sources in parts.items():
        sources.append(Source("time_s", STAMP.format(name)))
    return parts


def _listed(bag: Bag, parts: Mapping[str, Sequence[Source]]) -> Iterator[TableFinding]:
    """List the topics of a bag, and what became of each."""
    for topic in bag.topics:
        what = f"{topic.kind}, {topic.messages} messages"
        if topic.name in parts:
            ours = ", ".join(one.ours for one in parts[topic.name] if one.ours != "time_s")
            yield TableFinding("read", topic.name, topic.messages, 0, f"{what}: {ours}")
        elif topic.kind in READ:
            advice = "its joints" if topic.kind == JOINT_STATE else "it"
            words = f"{what}: not read; name {advice} in the map's [bag] if it is of the run"
            yield TableFinding("ignored", topic.name, topic.messages, 0, words)


def together(base: Imported, other: Imported, later_s: float = 0.0) -> Imported:
    """Return one run of two of its parts, on the times of the first; see ``joined``."""
    if base.trial is None or other.trial is None:
        return base
    name = other.report.name
    findings = tuple(
        finding
        if finding.kind != "ignored"
        else replace(finding, detail="a field that no column has")
        for finding in other.report.findings
    )
    dropped = tuple(replace(row, reason=f"{name}: {row.reason}") for row in other.report.dropped)
    report = replace(
        base.report,
        columns=tuple(dict.fromkeys([*base.report.columns, *other.report.columns])),
        # what is so of several topics is said once
        findings=tuple(dict.fromkeys((*base.report.findings, *findings))),
        dropped=(*base.report.dropped, *dropped),
    )
    return Imported(joined(base.trial, other.trial, later_s), report)
