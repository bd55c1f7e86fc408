"""A balancing spring that robot.toml states counts in the sag, and is named where it may be the cause of a misfit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.identification.answers.document import fit_warnings
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.geometry import with_geometry
from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.measurements.load_states import LoadStates, Sigma
from stiffcal.mechanics.chain import Chain, GeometryTolerance
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.catalogue.catalogue import find_effects
from stiffcal.model.effect import Place
from tests.laboratory.robots import SIX_STIFFNESS, six_axes
from tests.laboratory.simulated_states import joint_springs, played

RATE = 2e5  # N/m
SPRING: dict[str, object] = {
    "joint": 2, "anchor_m": [-0.4, 0.0, -0.2], "arm_m": [0.3, 0.05, 0.0], "rate_N_m": RATE, "preload_N": 3e4,
}  # fmt: skip
TOLERANCE = GeometryTolerance(3e-4, 3e-4)


def chain(**changed: object) -> Chain:
    return replace(six_axes(), compensator={**SPRING, **changed}, tolerance=TOLERANCE)


@pytest.fixture(scope="module")
def states() -> LoadStates:
    noise = Sigma(translation=2e-5, rotation=1e-5, force=0.5, moment=0.1)
    return played(joint_springs(chain(), np.array(SIX_STIFFNESS)), 10, noise=noise)


def fitted(states: LoadStates, robot: CompliantRobot) -> Fit:
    return with_geometry(identify_parameters(states, robot), states)


def spring_warnings(fit: Fit) -> list[str]:
    return [text for text in fit_warnings(fit) if "absolute positions" in text]


def test_a_stated_spring_that_the_model_lacks_contradicts_no_place(states: LoadStates) -> None:
    fit = fitted(states, joint_springs(chain()))
    assert spring_warnings(fit) == []
    stiffness = 1.0 / np.array([parameter.value for parameter in fit.parameters])
    np.testing.assert_allclose(stiffness, SIX_STIFFNESS, rtol=0.03)


def test_a_spring_of_unknown_rate_is_offered_as_the_cause(states: LoadStates) -> None:
    (text,) = spring_warnings(fitted(states, joint_springs(chain(rate_N_m=None))))
    assert "gravity-compensator" in text
    # nothing of the kind where the file declares none
    (text,) = spring_warnings(fitted(states, joint_springs(replace(six_axes(), tolerance=TOLERANCE))))
    assert "gravity-compensator" not in text


def test_the_effect_estimates_the_rate_and_does_not_count_it_twice(states: LoadStates) -> None:
    """Whatever is stated: with half the rate, and half the preload, the free length is the same."""
    stated = chain(rate_N_m=0.5 * RATE, preload_N=1.5e4)
    place = Place("joints", (2,))
    effect = PlacedEffect(find_effects()["gravity-compensator"].at(place, stated), place)
    springs = joint_springs(stated)
    fit = fitted(states, replace(springs, placed=(*springs.placed, effect)))
    rate = fit.parameter("gravity-compensator.j2.rate")
    assert rate.value is not None
    assert rate.std is not None
    assert abs(rate.value - RATE) < 4.0 * rate.std
    assert rate.std < 0.25 * RATE
    assert spring_warnings(fit) == []
