"""The practice campaigns of single joints: what `improve` adds, against what is hidden in them."""

from __future__ import annotations

import gzip
import shutil
from pathlib import Path

import numpy as np
import pytest

from stiffcal.commands.diagnose import diagnose_campaign
from stiffcal.commands.history import read_history
from stiffcal.commands.report import report_campaign
from stiffcal.report.building import lay_out
from stiffcal.report.gathering.content import report_content
from stiffcal.stages.fit import up_to_date_fit
from stiffcal.stages.steps import RunContext, up_to_date_states
from stiffcal.stages.validation import up_to_date_validation
from tests.laboratory.once import once
from tests.laboratory.practice_marks import with_practice
from tests.rates.practice_joints import JOINTS, LEAST_P, JointAnswer, ask_joint, read_truths, series_of_p_form

NAMES = sorted(read_truths())


def answer_of(name: str) -> JointAnswer:
    """Return `improve`'s answer of one campaign, asked once in a session."""
    return once(ask_joint, JOINTS / name)


@pytest.mark.long
@pytest.mark.parametrize("name", with_practice(NAMES, "02", "05"))
def test_the_hidden_effects_are_added(name: str) -> None:
    answer = answer_of(name)
    assert answer.searched
    if answer.truth.outside:
        assert answer.unexplained
        assert answer.named == ()
        return
    assert set(answer.named) == answer.truth.hidden
    assert not answer.unexplained
    assert answer.p_value > LEAST_P


@pytest.mark.long
@pytest.mark.parametrize(
    "name",
    [
        *with_practice(["01", "02", "03", "04", "06", "07"], "02"),
        pytest.param(
            "08",
            marks=[
                pytest.mark.practice,
                pytest.mark.xfail(
                    strict=True, reason="1.057: the fit of the true laws leaves 1.048, as 480 means scatter by 3 %"
                ),
            ],
        ),
    ],
)
def test_held_out_errors_are_within_five_percent_of_the_noise(name: str) -> None:
    assert answer_of(name).after < 1.05


def test_series_of_the_p_form() -> None:
    p = np.array([1e5, 2e7, -3e10])
    coefficients, jacobian = series_of_p_form(p)
    # the curve at an angle so small that the fourth order is below 1e-9 of the first
    angle = 1e-6
    torque = float(p @ angle ** np.array([1.0, 2.0, 3.0]))
    assert coefficients @ torque ** np.array([1.0, 2.0, 3.0]) == pytest.approx(angle, rel=1e-9)
    steps = 1e-6 * p
    differences = [
        (series_of_p_form(p + step)[0] - series_of_p_form(p - step)[0]) / (2.0 * step.sum()) for step in np.diag(steps)
    ]
    np.testing.assert_allclose(np.transpose(differences), jacobian, rtol=1e-6, atol=1e-30)


@pytest.mark.parametrize("name", ["02", "08"])
def test_a_joint_on_a_bench_gets_a_report(name: str, tmp_path: Path) -> None:
    """One joint has no dimensions to draw: its pages leave the robot's pictures out."""
    folder = Path(shutil.copytree(JOINTS / name, tmp_path / name, ignore=shutil.ignore_patterns("store")))
    report = report_campaign(folder)
    assert Path(report.file).stat().st_size > 10_000
    context = RunContext()
    data = up_to_date_states(folder, context)
    identified = up_to_date_fit(data, context)
    validation = up_to_date_validation(data, identified, context)
    content = report_content(data, identified, validation, read_history(folder, context))
    sections = {section.title: section for section in lay_out(content)}
    first_page = " ".join(str(block) for block in sections["Summary"].blocks)
    assert " 0 readings" not in first_page
    assert "It cannot be validated" not in first_page
    assert "predicted" in first_page


def test_logs_of_a_hundred_readings_are_searched_too(tmp_path: Path) -> None:
    """What a lab notes by hand or logs slowly: three cycles of 36 readings in each position."""
    folder = shutil.copytree(JOINTS / "02", tmp_path / "02", ignore=shutil.ignore_patterns("store"))
    for log in (folder / "raw").iterdir():
        head, *rows = gzip.decompress(log.read_bytes()).decode().splitlines()
        log.write_bytes(gzip.compress("\n".join([head, *rows[::28]]).encode()))
    diagnosis = diagnose_campaign(folder)
    assert [effect.effect for effect in diagnosis.missing] == ["backlash"]
    assert not diagnosis.unexplained
