"""What a remainder of torque over motion follows, judged by folds drawn anew as blocks."""

from __future__ import annotations

import numpy as np

from stiffcal.diagnosis.of_rows.row_structure import LEAST_OF_DRAWS, share_of_draws


def test_a_fall_in_one_fold_alone_is_no_proof() -> None:
    """Nine seconds, one of which makes all of the fall: a third of the resamplings do not hold it."""
    fall = np.full(9, -0.01)
    fall[4] = 10.0
    assert abs(share_of_draws(fall) - (1.0 - (8.0 / 9.0) ** 9)) < 0.03
    assert share_of_draws(fall) < LEAST_OF_DRAWS


def test_a_fall_in_all_folds_is_one() -> None:
    assert share_of_draws(np.linspace(0.1, 2.0, 9)) == 1.0
