"""The last line of each answer follows the loop, and a user who follows it comes to an end."""

from __future__ import annotations

import shlex
from itertools import product
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from stiffcal.cli.app import main
from stiffcal.cli.command_tree import COMMANDS, command_named
from stiffcal.commands.next_step import line_of
from stiffcal.escapes.shell import command_line
from stiffcal.measurements.rms import Rms
from stiffcal.results.next_step import ORDER, Standing, Step, is_within_noise, next_step

FOLDER = Path("campaign")
NOISE = Rms(1e-5, None)
LARGE, SMALL = Rms(1e-4, None), Rms(1e-5, None)


def diagnosis(**found: Any) -> Any:
    """Return a diagnosis of a complete model but for what is given."""
    return SimpleNamespace(**({"missing": [], "superfluous": [], "pattern": None} | found))


def standing(**known: Any) -> Standing:
    """Return a fitted campaign with a noise of 10 µm, of which more is known."""
    of_fitted: dict[str, Any] = {"logs_missing": False, "is_fitted": True, "noise": NOISE}
    return Standing(**(of_fitted | known))


def test_no_answer_leads_back_whatever_is_known() -> None:
    """All combinations: the steps that are proposed one after the other rise in their order, so that they end."""
    diagnoses = (None, diagnosis(), diagnosis(missing=["an effect"]))
    known = [
        Standing(missing, fitted, rms, noise, found, untested)
        for missing, fitted, rms, noise, found, untested in product(
            (True, False), (True, False), (None, SMALL, LARGE), (None, NOISE), diagnoses, (None, "an-effect")
        )
    ]
    assert len(known) > 100
    for one in known:
        for after in (None, *ORDER):
            for done in ((), (Step.REPORT,)):
                step = next_step(one, after, done)
                assert step is None or after is None or ORDER.index(step) > ORDER.index(after)
                assert step not in done


@pytest.mark.parametrize(
    ("error", "noise", "within"),
    [
        (Rms(1.02e-5, None), NOISE, True),
        (Rms(2e-5, None), NOISE, False),
        (Rms(1e-5, 3e-5), Rms(1e-5, 1e-5), False),
        (Rms(1e-5, None), None, False),
        (Rms(None, None), NOISE, False),
        (None, NOISE, False),
    ],
)
def test_an_error_is_within_the_noise_only_where_both_are_known(
    error: Rms | None, noise: Rms | None, within: bool
) -> None:
    assert is_within_noise(error, noise) is within
    expected = Step.REPORT if within else Step.DIAGNOSE
    assert next_step(standing(heldout_rms=error or LARGE, noise=noise), Step.VALIDATE) is expected


@pytest.mark.parametrize(
    ("known", "after", "expected"),
    [
        ({"logs_missing": True, "is_fitted": False}, None, Step.CHECK),
        ({"is_fitted": False}, None, Step.IDENTIFY),
        ({"is_fitted": False, "is_ingested": False}, None, Step.CHECK),
        ({"is_fitted": False, "is_ingested": False}, Step.CHECK, Step.IDENTIFY),
        ({}, None, Step.VALIDATE),
        ({"heldout_rms": LARGE}, None, Step.DIAGNOSE),
        ({"heldout_rms": SMALL}, None, Step.REPORT),
        ({"heldout_rms": LARGE, "diagnosis": diagnosis()}, Step.DIAGNOSE, Step.REPORT),
        ({"heldout_rms": LARGE, "diagnosis": diagnosis(superfluous=["an effect"])}, Step.DIAGNOSE, Step.REPORT),
        ({"heldout_rms": LARGE, "diagnosis": diagnosis(missing=["an effect"])}, Step.DIAGNOSE, Step.IMPROVE),
        # once improve has ended, the same command would change nothing
        ({"heldout_rms": LARGE, "diagnosis": diagnosis(missing=["an effect"])}, Step.IMPROVE, Step.REPORT),
        ({"heldout_rms": LARGE, "diagnosis": diagnosis(), "untested": "over-time"}, Step.IMPROVE, Step.NEW_EFFECT),
        ({"heldout_rms": SMALL}, Step.REPORT, Step.VIEW),
        ({"heldout_rms": SMALL}, Step.VIEW, Step.EXPORT),
        ({"heldout_rms": SMALL}, Step.EXPORT, None),
    ],
)
def test_each_state_calls_for_its_step(known: dict[str, Any], after: Step | None, expected: Step | None) -> None:
    assert next_step(standing(**known), after) is expected


def test_only_what_runs_as_it_is_stands_after_next() -> None:
    missing = standing(heldout_rms=LARGE, diagnosis=diagnosis(missing=["an effect"]))
    assert line_of(FOLDER, missing, "kept").text == "next: stiffcal improve campaign --store kept"
    assert line_of(FOLDER, missing, None, Step.VIEW).text == "next: stiffcal export campaign -o model.json"
    last = line_of(FOLDER, missing, None, Step.EXPORT)
    assert last.once
    assert last.command == "stiffcal compare campaign LATER_DIR"
    assert not last.text.startswith("next:")
    empty = line_of(FOLDER, standing(is_fitted=False, has_effects=False), None)
    assert empty.once
    assert empty.command == "stiffcal identify campaign"


def run(*words: str | Path) -> int:
    with pytest.raises(SystemExit) as end:
        main([*map(str, words)])
    return int(end.value.code or 0)


def test_run_without_logs_names_check(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "new"
    assert run("init", folder, "--kind", "load") == 0
    capsys.readouterr()
    assert run("run", folder) == 2
    printed = capsys.readouterr().err
    assert printed.rstrip().splitlines()[-1] == f"next: stiffcal check {folder}"
    assert "Traceback" not in printed


def test_run_without_a_robot_file_names_no_next_step(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "new"
    assert run("init", folder, "--kind", "load") == 0
    (folder / "robot.toml").unlink()
    capsys.readouterr()
    assert run("run", folder) == 2
    printed = capsys.readouterr().err
    assert "next:" not in printed
    assert "robot.toml" in printed


@pytest.mark.parametrize("name", COMMANDS)
def test_a_printed_line_names_the_current_folder_where_its_command_has_no_default(name: str) -> None:
    first = next((one for one in command_named(name).params if one.param_type_name == "argument"), None)
    assert ("." in command_line(name, Path()).split()) == (first is not None and first.required)


@pytest.mark.parametrize("folder", [Path(), FOLDER])
def test_every_line_is_taken_by_its_command(folder: Path) -> None:
    """With the results elsewhere: what `compare` and the others take differs."""
    for one in (standing(), standing(heldout_rms=SMALL, diagnosis=diagnosis()), standing(is_fitted=False)):
        for after in (None, *ORDER):
            _, name, *words = shlex.split(line_of(folder, one, "elsewhere", after).command)
            command_named(name).make_context(name, words)
