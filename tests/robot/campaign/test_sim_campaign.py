"""``bigant campaign make`` and ``sim unseal`` as one types them; local processes and a Dask cluster."""

import contextlib
import io
import json
import re
from dataclasses import dataclass, replace
from pathlib import Path

import pytest
from pyarrow.parquet import read_table

from robot.cli.main import run as command
from robot.console import cluster as dask_cluster
from tests.robot.scenarios import ONE, write_scenario


@pytest.fixture
def scenario_file(tmp_path: Path) -> Path:
    return write_scenario(tmp_path, ONE)


@dataclass(frozen=True)
class Made:
    """A campaign as a person makes it: the command line and what it printed."""

    scenario: Path
    out: Path
    said: str

    @property
    def line(self) -> list[str]:
        return ["campaign", "make", str(self.scenario), "--out", str(self.out), "--jobs", "1"]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Made:
    folder = tmp_path_factory.mktemp("campaign")
    one = Made(write_scenario(folder, ONE), folder / "out", "")
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        assert command(one.line) == 0
    return replace(one, said=said.getvalue())


def tables(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*.parquet"))}


@pytest.mark.parametrize("key", ["repeats", "seed", "conditions"])
def test_a_mistake_in_a_scenario_names_the_page_on_scenarios(
    scenario_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], key: str
) -> None:
    text = scenario_file.read_text()
    scenario_file.write_text(re.sub(rf"(?m)^{key} =.*$|\[{key}\]", "", text))
    assert command(["campaign", "make", str(scenario_file), "--out", str(tmp_path / "out")]) != 0
    told = capsys.readouterr().err
    assert f"{key}: is missing" in told
    assert told.endswith("(see docs/twin.md#a-campaign)\n")


def test_a_mistake_in_the_robot_file_of_a_scenario_names_the_page_on_robot_files(
    scenario_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    robot = tmp_path / "bigant.toml"
    robot.write_text(re.sub("(?m)^servo_zero.*$", "", robot.read_text()))
    assert command(["campaign", "make", str(scenario_file), "--out", str(tmp_path / "out")]) != 0
    told = capsys.readouterr().err
    assert "bigant.toml: " in told
    assert told.endswith("(see docs/tutorial.md#your-robots-file)\n")


@pytest.mark.soak
def test_a_campaign_is_made_once(made: Made, capsys: pytest.CaptureFixture[str]) -> None:
    assert "3 trials, 3 made now" in made.said
    before = tables(made.out)
    assert len(before) == 3
    assert command([*made.line, "--json"]) == 0
    again = json.loads(capsys.readouterr().out)
    assert (again["trials"], again["made"], again["failed"]) == (3, 0, 0)
    assert tables(made.out) == before
    made.scenario.write_text(ONE.replace("seed = 1", "seed = 2"))
    assert command(made.line) != 0
    assert "another scenario's campaign" in capsys.readouterr().err


@pytest.mark.soak
def test_a_sealed_campaign_is_opened_by_its_key(
    scenario_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, key = tmp_path / "out", tmp_path / "away" / "final.key"
    key.parent.mkdir()
    line = ["campaign", "make", str(scenario_file), "--out", str(out), "--jobs", "1", "--sealed"]
    assert command(line) != 0
    assert "--key" in capsys.readouterr().err
    assert command([*line, "--key", str(out / "final.key")]) != 0
    assert "outside the campaign's folder" in capsys.readouterr().err
    assert command([*line, "--key", str(key)]) == 0
    said = capsys.readouterr().out
    assert "labels sealed, SHA-256" in said
    assert not list(out.rglob("*labels.json"))
    assert not any(b"force_bias" in path.read_bytes() for path in out.rglob("*") if path.is_file())

    assert command(["campaign", "unseal", str(out), "--key", str(key), "--json"]) == 0
    labels = json.loads(capsys.readouterr().out)
    names = {path.name for path in (out / "cases").iterdir()}
    assert set(labels["cases"]) == names
    opened = tmp_path / "labels.toml"
    assert command(["campaign", "unseal", str(out), "--key", str(key), "--out", str(opened)]) == 0
    assert "force_bias" in opened.read_text()
    assert command(["campaign", "unseal", str(out), "--key", str(scenario_file)]) != 0
    assert "holds no key" in capsys.readouterr().err


@pytest.mark.thorough
def test_a_cluster_makes_the_same_bytes(
    made: Made, scenario_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    distributed = pytest.importorskip("distributed", reason="pip install -e '.[dask]'")
    line = ["campaign", "make", str(scenario_file), "--out"]
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, host="127.0.0.1", dashboard_address="127.0.0.1:0"
    ) as cluster:
        address = cluster.scheduler_address
        assert command([*line, str(tmp_path / "dask"), "--dask", address]) == 0
        still = [name for name in cluster.scheduler.clients if name.startswith("Client")]
        assert not still, "the command has said goodbye"
    assert "3 made now" in capsys.readouterr().out.splitlines()[-1]
    local = tables(made.out)
    assert local
    assert tables(tmp_path / "dask") == local


def test_no_cluster_there_is_said(
    scenario_file: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    pytest.importorskip("distributed", reason="pip install -e '.[dask]'")
    monkeypatch.setattr(dask_cluster, "CONNECT_S", 0.2)
    line = ["campaign", "make", str(scenario_file), "--out", str(tmp_path / "out")]
    assert command([*line, "--dask", "tcp://127.0.0.1:9"]) != 0
    assert "nothing answers at tcp://127.0.0.1:9" in capsys.readouterr().err
    assert command([*line, "--dask", "nonsense://x"]) != 0
    assert "--dask" in capsys.readouterr().err


def test_recordings_begin_anywhere_and_are_as_long_if_a_scenario_asks_for_it(
    tmp_path: Path,
) -> None:
    text = ONE.replace("seconds = 0.1", "seconds = 0.1\nbegin_within_s = 2.0")
    scenario = write_scenario(tmp_path, text.replace("count = 1", "count = 3"))
    line = ["campaign", "make", str(scenario), "--jobs", "1", "--out"]
    assert command([*line, str(tmp_path / "one")]) == 0
    begins, rows = set(), set()
    for path in sorted((tmp_path / "one" / "references").glob("*.parquet")):
        time_s = read_table(path)["time_s"].to_numpy()
        begins.add(float(time_s[0]))
        rows.add(len(time_s))
    assert len(begins) == 3
    assert all(0.0 <= begin <= 2.0 for begin in begins)
    assert rows == {10}
    assert command([*line, str(tmp_path / "two")]) == 0
    assert tables(tmp_path / "one") == tables(tmp_path / "two")
    scenario.write_text(scenario.read_text().replace("= 2.0", "= -1.0"))
    assert command([*line, str(tmp_path / "three")]) != 0
