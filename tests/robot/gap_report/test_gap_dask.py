"""``bigant gap diagnose --dask``: the same answer from a cluster, and one sentence where there is none."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from robot.cli import main as cli
from robot.console import cluster
from tests.test_examples import EXAMPLES

REASON = "pip install -e '.[dask]'"


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The log of the tutorial's arm, and its model."""
    folder = tmp_path_factory.mktemp("arm")
    code = (
        "import runpy; arm = runpy.run_path(r'{}'); from pathlib import Path\n"
        "Path('arm.xml').write_text(arm['MODEL']); Path('arm_map.toml').write_text(arm['MAP'])\n"
        "Path('arm_log.csv').write_text('\\n'.join(arm['log_of_the_real_arm']()) + '\\n')\n"
    ).format(EXAMPLES / "own_arm.py")
    env = {**os.environ, "PYTHONPATH": str(EXAMPLES.parent)}
    subprocess.run([sys.executable, "-c", code], cwd=folder, env=env, check=True)
    table, out = folder / "arm_log.csv", folder / "arm.parquet"
    assert (
        cli.run(["import", str(table), "--map", str(folder / "arm_map.toml"), "--out", str(out)])
        == 0
    )
    return out


def test_a_cluster_that_is_not_there_and_options_that_do_not_go_with_one_are_said(
    arm: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("distributed", reason=REASON)
    monkeypatch.setattr(cluster, "CONNECT_S", 0.2)
    line = ["gap", "diagnose", str(arm), "--dask", "tcp://127.0.0.1:9"]
    assert cli.run(line) == 2
    assert "--dask: nothing answers at tcp://127.0.0.1:9" in capsys.readouterr().err
    for other in (["--alone"], ["--sim", "mujoco"]):
        assert cli.run([*line, *other]) == 2
        assert "it goes neither with --alone nor with --sim mujoco" in capsys.readouterr().err


@pytest.mark.thorough
def test_a_cluster_answers_as_one_computer(
    arm: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    distributed = pytest.importorskip("distributed", reason=REASON)
    line = ["gap", "diagnose", str(arm), "--json"]
    assert cli.run([*line, str(tmp_path / "here.json"), "--jobs", "1"]) == 0
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address="127.0.0.1:0"
    ) as local:
        address = local.scheduler_address
        assert cli.run([*line, str(tmp_path / "there.json"), "--dask", address]) == 0
        local.scale(0)
        local.sync(local._correct_state)
        monkeypatch.setattr(cluster, "CONNECT_S", 1.0)
        assert cli.run([*line, str(tmp_path / "lost.json"), "--dask", address]) == 2
    assert f"has no workers; start one: dask worker {address}" in capsys.readouterr().err
    here, there = (json.loads((tmp_path / f"{at}.json").read_text()) for at in ("here", "there"))
    assert here["verdict"] == there["verdict"] == "explained"
    for one, other in zip(here["causes"], there["causes"], strict=True):
        assert one["effect"] == other["effect"]
        assert one["parameters"] == pytest.approx(other["parameters"], rel=1e-6, abs=1e-9)
