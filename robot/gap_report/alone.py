"""``bigant gap diagnose --alone``: how much of the gap each effect could explain alone."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict

from gap.diagnosis.alone import Alone, each_alone
from gap.interfaces import Cause, Effect
from model.errors import ConfigError
from robot.console.exit_codes import ExitCode
from robot.console.json_output import give_json, to_stdout
from robot.console.progress import ProgressBar
from robot.console.table import Column, table_lines
from robot.gap_report.split import with_hold_out
from robot.gap_report.trials import read_runs
from robot.gap_report.words import parameters_of
from robot.requests.gap import CHAIN, GapDiagnoseRequest

TABLE = (
    Column("", width=40), Column("", ".4g", 9), Column(""), Column(""), Column("", ".0%", 4), Column(""),
)  # fmt: skip


def fit_alone(request: GapDiagnoseRequest) -> ExitCode:
    """Fit each effect by itself, or several joined with +, and judge it on the held-out runs.

    Raises:
        RecordError: A trial cannot be read.
        GapError: The trials cannot be compared with a simulator, or an effect is not known.
        ConfigError: Options of a whole diagnosis were given.
    """
    whole = {
        "--reference": request.reference,
        "--html": request.html,
        "--sim": request.sim != CHAIN,
    }
    if wrong := [name for name, value in whole.items() if value]:
        raise ConfigError(
            wrong[0],
            "does not go with --alone, which fits each effect by itself; leave one of them out",
        )
    runs = read_runs(request.trials, (), request.robot, request.joint, request.machine)
    runs = with_hold_out(runs, request.trials, request.hold_out)
    trials, simulator = runs.trials, runs.simulator(request.effects)
    effects = {effect.name: effect for effect in simulator.effects}
    sets = [tuple(text.split("+")) for text in request.effect] or [(name,) for name in effects]
    with ProgressBar("alone") as bar:
        fits = each_alone(trials, simulator, sets, bar.tell, runs.hold_out)
    result = [_as_json(one, effects) for one in fits]
    if not to_stdout(request.json):
        print("\n".join(_lines(fits, effects)))
    give_json(result, request.json)
    return ExitCode.OK


def _lines(fits: Sequence[Alone], effects: Mapping[str, Effect]) -> Iterator[str]:
    for at, first in enumerate(fits[0].channels):
        low, high = first.before_range
        yield (
            f"{first.channel} {first.joint}".rstrip()
            + f": RMS {first.before:.4g} [{low:.4g}, {high:.4g}] {first.unit} on the held-out runs"
        )
        rows = []
        for one in sorted(fits, key=lambda a: a.channels[at].after):
            c = one.channels[at]
            low, high = c.after_range
            own = [cause for cause in one.causes if c.joint in cause.joints or not cause.joints]
            interval = f"[{low:.4g}, {high:.4g}]"
            rows.append(
                ("+".join(one.effects), c.after, interval, "cut", c.cut, _sizes(own, effects))
            )
        yield from table_lines(TABLE, rows, "  ")


def _sizes(causes: Sequence[Cause], effects: Mapping[str, Effect]) -> str:
    return ", ".join(
        f"{name} {value:.3g}"
        for cause in causes
        for name, value in parameters_of(cause, effects).items()
    )


def _as_json(one: Alone, effects: Mapping[str, Effect]) -> dict[str, object]:
    return {
        "effects": one.effects,
        "causes": [
            {
                "effect": cause.effect,
                "joints": cause.joints,
                "parameters": parameters_of(cause, effects),
            }
            for cause in one.causes
        ],
        "channels": [{**asdict(c), "cut": c.cut} for c in one.channels],
    }
