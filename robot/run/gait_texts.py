"""The Python file of a gait in the log of its run: kept as text, and run again only if a person says so."""

import json
from collections.abc import Mapping
from dataclasses import asdict, replace
from pathlib import Path

from model.errors import ConfigError, RecordError
from model.values.parameters import PluginParameters, RobotParameters
from record.json_text import parse_json
from robot.config.gait_file import read_gait_file, with_plugin
from robot.config.robot_file import RobotConfig

GAIT_FILES_KEY = "gait_files"
RECORDED = "recorded"  # --gait recorded: run the text that is in the log


def gait_metadata(robot: RobotParameters) -> dict[str, str]:
    """Return what a log keeps of the gaits that Python files gave; nothing if there were none."""
    plugins = [gait for gait in robot.gaits if isinstance(gait, PluginParameters)]
    texts = [asdict(replace(one, file=Path(one.file).name)) for one in plugins]
    return {GAIT_FILES_KEY: json.dumps(texts)} if texts else {}


def gaits_of_log(metadata: Mapping[str, str]) -> tuple[PluginParameters, ...]:
    """Return the gaits of Python files that a log's run had; nothing of them is run.

    Raises:
        RecordError: The metadata are damaged.
    """
    try:
        return tuple(
            PluginParameters(str(one["name"]), str(one["file"]), str(one["text"]))
            for one in parse_json(metadata.get(GAIT_FILES_KEY, "[]"))
        )
    except (ValueError, TypeError, KeyError) as error:
        raise RecordError(
            f"the log's {GAIT_FILES_KEY} cannot be read ({error}): it is damaged, or newer than this "
            "software"
        ) from error


def with_gaits_of_log(
    config: RobotConfig, metadata: Mapping[str, str], allowed: str | None
) -> tuple[RobotConfig, tuple[str, ...]]:
    """Return the robot of a log with the gaits of Python files that its run had, and notes on them.

    Args:
        config: Robot file in use.
        metadata: Of the log.
        allowed: A file to be run in place of the recorded text, ``recorded`` to run that text, or None.

    Raises:
        RecordError: The run had such a gait, and nobody said what may be run.
        ConfigError: A file is given for a run that had none, or it gives no gait.
    """
    recorded = gaits_of_log(metadata)
    if not recorded:
        if allowed is not None:
            raise ConfigError("--gait", "this run had no gait of a Python file; leave it out")
        return config, ()
    if allowed is None:
        files = " and ".join(one.file for one in recorded)
        raise RecordError(
            f"the run had the gait of a Python file, {files}; its text is in the log (bigant log info "
            f"LOG --json). To run that text add --gait {RECORDED} if you trust its author; to run your own "
            "copy name it with --gait FILE.py"
        )
    if allowed == RECORDED:
        for one in recorded:
            config = with_plugin(config, replace(one, file=f"{one.file} in the log"))
        return config, (
            f"the gait's text in the log was run: {', '.join(o.file for o in recorded)}",
        )
    own = read_gait_file(Path(allowed))
    if len(recorded) > 1:
        names = ", ".join(one.file for one in recorded)
        raise ConfigError(
            "--gait", f"the run had several gait files, {names}; use --gait {RECORDED}"
        )
    config = with_plugin(config, replace(own, name=recorded[0].name))
    same = own.text == recorded[0].text
    return config, () if same else (f"{allowed} is not the text that was walked",)
