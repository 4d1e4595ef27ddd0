"""``bigant completion``: the script that shtab writes of the parser, and where it belongs."""

import argparse
from collections.abc import Iterator, Sequence
from importlib.util import find_spec

from gaits.catalog import gait_names
from model.errors import ConfigError
from robot.config.robot_file import load_robot
from robot.console.arguments import path_of
from robot.console.exit_codes import ExitCode
from robot.console.installed import how_to_install
from robot.requests.single import CompletionRequest

PACKAGE = "shtab"
INSTALLED = {
    "bash": "bigant completion bash > ~/.local/share/bash-completion/completions/bigant",
    "zsh": "bigant completion zsh > ~/.zfunc/_bigant   # with fpath+=~/.zfunc before compinit",
    "fish": "bigant completion fish > ~/.config/fish/completions/bigant.fish",
}


def completion(request: CompletionRequest) -> ExitCode:
    """Print the script.

    Raises:
        ConfigError: The package that writes it is missing.
    """
    print(script_for(request.shell))
    return ExitCode.OK


def script_for(shell: str) -> str:
    """Return the completion script of a shell.

    Raises:
        ConfigError: The package that writes it is missing, or the robot file cannot be used.
    """
    if find_spec(PACKAGE) is None:
        raise ConfigError(
            "shell completion",
            "the package that writes the script is not installed; install it with: "
            f"{how_to_install('completion')} (see docs/howto.md#shell-completion)",
        )
    import shtab

    from robot.cli.main import full_parser

    parser = full_parser()
    _mark_files(parser, shtab.FILE)
    _mark_gaits(parser, gait_names(load_robot().parameters))
    text: str = shtab.complete(parser, shell)
    first, rest = text.split("\n", 1) if text.startswith("#") else ("", text)
    note = f"# Install with: {INSTALLED[shell]}"
    return "\n".join(line for line in (first, note, rest) if line)


def _mark_files(parser: argparse.ArgumentParser, files: object) -> None:
    """Tell shtab which arguments are names of files: those that argparse turns into a path."""
    for action in _actions(parser):
        if action.type is path_of or action.dest in {"log", "hardware", "port"}:
            action.complete = files  # type: ignore[attr-defined]


def _mark_gaits(parser: argparse.ArgumentParser, names: Sequence[str]) -> None:
    """Offer the gaits of the robot file that is there now; which ones a command takes is its robot's."""
    for action in _actions(parser):
        if action.dest == "gait":
            action.choices = names


def _actions(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    """Arguments of a parser and of the commands below it."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for child in action.choices.values():
                yield from _actions(child)
        else:
            yield action
