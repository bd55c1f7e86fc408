"""campaigns/mixed: load, clamped and friction runs of one robot, one model, one diagnosis, one ladder."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from scipy.stats import chi2

from stiffcal.campaign.loading import load_campaign
from stiffcal.commands.diagnose import diagnose_campaign
from stiffcal.commands.identify import identify_campaign
from stiffcal.commands.improve import improve_campaign
from stiffcal.results.identify_result import IdentifyResult
from stiffcal.simulation.settings import load_settings
from stiffcal.simulation.simulate import simulate_campaign
from tests.benchmarks.mixed_coverage import deviation
from tests.laboratory.kr125 import some_runs
from tests.whole_campaigns.conftest import CAMPAIGNS

# Enough of the runs for five searches in a row, and for what one fit states.
FEWER = ("pose1", "pose2", "pose3", "pose4", "clamped6-a", "clamped6-b", "friction1", "friction2")
HIDDEN = {("backlash", (6,)), ("stribeck", (2,))}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("mixed") / "out"
    simulate_campaign(load_campaign(CAMPAIGNS / "mixed", check_files=False), load_settings(CAMPAIGNS / "mixed"), out)
    return out


@pytest.fixture(scope="module")
def begun(folder: Path) -> IdentifyResult:
    return identify_campaign(folder)


def test_without_the_play_loads_and_clamped_runs_disagree(tmp_path: Path) -> None:
    source = Path(shutil.copytree(CAMPAIGNS / "mixed", tmp_path / "source"))
    for name in ("campaign.toml", "simulate.toml"):
        (source / name).write_text(some_runs((source / name).read_text("utf-8"), FEWER), "utf-8")
    simulate_campaign(load_campaign(source, check_files=False), load_settings(source), tmp_path / "out")
    (agreement,) = identify_campaign(tmp_path / "out").agreement or []
    assert (agreement.first, agreement.second) == ("loads", "clamped")
    (parameter,) = agreement.parameters
    assert parameter.name == "joint-compliance.j6.c"
    assert not agreement.agree
    assert abs(parameter.standard_errors) > 10.0


@pytest.mark.practice
def test_both_hidden_effects_are_named_and_no_others(folder: Path, begun: IdentifyResult) -> None:
    diagnosis = diagnose_campaign(folder)
    assert {(effect.effect, tuple(effect.where.joints or ())) for effect in diagnosis.missing} == HIDDEN
    assert not diagnosis.unexplained
    finding = diagnosis.findings[0]
    assert finding.effect == "backlash"
    # the effect that the bench shows is tried on the tracker's data as well
    assert {kind.experiment: (kind.n_fell, kind.n_folds) for kind in finding.by_experiment or []} == {
        "loads": (8, 8),
        "clamped": (15, 15),
    }
    for kind in finding.by_experiment or []:
        assert (kind.after or 0.0) < 0.85 * (kind.before or 0.0)


def test_the_ladder_ends_at_the_noise_with_true_values(folder: Path, begun: IdentifyResult) -> None:
    improved = improve_campaign(folder)
    added = {(step.effect, tuple(step.where.joints or ())) for step in improved.steps if step.effect is not None}
    assert added == HIDDEN
    assert not improved.unexplained
    result = identify_campaign(folder)
    assert result.reduced_chi2 is not None
    assert result.reduced_chi2 < 1.1
    truth = load_campaign(CAMPAIGNS / "mixed", check_files=False).model.parameter_settings()
    statistic, count = deviation(result, {name: setting.value for name, setting in truth.items() if setting.value})
    assert count == 15
    assert chi2.sf(statistic, count) > 1e-3
    (agreement,) = result.agreement or []
    assert agreement.agree
    assert agreement.dof == 3


@pytest.mark.practice
def test_from_compliances_alone_friction_comes_first_and_what_is_on_top_of_it_then(
    folder: Path, tmp_path: Path
) -> None:
    """Torque of which the model says nothing is all error; no other effect is named in its place."""
    copy = Path(shutil.copytree(folder, tmp_path / "copy", ignore=shutil.ignore_patterns("store")))
    manifest = (copy / "campaign.toml").read_text("utf-8")
    (copy / "campaign.toml").write_text(some_runs(manifest, FEWER), "utf-8")
    compliances = (copy / "model.toml").read_text("utf-8").split('[[effects]]\ntype = "joint-friction"')[0]
    (copy / "model.toml").write_text(compliances.split('[[effects]]\ntype = "backlash"')[0], "utf-8")
    improved = improve_campaign(copy)
    added = [(step.effect, tuple(step.where.joints or ())) for step in improved.steps if step.effect is not None]
    assert set(added) == {*HIDDEN, ("joint-friction", (1,)), ("joint-friction", (2,))}
    assert added.index(("joint-friction", (2,))) < added.index(("stribeck", (2,)))
    errors = [step.heldout_rms.torque or 0.0 for step in improved.steps if step.heldout_rms is not None]
    assert errors[0] == pytest.approx(125.0, rel=0.02)  # all of the torque that was measured
    assert errors == sorted(errors, reverse=True)
    assert not improved.unexplained
