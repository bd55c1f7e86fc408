"""Places of a target that was lost, and components of it that are dead, in an instrument turned against the base."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.errors import InputError
from stiffcal.measurements.load_states import LoadStates, Sigma, TrackerPlace
from stiffcal.mechanics.rotations import rotation_from_vector
from stiffcal.mistakes.displacements.stopped_targets import stopped_targets
from stiffcal.mistakes.references.kinematics import check_kinematics
from stiffcal.quantities import unit
from stiffcal.reduction.logs.plausibility import LogQuality
from stiffcal.reduction.registration.still_components import still_components
from stiffcal.reduction.set_aside.run_displacements import check_displacements
from tests.laboratory.robots import DEGREES, SIX_STIFFNESS, six_axes
from tests.laboratory.simulated_states import joint_springs, played

NOISE = Sigma(translation=20e-6, force=0.3)
PLACED = np.eye(4)
PLACED[:3, :3], PLACED[:3, 3] = rotation_from_vector(np.array([0.1, -0.3, 2.1])), (3.4, -1.1, 0.4)


@pytest.fixture(scope="module")
def runs() -> LoadStates:
    """Four runs of 25 positions, read by a tracker that is turned against the base."""
    states = played(joint_springs(six_axes(), np.array(SIX_STIFFNESS)), 4, noise=NOISE, full_pose=False)
    return replace(states, setup=replace(states.setup, trackers=(TrackerPlace("tracker", PLACED),)))


def _read(states: LoadStates, change: Callable[[Floats], None]) -> LoadStates:
    """Return states whose readings (n, 3), m in the tracker's axes, were changed."""
    places = (states.position[:, 0] - PLACED[:3, 3]) @ PLACED[:3, :3]
    change(places)
    return replace(states, position=(places @ PLACED[:3, :3].T + PLACED[:3, 3])[:, None])


@pytest.mark.parametrize("component", [0, 1, 2])
@pytest.mark.parametrize("rows", [slice(25, 50), slice(30, 44)])
def test_a_component_that_stands_still_is_named(component: int, rows: slice, runs: LoadStates) -> None:
    def dead(places: Floats) -> None:
        places[rows, component] = places[rows.start, component]

    (line,) = stopped_targets(_read(runs, dead), six_axes())
    assert f"rows {runs.row[rows.start]} to {runs.row[rows.stop - 1]}: {'XYZ'[component]} of" in line


@pytest.mark.parametrize(("value", "components"), [(0.0, [0, 1, 2]), (0.0, [1]), (-9.999, [0, 1, 2]), (-9.999, [2])])
@pytest.mark.parametrize("rows", [slice(30, 34), slice(30, 48)])
def test_rows_of_a_lost_target_are_named(value: float, components: list[int], rows: slice, runs: LoadStates) -> None:
    def lost(places: Floats) -> None:
        places[rows, components] = value

    (fault,) = check_displacements(_read(runs, lost), "campaign.toml")
    assert f"({runs.row[rows.start]}-{runs.row[rows.stop - 1]})" in fault.reason


def test_another_unit_is_no_lost_target(runs: LoadStates) -> None:
    def in_millimetres(places: Floats) -> None:
        places *= 1e3

    (first, *_) = check_displacements(_read(runs, in_millimetres), "campaign.toml")
    assert "units" in first.mend


def test_a_component_that_is_dead_in_all_runs_is_named(runs: LoadStates) -> None:
    assert still_components(runs) == []

    def dead(places: Floats) -> None:
        places[:, 1] = 0.3

    states = _read(runs, dead)
    (fault,) = check_kinematics(states, six_axes(), estimated=False, stated=DEGREES)
    assert "Y of" in fault.mend
    (name,) = still_components(states)
    assert name == f"Y of {states.setup.target_names[0]}"


def test_numbers_filled_in_are_a_lost_target() -> None:
    columns = {"position.probe": ("X", "Y", "Z")}
    log = LogQuality("raw/a.csv", "line {}".format, True, columns, declared=dict.fromkeys("XYZ", unit("mm", "length")))
    places = np.random.default_rng(1).uniform(1.0, 1.1, (3, 40))
    places[:, 20:23] = -9.999
    with pytest.raises(InputError) as refused:
        log.update(np.arange(1, 41), np.arange(40.0), {"position.probe": places})
    (fault,) = refused.value.faults
    assert fault.place == "line 21"
    assert 'rows = "X != -9999"' in fault.mend


def test_a_component_that_stops_within_a_log_is_named() -> None:
    places = np.random.default_rng(1).uniform(1.0, 1.1, (3, 80))
    places[1, 30:50] = places[1, 30]
    assert "column Y" in _remark(places)
    places[:, 30:50] = places[:, [30]]
    assert "(X, Y, Z)" in _remark(places)


def _remark(places: Floats) -> str:
    log = LogQuality("raw/a.csv", "line {}".format, True, {"position.probe": ("X", "Y", "Z")})
    log.update(np.arange(1, places.shape[1] + 1), np.arange(places.shape[1], dtype=float), {"position.probe": places})
    (remark,) = log.summary().remarks()
    return remark
