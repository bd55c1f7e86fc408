"""The pictures of effects of moving joints: what is left without each and with it, against what drives it."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np

from stiffcal.kinds.friction.answers.parts import friction_evidence
from stiffcal.model.summary import EffectAt, Where
from stiffcal.presentation.values import Marks, Picture
from stiffcal.stages.experiments import measured_runs
from stiffcal.stages.steps import RunContext, up_to_date_states

CAMPAIGN = Path(__file__).parents[2] / "campaigns" / "joints" / "08"
HIDDEN = ("torque-ripple", "friction-temperature")


def left_in(picture: Picture) -> list[float]:
    """Return the rms of the points in each panel, N·m."""
    points = [
        np.concatenate([marks.y for marks in panel.series if isinstance(marks, Marks)]) for panel in picture.panels
    ]
    return [float(np.sqrt(np.mean(y**2))) for y in points]


def test_each_missing_effect_has_its_own_picture(tmp_path: Path) -> None:
    folder = Path(shutil.copytree(CAMPAIGN, tmp_path / "08", ignore=shutil.ignore_patterns("store")))
    measured = measured_runs(up_to_date_states(folder, RunContext()))
    assert friction_evidence(measured) == []  # joint-friction alone is what every model begins with
    missing = tuple(EffectAt(effect=name, where=Where(joints=[1])) for name in HIDDEN)
    ripple, warming = friction_evidence(replace(measured, missing=missing))
    assert [panel.x_label for panel in ripple.panels] == ["angle of the joint [°]"] * 2
    assert [panel.x_label for panel in warming.panels] == ["temperature above the first reading [K]"] * 2
    # the noise of a mean is 0.485 N·m; each is judged with the other in the fit
    for picture, without in ((ripple, 2.1), (warming, 0.62)):
        before, after = left_in(picture)
        assert abs(before - without) < 0.05
        assert abs(after - 0.508) < 0.02
