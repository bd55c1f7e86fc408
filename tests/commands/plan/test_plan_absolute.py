"""`plan` for absolute places: each pose once, under the robot's own weight."""

from __future__ import annotations

import csv
import shutil
from pathlib import Path

import numpy as np
import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.campaign.plan_file import PlanFile
from stiffcal.commands.plan import plan_campaign
from stiffcal.planning.campaign.pairs import Candidates
from stiffcal.planning.campaign.request import PlanRequest
from stiffcal.planning.choice import identifiable
from stiffcal.stages.fit import fit_now
from stiffcal.stages.plans.model import planned_model
from stiffcal.stages.steps import RunContext, up_to_date_states

CAMPAIGN = Path(__file__).parents[3] / "campaigns" / "absolute" / "01"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a campaign of absolute places without its table."""
    for name in ("campaign.toml", "robot.toml", "model.toml"):
        shutil.copy(CAMPAIGN / name, tmp_path / name)
    return tmp_path


def test_the_expected_uncertainties_are_those_of_the_fit(tmp_path: Path) -> None:
    """At the poses that were measured, with the values and the noise that were found there."""
    context = RunContext(store=str(tmp_path / "store"))
    data = up_to_date_states(CAMPAIGN, context)
    fit = fit_now(data, "linear", context)
    assert fit is not None
    assert fit.noise is not None
    campaign = load_campaign(CAMPAIGN)
    model = planned_model(campaign, PlanFile.model_validate({}), context)
    used = data.states.select(data.states.used)
    runs = model.information(Candidates(used.joints, np.zeros((len(used), 1, 6))))
    free, _ = identifiable(runs.factors, None, runs.nonlinear)
    rows = runs.factors[:, :, free].reshape(-1, int(free.sum()))
    promised = np.sqrt(np.diagonal(np.linalg.inv(rows.T @ rows))) * runs.scale[free]
    names = [name for name, is_free in zip(runs.names, free, strict=True) if is_free]
    obtained = dict(zip(fit.free_names, np.sqrt(np.diagonal(fit.covariance)), strict=True))
    assert set(names) == set(obtained)
    # the fit scales by what is left, which with these degrees of freedom scatters by a few per cent
    np.testing.assert_allclose(promised, [obtained[name] for name in names], rtol=0.1)


def test_places_are_planned_by_determinant_and_their_folder_is_ready(folder: Path) -> None:
    out = folder / "next"
    plan = plan_campaign(folder, request=PlanRequest(campaign=out))
    assert (plan.experiment, plan.criterion) == ("absolute", "determinant")
    # twice as many numbers as parameters: 33 that no others make up for
    assert len(plan.runs) == 22
    assert plan.efficiency > 0.95
    assert plan.observability is not None
    assert plan.observability.n_poses == 22
    rows = list(csv.DictReader((out / "runs.csv").read_text(encoding="utf-8").splitlines()))
    assert len(rows) == 22
    assert {row["Fz [N]"] for row in rows} == {"0.0"}
    made = load_campaign(out, check_files=False)
    assert [run.experiment for run in made.manifest.runs] == ["absolute"]
    # weight turns no vertical axis
    assert "joint-compliance.j1.c" in plan.not_identified
    remedies = {remedy.parameter: remedy.means for remedy in plan.remedies or []}
    assert any(text.startswith("load runs") for text in remedies["joint-compliance.j1.c"])


def test_payloads_show_what_weight_alone_does_not(folder: Path) -> None:
    alone = plan_campaign(folder)
    text = 'schema = "stiffcal/plan-input/1"\nruns = 22\n[load]\ndead_weights_kg = [20.0]\n'
    (folder / "plan.toml").write_text(text, encoding="utf-8")
    loaded = plan_campaign(folder, request=PlanRequest(program=folder / "poses.src"))
    assert "joint-compliance.j5.c" in alone.not_identified
    assert "joint-compliance.j5.c" not in loaded.not_identified
    assert {float(np.round(run.wrench[0, 2], 1)) for run in loaded.runs} == {0.0, -196.2}
    program = (folder / "poses.src").read_text(encoding="ascii")
    assert "196 N along (0.00, 0.00, -1.00)" in program
