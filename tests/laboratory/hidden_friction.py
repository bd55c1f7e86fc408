"""Rows of a joint that goes to and fro at several speeds, with a law hidden in its torque."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.kinds.friction.answers.problem import friction_problems
from stiffcal.kinds.friction.fitting.torque_rows import steady_rows
from stiffcal.kinds.friction.logs.friction_run import FrictionRun
from stiffcal.kinds.friction.logs.runs import reduce_friction
from stiffcal.kinds.row_search import RowProblem
from stiffcal.measurements.load_states import RunInfo
from stiffcal.model.assembled.composite import PlacedEffect
from stiffcal.model.catalogue.catalogue import find_effects
from stiffcal.model.effect import Place
from tests.laboratory.joint_strokes import LAW, robot, to_and_fro

Law = Callable[[Floats, Floats, Floats], Floats]
SPEEDS = (0.02, 0.04, 0.08, 0.15, 0.3, 0.5, 0.8, 1.2)
NOISE = 1.0


def nothing(angle: Floats, velocity: Floats, warm: Floats) -> Floats:
    return 0.0 * angle


def problem_of(
    law: Law,
    joint: int = 1,
    temperature: bool = True,
    seed: int = 0,
    per_pass: float = 0.0,
    rises_once: bool = False,
    added: Mapping[str, Mapping[str, float]] | None = None,
    with_friction: bool = True,
) -> RowProblem:
    """Return the rows of runs at eight speeds; ``law`` gives torque at angle, velocity and warmth, K.

    Parameters
    ----------
    per_pass : N·m, standard deviation of a friction that each run has of its own.
    rises_once : whether the drive warms up steadily; else it cools down in between.
    added : effects of the model beyond joint-friction, with values. with_friction : whether the model has that.
    """
    rng = np.random.default_rng(seed)
    runs, begins = [], 0.0
    for number in rng.permutation(len(SPEEDS)):
        time, angle = to_and_fro(SPEEDS[number], cycles=2)
        velocity = np.gradient(angle, time)
        warm = 12.0 * (1.0 - np.exp(-(begins + time) / 300.0))
        warm = 0.04 * (begins + time) if rises_once else warm * np.cos((begins + time) / 80.0)
        torque = 40.0 * np.sign(velocity) + 30.0 * velocity + law(angle, velocity, warm)
        torque += NOISE * rng.normal(size=time.size) + per_pass * rng.normal() * np.sign(velocity)
        angles, torques = np.zeros((time.size, 6)), np.zeros((time.size, 6))
        angles[:, joint - 1], torques[:, joint - 1] = angle, torque
        kelvin = 293.15 + warm if temperature else None
        info = RunInfo(f"{SPEEDS[number]:g}", "friction")
        runs.append(FrictionRun(info, None, begins + time, angles, torques, None, kelvin))
        begins += float(time[-1])
    reduction = reduce_friction(runs, robot())
    assert reduction.samples is not None
    place = Place("joints", (joint,))
    basic = (PlacedEffect(LAW, place),) if with_friction else ()
    more = (PlacedEffect(find_effects()[name], place, values) for name, values in (added or {}).items())
    rows = steady_rows(reduction.samples)
    (problem,) = friction_problems(rows, np.arange(len(rows)), (*basic, *more), robot(), frozenset())
    return problem
