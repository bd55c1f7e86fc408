"""What large campaigns cost: folds of 4000 runs, the memory of ``diagnose``, ``check`` of many rows and of many logs.

Each figure is compared with its limit. Times are processor time of a whole process of its own, so that others on the
machine do not count; memory is that process's largest resident size. The campaigns are made on the spot, from the
balance of a robot with springs and a play, and from ``campaigns/max100``.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import load_campaign
from stiffcal.estimation.triangular import TriangularFactor, triangular_of_rows
from stiffcal.measurements.load_states import Attachment, MeasurementSetup
from stiffcal.mechanics.like_poses import pose_groups
from stiffcal.mechanics.rotations import vector_from_rotation
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.balance.equilibrium import solve_balance
from stiffcal.model.catalogue.catalogue import find_effects
from stiffcal.model.effect import Place
from stiffcal.propose.templates import bundled_robot
from tests.laboratory.robots import shifted

FOLDS_RATIO = 5.0
DIAGNOSE_MEGABYTES = 1200.0
CHECK_ROWS_S, CHECK_LOGS_S = 4.0, 8.0
STATES_PER_RUN = 20
COLUMNS = 70
COMPLIANCES = (4e-7, 6e-7, 8e-7, 3e-6, 4e-6, 8e-6)
CAMPAIGNS = Path(__file__).parents[2] / "campaigns"
MANIFEST = """schema = "stiffcal/campaign/1"
robot = "robot.toml"
[frames.tracker]
parent = "base"
{tracker}
[frames.tool]
parent = "flange"
{tool}
[sources.table]
file = "table.csv"
sampling = "states"
run = {run}
joints = {{ position = "A1..A6", units = {{ position = "deg" }} }}
"""
WRENCH = """wrench = { columns = ["Fx", "Fy", "Fz", "Tx", "Ty", "Tz"], axes = "base", point = "tool" }
"""
POSE = """[sources.table.pose]
frame = "tracker"
body = "tool"
position = ["X", "Y", "Z"]
rotvec = ["RX", "RY", "RZ"]
units = { position = "mm", rotation = "rad" }
"""
PLACES = """[sources.table.pose]
frame = "tracker"
body = "tool"
position = ["X", "Y", "Z"]
units = { position = "mm" }
sigma = { position = 0.015 }
"""
ABSOLUTE = """[[runs]]
id = "poses"
experiment = "absolute"
"""
TOOL_M = (0.06, -0.04, 0.2)


@dataclass(frozen=True)
class Spent:
    """What a process took: processor seconds, user and system, and its largest resident size in MB."""

    seconds: float
    megabytes: float
    answer: dict[str, Any]
    """The command's document."""


def make_load_campaign(folder: Path, n_runs: int) -> Path:
    """Write a table of full poses under load: runs of an unloaded state and random loads, half of them repeated."""
    place = f"xyz_m = {list(TOOL_M)}"
    text = MANIFEST.format(tracker="xyz_m = [0.0, 0.0, 0.0]", tool=place, run='{ column = "run" }')
    return _written(folder, text + WRENCH + POSE, n_runs, STATES_PER_RUN)


def make_pose_campaign(folder: Path, n_rows: int) -> Path:
    """Write a table of absolute full poses; where tracker and target stand is left to be found."""
    return _written(folder, _absolute() + POSE + ABSOLUTE, n_rows, 1)


def make_place_campaign(folder: Path, n_rows: int) -> Path:
    """Write a table of absolute places without orientation, as of a tracker; two joints' angles err by a sine."""
    errors = [
        PlacedEffect(find_effects()["joint-eccentricity"], Place("joints", (joint,)), {"a": a, "b": -a, "order": order})
        for joint, a, order in ((2, 1e-4, 2.0), (3, 2e-4, 1.0))
    ]
    return _written(folder, _absolute() + PLACES + ABSOLUTE, n_rows, 1, errors)


def _absolute() -> str:
    """Return the manifest's beginning of absolute places: all rows in one run, tracker and target to be found."""
    return MANIFEST.format(tracker="estimate = true", tool="estimate = true", run='""').replace('run = ""\n', "")


def _written(folder: Path, manifest: str, n_runs: int, per_run: int, more_effects: Sequence[PlacedEffect] = ()) -> Path:
    folder.mkdir()
    (folder / "campaign.toml").write_text(manifest, "utf-8")
    (folder / "robot.toml").write_text(bundled_robot("irb4400"), "utf-8")
    chain = load_campaign(folder, check_files=False).chain
    rng, n = np.random.default_rng(3), n_runs * per_run
    joints = np.radians([0.0, 0.0, 0.0, 0.0, 30.0, 0.0] + [60, 35, 25, 100, 60, 120] * rng.uniform(-1, 1, (n_runs, 6)))
    joints = np.repeat(joints, per_run, axis=0)
    wrench = _loads(rng, n_runs, per_run)
    effects = find_effects()
    placed = [
        PlacedEffect(effects["joint-compliance"], Place("joints", (k,)), {"c": c})
        for k, c in enumerate(COMPLIANCES, start=1)
    ]
    play = effects["backlash"]
    typical = {spec.symbol: spec.typical for spec in play.parameters}
    placed.append(PlacedEffect(play, Place("joints", (4,)), typical))
    placed += more_effects
    tool = Attachment(chain.n_joints + 1, shifted(*TOOL_M))
    setup = MeasurementSetup(Attachment(0, np.eye(4)), tool, (tool,), ("tool",), True)
    balance = solve_balance(CompliantRobot(chain, tuple(placed)), chain.model_angles(joints), wrench, setup)
    position = balance.target_position[:, 0] + 15e-6 * rng.normal(size=(n, 3))
    turn = vector_from_rotation(balance.target_rotation[:, 0]) + 3e-5 * rng.normal(size=(n, 3))
    read = wrench + rng.normal(size=(n, 6)) * np.repeat([0.5, 0.1], 3)
    columns = np.column_stack([np.repeat(np.arange(n_runs), per_run), np.degrees(joints), read, 1e3 * position, turn])
    header = "run,A1,A2,A3,A4,A5,A6,Fx,Fy,Fz,Tx,Ty,Tz,X,Y,Z,RX,RY,RZ"
    np.savetxt(folder / "table.csv", columns, ["%d"] + ["%.9g"] * 18, ",", header=header, comments="")
    return folder


def _loads(rng: np.random.Generator, n_runs: int, per_run: int) -> Floats:
    """Return (n_runs · per_run, 6) wrenches: nothing at first, then random loads, each but the last taken twice."""
    wrench = rng.normal(size=(n_runs, per_run, 6)) * np.repeat([300.0, 40.0], 3)
    wrench[:, 0] = 0.0
    half = (per_run - 1) // 2
    again = 1.0 + 0.01 * rng.normal(size=(n_runs, half, 1))
    wrench[:, 1 + half : 1 + 2 * half] = wrench[:, 1 : 1 + half] * again
    return np.asarray(wrench.reshape(-1, 6))


def spent_by(*arguments: str | Path) -> Spent:
    """Run stiffcal with these arguments in a process of its own; raise where it fails."""
    command = [sys.executable, "-P", "-m", "stiffcal", *map(str, arguments), "--json"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE)
    assert process.stdout is not None
    answer = process.stdout.read()
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    # 1 says that something is still missing or does not hold: a table without loads identifies no joint
    if process.returncode not in (0, 1):
        raise subprocess.CalledProcessError(process.returncode, command)
    megabytes = used.ru_maxrss / (1024 if sys.platform != "darwin" else 1024**2)
    return Spent(used.ru_utime + used.ru_stime, megabytes, json.loads(answer))


def seconds_of_folds(n_runs: int) -> float:
    """Return the least of three processor times of sorting runs into poses; a tenth of them are taken twice."""
    rng = np.random.default_rng(n_runs)
    angles = rng.uniform(-1.5, 1.5, (n_runs, 6))
    again = rng.permutation(n_runs)[: n_runs // 10]
    like = angles[again] + np.radians(0.9) * rng.uniform(-1.0, 1.0, (len(again), 6))
    found = pose_groups(np.vstack([angles, like]), np.radians(1.0))
    assert np.array_equal(found, [*range(n_runs), *again]), "runs of one pose were not sorted into it"
    taken = []
    for _ in range(3):
        began = process_time()
        pose_groups(angles, np.radians(1.0))
        taken.append(process_time() - began)
    return min(taken)


def seconds_of_factors(n_rows: int) -> float:
    """Return the processor time of factorising so many rows of `COLUMNS` columns, at once and as they come.

    The factor R of the rows X must keep their inner products, RᵀR = XᵀX.
    """
    rows = np.random.default_rng(n_rows).normal(size=(COLUMNS, n_rows))
    began, pieces = process_time(), TriangularFactor()
    for piece in np.array_split(rows, 5, axis=1):
        pieces.add(piece)
    factors = {"of all rows": triangular_of_rows(rows), "piece by piece": pieces.whole()}
    seconds = process_time() - began
    inner = rows @ rows.T
    for name, factor in factors.items():
        assert np.allclose(factor.T @ factor, inner, rtol=1e-9, atol=1e-9 * n_rows), f"the factor {name} lost rows"
    return seconds


def reported(name: str, value: float, limit: float, unit: str) -> bool:
    """Print a figure with its limit; return whether it holds."""
    holds = value <= limit
    print(f"{name}: {value:.3g}{unit}, limit {limit:g}{unit}: {'holds' if holds else 'MISSED'}", flush=True)
    return holds


def main(states: int = 20_000, rows: int = 2773, runs: int = 4000, logged: str = "max100") -> bool:
    """Print all figures; return whether all limits hold.

    Parameters
    ----------
    states : of the campaign that is diagnosed. rows : of the table that is checked. runs : that are sorted into poses.
    logged : bundled campaign whose simulated logs are checked.
    """
    ratio = seconds_of_folds(runs) / seconds_of_folds(runs // 4)
    assert ratio < 2.0 * FOLDS_RATIO, f"sorting {runs} runs into poses takes the square of their number"
    held = [reported(f"folds of {runs} runs over those of {runs // 4}", ratio, FOLDS_RATIO, " x")]
    print(f"factors of the rows of {states} full poses: {seconds_of_factors(6 * states):.3g} s of processor time")
    with tempfile.TemporaryDirectory(prefix="stiffcal-cost-") as place:
        folder = Path(place)
        loaded = make_load_campaign(folder / "loaded", max(2, states // STATES_PER_RUN))
        diagnosed = spent_by("diagnose", loaded)
        print(f"diagnose of {states} full poses: {diagnosed.seconds:.3g} s of processor time")
        held.append(reported("  its memory", diagnosed.megabytes, DIAGNOSE_MEGABYTES, " MB"))
        checked = spent_by("check", make_pose_campaign(folder / "poses", rows))
        held.append(reported(f"check of {rows} rows of poses", checked.seconds, CHECK_ROWS_S, " s"))
        spent_by("simulate", folder / logged, "--from", CAMPAIGNS / logged)
        checked = spent_by("check", folder / logged)
        held.append(reported(f"check of {logged}", checked.seconds, CHECK_LOGS_S, " s"))
    return all(held)


if __name__ == "__main__":
    sys.exit(0 if main() else 1)
