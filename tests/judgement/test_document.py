"""The document of a judgement: what could not be excluded, and the load that would decide."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from stiffcal.diagnosis.answers.results import DiagnoseResult
from stiffcal.judgement.diagnosed import DiagnosedStates, diagnose_states
from stiffcal.judgement.document import _deciding_force, diagnosis_result
from stiffcal.measurements.load_states import Sigma
from stiffcal.model.catalogue.catalogue import built_in_effects
from tests.laboratory.robots import six_axes
from tests.laboratory.simulated_states import joint_springs, medium_robot, played

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def diagnosed() -> tuple[DiagnosedStates, DiagnoseResult]:
    """Return the diagnosis of a model that is complete."""
    states = played(medium_robot(), runs=4, noise=Sigma(16e-6, 30e-6, 0.5, 0.1), seed=3)
    found = diagnose_states(states, joint_springs(six_axes()), built_in_effects())
    return found, diagnosis_result(found)


def test_where_nothing_is_found_each_place_has_a_size_and_an_effect(
    diagnosed: tuple[DiagnosedStates, DiagnoseResult],
) -> None:
    _, result = diagnosed
    assert not result.missing
    assert result.excluded_sizes
    assert {one.effect for one in result.excluded_sizes} <= set(built_in_effects())
    assert {one.of for one in result.excluded_sizes} >= {f"joint {k}" for k in range(1, 6)}


def test_the_load_that_decides_makes_an_effect_of_the_noise_as_large_as_what_is_found(
    diagnosed: tuple[DiagnosedStates, DiagnoseResult],
) -> None:
    found, result = diagnosed
    noise = found.first.fit.noise_length["translation"]
    force = float(np.linalg.norm(found.states.wrench[:, :3], axis=1).max())
    assert noise
    forces = {one.of: one for one in result.excluded_sizes or () if one.deciding_force_N is not None}
    assert forces
    assert not {"time", "instrument"} & set(forces)
    for one in forces.values():
        assert one.size_m
        assert one.deciding_force_N
        assert one.deciding_force_N == pytest.approx(force * one.size_m / noise)
        assert one.deciding_force_N > force
    # no load that the robot cannot bear is proposed
    weak = replace(found.first.fit.robot.chain, rated_payload=0.01)
    fit = SimpleNamespace(noise_length=found.first.fit.noise_length, robot=SimpleNamespace(chain=weak))
    of_weak = SimpleNamespace(kept_states=found.kept_states, noise_known=True, first=SimpleNamespace(fit=fit))
    size = SimpleNamespace(grows_with_load=True, size=2.0 * noise)
    assert _deciding_force(cast(Any, of_weak), cast(Any, size)) is None


def test_what_was_not_compared_is_stated(diagnosed: tuple[DiagnosedStates, DiagnoseResult]) -> None:
    _, result = diagnosed
    assert result.not_weighed is not None
    assert 0.0 < result.not_weighed < 0.5
