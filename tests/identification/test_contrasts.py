"""Contrasts of repeats are Helmert's, group by group, whatever the sizes of the groups."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg

from stiffcal.identification.fitting.identify import fit_problem
from stiffcal.identification.noise.contrasts import contrasts
from tests.laboratory.simulated_states import medium_robot, played


def test_contrasts_are_those_of_helmerts_matrix() -> None:
    truth = medium_robot()
    data = fit_problem(played(truth), truth).data
    rng = np.random.default_rng(1)
    m, n = data.measured.shape
    measured, predicted = rng.normal(size=(m, n)), rng.normal(size=(m, n))
    sensitivity, mask = rng.normal(size=(m, 6, n)), np.ones((m, n), dtype=np.bool_)
    groups = np.split(rng.permutation(n)[:20], [3, 5, 9, 12, 17])
    mask[:, groups[2][0]] = False  # one of four was not read
    found = contrasts(replace(data, measured=measured, measured_mask=mask), predicted, sensitivity, groups)
    first = 0
    for group in groups:
        kept = group[mask[:, group].all(axis=0)]
        # scipy's rows compare the earlier with the later as ours do, with the other sign
        matrix = -scipy.linalg.helmert(len(kept))
        own = slice(first, first + len(kept) - 1)
        assert found.differences[own] == pytest.approx(matrix @ (measured - predicted)[:, kept].T, abs=1e-12)
        assert found.run[own].tolist() == [data.run[kept[0]]] * (len(kept) - 1)
        first += len(kept) - 1
    assert first == len(found.differences) == len(found.compliance)


def test_without_repeats_there_are_none() -> None:
    truth = medium_robot()
    data = fit_problem(played(truth), truth).data
    m, n = data.measured.shape
    found = contrasts(data, np.zeros((m, n)), np.zeros((m, 6, n)), [np.array([0])])
    assert found.differences.shape == (0, m)
