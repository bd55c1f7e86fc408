"""Laws that cross steeply: the wrench's noise is carried into the readings by the model that is judged."""

from __future__ import annotations

from dataclasses import replace

import pytest

from stiffcal.judgement.diagnosed import DiagnosedStates, diagnose_states
from stiffcal.measurements.load_states import Sigma
from stiffcal.model.assembled.composite import PlacedEffect
from stiffcal.model.catalogue.catalogue import built_in_effects
from stiffcal.model.effect import Place
from tests.laboratory.named_effects import named, named_with_alike
from tests.laboratory.robots import six_axes
from tests.laboratory.simulated_states import joint_springs, medium_robot, played

pytestmark = pytest.mark.long

JOINT = Place("joints", (4,))


def searched(seed: int, effect: str, values: dict[str, float]) -> DiagnosedStates:
    """Diagnose a campaign with one of two laws that look alike, 0.3 N·m of noise in the torque."""
    robot, catalogue = medium_robot(), {name: built_in_effects()[name] for name in ("backlash", "two-slope")}
    true = replace(robot, placed=(*robot.placed, PlacedEffect(catalogue[effect], JOINT, values)))
    states = played(true, runs=8, noise=Sigma(16e-6, 30e-6, 0.5, 0.6), load_scatter=0.3, seed=seed)
    return diagnose_states(states, joint_springs(six_axes()), catalogue)


@pytest.mark.practice
@pytest.mark.parametrize("seed", [2, 9])
@pytest.mark.parametrize(
    ("effect", "values"),
    # a knee of three times the noise of the torque, which makes 0.3 mrad of it where the drive winds up
    [("two-slope", {"c": 5e-4, "knee": 2.0}), ("backlash", {"width": 2e-3, "band": 2.0})],
)
def test_the_law_that_is_there_is_named_or_listed(seed: int, effect: str, values: dict[str, float]) -> None:
    found = searched(seed, effect, values)
    (names,) = named_with_alike(found)
    assert f"{effect} j4" in names
    assert not found.unexplained


def test_a_knee_of_ten_times_the_noise_of_the_torque_is_named_alone() -> None:
    """Enough states lie below it."""
    found = searched(2, "two-slope", {"c": 5e-4, "knee": 6.0})
    assert named(found) == ["two-slope j4"]
    assert found.found[0].alternatives == ()
    assert found.found[0].group.firm
