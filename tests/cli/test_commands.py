"""The command line as a person and as a script meet it: answers, exit codes, one line per mistake."""

from __future__ import annotations

import json
import re
import shlex
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from stiffcal.cli.app import COMMANDS, main

ROOT = Path(__file__).parents[2]


def run(*words: str | Path) -> int:
    """Run the command line in this process; return its exit code."""
    with pytest.raises(SystemExit) as end:
        main([str(word) for word in words])
    assert isinstance(end.value.code, int)
    return end.value.code


def document_of(capsys: pytest.CaptureFixture[str], *words: str | Path) -> tuple[dict[str, Any], int]:
    """Run with --json; return the one document on standard output and the exit code."""
    code = run(*words, "--json")
    return json.loads(capsys.readouterr().out), code


@pytest.mark.parametrize("name", COMMANDS)
def test_help_of_each_command_shows_an_example_that_it_understands(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(name, "--help") == 0
    text = capsys.readouterr().out
    examples = re.findall(r"Example: (stiffcal .*)", text)
    assert examples, "no example"
    for example in examples:
        command, *words = shlex.split(example)[1:]
        assert command == name
        options = {word for word in words if word.startswith("--")}
        assert options <= set(re.findall(r"--[\w-]+", text))
        folder = next((word for word in words if word.startswith("campaigns/")), None)
        assert folder is None or (ROOT / folder).is_dir()


def test_an_empty_force_is_no_load_of_zero(campaign: Path, capsys: pytest.CaptureFixture[str]) -> None:
    document, code = document_of(capsys, "predict", campaign, "--pose", "0,-70,20,0,30,0", "--force", "")
    assert code == 2
    assert "--force" in json.dumps(document)


@pytest.mark.parametrize("name", COMMANDS)
def test_list_of_commands_says_what_the_help_says(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    run(name, "--help")
    assert COMMANDS[name] in " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize(
    ("words", "schema", "exit_code"),
    [
        (["ingest"], "stiffcal/ingest/1", 0),
        (["identify"], "stiffcal/identify/1", 0),
        (["validate"], "stiffcal/validate/1", 0),
        (["history"], "stiffcal/history/1", 0),
        (["plot", "-o", "{}/p.svg"], "stiffcal/plot/1", 0),
        (["view", "-o", "{}/v.html"], "stiffcal/view/1", 0),
        (["export", "-o", "{}/s.csv"], "stiffcal/export/1", 0),
        (["predict", "--load-path", "0,0,0;0,0,-100", "--at", "0,-70,20,0,30,0"], "stiffcal/predict/1", 0),
        (["plan", "--force", "300", "--runs", "4"], "stiffcal/plan/1", 0),
    ],
    ids=lambda value: value[0] if isinstance(value, list) else "",
)
def test_json_is_one_document_on_standard_output(
    campaign: Path, capsys: pytest.CaptureFixture[str], words: list[str], schema: str, exit_code: int
) -> None:
    command, *options = [word.format(campaign) for word in words]
    document, code = document_of(capsys, command, campaign, *options)
    assert document["schema"] == schema
    assert isinstance(document["warnings"], list)
    assert code == exit_code


@pytest.mark.parametrize(
    "words",
    [
        ["ingest"],
        ["identify"],
        ["validate"],
        ["history"],
        ["plot", "-o", "{}/p.svg"],
        ["view", "-o", "{}/v.html"],
        ["export", "-o", "{}/s.csv"],
        ["predict", "--load-path", "0,0,0;0,0,-100", "--at", "0,-70,20,0,30,0"],
        ["plan", "--force", "300", "--runs", "4"],
    ],
    ids=lambda words: words[0],
)
def test_every_answer_ends_with_the_next_step(
    campaign: Path, capsys: pytest.CaptureFixture[str], words: list[str]
) -> None:
    command, *options = [word.format(campaign) for word in words]
    assert run(command, campaign, *options) == 0
    last = capsys.readouterr().out.rstrip().splitlines()[-1]
    # a step that needs something of the user first stands after "once …:"
    condition, colon, line = last.partition(": ")
    assert colon
    assert condition == "next" or (command == "export" and condition.startswith("once "))
    following = shlex.split(line)
    assert following[0] == "stiffcal"
    assert following[1] in COMMANDS
    assert str(campaign) in following


def test_stiffness_has_the_digits_of_its_interval(campaign: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run("identify", campaign)
    text = capsys.readouterr().out
    assert re.search(r"joint 1 +\(7\.(\d+) ± 0\.(\d+)\)·10⁵ +\d+ % +N·m/rad", text)
    assert "expected error in new poses of this kind:" in text


def test_validate_with_a_broken_threshold_ends_with_1(campaign: Path, capsys: pytest.CaptureFixture[str]) -> None:
    manifest = campaign / "campaign.toml"
    manifest.write_text(manifest.read_text() + "\n[thresholds]\nmax_rms_m = 1e-6\n")
    document, code = document_of(capsys, "validate", campaign)
    assert (document["passed"], code) == (False, 1)
    assert run("validate", campaign) == 1
    assert "NOT met: rms in held-out poses" in capsys.readouterr().out


def test_add_without_a_place_lists_the_places(campaign: Path, capsys: pytest.CaptureFixture[str]) -> None:
    document, code = document_of(capsys, "add", campaign, "joint-compliance")
    assert code == 2
    assert set(document["error"]) == {"code", "file", "place", "reason", "mend"}
    assert "--joints with one or more of 1, 2, 3, 4, 5, 6" in document["error"]["mend"]


def test_add_and_remove(campaign: Path, capsys: pytest.CaptureFixture[str]) -> None:
    document, code = document_of(capsys, "remove", campaign, "joint-compliance", "--joints", "6")
    assert (code, document["model"]["effects"][0]["joints"]) == (0, [1, 2, 3, 4, 5])
    assert run("history", campaign) == 0
    assert "not fitted yet" in capsys.readouterr().out
    assert run("add", campaign, "joint-compliance", "--all") == 0
    assert "added joint-compliance: j6" in capsys.readouterr().out


def test_an_effects_page_has_sections(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("effects", "stribeck") == 0
    page = capsys.readouterr().out
    assert "\\n" not in page
    for heading in ("Physics", "Law", "Assumptions", "Where it ends", "Parameters", "Picture"):
        assert f"\n{heading}\n" in page
    assert "torque of the drive while the joint moves" in page


def test_effects_catalogue(capsys: pytest.CaptureFixture[str]) -> None:
    document, _ = document_of(capsys, "effects")
    assert "joint-compliance" in [effect["name"] for effect in document["effects"]]
    assert run("effects", "joint-compliance") == 0
    text = capsys.readouterr().out
    assert "rad/(N·m)" in text
    assert text.rstrip().endswith(": stiffcal diagnose DIR")


@pytest.mark.parametrize(
    ("words", "line"),
    [
        (["nothing"], r"command line: no such command: nothing.*; see stiffcal --help"),
        (["vaildate"], r"did you mean validate"),
        (["validate", "--fast"], r"command line: No such option: --fast.*; see stiffcal validate --help"),
        (["simulate", "out"], r"command line: Missing option '--from'.*; see stiffcal simulate --help"),
        (["identify", "no-such-folder"], r"no-such-folder: no such folder; give a campaign folder"),
        (
            ["init", "x", "--kind", "loud"],
            r'^command line: --kind: there is no kind "loud"; use one of absolute, clamped, friction, ',
        ),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_mistakes_get_one_line_and_exit_code_2(capsys: pytest.CaptureFixture[str], words: list[str], line: str) -> None:
    assert run(*words) == 2
    reported = capsys.readouterr()
    assert reported.out == ""
    assert len(reported.err.splitlines()) == 1
    assert re.search(line, reported.err)
    document, code = document_of(capsys, *words)
    assert code == 2
    assert set(document["error"]) == {"code", "file", "place", "reason", "mend"}


def test_every_fault_of_the_input_gets_its_line(campaign: Path, capsys: pytest.CaptureFixture[str]) -> None:
    manifest = campaign / "campaign.toml"
    manifest.write_text(manifest.read_text().replace('"N"', '"lbs"').replace('position = "mm"', 'position = "furlong"'))
    assert run("identify", campaign) == 2
    reported = capsys.readouterr().err.splitlines()
    assert len(reported) >= 2
    assert all(line.startswith("campaign.toml: ") for line in reported)
    document, _ = document_of(capsys, "identify", campaign)
    assert len(document["others"]) == len(reported) - 1


def test_an_internal_fault_is_one_line_with_a_log(
    campaign: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    import stiffcal.commands.history

    def broken(*_: object) -> None:
        raise ZeroDivisionError("nobody thought of this")

    monkeypatch.delenv("STIFFCAL_DEBUG", raising=False)
    monkeypatch.setattr(stiffcal.commands.history, "read_history", broken)
    assert run("history", campaign) == 3
    reported = capsys.readouterr()
    assert reported.out == ""
    (line,) = reported.err.splitlines()
    assert "ZeroDivisionError: nobody thought of this" in line
    match = re.search(r"log file (\S+)", line)
    assert match is not None
    log = Path(match[1])
    assert "Traceback" in log.read_text()
    log.unlink()
    assert run("history", campaign, "--debug") == 3
    assert "Traceback (most recent call last)" in capsys.readouterr().err
    document, code = document_of(capsys, "history", campaign)
    assert code == 3
    Path(document["error"]["file"]).unlink()


def test_no_update_refuses_with_exit_code_2(campaign: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model = campaign / "model.toml"
    model.write_text(model.read_text().replace("[1, 2, 3, 4, 5, 6]", "[1, 2, 3]"))
    assert run("validate", campaign, "--no-update") == 2
    assert "run stiffcal identify" in capsys.readouterr().err


@pytest.mark.skipif(sys.platform == "win32", reason="signals are another matter there")
def test_interrupting_ends_with_130_and_one_line(campaign: Path) -> None:
    code = (
        "import sys, time\n"
        "import stiffcal.commands.history as history\n"
        "def wait(*_):\n    print('waiting', flush=True)\n    time.sleep(60)\n"
        "history.read_history = wait\n"
        "from stiffcal.cli.app import main\nmain(sys.argv[1:])\n"
    )
    words = [sys.executable, "-c", code, "history", str(campaign)]
    with subprocess.Popen(words, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "waiting\n"
        process.send_signal(signal.SIGINT)
        _, error = process.communicate(timeout=240)
    assert process.returncode == 130
    assert error == "interrupted; the store is intact: finished steps are kept, the interrupted one is discarded\n"


def test_a_reader_that_goes_away_is_no_fault(campaign: Path) -> None:
    command = f"{shlex.quote(sys.executable)} -m stiffcal effects joint-compliance | head -n 1"
    done = subprocess.run(["bash", "-c", command], cwd=ROOT, capture_output=True, text=True)
    assert done.stderr == ""
