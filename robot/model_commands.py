"""``bigant model``: the model on its own, without a robot. Parsing only."""

import argparse
import importlib

from robot.exit_codes import ExitCode

# action -> its module (which has ``add_arguments`` and ``run``), and what it is for
ACTIONS = (
    ("run", "robot.model_run", "a named system through the model, with a picture"),
    ("sensitivity", "robot.model_sensitivity", "naive against fitted parameters on logs"),
    ("figures", "robot.model_figures", "our version of the paper's figures and tables"),
)


def add_model(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the command to the parser."""
    model = commands.add_parser("model", help="the model of slipping, without a robot")
    actions = model.add_subparsers(dest="action", required=True, metavar="ACTION")
    for name, module, words in ACTIONS:
        parser = actions.add_parser(name, help=words)
        importlib.import_module(module).add_arguments(parser)


def run_model(options: argparse.Namespace) -> ExitCode:
    """Run the action that was asked for."""
    module = next(module for name, module, _ in ACTIONS if name == options.action)
    code: ExitCode = importlib.import_module(module).run(options)
    return code
