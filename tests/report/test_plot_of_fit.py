"""Pictures of a fit: which readings they are of, in which unit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.measurements.load_states import Sigma
from stiffcal.presentation.pictures import Picture
from stiffcal.report.gathering import plot_of_fit
from stiffcal.report.gathering.plot_of_fit import picture_of_fit, pictures_of_fit, residuals_in_noises, statistics_page
from stiffcal.report.kept_pictures import KeptPictures
from stiffcal.report.pictures_of_fit import PictureOfFit
from stiffcal.stages.fit import fit_again, fit_now, up_to_date_fit_at_hand
from stiffcal.stages.steps import RunContext, up_to_date_states
from tests.laboratory.simulated_states import medium_robot, played


def test_residuals_are_in_noises_by_what_was_read() -> None:
    truth = medium_robot()
    states = played(truth, noise=Sigma(15e-6, 2e-5), seed=3)
    fit = identify_parameters(states, truth)
    found = residuals_in_noises(fit)
    assert list(found) == ["displacements and gauges", "rotations"]
    for values in found.values():
        # n readings scatter by one, to 1 / sqrt(2 n)
        assert np.sqrt(np.mean(values**2)) == pytest.approx(1.0, abs=4.0 / np.sqrt(2.0 * values.size))


@pytest.mark.parametrize("of", ["correlation", "influence"])
def test_a_model_without_a_free_parameter_says_so(of: str, campaign: Path) -> None:
    model = campaign / "model.toml"
    held = ", ".join(f'"joint-compliance.j{k}.c" = {{ value = 2e-6, fixed = true }}' for k in range(1, 7))
    model.write_text(model.read_text(encoding="utf-8") + f"parameters = {{ {held} }}\n", encoding="utf-8")
    context = RunContext()
    assert picture_of_fit(of, up_to_date_states(campaign, context), context).panels[0].empty


def test_the_history_is_drawn_in_the_unit_of_its_errors(campaign: Path) -> None:
    context = RunContext()
    panel = picture_of_fit("history", up_to_date_states(campaign, context), context).panels[0]
    assert panel.y_label == "error in held-out data, rms [mm]"


def test_a_picture_in_the_report_is_known_by_the_key_of_its_fit_and_computed_where_it_is_drawn() -> None:
    def never() -> Picture:
        raise AssertionError

    same = [KeptPictures().key(PictureOfFit("normal", key, "", never)) for key in ("a", "a", "b")]
    assert same[0] == same[1] != same[2]


def test_a_fit_that_was_made_now_is_not_made_again(campaign: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    context = RunContext()
    data = up_to_date_states(campaign, context)
    identified = up_to_date_fit_at_hand(data, context)[0]
    fit = fit_now(data, identified.loss, context)
    monkeypatch.setattr(plot_of_fit, "fit_again", None)
    assert pictures_of_fit(data, identified, context, fit)["normal"]().panels[0].series


def test_a_fit_that_is_made_again_starts_where_it_ended(campaign: Path) -> None:
    context = RunContext()
    data = up_to_date_states(campaign, context)
    identified = up_to_date_fit_at_hand(data, context)[0]
    again = fit_again(data, identified, context)
    assert again is not None
    spread = np.sqrt(np.diag(again.covariance))
    ends = {one.name: one.value for one in again.parameters}
    for one, std in zip(identified.parameters, spread, strict=True):
        # a fit ends where a step is a hundredth of a standard uncertainty
        assert ends[one.name] == pytest.approx(one.value, abs=0.02 * std)


def test_the_statistics_of_a_fit_are_a_page_of_pictures(campaign: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    context = RunContext()
    data = up_to_date_states(campaign, context)
    identified = up_to_date_fit_at_hand(data, context)[0]
    page = statistics_page(data, identified, context)
    assert page is not None
    drawn = [block for block in page.blocks if isinstance(block, Picture)]
    assert len(drawn) == len(page.blocks) == 2
    assert all(picture.caption for picture in drawn)
    assert drawn[0].panels[0].series
    # every parameter has a profile that is asked for one
    monkeypatch.setattr("stiffcal.identification.profiles.NEAR_BOUND", 1e9)
    page = statistics_page(data, identified, context)
    assert page is not None
    assert isinstance(page.blocks[0], Picture)
    assert {panel.title.split(".")[0] for panel in page.blocks[0].panels} == {"joint-compliance"}
