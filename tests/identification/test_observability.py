"""Observability indices: their definitions, and what more poses and more noise do to them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.effects.joint_compliance import JointCompliance
from stiffcal.effects.link_geometry import LinkGeometry
from stiffcal.identification.answers.observability import observability_of
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.model.assembled.composite import CompliantRobot
from tests.laboratory.absolute_places import absolute_states, measured_by, on_all_joints
from tests.laboratory.robots import SIX_STIFFNESS, six_axes


def fitted(n_poses: int) -> Fit:
    chain = six_axes()
    springs = on_all_joints(JointCompliance(), 6, [{"c": 1.0 / float(k)} for k in SIX_STIFFNESS])
    states = measured_by(CompliantRobot(chain, tuple(springs)), absolute_states(chain, n_poses, 3), 4)
    return identify_parameters(states, CompliantRobot(chain, tuple(on_all_joints(LinkGeometry(), 6))))


def test_two_parameters_of_known_covariance() -> None:
    """σ = 4 and 2: the indices by hand, for parameters of typical size 3e-4 m (Sun and Hollerbach 2008)."""
    fit = fitted(60)
    names = tuple(name for name in fit.free_names if name.endswith(".x") and name.startswith("link"))[:2]
    assert len(names) == 2
    known = replace(fit, free_names=names, covariance=np.diag([3e-4 / 4.0, 3e-4 / 2.0]) ** 2)
    indices = observability_of(known)
    assert indices is not None
    assert pytest.approx(np.sqrt(8.0) / np.sqrt(60.0)) == indices.O1
    assert pytest.approx(0.5) == indices.O2
    assert pytest.approx(2.0) == indices.O3
    assert pytest.approx(1.0) == indices.O4
    assert pytest.approx(4.0 / 3.0) == indices.O5


def test_four_times_the_poses_double_what_is_known_worst() -> None:
    few, many = observability_of(fitted(60)), observability_of(fitted(240))
    assert few is not None
    assert many is not None
    # poses are drawn anew: by some ten percent
    assert pytest.approx(2.0, rel=0.25) == many.O3 / few.O3
    assert pytest.approx(1.0, rel=0.15) == many.O1 / few.O1


def test_nothing_is_determined_by_nothing() -> None:
    fit = fitted(60)
    assert observability_of(replace(fit, free_names=(), covariance=np.zeros((0, 0)))) is None
