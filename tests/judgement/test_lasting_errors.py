"""The zero of a force sensor, which all states of a run share."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.identification.derivatives.observation import Observations, observe, predicted, rests
from stiffcal.identification.fitting.regressors import Linearised
from stiffcal.identification.noise.reading_noise import Noise
from stiffcal.judgement.lasting_errors import lasting_errors, made_by
from stiffcal.measurements.load_states import Sigma
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.catalogue.catalogue import built_in_effects
from stiffcal.model.effect import Place
from tests.laboratory.simulated_states import medium_robot, played

NOISE = Noise(16e-6, 30e-6, 0.5, 0.1, "manifest", np.inf)
SIGMA = Sigma(NOISE.translation, NOISE.rotation, NOISE.force, NOISE.moment)
PLAY = PlacedEffect(built_in_effects()["backlash"], Place("joints", (1,)), {"width": 1e-3, "band": 5.0})


def made_by_zeros(robot: CompliantRobot) -> tuple[Observations, Floats]:
    """Return readings of three runs of a robot, and what the errors that states share make in them."""
    data = observe(played(robot, runs=3, noise=SIGMA, seed=5), robot.chain)
    _, columns = made_by(lasting_errors(Linearised.about(robot, data), NOISE), data, by_run=False)
    return data, columns


def with_play() -> CompliantRobot:
    robot = medium_robot()
    return replace(robot, placed=(*robot.placed, PLAY))


def test_of_springs_alone_the_constant_of_a_run_takes_it() -> None:
    assert len(made_by_zeros(medium_robot())[1]) == 0


def test_next_to_a_play_it_shifts_readings_as_the_model_says() -> None:
    robot = with_play()
    data, columns = made_by_zeros(robot)
    runs = [np.unique(data.run[column.any(axis=0)]) for column in columns]
    assert all(len(run) == 1 for run in runs)
    assert {int(run[0]) for run in runs} == {0, 1, 2}
    at_rest = predicted(robot, data, *rests(robot, data))
    for run in range(3):
        own = data.run == run
        shifted = data.wrench + np.where(own, 0.02 * np.repeat([NOISE.force, NOISE.moment], 3)[:, None], 0.0)
        moved = replace(data, wrench=shifted)
        change = without_constant((predicted(robot, moved, *rests(robot, moved)) - at_rest)[:, own])
        makes = np.array(
            [without_constant(column[:, own]) for column, (of_run,) in zip(columns, runs, strict=True) if of_run == run]
        )
        left = change - makes.T @ np.linalg.lstsq(makes.T, change, rcond=None)[0]
        assert np.linalg.norm(left) < 0.1 * np.linalg.norm(change)


def without_constant(readings: Floats) -> Floats:
    """Return (m · n,) readings (m, n) less the constant of their run."""
    return np.ravel(readings - readings.mean(axis=1, keepdims=True))
