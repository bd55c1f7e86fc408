"""One effect at all joints together: found where many small errors are, not where the error is of another kind."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from stiffcal.diagnosis.everywhere import effect_everywhere, everywhere_in_words
from stiffcal.diagnosis.explained import Explained
from stiffcal.diagnosis.load_search_context import LoadSearchContext
from stiffcal.diagnosis.search_results import Search
from stiffcal.effects.joint_compliance import JointCompliance
from stiffcal.effects.joint_eccentricity import JointEccentricity
from stiffcal.effects.link_geometry import LinkGeometry
from stiffcal.identification.identify import Settings, fit_problem
from stiffcal.measurements.load_states import LoadStates
from stiffcal.model.catalogue import built_in_effects
from stiffcal.model.composite import CompliantRobot
from stiffcal.model.effect import Effect
from tests.laboratory.absolute_places import absolute_states, measured_by, on_all_joints
from tests.laboratory.robots import six_axes

N_POSES = 150
TRIED = ("joint-eccentricity", "link-weight", "cubic-stiffness", "backlash")


@cache
def looked_at(wave: float, unknown: float, held: Effect | None = None) -> tuple[LoadSearchContext, Search]:
    """Return the unexplained search of places with waves of so many rad at all joints and an error of so many metres.

    The error is a smooth function of the joints' angles that no effect of the catalogue makes; ``held`` is an effect
    that the model holds at all joints beyond link geometry.
    """
    chain, rng = six_axes(), np.random.default_rng(11)
    waves = [{"a": wave * float(rng.choice([-1.0, 1.0])), "b": wave, "order": 1.0} for _ in range(6)]
    plan = absolute_states(chain, N_POSES, 5)
    states = measured_by(CompliantRobot(chain, tuple(on_all_joints(JointEccentricity(), 6, waves))), plan, 6)
    states = replace(states, position=states.position + unknown * strange(states, rng))
    more = [] if held is None else on_all_joints(held, 6)
    robot = CompliantRobot(chain, (*on_all_joints(LinkGeometry(), 6), *more))
    catalogue = {name: built_in_effects()[name] for name in TRIED}
    bench = LoadSearchContext(states, fit_problem(states, robot), catalogue, Settings())
    scan = bench.look(robot)
    search = Search(
        first=scan, found=(), tried=(), final=scan.fit, final_scan=scan, before=None, after=None,
        explained=Explained(0.0, 0.0, 0.0, 0.0), unexplained=True, not_tried=(), pace=bench.pace(),
    )  # fmt: skip
    return bench, search


def strange(states: LoadStates, rng: np.random.Generator) -> np.ndarray:
    """Return (n, 1, 3) waves of sums of the angles of all joints, rms 1."""
    along = rng.normal(size=(3, 6))
    waves = np.sin(states.joints @ along.T + rng.uniform(0.0, 6.0, 3))
    return np.asarray(np.sqrt(2.0) * waves[:, None])


def test_waves_of_all_joints_lower_the_error_in_both_schemes() -> None:
    bench, search = looked_at(wave=3e-4, unknown=1e-4)
    found = effect_everywhere(bench, search)
    assert found is not None
    assert found.effect == "joint-eccentricity"
    assert found.where.joints == [1, 2, 3, 4, 5, 6]
    assert found.n_parameters == 18
    for scheme in (found.heldout_random, found.heldout_region):
        assert scheme.standard_errors > 4.0
        # the error of another kind stays, but for what the geometry takes of it
        assert 1e-4 < scheme.after < 0.85 * scheme.before
    words = everywhere_in_words(found)
    assert "joint-eccentricity of joints 1, 2, 3, 4, 5, 6 together" in words
    assert "not a cause" in words


def test_an_error_of_another_kind_is_no_effect_of_all_joints() -> None:
    bench, search = looked_at(wave=0.0, unknown=2e-4)
    assert effect_everywhere(bench, search) is None


def test_a_model_that_holds_one_gets_another_as_long_as_the_error_falls() -> None:
    found = effect_everywhere(*looked_at(wave=3e-4, unknown=1e-4, held=JointCompliance()))
    assert found is not None
    assert found.effect == "joint-eccentricity"


@pytest.mark.parametrize("change", [{"unexplained": False}, {"found": ("something",)}, {"undecided": ("rivals",)}])
def test_what_is_explained_or_named_needs_none(change: dict[str, object]) -> None:
    bench, search = looked_at(wave=3e-4, unknown=1e-4)
    assert effect_everywhere(bench, replace(search, **change)) is None  # type: ignore[arg-type]
