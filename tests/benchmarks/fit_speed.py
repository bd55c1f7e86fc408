"""From load states in memory to a `Fit`: 36 compliances, 200 000 full poses, against `numpy.linalg.lstsq`.

The peer gets the finished observation matrix (1.2 million rows, 36 columns) and only solves it, on one thread like us.
We observe, build the matrix, weigh, eliminate each run's offset, solve, and say what the data cannot tell. Two fits:
first order (wanted: at most 3 × the peer's time) and balanced on the deformed robot (at most 8 ×). Peak memory is that
of a process of its own that makes the states and runs the balanced fit (wanted: below 1.5 GB).
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from dataclasses import replace
from time import perf_counter

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.estimation.unknowns import free_columns
from stiffcal.identification.derivatives.observation import evaluate, observe
from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.balance.equilibrium import solve_balance
from stiffcal.model.effect import Law, NodeLoads, ParameterSpec, Place, Term, Values
from tests.laboratory.mujoco_states import NOISE, turn_by
from tests.laboratory.robots import SIX_STIFFNESS, force_sensor_setup, six_axes, six_axis_joints
from tests.laboratory.unread_states import unread_states

FIRST_ORDER, BALANCED, GIGABYTES = 3.0, 8.0, 1.5
STATES_PER_RUN = 100


class JointSprings(Law):
    """All six compliances of a joint: joint-compliance, bearing-tilt and joint-translation together."""

    name = "joint-springs"
    place_kind = "joints"
    summary = "six springs in a joint"
    parameters = tuple(
        ParameterSpec(symbol, unit, "", 0.0, 1e-3, size, "this benchmark", compliance=True)
        for symbol, unit, size in (
            ("tx", "m/N", 1e-9), ("ty", "m/N", 1e-9), ("tz", "m/N", 1e-9),
            ("x", "rad/(N·m)", 3e-7), ("y", "rad/(N·m)", 3e-7), ("c", "rad/(N·m)", 2e-6),
        )
    )  # fmt: skip

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> list[Term]:
        node = 2 * place.joints[0] - 1
        return [Term(node, a, spec.symbol, loads.wrench[node, a]) for a, spec in enumerate(self.parameters)]


def springs(chain: Chain, deformed: bool, valued: bool) -> CompliantRobot:
    """Return the robot of 36 compliances, with values or to be identified."""
    effect = JointSprings()
    placed = []
    for k in range(1, chain.n_joints + 1):
        values = {spec.symbol: spec.typical for spec in effect.parameters} | {"c": float(1.0 / SIX_STIFFNESS[k - 1])}
        placed.append(PlacedEffect(effect, Place("joints", (k,)), values if valued else {}))
    return CompliantRobot(chain, tuple(placed), deformed)


def many_states(n: int) -> LoadStates:
    """Make n full-pose load states, each run a pose and 100 random loads; the noise is stated."""
    rng = np.random.default_rng(7)
    chain = six_axes()
    setup = replace(force_sensor_setup(chain, 12.0, (0.01, -0.02, 0.09)), sigma=NOISE)
    n_runs = max(2, n // STATES_PER_RUN)
    run = np.repeat(np.arange(n_runs), STATES_PER_RUN)
    n = len(run)
    joints = six_axis_joints(rng, n_runs)
    wrench = rng.normal(size=(n, 6)) * np.repeat([300.0, 40.0], 3)
    wrench[::STATES_PER_RUN] = 0.0
    balance = solve_balance(springs(chain, True, True), chain.model_angles(joints[run]), wrench, setup)
    assert NOISE.translation is not None
    assert NOISE.rotation is not None
    position = balance.target_position + NOISE.translation * rng.normal(size=(n, 1, 3))
    rotation = (turn_by(NOISE.rotation * rng.normal(size=(n, 3))) @ balance.target_rotation[:, 0])[:, None]
    planned = unread_states(joints, wrench.reshape(n_runs, STATES_PER_RUN, 6), setup)
    return replace(planned, hold=np.full(n, 2.0), position=position, rotation=rotation)


def finished_matrix(states: LoadStates) -> tuple[Floats, Floats]:
    """Return the observation matrix (6 n, 36) and the measured displacements, in units of their noise."""
    chain = six_axes()
    robot, data = springs(chain, False, False), observe(states, chain)
    scale = 1.0 / np.where(data.rotational, NOISE.rotation or 1.0, NOISE.translation or 1.0)[:, None]
    blocks = [block.columns * scale for block in evaluate(replace(robot, deformed=False), data, free_columns(robot))]
    matrix = np.concatenate(blocks, axis=2)
    return np.ascontiguousarray(matrix.reshape(len(matrix), -1).T), (data.measured * scale).ravel()


def timed_fit(states: LoadStates, deformed: bool) -> tuple[float, int]:
    """Return seconds and steps of one fit."""
    robot = springs(six_axes(), deformed, False)
    started = perf_counter()
    fit = identify_parameters(states, robot)
    return perf_counter() - started, fit.iterations


def peak_of_own_process(n: int) -> float | None:
    """Return the peak memory, GB, of a process that makes n states and fits them balanced; None on Windows."""
    if sys.platform == "win32":
        return None
    command = [sys.executable, "-m", "tests.benchmarks.fit_speed", "peak", str(n)]
    return float(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def main(n: int = 200_000, repeats: int = 3) -> bool:
    """Print the comparison; return whether all wanted ratios were met."""
    states = many_states(n)
    matrix, measured = finished_matrix(states)
    timed_fit(many_states(2 * STATES_PER_RUN), deformed=True)  # imports are done by now
    peer, first, balanced = [], [], []
    steps = 0
    for _ in range(repeats):  # taking turns, so that a busy machine disturbs all alike
        started = perf_counter()
        np.linalg.lstsq(matrix, measured, rcond=None)
        peer.append(perf_counter() - started)
        first.append(timed_fit(states, deformed=False)[0])
        seconds, steps = timed_fit(states, deformed=True)
        balanced.append(seconds)
    one, two = min(first) / min(peer), min(balanced) / min(peer)
    peak = peak_of_own_process(n)
    print(f"{len(states)} full poses, 36 compliances, one thread")
    print(f"  numpy.linalg.lstsq on the finished matrix {matrix.shape} {min(peer):7.2f} s")
    print(f"  first-order fit        {min(first):7.2f} s: {one:.2f} x the peer (wanted at most {FIRST_ORDER})")
    print(f"  balanced fit           {min(balanced):7.2f} s: {two:.2f} x the peer (wanted at most {BALANCED})")
    print(f"                         in {steps} Gauss-Newton steps")
    if peak is not None:
        print(f"  peak memory            {peak:7.2f} GB (wanted below {GIGABYTES})")
    return one <= FIRST_ORDER and two <= BALANCED and (peak is None or peak < GIGABYTES)


def print_peak(n: int) -> None:
    """Make the states, fit, print this process's peak memory in GB."""
    import resource

    states = many_states(n)
    timed_fit(states, deformed=True)
    unit = 1.0 if sys.platform == "darwin" else 1024.0
    print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit / 1e9)


def run(arguments: Sequence[str]) -> int:
    """Run the comparison, or with ``peak N`` the process whose memory is measured."""
    if len(arguments) == 2 and arguments[0] == "peak":
        print_peak(int(arguments[1]))
        return 0
    return 0 if main() else 1


if __name__ == "__main__":
    sys.exit(run(sys.argv[1:]))
