"""What a report holds of a campaign: its pages in order, and every number of the fit."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from stiffcal.commands.history import read_history
from stiffcal.report.blocks import Paragraph
from stiffcal.report.building import lay_out
from stiffcal.report.gathering.content import report_content
from stiffcal.report.gathering.states import _loads
from stiffcal.stages.fit import up_to_date_fit
from stiffcal.stages.steps import RunContext, up_to_date_states
from stiffcal.stages.validation import up_to_date_validation
from tests.laboratory.absolute_places import absolute_states
from tests.laboratory.hidden_campaigns import copied
from tests.laboratory.robots import six_axes


@pytest.mark.parametrize("name", ["01", "08"])
def test_a_campaign_without_a_diagnosis_lays_out(name: str, tmp_path: Path) -> None:
    folder, context = copied(name, tmp_path), RunContext()
    data = up_to_date_states(folder, context)
    identified = up_to_date_fit(data, context)
    history = read_history(folder, context)
    content = report_content(data, identified, up_to_date_validation(data, identified, context), history)
    titles = [section.title for section in lay_out(content)]
    assert titles[:2] == ["Summary", "History of fits: from no model to the noise"]
    assert titles[2:4] == ["The campaign", "Stiffness"]
    left_out = lay_out(content)[-1].blocks[-1]
    assert isinstance(left_out, Paragraph)
    # the pages of a diagnosis that was not made, and nothing of what nobody asked for
    assert left_out.text.startswith("Left out: ")
    assert left_out.text.count("stiffcal diagnose") == 1
    assert content.identify is not None
    assert len(content.identify.parameters) == len(content.joint_names)
    assert content.states is not None
    assert np.isfinite(content.states.measured).all()
    # positions alone in 08
    assert content.states.measured.shape[1] == (6 if name == "01" else 3)


def test_absolute_poses_with_a_payload_have_its_weight_as_load() -> None:
    chain = six_axes()
    wrench = np.zeros((4, 6))
    wrench[2:, 2] = -1177.2
    states = absolute_states(chain, 4, 1, wrench=wrench)
    # each row is a run of its own, and its own first state
    states = replace(states, reference=np.ones(4, dtype=np.bool_))
    force, direction, _ = _loads(states, chain)
    assert_allclose(force, wrench[:, :3])
    assert direction.tolist()[2:] == ["near −z"] * 2
