"""Places and loads of one robot together and each alone, over seeds: ``python -m tests.benchmarks.absolute_and_loads``.

The robot is MuJoCo (`tests.laboratory.absolute_and_loads`). Of each seed: the standard uncertainty of the stiffness
from both together over that from the loads alone, joint by joint; the distance of predicted from true places, without
noise, in poses that were not measured, from both together and from the places alone; reduced χ².
The distances of a seed are one draw of the noise. What the covariances predict stands next to them: the expected
distance, and the probability that a draw of the noise makes the places from both together the worse ones.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.stats import chi2

from stiffcal.arrays import Floats
from stiffcal.estimation.unknowns import ParameterColumn, free_columns
from stiffcal.identification.derivatives.observation import evaluate, observe
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.geometry import with_geometry
from stiffcal.identification.fitting.identify import identify_parameters, predict_observations
from stiffcal.measurements.load_states import LoadStates, RunInfo
from stiffcal.measurements.state_measures import StateMeasure
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.catalogue.campaign_effects import placed_robot
from stiffcal.stages.steps import RunContext, up_to_date_states
from tests.laboratory.absolute_and_loads import Truth, write_campaign
from tests.laboratory.effect_bench import bare_states
from tests.laboratory.robots import six_axis_joints

N_HELD_OUT = 1000
N_DRAWS = 4000
JOINTS = range(1, 7)


@dataclass(frozen=True)
class Compared:
    """One seed."""

    std_ratio: Floats
    """(6,) standard uncertainty of each joint's compliance, together over loads alone."""
    place_error: tuple[float, float]
    """m rms in poses that were not measured: together, places alone."""
    expected_error: tuple[float, float]
    """m, the same as the two covariances predict it."""
    chance_worse: float
    """Probability that a draw of the noise makes the first of the two the larger one."""
    reduced_chi2: float
    """Of the fit of both together."""
    stiffness_chi2: float
    """Of the six compliances against the truth, by their joint covariance."""


def std_of(fit: Fit) -> Floats:
    """Return (6,) standard uncertainties of the joint compliances; infinite where one is not identified."""
    parameters = [fit.parameter(f"joint-compliance.j{joint}.c") for joint in JOINTS]
    return np.array([parameter.std or np.inf for parameter in parameters])


def unmeasured(states: LoadStates, truth: Truth, robot: CompliantRobot, seed: int) -> LoadStates:
    """Return rows of poses that were not measured, with their true places as the states' tracker frame has them."""
    joints = six_axis_joints(np.random.default_rng([7, seed]), N_HELD_OUT)
    nothing = np.zeros((N_HELD_OUT, 6))
    placed = states.setup.trackers[0].base_from_frame
    turn, shift = placed[:3, :3], placed[:3, 3]
    places = truth.places(robot.chain, joints, nothing) @ turn.T + shift
    rows = bare_states(
        list(range(N_HELD_OUT)),
        joints,
        states.setup,
        position=places[:, None],
        wrench=nothing,
        time=np.zeros(N_HELD_OUT),
    )
    runs = tuple(
        RunInfo(f"row {k + 1}", "absolute", of="unmeasured", measures=StateMeasure.PLACE) for k in range(N_HELD_OUT)
    )
    return replace(rows, runs=runs)


def rms_distance(fit: Fit, rows: LoadStates) -> float:
    """Return how far a fit's places are from the true ones, m rms."""
    data = observe(rows, fit.robot.chain)
    away = data.measured - predict_observations(fit.robot, data)
    return float(np.sqrt(np.mean(np.sum(away**2, axis=0))))


def predicted_distances(together: Fit, places: Fit, rows: LoadStates) -> tuple[tuple[float, float], float]:
    """Return the expected distances, m rms, of both fits, and the probability that the first is the larger.

    The places alone are a part of both together, whose estimate is efficient: the difference of the two estimates is
    not correlated with it, and has the difference of their covariances.
    """
    data = observe(rows, together.robot.chain)
    columns = [c for c in free_columns(together.robot) if column_name(together, c) in places.free_names]
    names = [column_name(together, c) for c in columns]
    blocks = evaluate(together.robot, data, columns)
    slopes = np.concatenate([block.columns for block in blocks], axis=2).reshape(len(names), -1)
    gram = slopes @ slopes.T / len(rows)
    both, alone = (
        fit.covariance[np.ix_(chosen, chosen)]
        for fit, chosen in ((fit, [fit.free_names.index(name) for name in names]) for fit in (together, places))
    )
    expected = [float(np.sqrt(np.sum(gram * covariance))) for covariance in (both, alone)]
    rng = np.random.default_rng(5)
    own = rng.multivariate_normal(np.zeros(len(names)), both, N_DRAWS, method="eigh")
    more = rng.multivariate_normal(np.zeros(len(names)), alone - both, N_DRAWS, method="eigh", check_valid="ignore")
    first, second = (np.einsum("ni,ij,nj->n", drawn, gram, drawn) for drawn in (own, own + more))
    return (expected[0], expected[1]), float(np.mean(first > second))


def column_name(fit: Fit, column: ParameterColumn) -> str:
    """Return the full name of a column's parameter."""
    return fit.robot.placed[column.placed].parameter_name(column.symbol)


def compare(folder: Path, seed: int) -> Compared:
    """Write the campaign of a seed, and fit both kinds of runs together and each alone."""
    truth = write_campaign(folder, seed)
    data = up_to_date_states(folder, RunContext())
    states, robot = data.states, placed_robot(data.campaign)
    springs = replace(robot, placed=tuple(p for p in robot.placed if p.effect.name == "joint-compliance"))
    together = with_geometry(identify_parameters(states, robot), states)
    loads_alone = states.select(~states.absolute)
    loads = with_geometry(identify_parameters(loads_alone, springs), loads_alone)
    places = identify_parameters(states.select(states.absolute), robot)
    rows = unmeasured(states, truth, robot, seed)
    names = [f"joint-compliance.j{joint}.c" for joint in JOINTS]
    chosen = [together.free_names.index(name) for name in names]
    away = np.array([together.robot.values()[name] for name in names]) - 1.0 / truth.stiffness
    statistic = float(away @ np.linalg.solve(together.covariance[np.ix_(chosen, chosen)], away))
    expected, chance_worse = predicted_distances(together, places, rows)
    return Compared(
        std_of(together) / std_of(loads),
        (rms_distance(together, rows), rms_distance(places, rows)),
        expected,
        chance_worse,
        together.reduced_chi2 or np.nan,
        statistic,
    )


def main(arguments: Sequence[str] | None = None) -> None:
    """Print each seed and what is true of all of them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=50)
    parser.add_argument("--first", type=int, default=1)
    wanted = parser.parse_args(arguments)
    found = []
    for seed in range(wanted.first, wanted.first + wanted.seeds):
        with tempfile.TemporaryDirectory() as folder:
            compared = compare(Path(folder) / "out", seed)
        found.append(compared)
        ratios = ", ".join(f"{ratio:.3f}" for ratio in compared.std_ratio)
        together, alone = 1e6 * np.array(compared.place_error)
        expected, expected_alone = 1e6 * np.array(compared.expected_error)
        print(
            f"seed {seed}: ± over loads alone {ratios}; places {together:.1f} µm, alone {alone:.1f} µm, expected "
            f"{expected:.1f} and {expected_alone:.1f} µm, worse with probability {compared.chance_worse:.3f}; "
            f"reduced χ² {compared.reduced_chi2:.3f}",
            flush=True,
        )
    largest = max(float(compared.std_ratio.max()) for compared in found)
    better = [
        compared.std_ratio.max() < 1.0 and compared.place_error[0] < compared.place_error[1] for compared in found
    ]
    no_worse = sum(compared.place_error[0] <= compared.place_error[1] for compared in found)
    errors, expected_errors = (
        np.array([getattr(c, name) for c in found]) for name in ("place_error", "expected_error")
    )
    ratio, expected_ratio = (both[:, 0] / both[:, 1] for both in (errors, expected_errors))
    chances = np.array([compared.chance_worse for compared in found])
    print(
        f"places over places alone: mean {ratio.mean():.3f}, largest {ratio.max():.3f}; expected mean "
        f"{expected_ratio.mean():.3f}, largest {expected_ratio.max():.3f}; worse in {np.sum(ratio > 1.0)}, expected "
        f"{chances.sum():.1f} ± {np.sqrt(np.sum(chances * (1.0 - chances))):.1f}; mean square over what is expected "
        f"{np.mean(errors[:, 0] ** 2 / expected_errors[:, 0] ** 2):.3f}, alone "
        f"{np.mean(errors[:, 1] ** 2 / expected_errors[:, 1] ** 2):.3f}"
    )
    statistic, dof = sum(compared.stiffness_chi2 for compared in found), 6 * len(found)
    print(
        f"largest ratio of ± {largest:.3f}; places no worse in {no_worse} of {len(found)}; better than each alone in "
        f"{sum(better)} of {len(found)}; mean reduced χ² {np.mean([c.reduced_chi2 for c in found]):.4f}; stiffness "
        f"against the truth χ² {statistic:.1f} of {dof}, p {chi2.sf(statistic, dof):.3f}"
    )


if __name__ == "__main__":
    main()
