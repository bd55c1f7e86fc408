"""No effect is named in place of an error of a robot file that absolute places contradict."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.judgement.diagnosed import diagnose_states
from stiffcal.judgement.document import diagnosis_result
from stiffcal.mechanics.chain import Chain, GeometryTolerance
from stiffcal.model.catalogue.catalogue import built_in_effects
from tests.rates.playing import simulate_runs

DEFAULT = GeometryTolerance(5e-4, 3.5e-4, stated=False)
# What a wrong forearm is mimicked by, and what it is not: trying all would take a minute.
CATALOGUE = {
    name: effect
    for name, effect in built_in_effects().items()
    if name in ("joint-compliance", "bearing-tilt", "axis-coupling", "base-compliance", "joint-full", "tool-compliance")
}


def longer(chain: Chain, joint: int, axis: int, length: float) -> Chain:
    """Return the chain with one length off, m, and the tolerance of a robot file that states none."""
    fixed = chain.fixed.copy()
    fixed[joint - 1][axis, 3] += length
    return replace(chain, fixed=fixed, tolerance=DEFAULT)


@pytest.mark.long
def test_a_forearm_that_is_30_mm_longer_is_no_effect() -> None:
    campaign = simulate_runs("none", np.random.default_rng([31, 4]))
    wrong = replace(campaign.model, chain=longer(campaign.model.chain, 4, 0, 0.03))
    result = diagnosis_result(diagnose_states(campaign.states, wrong, CATALOGUE))
    # what comes nearest is listed, and not certain
    assert not any(one.firm for one in result.missing)
    assert result.unexplained
    assert result.wrong_geometry is not None
    assert result.wrong_geometry.explains > 0.8
    assert result.wrong_geometry.misfit > 6.0
    assert any("robot.toml" in warning for warning in result.warnings)
    assert "geometry" in result.summary


@pytest.mark.long
def test_the_right_robot_file_is_not_doubted() -> None:
    campaign = simulate_runs("none", np.random.default_rng([31, 4]))
    right = replace(campaign.model, chain=replace(campaign.model.chain, tolerance=DEFAULT))
    found = diagnose_states(campaign.states, right, CATALOGUE)
    assert found.wrong_geometry is None
    assert found.found == ()
    assert found.adequate
