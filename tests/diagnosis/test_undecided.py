"""What is answered where no effect of a group has half of its probability."""

from __future__ import annotations

from dataclasses import replace

import pytest

from stiffcal.judgement.diagnosed import diagnose_states
from stiffcal.judgement.document import diagnosis_result
from stiffcal.measurements.load_states import Sigma
from stiffcal.model.assembled.composite import PlacedEffect
from stiffcal.model.catalogue.catalogue import built_in_effects
from stiffcal.model.effect import Place
from tests.laboratory.robots import six_axes
from tests.laboratory.simulated_states import joint_springs, medium_robot, played


@pytest.mark.long
def test_an_effect_that_has_less_than_the_others_of_its_group_is_undecided() -> None:
    """The tilt of a wrist joint shows a third of the noise: joints 4, 5 and 6 are not distinguished."""
    robot, tilt = medium_robot(), built_in_effects()["bearing-tilt"]
    hidden = PlacedEffect(tilt, Place("joints", (5,)), {"x": 1e-6, "y": 1e-6})
    states = played(replace(robot, placed=(*robot.placed, hidden)), runs=8, noise=Sigma(16e-6, 30e-6, 0.5, 0.1), seed=2)
    answer = diagnosis_result(diagnose_states(states, joint_springs(six_axes()), {"bearing-tilt": tilt}))
    (missing,) = answer.missing
    assert missing.firm is False
    assert missing.probability == pytest.approx(1.0, abs=0.01)
    assert missing.member_probability is not None
    assert missing.member_probability < 0.6
    assert [5] in [one.where.joints for one in answer.undecided]
    assert sum(one.share or 0.0 for one in answer.undecided) == pytest.approx(1.0, abs=0.06)
    assert [one.probability for one in answer.undecided] == [one.share for one in answer.undecided]
    assert "undecided" in answer.summary
