"""Completion scripts: bash itself completes with what is printed."""

import shutil
import subprocess
from pathlib import Path

import pytest

from robot.cli import completion
from robot.cli import main as cli
from robot.cli.commands import COMMANDS, GROUP_HELP
from robot.console.exit_codes import ExitCode
from robot.requests.single import SHELLS

pytest.importorskip("shtab")
# What bash does when Tab is pressed after the given words.
ASK = """
source {script}
COMP_WORDS=({words})
COMP_CWORD=$(( ${{#COMP_WORDS[@]}} - 1 ))
COMP_LINE="${{COMP_WORDS[*]}}"
COMP_POINT=${{#COMP_LINE}}
$(complete -p bigant | sed -E 's/.*-F ([^ ]+).*/\\1/') bigant "${{COMP_WORDS[COMP_CWORD]}}" ""
printf '%s\\n' "${{COMPREPLY[@]}}"
"""


@pytest.fixture(scope="module")
def bash_script(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("completion") / "bigant.sh"
    path.write_text(completion.script_for("bash"), encoding="utf-8")
    return path


def offered(script: Path, words: str, folder: Path | None = None) -> set[str]:
    bash = shutil.which("bash")
    if bash is None:
        pytest.skip("no bash here")
    done = subprocess.run(
        [bash, "--norc", "-c", ASK.format(script=script, words=words)],
        capture_output=True, text=True, check=True, cwd=folder,
    )  # fmt: skip
    assert done.stderr == ""
    return set(done.stdout.split())


def test_bash_offers_all_commands_and_all_actions(bash_script: Path) -> None:
    single = {command.split()[0] for command in COMMANDS}
    assert offered(bash_script, 'bigant ""') >= single
    for group in GROUP_HELP:
        actions = {c.split()[1] for c in COMMANDS if c.startswith(f"{group} ")}
        assert offered(bash_script, f'bigant {group} ""') >= actions, group


def test_bash_offers_options_choices_and_files(bash_script: Path, tmp_path: Path) -> None:
    assert offered(bash_script, "bigant dr") == {"drive"}
    options = offered(bash_script, "bigant drive --v")
    assert "--virtual-time" in options
    assert "--teleop" not in options
    assert offered(bash_script, 'bigant drive --gait ""') == {"tripod", "metachronal"}
    (tmp_path / "walk.mcap").touch()
    assert "walk.mcap" in offered(bash_script, "bigant show wa", tmp_path)
    assert "walk.mcap" in offered(bash_script, "bigant log info wa", tmp_path)


def test_every_shell_has_a_script_that_says_how_to_install_it(
    capsys: pytest.CaptureFixture[str],
) -> None:
    for shell in SHELLS:
        assert cli.run(["completion", shell]) == ExitCode.OK
        script = capsys.readouterr().out
        assert f"bigant completion {shell} > ~/" in script
        for word in ("drive", "metachronal", "virtual-time", "campaign"):
            assert word in script, (shell, word)


@pytest.mark.parametrize("shell", SHELLS)
def test_the_shell_accepts_its_script(shell: str, tmp_path: Path) -> None:
    program = shutil.which(shell)
    if program is None:
        pytest.skip(f"no {shell} here")
    path = tmp_path / "script"
    path.write_text(completion.script_for(shell), encoding="utf-8")
    subprocess.run([program, "-n", str(path)], check=True)


def test_without_the_package_the_extra_is_named(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(completion, "PACKAGE", "no_such_package_of_anybody")
    assert cli.run(["completion", "bash"]) == ExitCode.USAGE
    assert "[completion]" in capsys.readouterr().err
