"""Look-alikes in the weights of the model with the effect: steep laws carry the wrench's noise into the readings."""

from __future__ import annotations

from dataclasses import replace

from stiffcal.diagnosis.document import proposed
from stiffcal.diagnosis.naming import near_best
from stiffcal.diagnosis.search import search_missing
from stiffcal.diagnosis.search_results import Search
from stiffcal.measurements.load_states import Sigma
from stiffcal.model.catalogue import built_in_effects
from stiffcal.model.composite import PlacedEffect
from stiffcal.model.effect import Place
from tests.laboratory.robots import six_axes
from tests.laboratory.simulated_states import joint_springs, medium_robot, played

# A knee of three times the noise of the torque, which makes 0.3 mrad of it where the drive winds up.
KNEE = PlacedEffect(built_in_effects()["two-slope"], Place("joints", (4,)), {"c": 5e-4, "knee": 2.0})


def searched(seed: int, knee: float = 2.0) -> Search:
    """Search a campaign with the knee, N·m, for it and its look-alike."""
    robot, catalogue = medium_robot(), {name: built_in_effects()[name] for name in ("backlash", "two-slope")}
    true = replace(robot, placed=(*robot.placed, replace(KNEE, values={"c": 5e-4, "knee": knee})))
    states = played(true, runs=8, noise=Sigma(16e-6, 30e-6, 0.5, 0.6), load_scatter=0.3, seed=seed)
    return search_missing(states, joint_springs(six_axes()), catalogue)


def test_what_only_the_weights_without_the_effect_separate_is_an_alternative() -> None:
    """The scan sets them two standard errors apart, of residuals twice the noise; in its own weights it is less."""
    search = searched(seed=9)
    assert [trial.candidate.name for trial in near_best(search.first)] == ["two-slope j4"]
    named = search.found[0]
    assert named.candidate.name == "two-slope j4"
    assert [other.name for other in named.alternatives] == ["backlash j4"]
    assert len(proposed(named).alternatives) == 1
    assert proposed(named).alternatives[0].cosine == named.cosines[0]


def test_what_both_weights_separate_is_named_alone() -> None:
    """A knee of ten times the noise of the torque: enough states lie below it."""
    named = searched(seed=2, knee=6.0).found[0]
    assert named.candidate.name == "two-slope j4"
    assert named.alternatives == ()
