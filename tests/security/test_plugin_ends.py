"""Code that ends the program is a fault of its file with exit code 2, never success without an answer."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from stiffcal.cli import supervision
from stiffcal.commands.ingest import ingest_campaign
from stiffcal.model.catalogue.catalogue import built_in_effects
from stiffcal.trust.record import open_record
from tests.laboratory.plugin_campaigns import NAME, ran, stiffcal, stranger, write_plugin
from tests.laboratory.small_campaign import write_small_campaign
from tests.security.test_plugins import IN_TERMS

posix = pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")


@pytest.fixture
def folder(state: Path, tmp_path: Path) -> Path:
    """A campaign whose code its user trusts."""
    folder = stranger(tmp_path / "stranger", further="")
    open_record().allow_folder(folder)
    return folder


def prediction(folder: Path) -> tuple[str, ...]:
    return ("add", str(folder), "cross-stiffness", "--joints", "3", "--json")


@pytest.mark.parametrize(
    ("code", "how"),
    [
        ("import os; os._exit(0)", "ended with code 0, without an answer"),
        pytest.param("import os; os.kill(os.getpid(), 9)", "ended by signal 9, without an answer", marks=posix),
    ],
)
def test_code_that_ends_the_process_while_it_is_loaded_is_at_fault(folder: Path, code: str, how: str) -> None:
    write_plugin(folder, f"\n{code}\n")
    done = stiffcal(*prediction(folder))
    assert done.returncode == 2
    error = json.loads(done.stdout)["error"]
    assert (error["file"], error["place"]) == (NAME, "plugins")
    assert error["reason"] == f"the program {how}, after code of this campaign began to run"
    assert "\n" not in done.stderr.strip()


@pytest.mark.parametrize(
    ("statement", "line"),
    [
        ("import os; os._exit(0)", "the program ended with code 0, without an answer"),
        pytest.param(
            "raise KeyboardInterrupt",
            "the program ended by an interruption that did not come from you",
            marks=pytest.mark.practice,
        ),
        pytest.param(
            "import typer; raise typer.Exit(0)", "the program ended without an answer", marks=pytest.mark.practice
        ),
    ],
)
def test_code_that_ends_the_process_while_its_effect_is_used_is_at_fault(
    folder: Path, statement: str, line: str
) -> None:
    ingest_campaign(folder)
    write_plugin(folder, IN_TERMS.format(statement))
    done = stiffcal("identify", folder)
    assert done.returncode == 2
    assert done.stdout == ""
    assert f"{NAME}: plugins: {line}" in done.stderr


def test_what_it_writes_to_standard_output_by_number_does_not_get_into_the_answer(folder: Path) -> None:
    write_plugin(folder, "\nimport os, subprocess\nos.write(1, b'raw')\nsubprocess.run(['echo', 'program'])\n")
    done = stiffcal(*prediction(folder))
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["changes"]
    assert "raw" in done.stderr
    assert "program" in done.stderr


WAITS = """
import time
from pathlib import Path
Path(__file__).with_name('ran').touch()
time.sleep(60)
"""


@posix
@pytest.mark.parametrize(
    ("sent", "to_all", "code"),
    [(signal.SIGINT, True, 130), (signal.SIGINT, False, 130), (signal.SIGTERM, False, -signal.SIGTERM)],
)
def test_interrupting_the_command_reaches_what_runs(
    folder: Path, sent: signal.Signals, to_all: bool, code: int
) -> None:
    write_plugin(folder, WAITS)
    command = [sys.executable, "-P", "-m", "stiffcal", *prediction(folder)]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, process_group=0
    ) as process:
        while not ran(folder):
            assert process.poll() is None, process.communicate()
            time.sleep(0.02)
        if to_all:
            os.killpg(process.pid, sent)
        else:
            process.send_signal(sent)
        out, error = process.communicate(timeout=60)
    assert process.returncode == code
    assert out == ""
    assert "Traceback" not in error
    assert ("interrupted" in error) is (sent == signal.SIGINT)


ENDS_SLOWLY = """
import time
from pathlib import Path
here = Path(__file__)
here.with_name('ran').touch()
try:
    time.sleep(60)
except KeyboardInterrupt:
    here.with_name('interrupted').touch()
    try:
        while not here.with_name('go').exists():
            time.sleep(0.02)
    except KeyboardInterrupt:
        here.with_name('twice').touch()
    raise
"""


@posix
def test_one_interruption_is_one_however_late_the_parent_sends_it_on(folder: Path) -> None:
    """A terminal interrupts both processes; here the parent stands still until its child is half a second further."""
    write_plugin(folder, ENDS_SLOWLY)
    command = [sys.executable, "-P", "-m", "stiffcal", *prediction(folder)]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, process_group=0
    ) as process:
        for file in ("ran", "interrupted"):
            while not (folder / file).exists():
                assert process.poll() is None, process.communicate()
                time.sleep(0.02)
            if file == "ran":
                process.send_signal(signal.SIGSTOP)
                os.killpg(process.pid, signal.SIGINT)
        time.sleep(0.5)
        process.send_signal(signal.SIGCONT)
        time.sleep(0.3)
        (folder / "go").touch()
        process.communicate()
    assert process.returncode == 130
    assert not (folder / "twice").exists()


@posix
def test_a_killed_command_leaves_no_process_behind(folder: Path) -> None:
    write_plugin(folder, WAITS)
    command = [sys.executable, "-P", "-m", "stiffcal", *prediction(folder)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        while not ran(folder):
            assert process.poll() is None, process.communicate()
            time.sleep(0.02)
        process.kill()
        process.communicate(timeout=60)  # returns when nobody holds the pipes any more


@posix
def test_a_reader_that_has_gone_is_no_fault_of_the_code(folder: Path) -> None:
    command = [sys.executable, "-P", "-m", "stiffcal", *prediction(folder)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        error = process.stderr.read()
        assert process.wait(60) == 0, error
    assert error == ""


def test_a_campaign_without_code_has_no_child_process(
    state: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from stiffcal.campaign.loading import load_campaign
    from stiffcal.model.catalogue.campaign_effects import all_effects, model_effects

    folder = write_small_campaign(tmp_path / "own")
    with supervision.supervised(own_process=False, as_json=False) as command:
        campaign = load_campaign(folder)
        assert set(model_effects(campaign)) == set(all_effects(campaign)[0]) == set(built_in_effects())
        assert command.files == ()
