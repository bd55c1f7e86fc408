"""Places and load runs of one robot that MuJoCo is: a campaign folder with its truth, a seed at a time.

The robot's links are off by what assembly leaves, its joints give, its links weigh. One tracker, whose place is
unknown, measures sixty places without a load and then eight poses in which the tool is pulled; a force sensor measures
the pull.
``python -m tests.laboratory.absolute_and_loads`` writes the files of ``campaigns/absolute-and-loads`` again.
"""

from __future__ import annotations

import json
import shutil
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.frames.frames import measurement_setup, resolve_frames
from stiffcal.campaign.loading import load_campaign
from stiffcal.measurements.load_states import Attachment
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.rotations import rotation_from_vector, transform
from tests.laboratory.mujoco_robot import MujocoRobot, Spring
from tests.laboratory.robots import SIX_STIFFNESS, shifted, six_axis_joints, turned

SOURCE = Path(__file__).parents[2] / "campaigns" / "absolute-and-loads"
N_PLACES, N_RUNS = 60, 8
# Levels of one load and unload, in parts of the largest.
LEVELS = (0.5, 1.0, 0.5, 0.0)
FORCE = 400.0
LOAD_POINT = np.array([0.15, 0.05, 0.12])
"""Where the force acts, in the sensor's frame, m: off the last axis, else nothing turns joint 6."""
TRACKER_M, FORCE_N, MOMENT_NM = 2e-5, 0.7, 0.2
SPREAD = {"a": 2.5e-4, "alpha": 3e-4, "theta": 8e-4, "d": 2.5e-4, "beta": 3e-4}
"""Standard deviations of the links' errors, m and rad."""


@dataclass(frozen=True)
class Truth:
    """What is hidden in a campaign."""

    stiffness: Floats
    """(6,) N·m/rad."""
    chain: Chain
    """The robot's true rigid geometry."""
    target: Floats
    """(3,) m, of the target in the flange's frame."""
    tracker_in_base: Floats
    """(4, 4)"""
    errors: dict[str, list[float]]
    """Of each joint, as in `SPREAD`."""
    robot: MujocoRobot
    """The robot that was measured."""

    def places(self, nominal: Chain, joints: Floats, wrench: Floats) -> Floats:
        """Return (n, 3) where the target is in the tracker's frame, m, without noise.

        Parameters
        ----------
        nominal : the robot file's chain, which joint angles (n, 6), rad, are logged for.
        wrench : (n, 6) N and N·m at the sensor.
        """
        place = self.robot.settle(nominal.model_angles(joints), wrench).position[:, 0]
        inverse = np.linalg.inv(self.tracker_in_base)
        return np.asarray(place @ inverse[:3, :3].T + inverse[:3, 3])


def true_chain(nominal: Chain, rng: np.random.Generator, size: float = 1.0) -> tuple[Chain, dict[str, list[float]]]:
    """Return the chain with errors A = R_x(α) R_y(β) T_x(a) R_z(θ) T_z(d) in front of each joint's turn."""
    errors = {name: (size * sigma * rng.normal(size=nominal.n_joints)).tolist() for name, sigma in SPREAD.items()}
    fixed = nominal.fixed.copy()
    for k in range(nominal.n_joints):
        small = turned(turned(np.eye(4), 0, errors["alpha"][k]), 1, errors["beta"][k]) @ shifted(errors["a"][k], 0, 0)
        fixed[k] = fixed[k] @ turned(small, 2, errors["theta"][k]) @ shifted(0, 0, errors["d"][k])
    return replace(nominal, fixed=fixed), errors


def pulls(rng: np.random.Generator) -> Floats:
    """Return one run's wrenches (n, 6) at the sensor: unloaded, then three directions up and down, twice each."""
    directions = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    levels = np.tile(LEVELS, 2) * FORCE
    force = np.concatenate([np.zeros((1, 3)), *(levels[:, None] * direction for direction in directions)])
    force = force * (1.0 + 0.03 * rng.normal(size=(len(force), 1)))
    return np.concatenate([force, np.cross(LOAD_POINT, force)], axis=1)


def write_campaign(
    folder: Path, seed: int, springs: tuple[Spring, ...] = (), geometry: float = 1.0, source: Path = SOURCE
) -> Truth:
    """Write the campaign of a seed into a new folder; return what is hidden in it.

    Parameters
    ----------
    springs : what gives besides the drives. geometry : how many times larger the links' errors are.
    """
    (folder / "raw").mkdir(parents=True, exist_ok=True)
    for name in ("campaign.toml", "robot.toml", "model.toml"):
        if source != folder:
            shutil.copy(source / name, folder / name)
    campaign = load_campaign(folder, check_files=False)
    nominal = campaign.chain
    rng = np.random.default_rng([20261124, seed])
    chain, errors = true_chain(nominal, rng, geometry)
    stiffness = SIX_STIFFNESS * np.exp(0.1 * rng.normal(size=6))
    setup = measurement_setup(campaign.manifest, nominal, resolve_frames(campaign.manifest, nominal))
    target = setup.targets[0].transform[:3, 3] + 5e-4 * rng.normal(size=3)
    setup = replace(setup, targets=(Attachment(nominal.n_joints + 1, shifted(*target)),))
    robot = MujocoRobot(chain, stiffness, setup, springs)
    base_from_tracker = transform(rotation_from_vector(np.array([0.01, -0.02, 2.1])), np.array([3.1, -1.4, 0.4]))
    truth = Truth(stiffness, chain, target, base_from_tracker, errors, robot)

    def measured(joints: Floats, wrench: Floats) -> Floats:
        exact = truth.places(nominal, joints, wrench)
        return np.asarray(exact + TRACKER_M * rng.normal(size=exact.shape))

    joints = six_axis_joints(rng, N_PLACES)
    places = measured(joints, np.zeros((N_PLACES, 6)))
    rows = [[20.0 * k, *np.degrees(joints[k]), *(1e3 * places[k])] for k in range(N_PLACES)]
    _write(folder / "raw" / "places.csv", "t,A1,A2,A3,A4,A5,A6,X,Y,Z", rows)
    rows, labels = [], []
    for run, pose in enumerate(six_axis_joints(rng, N_RUNS), start=1):
        wrench = pulls(rng)
        same = np.repeat(pose[None], len(wrench), axis=0)
        places = measured(same, wrench)
        read = wrench + np.repeat([FORCE_N, MOMENT_NM], 3) * rng.normal(size=wrench.shape)
        for k in range(len(wrench)):
            rows.append([8.0 * k, *np.degrees(pose), *read[k], *(1e3 * places[k])])
            labels.append(f"pull{run}")
    _write(folder / "raw" / "loads.csv", "run,t,A1,A2,A3,A4,A5,A6,Fx,Fy,Fz,Tx,Ty,Tz,X,Y,Z", rows, labels)
    return truth


def _write(file: Path, header: str, rows: list[list[float]], labels: list[str] | None = None) -> None:
    lines = [",".join(f"{value:.9g}" for value in row) for row in rows]
    if labels is not None:
        lines = [f"{label},{line}" for label, line in zip(labels, lines, strict=True)]
    file.write_text("\n".join([header, *lines]) + "\n", encoding="utf-8")


def main() -> None:
    """Write the bundled campaign's readings and its truth."""
    truth = write_campaign(SOURCE, int(sys.argv[1]) if len(sys.argv) > 1 else 1)
    document = {
        "joint_stiffness": truth.stiffness.tolist(),
        "geometry_errors": truth.errors,
        "target_in_flange": truth.target.tolist(),
        "base_from_tracker": truth.tracker_in_base.tolist(),
        "noise_m": TRACKER_M,
        "noise_N": FORCE_N,
        "noise_Nm": MOMENT_NM,
    }
    (SOURCE / "truth.json").write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
