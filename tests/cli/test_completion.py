"""Shell completion: commands first, then the options of the command that stands there."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from stiffcal.cli.app import COMMANDS, main
from stiffcal.cli.command_tree import command_named
from stiffcal.cli.completion import SHELLS, completion_script, options_of


def completed(script: Path, *words: str) -> list[str]:
    """Return what bash proposes for the last word."""
    line = " ".join(f"'{word}'" for word in words)
    code = f"source {script}; COMP_WORDS=({line}); COMP_CWORD={len(words) - 1}; _stiffcal_completion"
    done = subprocess.run(
        ["bash", "-c", code + '; printf "%s\\n" "${COMPREPLY[@]}"'], capture_output=True, text=True, check=True
    )
    return done.stdout.split()


@pytest.fixture(scope="module")
def script(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("completion") / "stiffcal.bash"
    file.write_text(completion_script("bash", COMMANDS))
    return file


needs_bash = pytest.mark.skipif(shutil.which("bash") is None, reason="there is no bash")


@needs_bash
def test_bash_completes_commands(script: Path) -> None:
    assert completed(script, "stiffcal", "di") == ["diagnose"]
    assert set(COMMANDS) < set(completed(script, "stiffcal", ""))


@needs_bash
def test_bash_completes_the_options_of_the_command(script: Path) -> None:
    assert completed(script, "stiffcal", "identify", "--lo") == ["--log-file", "--loss"]
    assert completed(script, "stiffcal", "check", "--lo") == ["--log-file"]
    assert completed(script, "stiffcal", "check", "camp") == []  # names of files are the shell's own


@pytest.mark.parametrize("shell", SHELLS)
def test_every_shell_has_every_command_and_option(shell: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        main(["--show-completion", shell])
    text = capsys.readouterr().out
    assert end.value.code == 0
    for name in COMMANDS:
        assert name in text
        assert all(option.removeprefix("--") in text for option in options_of(name))


@pytest.mark.parametrize("name", COMMANDS)
def test_the_listed_options_are_those_that_the_command_parses(name: str) -> None:
    parameters = command_named(name).params
    words = [word for one in parameters for word in (*one.opts, *one.secondary_opts) if word.startswith("--")]
    assert options_of(name) == sorted({*words, "--help"})


@pytest.mark.parametrize("words", [[], ["tcsh"]], ids=len)
def test_an_unknown_shell_is_a_mistake_of_the_user(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        main(["--show-completion", *words])
    assert end.value.code == 2
    assert capsys.readouterr().err.count("\n") == 1
