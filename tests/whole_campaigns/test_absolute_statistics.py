"""Fifty campaigns of absolute places: residuals are the noise, and springs are within their joint covariance."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.effects.joint_compliance import JointCompliance
from stiffcal.effects.link_geometry import LinkGeometry
from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.model.assembled.composite import CompliantRobot
from tests.laboratory.absolute_places import absolute_states, measured_by, on_all_joints
from tests.laboratory.robots import SIX_STIFFNESS, six_axes

SEEDS, N_POSES = 50, 80


@pytest.mark.practice
def test_reduced_chi_square_and_springs_over_fifty_seeds() -> None:
    """Issue 16: mean reduced χ² 1.00 ± 0.04. Poses, geometry and noise are drawn anew with each seed.

    With 240 readings and some 31 numbers the mean of fifty scatters by √(2/209/50) = 0.014.
    """
    chain = six_axes()
    springs = [{"c": 1.0 / float(stiffness)} for stiffness in SIX_STIFFNESS]
    reduced, of_springs, degrees = [], 0.0, 0
    for seed in range(SEEDS):
        rng = np.random.default_rng([20261201, seed])
        errors = [
            dict(zip(("x", "y", "rx", "ry"), rng.normal(0.0, (2.5e-4, 2.5e-4, 5e-4, 5e-4)), strict=True))
            for _ in range(6)
        ]
        true = (*on_all_joints(LinkGeometry(), 6, errors), *on_all_joints(JointCompliance(), 6, springs))
        states = measured_by(CompliantRobot(chain, true), absolute_states(chain, N_POSES, 1000 + seed), 2000 + seed)
        model = (*on_all_joints(LinkGeometry(), 6), *on_all_joints(JointCompliance(), 6))
        fit = identify_parameters(states, CompliantRobot(chain, model))
        assert fit.last_step is None
        assert fit.reduced_chi2 is not None
        reduced.append(fit.reduced_chi2)
        # joints 2 and 3 are far from the bound at zero, where a normal distribution would not hold
        names = [f"joint-compliance.j{joint}.c" for joint in (2, 3)]
        chosen = [fit.free_names.index(name) for name in names]
        away = np.array([fit.robot.values()[name] for name in names]) - 1.0 / np.array(SIX_STIFFNESS[1:3])
        of_springs += float(away @ np.linalg.solve(fit.covariance[np.ix_(chosen, chosen)], away))
        degrees += len(names)
    print(f"mean reduced chi-square {np.mean(reduced):.4f}, springs {of_springs:.1f} of {degrees}")
    assert np.mean(reduced) == pytest.approx(1.0, abs=0.04)
    # χ² of 100: 99.9 % lie between 61.9 and 149.4
    assert 60.0 < of_springs < 150.0
