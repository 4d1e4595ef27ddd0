"""Bad files and arguments give one line and an exit code, never a traceback, whatever is wrong in them."""

import io
import math
import os
import random
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from mcap.reader import NonSeekingReader
from mcap.writer import Writer

from model.errors import RecordError
from robot.campaign.case import parse_labels, read_answer
from robot.campaign.visible import measure_visibility
from robot.cli.main import run
from robot.run.gait_texts import GAIT_FILES_KEY, gaits_of_log
from robot.run.header import CALIBRATIONS_KEY
from robot.run.rebuilt import calibrations_of
from robot.study.figures_runtime import read_benchmark

BAD_TOML = {
    "nested": "a = " + "[" * 5000 + "]" * 5000,
    "dotted": ".".join("a" * 300) + " = 1",
    "digits": f"a = {'1' * 5000}",
    "huge": f"name = 'x'\n[body]\nmass = {'1' * 400}",
}
READERS = (
    ("drive", "--robot", "FILE"),
    ("drive", "--calibration", "FILE"),
    ("drive", "--scenario", "FILE"),
    ("servo", "restore", "FILE", "--port", "/dev/null"),
    ("import", "TABLE", "--map", "FILE"),
)


def one_line(words: list[str], capsys: pytest.CaptureFixture[str]) -> tuple[int, str]:
    """Run a command; return its exit code and the one line that it said on stderr."""
    try:
        code = run(words)
    except SystemExit as end:
        code = int(end.code or 0)
    said = capsys.readouterr().err.strip().splitlines()
    lines = [line for line in said if not line.startswith("compiling")]
    assert len(lines) == 1 or lines[0].startswith("usage:"), lines
    return code, lines[-1]


@pytest.mark.parametrize("words", READERS, ids=lambda words: " ".join(words))
@pytest.mark.parametrize("kind", [*BAD_TOML, "no text", "endless", "pipe"])
def test_a_bad_toml_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], words: tuple[str, ...], kind: str
) -> None:
    path, table = tmp_path / "bad.toml", tmp_path / "table.csv"
    table.write_text("t\n0\n1\n")
    if kind == "endless":
        path = Path("/dev/zero")
    elif kind == "pipe":
        os.mkfifo(path)
    elif kind == "no text":
        path.write_bytes(b"a = '\x9b'")
    else:
        path.write_text(BAD_TOML[kind])
    given = {"FILE": str(path), "TABLE": str(table)}
    code, line = one_line([given.get(word, word) for word in words], capsys)
    assert code in ({2, 4} if words[0] == "import" else {2}), line
    assert path.name in line


BAD_JSON = {
    "nested": b"[" * 100_000,
    "deep": b'{"verdict":' * 900 + b"1" + b"}" * 900,
    "digits": b'{"verdict": ' + b"1" * 5000 + b"}",
    "surrogate": b'{"verdict": "\\ud83e", "gap": {}, "causes": []}',
    "no text": b'{"verdict": "\x9b"}',
}


@pytest.mark.parametrize(
    "words",
    [
        ("gap", "next", "FILE", "--json"),
        ("gap", "apply", "FILE", "--out", "OUT", "--anyway"),
        ("bringup", "--hardware", "virtual", "--folder", "FOLDER"),
    ],
    ids=lambda words: " ".join(words[:2]),
)
@pytest.mark.parametrize("kind", BAD_JSON)
def test_a_bad_json_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], words: tuple[str, ...], kind: str
) -> None:
    path = tmp_path / ("first_day.json" if words[0] == "bringup" else "bad.json")
    path.write_bytes(BAD_JSON[kind])
    given = {"FILE": str(path), "FOLDER": str(tmp_path), "OUT": str(tmp_path / "new.toml")}
    code, line = one_line([given.get(word, word) for word in words], capsys)
    assert code in ({2} if words[0] == "bringup" else {1, 2, 4}), line
    assert path.name in line


@pytest.mark.parametrize("words", [["show"], ["log", "info"], ["odom"], ["odom", "--live"]])
def test_a_log_that_is_no_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], words: list[str]
) -> None:
    os.mkfifo(tmp_path / "pipe.mcap")
    for path in (tmp_path / "pipe.mcap", Path("/dev/zero")):
        code, line = one_line([*words, str(path)], capsys)
        assert code == 4
        assert "not a file" in line


@pytest.mark.parametrize(
    "words",
    [
        ["drive", "--log", "a\0b.mcap"],
        ["show", "a\0b.mcap"],
        ["odom", "--live", "--duration", "nan", "a.mcap"],
    ],
)
def test_arguments_that_make_no_sense(capsys: pytest.CaptureFixture[str], words: list[str]) -> None:
    assert one_line(words, capsys)[0] == 2


def with_messages(
    source: Path, out: Path, change: Mapping[int, bytes], most: float = math.inf
) -> None:
    """Copy a log, ``most`` of its ticks, with other bytes in some by their number; checksums are right."""
    with source.open("rb") as stream, out.open("wb") as file:
        reader, writer = NonSeekingReader(stream), Writer(file)
        writer.start(profile="ros2", library="bigant")
        schemas: dict[int, int] = {}
        channels: dict[int, int] = {}
        data = source.read_bytes()
        for one in NonSeekingReader(io.BytesIO(data)).iter_metadata():
            writer.add_metadata(one.name, one.metadata)
        for a in NonSeekingReader(io.BytesIO(data)).iter_attachments():
            writer.add_attachment(a.create_time, a.log_time, a.name, a.media_type, a.data)
        ticks = 0
        for schema, channel, message in reader.iter_messages():
            assert schema is not None
            if schema.id not in schemas:
                schemas[schema.id] = writer.register_schema(
                    schema.name, schema.encoding, schema.data
                )
            if channel.id not in channels:
                channels[channel.id] = writer.register_channel(
                    channel.topic, channel.message_encoding, schemas[schema.id], channel.metadata
                )
            body = message.data
            if channel.topic == "/bigant/tick":
                if ticks >= most:
                    break
                body, ticks = change.get(ticks, body), ticks + 1
            writer.add_message(
                channels[channel.id], message.log_time, body, message.publish_time, message.sequence
            )
        writer.finish()  # type: ignore[no-untyped-call]


def tick_bytes(source: Path) -> list[bytes]:
    """Return the messages of the ticks."""
    with source.open("rb") as stream:
        messages = NonSeekingReader(stream).iter_messages(topics=["/bigant/tick"])
        return [message.data for _, _, message in messages]


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("log") / "run.mcap"
    words = ["drive", "--virtual-time", "--duration", "0.5", "--record-bytes", "--log", str(path)]
    assert run(words) == 0
    return path


@pytest.fixture(scope="module")
def short_log(log: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The first ticks of it, more than the ones that are damaged."""
    path = tmp_path_factory.mktemp("short_log") / "run.mcap"
    with_messages(log, path, {}, 45)
    return path


TICK_READERS = (
    ["replay"],
    ["replay", "--bus"],
    ["odom", "--live"],
    ["log", "info"],
    ["show", "--json"],
)
DAMAGED = [
    # the first tick, and a later one, which for the others is damaged in make soak
    pytest.param(
        words, number, id=f"{' '.join(words)}-{number}",
        marks=pytest.mark.soak if number and words != TICK_READERS[0] else (),
    )
    for words in TICK_READERS
    for number in (0, 40)
]  # fmt: skip


@pytest.mark.parametrize(("words", "number"), DAMAGED)
def test_a_damaged_tick_that_its_checksum_does_not_show(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    short_log: Path,
    words: list[str],
    number: int,
) -> None:
    whole = tick_bytes(short_log)[number]
    dice = random.Random(number + 3)
    for turn in range(4):
        data = bytearray(whole[: len(whole) // 2] if turn == 0 else whole)
        for _ in range(1 + turn % 3):
            data[dice.randrange(4, len(data))] = dice.randrange(256)
        with_messages(short_log, tmp_path / "bad.mcap", {number: bytes(data)})
        assert run([*words, str(tmp_path / "bad.mcap")]) in {0, 1, 4}
    capsys.readouterr()


def test_odometry_with_a_robot_of_other_legs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], log: Path
) -> None:
    eight = Path(__file__).parents[3] / "examples" / "octopod.toml"
    code, line = one_line(["odom", str(log), "--robot", str(eight)], capsys)
    assert code == 2
    assert "legs" in line


def test_a_robot_that_the_simulator_cannot_build(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (Path(__file__).parents[3] / "config" / "bigant.toml").read_text()
    lines = [
        "inertia = [1e-9, 1e-9, 1e-9]" if line.startswith("inertia") else line
        for line in text.splitlines()
    ]
    (tmp_path / "light.toml").write_text("\n".join(lines))
    words = ["sim", "run", "--fast", "--robot", str(tmp_path / "light.toml")]
    code, line = one_line([*words, "--out", str(tmp_path / "a.csv")], capsys)
    assert code == 2
    assert "inertia" in line


@pytest.mark.parametrize("kind", BAD_JSON)
def test_bad_json_that_is_kept_for_another_time(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "seen.json"
    path.write_bytes(BAD_JSON[kind])
    with pytest.raises(RecordError):
        read_answer(path)
    with pytest.raises(RecordError):
        read_benchmark(path)
    with pytest.raises(RecordError):
        measure_visibility((), {}, None, tmp_path, ThreadPoolExecutor(1), ())
    if kind != "no text":
        text = BAD_JSON[kind].decode()
        with pytest.raises(RecordError):
            parse_labels(text, "labels.json")
        with pytest.raises(RecordError):
            gaits_of_log({GAIT_FILES_KEY: text})
        with pytest.raises(RecordError):
            calibrations_of({CALIBRATIONS_KEY: text}, ())
