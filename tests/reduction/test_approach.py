"""From which side drives came to rest: of rows that follow each other, of logged signs, of coupled drives."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.campaign.manifest.manifest import Run
from stiffcal.measurements.set_aside import IN_USE
from stiffcal.reduction.states.approach import LEAST_MOTION, approach_of_drives, last_motion
from stiffcal.reduction.states.raw_states import RawStates
from tests.laboratory.robots import six_axes


def raw(number: list[int], logged: Floats | None = None, run: str = "poses") -> RawStates:
    n = len(number)
    signals = {} if logged is None else {"joints.approach": logged}
    nothing = np.full(n, np.nan)
    return RawStates(
        [run] * n, np.array(number), nothing, nothing, signals, {}, np.ones(n, dtype=np.int64), [IN_USE] * n
    )


def test_a_drive_that_stays_keeps_its_last_motion() -> None:
    angles = np.array([[0.0, 0.0], [0.1, 0.5 * LEAST_MOTION], [0.1, -0.2], [0.05, -0.2], [0.05, 0.3]])
    follows = np.array([False, True, True, True, True])
    assert last_motion(angles, follows).tolist() == [[0, 0], [1, 0], [1, -1], [-1, -1], [-1, 1]]


def test_a_row_that_is_missing_ends_the_sequence() -> None:
    angles = np.zeros((5, 6))
    angles[:, 2] = [0.0, 0.1, 0.2, 0.3, 0.1]
    runs = {"poses": Run(id="poses", experiment="absolute", approach="direct")}
    found = approach_of_drives(raw([1, 2, 4, 5, 6]), angles, np.ones(5, dtype=np.bool_), six_axes(), runs)
    assert found[:, 2].tolist() == [0, 1, 0, 1, -1]
    assert not found[:, [0, 1, 3, 4, 5]].any()


def test_nothing_is_known_where_nothing_is_stated() -> None:
    runs = {"poses": Run(id="poses", experiment="absolute")}
    angles = np.cumsum(np.ones((3, 6)), axis=0)
    everywhere = np.ones(3, dtype=np.bool_)
    assert approach_of_drives(raw([1, 2, 3]), angles, everywhere, six_axes(), runs).shape == (3, 0)
    # in load runs the joints stand still while the load changes
    assert approach_of_drives(raw([1, 2, 3], np.ones((3, 6))), angles, ~everywhere, six_axes(), runs).shape == (3, 0)


def test_logged_signs_count_before_those_of_the_rows() -> None:
    logged = np.full((3, 6), np.nan)
    logged[1, 0], logged[2, 1] = -7.5, 0.0
    angles = np.cumsum(np.ones((3, 6)), axis=0)
    runs = {"poses": Run(id="poses", experiment="absolute", approach="direct")}
    found = approach_of_drives(raw([1, 2, 3], logged), angles, np.ones(3, dtype=np.bool_), six_axes(), runs)
    assert found[:, 0].tolist() == [0, -1, 1]
    assert found[:, 1].tolist() == [0, 1, 1]


def test_signs_are_those_of_the_drives() -> None:
    """FANUC's third joint is shown against the horizontal: its drive turns by the sum, against its sense."""
    chain = six_axes()
    coupling = np.eye(6)
    coupling[0, 0], coupling[2, 1] = -1.0, 1.0
    chain = replace(chain, coupling=coupling)
    logged = np.array([[1.0, 1, 1, 0, 0, 0], [1.0, 1, -1, 0, 0, 0]])
    found = approach_of_drives(raw([1, 2], logged), np.zeros((2, 6)), np.ones(2, dtype=np.bool_), chain, {})
    assert found.tolist() == [[-1, 1, 1, 0, 0, 0], [-1, 1, 0, 0, 0, 0]]


@pytest.mark.parametrize(
    ("degrees", "signs"),
    [
        # a creeping drive has moved as soon as its small steps sum up to the least motion, and goes on moving
        ([0.0, 0.04, 0.08, 0.12, 0.16], [0, 0, 1, 1, 1]),
        # the drive has to come back from the farthest angle, which the small last step reached
        ([0.0, 0.10, 0.13, 0.09, 0.07], [0, 1, 1, 1, -1]),
        # noise about a place is no motion, however long it lasts
        ([0.0, 0.02, -0.02, 0.02, -0.02, 0.02], [0, 0, 0, 0, 0, 0]),
        # just below the least motion, and just above
        ([0.0, -0.0499, 0.0], [0, 0, 0]),
        ([0.0, -0.0501, 0.0], [0, -1, 1]),
    ],
)
def test_which_motion_is_the_last_one(degrees: list[float], signs: list[int]) -> None:
    turned = np.radians(np.array(degrees))[:, None]
    follows = np.arange(len(degrees)) > 0
    assert last_motion(turned, follows)[:, 0].tolist() == signs
    assert last_motion(-turned, follows)[:, 0].tolist() == [-sign for sign in signs]


def test_small_steps_before_a_missing_row_do_not_count_after_it() -> None:
    turned = np.radians(np.array([0.0, 0.04, 0.08, 0.08, 0.04]))[:, None]
    assert last_motion(turned, np.array([False, True, False, True, True]))[:, 0].tolist() == [0, 0, 0, 0, 0]
