"""How visible effects are, told by a campaign's controls; and what their true values would close."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from gap.check.cases import CONTROL, SINGLE, Truth
from gap.interfaces import Cause
from record.trial.trial import write_trial
from robot.campaign.case import CaseFiles, Label
from robot.campaign.visible import FEWEST_CONTROLS, measure_visibility
from tests.gap.walks import cause, walk

HERE = ThreadPoolExecutor(1)
LONGER = cause("leg_length", -0.004, legs=("MR",))


def written(folder: Path, name: str, effects: list[Cause], seed: int) -> CaseFiles:
    """A case of two short walks, as a campaign keeps it."""
    paths = []
    for at, gait in enumerate(("tripod", "metachronal")):
        path = folder / name / f"trial_{at + 1}.parquet"
        path.parent.mkdir(parents=True, exist_ok=True)
        write_trial(walk(gait, 0.2, 6.0, effects, noise_seed=10 * seed + at), path)
        paths.append(path)
    return CaseFiles(name, tuple(paths), ())


def test_controls_tell_what_is_visible_without_walking_anything_again(tmp_path: Path) -> None:
    files = [written(tmp_path, f"c{i}", [], i) for i in range(FEWEST_CONTROLS)]
    files.append(written(tmp_path, "x", [LONGER], 20))
    labels = {one.name: Label(CONTROL, (), 0, (1, 2)) for one in files}
    truth = Truth("leg_length", "support", "MR", (("offset_m", -0.004),))
    labels["x"] = Label(SINGLE, (truth,), 0, (1, 2))
    seen = measure_visibility(files, labels, None, tmp_path, HERE, ())
    assert set(seen) == {"x"}
    assert seen["x"].visible > 10
    assert seen["x"].reachable > 0.9
    # kept, and not asked again
    assert measure_visibility(files, {}, None, tmp_path, HERE, ()) == seen


def test_few_controls_tell_nothing(tmp_path: Path) -> None:
    labels = {"c": Label(CONTROL, (), 0, (1,)), "x": Label(SINGLE, (), 0, (1,))}
    assert measure_visibility([], labels, None, tmp_path, HERE, ()) == {}
    # controls that were not walked tell nothing either
    away = {f"c{i}": Label(CONTROL, (), 0, (1,)) for i in range(FEWEST_CONTROLS)}
    assert measure_visibility([], away, None, tmp_path, HERE, ()) == {}
