"""Names of our packages that somebody else has as well: one sentence, before anything else fails."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from bigant.name_conflict import PACKAGES, NameConflict, check_names
from tests.test_layers import OURS, ROOT

SCRIPT = "from bigant.__main__ import main\nmain()\n"  # what pip makes of the entry point
THEIRS = "raise SystemExit('their code has run')\n"


def python(*words: str, folder: Path, path: Path | str = ROOT) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *words], cwd=folder, capture_output=True, text=True, check=False,
        env={**os.environ, "PYTHONPATH": str(path)},
    )  # fmt: skip


@pytest.fixture
def lab(tmp_path: Path) -> Path:
    """A folder in which a lab keeps modules of its own."""
    folder = tmp_path / "lab"
    folder.mkdir()
    for name in ("model", "robot"):
        (folder / f"{name}.py").write_text(THEIRS, encoding="utf-8")
    return folder


@pytest.fixture
def command(tmp_path: Path) -> str:
    """The command as it is installed: a script in a folder of its own."""
    script = tmp_path / "bin" / "bigant"
    script.parent.mkdir()
    script.write_text(SCRIPT, encoding="utf-8")
    return str(script)


def installed(folder: Path, distribution: str, name: str, code: str = THEIRS) -> Path:
    """A package as another distribution installs it."""
    module = folder / name / "__init__.py"
    module.parent.mkdir(parents=True, exist_ok=True)
    module.write_text(code, encoding="utf-8")
    record = folder / f"{distribution}-1.0.dist-info"
    record.mkdir()
    (record / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {distribution}\nVersion: 1.0\n")
    (record / "RECORD").write_text(f"{name}/__init__.py,,\n{record.name}/RECORD,,\n")
    return module


def test_every_package_of_ours_is_looked_at_and_is_ours_here() -> None:
    assert set(PACKAGES) == set(OURS) - {"bigant"}
    check_names()


def test_the_command_works_beside_modules_of_these_names(lab: Path, command: str) -> None:
    for words in ([command], ["-m", "bigant"]):
        done = python(*words, "gap", "effects", "--stage", "friction", folder=lab)
        assert (done.returncode, done.stderr) == (0, "")
        assert "friction" in done.stdout


def test_a_notebook_beside_a_model_py_is_told_what_to_do(lab: Path) -> None:
    done = python("-c", "import bigant", folder=lab)
    (lab / "robot.py").unlink()
    other = python("-c", "import bigant", folder=lab)
    for one, name in ((done, "robot"), (other, "model")):
        assert one.stderr.splitlines()[-1] == (
            f"bigant.name_conflict.NameConflict: {lab}/{name}.py has the name of BigANT's package "
            f"'{name}'; rename it, or start Python in another folder"
        )


def test_it_can_be_caught_as_an_import_error(lab: Path) -> None:
    code = "try:\n import bigant\nexcept ImportError as error:\n print(error.name, error.path)"
    done = python("-c", code, folder=lab)
    assert done.stdout.split() == ["robot", f"{lab}/robot.py"]


def test_a_module_that_is_imported_already_is_told_of(tmp_path: Path) -> None:
    code = "import sys; sys.path.append('theirs'); import gait_notes as notes; sys.modules['gaits'] = notes"
    (tmp_path / "theirs").mkdir()
    (tmp_path / "theirs" / "gait_notes.py").touch()
    done = python("-c", f"{code}\nimport bigant", folder=tmp_path)
    assert (
        "gait_notes.py has the name of BigANT's package 'gaits' and is imported already"
        in done.stderr
    )
    made = "import sys, types; sys.modules['gaits'] = types.ModuleType('gaits')\nimport bigant"
    assert "the module 'gaits' is not BigANT's" in python("-c", made, folder=tmp_path).stderr


def test_a_folder_of_data_is_no_conflict(tmp_path: Path) -> None:
    (tmp_path / "model").mkdir()
    done = python("-c", "import bigant; print(bigant.BigantError.__module__)", folder=tmp_path)
    assert (done.stdout.strip(), done.stderr) == ("model.errors", "")


def test_another_distribution_on_the_path_is_named(tmp_path: Path, command: str) -> None:
    module = installed(tmp_path / "site", "robotframework", "robot")
    path = os.pathsep.join([str(tmp_path / "site"), str(ROOT)])
    done = python(command, "--version", folder=tmp_path, path=path)
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr == (
        f"bigant: {module} of the distribution robotframework has the name of BigANT's package 'robot'; "
        "install BigANT into an environment without it\n"
    )
    again = python("-m", "bigant", "--version", folder=tmp_path, path=path)
    assert (again.returncode, again.stderr) == (2, done.stderr)


@pytest.fixture
def site(tmp_path: Path) -> Path:
    """Packages of ours as a wheel leaves them."""
    for name in OURS:
        shutil.copytree(
            ROOT / name, tmp_path / "site" / name, ignore=shutil.ignore_patterns("__pycache__")
        )
    return tmp_path / "site"


def test_a_package_that_was_overwritten_is_noticed(
    site: Path, tmp_path: Path, command: str
) -> None:
    fine = python(command, "gap", "effects", "--stage", "friction", folder=tmp_path, path=site)
    assert fine.returncode == 0
    module = installed(site, "robotframework", "robot")
    done = python(command, "--help", folder=tmp_path, path=site)
    assert done.returncode == 2
    assert done.stderr == (
        f"bigant: {module} of BigANT was overwritten by robotframework; install BigANT into an environment "
        "without it: both have a package 'robot'\n"
    )
    module.unlink()  # as when they uninstall it
    done = python(command, "--help", folder=tmp_path, path=site)
    assert "'robot' of BigANT has lost its __init__.py" in done.stderr
    assert "--force-reinstall" in done.stderr


def test_it_is_an_import_error_of_its_own() -> None:
    assert issubclass(NameConflict, ImportError)
