"""Cutting a piece out of a log, and putting logs of one robot one behind the other."""

from itertools import pairwise
from pathlib import Path

from mcap.records import Attachment, Message, Metadata

from model.errors import ConfigError, RecordError
from record.log.damage import Pass
from record.log.rewrite import Rewritten, log_copy
from record.log.salvage import read_records
from record.log.survey import LogSurvey, survey_log
from record.log.writer import CONFIG_NAME, METADATA_NAME, NAMES_KEY, START_KEY, START_UNIX_KEY

# These hold for the merged log as a whole, and are those of its first part.
_OF_THE_FIRST = frozenset({NAMES_KEY, START_KEY, START_UNIX_KEY})


def cut_log(
    path: Path, out: Path, *, from_s: float, to_s: float, progress: Pass | None = None
) -> Rewritten:
    """Copy the messages of a span of time. Times stay those of the run: the piece begins at ``from_s``.

    Args:
        path: The log.
        out: The file to write.
        from_s: First time kept, since the beginning of the run.
        to_s: First time not kept; may be infinite.
        progress: Filled on the way.

    Raises:
        ConfigError: The span is empty.
        RecordError: Nothing lies in it, or a file cannot be read or written.
    """
    if not from_s < to_s:
        raise ConfigError("--to", f"{to_s:g} s must lie after --from {from_s:g} s")
    done = progress or Pass()
    start_ns: int | None = None
    first_s = last_s = float("nan")
    with log_copy(out, (path,)) as copy:
        for record in read_records(path, done):
            if isinstance(record, Metadata) and record.name == METADATA_NAME:
                text = record.metadata.get(START_UNIX_KEY, "")
                start_ns = int(text) if text.isdecimal() else start_ns
            if isinstance(record, Message):
                start_ns = record.log_time if start_ns is None else start_ns
                at_s = (record.log_time - start_ns) * 1e-9
                first_s, last_s = at_s if first_s != first_s else first_s, at_s
                if not from_s <= at_s < to_s:
                    continue
            copy.add(record)
        if copy.messages == 0:
            raise RecordError(
                f"{path} has no data from {from_s:g} to {to_s:g} s; it covers {first_s:.2f} to "
                f"{last_s:.2f} s"
            )
    return Rewritten(copy.messages, tuple(done.damages))


def merge_logs(paths: tuple[Path, ...], out: Path, progress: Pass | None = None) -> Rewritten:
    """Put logs of one robot one behind the other, in order of time; gaps between them stay.

    The ticks stay as they are, with the clock and the numbers of their own run; times of the merged log
    are those of its first part, by UNIX time.

    Args:
        paths: The logs, in any order.
        out: The file to write.
        progress: Filled on the way, again for each log.

    Raises:
        ConfigError: There is only one.
        RecordError: They are of different robots or overlap, or a file cannot be read or written.
    """
    if len(paths) < 2:
        raise ConfigError("LOG", "merging needs two logs or more")
    parts = sorted((survey_log(path) for path in paths), key=lambda part: part.first_unix_ns)
    for first, second in pairwise(parts):
        _check_fit(first, second)
    done = progress or Pass()
    damages = tuple(damage for part in parts for damage in part.damages)
    with log_copy(out, paths) as copy:
        for number, part in enumerate(parts):
            copy.begin_source()
            done.position, done.finished = 0, False
            done.damages.clear()
            for record in read_records(part.path, done):
                if isinstance(record, Metadata) and record.name == METADATA_NAME:
                    if number == 0:
                        copy.add(Metadata(METADATA_NAME, _merged_metadata(parts)))
                    continue
                if isinstance(record, Attachment) and record.name == CONFIG_NAME and number:
                    continue  # the same robot file as that of the first
                copy.add(record)
    return Rewritten(copy.messages, damages)


def _check_fit(first: LogSurvey, second: LogSurvey) -> None:
    for key, words in (("robot", "robots"), (NAMES_KEY, "legs")):
        one, other = first.metadata.get(key, ""), second.metadata.get(key, "")
        if one != other:
            raise RecordError(
                f"{first.path} and {second.path} are of different {words} ({one or '?'}, "
                f"{other or '?'}); only logs of one robot can be merged"
            )
    if first.config_text != second.config_text:
        raise RecordError(
            f"{first.path} and {second.path} were made with different robot files; a log has one, "
            "so they cannot be merged"
        )
    overlap_s = (first.last_unix_ns - second.first_unix_ns) * 1e-9
    if overlap_s >= 0:
        raise RecordError(
            f"{first.path} and {second.path} overlap by {overlap_s:.2f} s; trim one of them first "
            "(bigant log trim)"
        )


def _merged_metadata(parts: list[LogSurvey]) -> dict[str, str]:
    merged = dict(parts[0].metadata)
    for key in sorted({key for part in parts for key in part.metadata} - _OF_THE_FIRST):
        values = dict.fromkeys(part.metadata.get(key, "") for part in parts)
        merged[key] = ", ".join(value for value in values if value)
    merged["merged"] = ", ".join(part.path.name for part in parts)
    return dict(sorted(merged.items()))
