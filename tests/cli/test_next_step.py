"""The last line of each answer follows the loop."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from stiffcal.cli.next_step import after_diagnosis, after_validation
from stiffcal.measurements.rms import Rms

FOLDER = Path("campaign")


def validation(error: Rms, noise: Rms | None) -> Any:
    """Return a validation with an error and a noise alone."""
    return SimpleNamespace(rms=error, noise=noise)


def diagnosis(**found: Any) -> Any:
    """Return a diagnosis of a complete model but for what is given."""
    return SimpleNamespace(**({"missing": [], "superfluous": [], "pattern": None} | found))


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
    assert after_diagnosis(FOLDER, diagnosis(superfluous=["an effect"]), None) == "stiffcal improve campaign"
    assert after_diagnosis(FOLDER, diagnosis(), None) == "stiffcal report campaign"
    assert after_diagnosis(FOLDER, diagnosis(), None, finished="view") == "stiffcal view campaign"
