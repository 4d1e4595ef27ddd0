"""``bigant sim unseal``: open the labels of a sealed campaign, for scoring.

Checks the published hashes, then prints the labels or writes them to --out (.toml or .json).
"""

import argparse
from pathlib import Path

from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    parser.add_argument("folder", type=Path, metavar="DIR")
    parser.add_argument("--key", type=Path, required=True, metavar="FILE")
    parser.add_argument(
        "--out", type=Path, metavar="FILE", help=".toml or .json (default: print TOML)"
    )
    parser.add_argument("--json", action="store_true", help="print JSON")


def run(options: argparse.Namespace) -> ExitCode:
    """Open the seal.

    Raises:
        ConfigError: The key file or --out cannot be used.
        RecordError: The labels cannot be opened.
    """
    from model.errors import ConfigError
    from robot.campaign.seal import labels_toml, read_key, unseal

    out: Path | None = options.out
    if out is not None and out.suffix not in {".toml", ".json"}:
        raise ConfigError("--out", f"must end in .toml or .json, not {out}")
    labels = unseal(options.folder, read_key(options.key))
    as_json = options.json if out is None else out.suffix == ".json"
    text = labels.text if as_json else labels_toml(labels)
    if out is None:
        print(text, end="")
        return ExitCode.OK
    try:
        out.write_text(text, encoding="utf-8")
    except OSError as error:
        raise ConfigError("--out", f"{out} cannot be written: {error.strerror}") from error
    print(f"labels: {out}")
    return ExitCode.OK
