"""The last line of each answer follows the loop."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from stiffcal.cli.next_step import after_diagnosis, after_history, after_improvement, after_validation
from stiffcal.measurements.rms import Rms
from tests.laboratory.plugin_campaigns import stiffcal

FOLDER = Path("campaign")


def validation(error: Rms, noise: Rms | None) -> Any:
    """Return a validation with an error and a noise alone."""
    return SimpleNamespace(rms=error, noise=noise)


def diagnosis(**found: Any) -> Any:
    """Return a diagnosis of a complete model but for what is given."""
    return SimpleNamespace(**({"missing": [], "superfluous": [], "everywhere": None, "pattern": None} | found))


@pytest.mark.parametrize(
    ("error", "noise", "command"),
    [
        (Rms(1.02e-5, None), Rms(1e-5, None), "report"),
        (Rms(2e-5, None), Rms(1e-5, None), "diagnose"),
        (Rms(1e-5, 3e-5), Rms(1e-5, 1e-5), "diagnose"),
        (Rms(1e-5, None), None, "diagnose"),
        (Rms(None, None), Rms(1e-5, None), "diagnose"),
    ],
)
def test_an_error_above_the_noise_is_diagnosed(error: Rms, noise: Rms | None, command: str) -> None:
    assert after_validation(FOLDER, validation(error, noise), None) == f"stiffcal {command} campaign"


def test_a_missing_effect_leads_to_improve_and_a_complete_model_to_the_report() -> None:
    assert after_diagnosis(FOLDER, diagnosis(missing=["an effect"]), "kept") == "stiffcal improve campaign --store kept"
    assert after_diagnosis(FOLDER, diagnosis(superfluous=["an effect"]), None) == "stiffcal report campaign"
    assert after_diagnosis(FOLDER, diagnosis(everywhere="an effect"), None) == "stiffcal improve campaign"
    assert after_diagnosis(FOLDER, diagnosis(), None) == "stiffcal report campaign"
    assert after_diagnosis(FOLDER, diagnosis(), None, finished=("view",)) == "stiffcal view campaign"


def history(heldout: Rms | None, is_fitted: bool = True) -> Any:
    """Return a history of a single fit with a noise of 10 µm."""
    fit = SimpleNamespace(id="1", heldout_rms=heldout, noise=Rms(1e-5, None))
    return SimpleNamespace(fits=[fit], not_fitted_yet=None if is_fitted else object())


def test_the_history_leads_on_from_its_last_fit() -> None:
    large, small = Rms(1e-4, None), Rms(1e-5, None)
    missing = diagnosis(missing=["an effect"])
    assert after_history(FOLDER, history(large, is_fitted=False), missing, None) == "stiffcal identify campaign"
    assert after_history(FOLDER, history(None), None, None) == "stiffcal validate campaign"
    assert after_history(FOLDER, history(large), None, None) == "stiffcal diagnose campaign"
    assert after_history(FOLDER, history(large), missing, None) == "stiffcal improve campaign"
    assert after_history(FOLDER, history(large), diagnosis(), None) == "stiffcal report campaign"
    assert after_history(FOLDER, history(small), None, "kept") == "stiffcal report campaign --store kept"


def test_improve_leads_on_only_while_it_can() -> None:
    """After effects were added and something is left, the same command once more would add nothing."""
    added, start = SimpleNamespace(action="add"), SimpleNamespace(action="start")

    def after(is_dry_run: bool = False, **found: Any) -> str:
        result: Any = SimpleNamespace(**({"steps": [start], "missing": [], "unexplained": False} | found))
        return after_improvement(FOLDER, result, is_dry_run, None).split()[1]

    assert after(missing=["an effect"], is_dry_run=True) == "improve"
    assert after(missing=["an effect"]) == "improve"
    assert after(missing=["an effect"], steps=[start, added]) == "diagnose"
    assert after(unexplained=True) == "diagnose"
    assert after(steps=[start, added]) == "report"


def test_after_the_pages_a_finished_model_is_exported() -> None:
    finished = ("export", "-o", "model.json")
    small, missing = Rms(1e-5, None), diagnosis(missing=["an effect"])
    expected = "stiffcal export campaign -o model.json"
    assert after_history(FOLDER, history(small), diagnosis(), None, finished) == expected
    assert after_history(FOLDER, history(small), None, None, finished) == expected
    assert after_history(FOLDER, history(Rms(1e-4, None)), None, None, finished) == "stiffcal diagnose campaign"
    assert after_history(FOLDER, history(small), missing, None, finished) == "stiffcal improve campaign"


def test_run_without_logs_names_check(tmp_path: Path) -> None:
    folder = tmp_path / "new"
    assert stiffcal("init", folder, "--kind", "load").returncode == 0
    ended = stiffcal("run", folder)
    assert ended.returncode == 2
    assert ended.stderr.rstrip().splitlines()[-1] == f"next: stiffcal check {folder}"
    assert "Traceback" not in ended.stderr


def test_run_without_a_robot_file_names_no_next_step(tmp_path: Path) -> None:
    folder = tmp_path / "new"
    assert stiffcal("init", folder, "--kind", "load").returncode == 0
    (folder / "robot.toml").unlink()
    ended = stiffcal("run", folder)
    assert ended.returncode == 2
    assert "next:" not in ended.stderr
    assert "robot.toml" in ended.stderr
