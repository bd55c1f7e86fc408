"""A laboratory for tests: a six-axis robot with something in it that its model lacks, measured by three devices.

Force sensor, tracker and controller write raw logs, each on its own clock, with noise, ramps and holds: ``stiffcal
simulate`` makes them, of its own exact balance or of a robot that MuJoCo plays (`tests.laboratory.mujoco_campaigns`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.model.effect import Place
from stiffcal.model.summary import Where
from tests.laboratory.mujoco_robot import Cable, Spring
from tests.laboratory.robots import SIX_STIFFNESS, six_axis_joints
from tests.laboratory.small_campaign import MODEL, robot_text

MANIFEST = """
schema = "stiffcal/campaign/1"
name = "laboratory"
robot = "robot.toml"

[frames.tracker]
parent = "base"
xyz_m = [3.1, -1.4, 0.6]
rpy_deg = [1.0, -0.5, 118.0]
[frames.ft_sensor]
parent = "flange"
xyz_m = [0.0, 0.0, 0.06]
rpy_deg = [0.0, 0.0, 35.0]
[frames.target]
parent = "flange"
xyz_m = [0.08, -0.06, 0.12]
rpy_deg = [5.0, -8.0, 20.0]
[frames.load_point]
parent = "flange"
xyz_m = [0.16, 0.08, 0.20]
[tool]
mass_kg = 12.0
com_m = [0.01, -0.02, 0.09]

[sources.force]
csv = { delimiter = ";", decimal = ",", encoding = "latin-1", skip_rows = 1 }
sampling = "time"
time = { column = "t_ms", unit = "ms" }
[sources.force.wrench]
columns = ["Fx", "Fy", "Fz", "Tx", "Ty", "Tz"]
frame = "ft_sensor"
sigma = { force = 0.3, moment = 0.06 }

[sources.tracker]
format = "csv"
sampling = "time"
time = { column = "t", unit = "s" }
[sources.tracker.pose]
frame = "tracker"
body = "target"
position = ["X", "Y", "Z"]
units = { position = "mm" }
"""
POSITION_ONLY = "sigma = { position = 0.0122 }\n"
FULL_POSE = 'quaternion_wxyz = ["q0", "qx", "qy", "qz"]\nsigma = { position = 0.0122, rotation = 2.03e-5 }\n'
CONTROLLER = """
[sources.controller]
format = "csv"
sampling = "time"
time = { column = "t", unit = "s" }
[sources.controller.joints]
position = "A1..A6"
units = { position = "deg" }
"""

SETTINGS = """
schema = "stiffcal/simulate/1"
[loads]
directions = [[1.0, 0.1, 0.05], [-0.08, 1.0, 0.1], [0.06, 0.1, 1.0]]
max_force_N = FORCE
first_hold_s = 3.0
level_scatter = 0.03
LOADS
[robot]
position_error_m = 0.0003
orientation_error_rad = 0.0002

[sensors.force]
rate_hz = 20.0
clock_drift_ppm = 8.0
white = { force_N = 0.8, moment_Nm = 0.15 }
between_holds = { force_N = 0.25, moment_Nm = 0.05 }
resolution = { force_N = 0.05, moment_Nm = 0.01 }
preamble = ["Kraftmessplatz"]
[sensors.tracker]
rate_hz = 10.0
clock_drift_ppm = -25.0
white = { translation_m = 6e-6, rotation_rad = 1e-5 }
between_holds = { translation_m = 12e-6, rotation_rad = 2e-5 }
resolution = { translation_m = 1e-7 }
[sensors.controller]
rate_hz = 5.0
clock_drift_ppm = 12.0
resolution = { angle_rad = 1e-7 }
"""
QUICK = "levels = [0.5, 1.0]\nhold_s = 1.2\nramp_s = 0.4\nsettle_s = 0.4\n"
SLOW = "levels = [0.5, 1.0]\nhold_s = 4.0\nhold_points = 3\nhold_scatter = 0.2\nramp_s = 0.4\nsettle_s = 0.4\n"
IRREGULAR = "levels = [0.5, 1.0]\nhold_s = 2.0\nhold_scatter = 0.5\nramp_s = 0.4\nsettle_s = 0.4\n"
STATES_A_RUN = 25


@dataclass(frozen=True)
class Hidden:
    """An effect that the model under test lacks: its name, its place, its true parameters by symbol.

    One that is no law of the robot (a turned frame) is not ``in_model``, but in what simulate.toml says.
    """

    effect: str
    place: Place
    values: Mapping[str, float]
    in_model: bool = True

    @property
    def proposal(self) -> dict[str, Any]:
        """As ``missing`` names it."""
        return {"effect": self.effect, "where": dict(Where.of(self.place).items())}

    @property
    def parameters(self) -> dict[str, float]:
        """True values by full name."""
        return {f"{self.effect}.{self.place.label}.{symbol}": float(value) for symbol, value in self.values.items()}

    def entry(self) -> str:
        """Return its entry in a model file."""
        where = {"joints": list(self.place.joints), "pairs": [list(self.place.joints)]}.get(self.place.kind)
        lines = ["", "[[effects]]", f'type = "{self.effect}"']
        lines += [f"{self.place.kind} = {where}"] * (where is not None) + ["[effects.parameters]"]
        lines += [f'"{name}" = {{ value = {value!r} }}' for name, value in self.parameters.items()]
        return "\n".join([*lines, ""])


def at(joint: int) -> Place:
    """Return a joint as a place."""
    return Place("joints", (joint,))


@dataclass(frozen=True)
class Robot:
    """What is measured, and how.

    Attributes
    ----------
    seed : of poses, loads and noise.
    hidden : what the model lacks, in the catalogue's words.
    drives : (6,) N·m/rad, what a fit should find for joint-compliance.
    springs, cables : MuJoCo's, next to ``mujoco_drives`` (6,), N·m/rad.
    full_pose : the tracker sees orientation.
    poses, force : runs, and the largest force, N.
    loads, settings : further lines of ``[loads]``, and of simulate.toml.
    """

    seed: int
    hidden: tuple[Hidden, ...] = ()
    drives: Floats | None = None
    springs: Sequence[Spring] = ()
    cables: Sequence[Cable] = ()
    mujoco_drives: Floats | None = None
    full_pose: bool = False
    poses: int = 7
    force: float = 400.0
    loads: str = QUICK
    settings: str = ""


def write_source(folder: Path, robot: Robot) -> Path:
    """Write what ``simulate`` starts from: manifest, robot, its true model, what is done with it."""
    folder.mkdir(parents=True)
    angles = np.degrees(six_axis_joints(np.random.default_rng(robot.seed), robot.poses)).round(3)
    manifest = MANIFEST + (FULL_POSE if robot.full_pose else POSITION_ONLY) + CONTROLLER
    settings = SETTINGS.replace("LOADS\n", robot.loads).replace("FORCE", str(robot.force)) + robot.settings
    for number, pose in enumerate(angles, start=1):
        run = f"pose{number:02d}"
        files = ", ".join(f'{name} = "raw/{run}_{name}.csv"' for name in ("force", "tracker", "controller"))
        manifest += f'\n[[runs]]\nid = "{run}"\nfiles = {{ {files} }}\n'
        settings += f'\n[[runs]]\nid = "{run}"\njoints_deg = {pose.tolist()}\npause_before_s = 60.0\n'
    drives = SIX_STIFFNESS if robot.drives is None else robot.drives
    model = MODEL + "[effects.parameters]\n"
    model += "".join(f'"joint-compliance.j{k}.c" = {{ value = {1.0 / float(v)!r} }}\n' for k, v in enumerate(drives, 1))
    model += "".join(one.entry() for one in robot.hidden if one.in_model)
    for name, text in (("campaign", manifest), ("robot", robot_text()), ("model", model), ("simulate", settings)):
        (folder / f"{name}.toml").write_text(text, encoding="utf-8")
    return folder


def forget(folder: Path) -> Path:
    """Leave the drives alone in the model file: what is to be found is not in it."""
    (folder / "model.toml").write_text(MODEL, encoding="utf-8")
    return folder
