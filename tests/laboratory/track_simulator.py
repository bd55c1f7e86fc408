"""A robot, on a track or not, in plain numpy, independent of stiffcal: geometry, springs, weight, a payload, noise.

Transforms are multiplied out joint by joint, and a spring's load is summed over masses about its axis: nothing of
`stiffcal.mechanics` or `stiffcal.model` is used.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from stiffcal.arrays import Floats
from tests.laboratory.track_and_arm import TRACK, Row

NAMES = ("X1", "A1", "A2", "A3", "A4", "A5", "A6")
TARGETS = {"P1": (0.06, -0.04, 0.10), "P2": (-0.08, 0.05, 0.15), "P3": (0.0, 0.1, 0.12)}
COMPLIANCE = np.array([2e-8, 1.4e-6, 2.0e-6, 2.3e-6, 1.7e-5, 1.8e-5, 6e-5])
"""m/N, then rad/(N·m)."""
GRAVITY = np.array([0.0, 0.0, -9.81])
SIGMA = 2e-5
"""m, of each coordinate."""
LOW = np.array([-0.4, *np.radians([-150.0, -60.0, -60.0, -150.0, -100.0, -170.0])])
HIGH = np.array([1.1, *np.radians([150.0, 60.0, 60.0, 150.0, 100.0, 170.0])])
TRACKER = np.array([[0.48, -0.87, -0.09, 4.0], [0.85, 0.49, -0.17, -2.0], [0.19, 0.01, 0.98, 1.0], [0, 0, 0, 1]])


@dataclass
class Track:
    """The true robot."""

    geometry: Floats
    """(J, 4) x, y, m, rx, ry, rad; a track's x and y play no part."""
    compliance: Floats = field(default_factory=lambda: COMPLIANCE.copy())
    rows: tuple[Row, ...] = TRACK
    nominal_gravity: Floats = field(default_factory=lambda: GRAVITY.copy())
    """As robot.toml has it, base axes."""
    gravity: Floats = field(default_factory=lambda: GRAVITY.copy())
    """As it is in the axes of the base."""

    @classmethod
    def drawn(cls, seed: int) -> Track:
        """Return a robot on a track with errors of 0.3 mm and 0.5 mrad, those of the first axis among them."""
        return cls(np.random.default_rng(seed).standard_normal((7, 4)) * [3e-4, 3e-4, 5e-4, 5e-4])

    @classmethod
    def arm(cls, seed: int, inclined: float) -> Track:
        """Return the arm without its track, its first axis inclined, rad; gravity's direction errs by 0.5 mrad too."""
        rng = np.random.default_rng(seed)
        first = TRACK[1]
        rows = ((0.0, 0.0, first[2], 0.0, *first[4:]), *TRACK[2:])
        nominal = _turn(np.array([0.0, inclined, 0.0]))[:3, :3] @ GRAVITY
        errors = rng.standard_normal((6, 4)) * [3e-4, 3e-4, 5e-4, 5e-4]
        actual = _turn(5e-4 * rng.standard_normal(3))[:3, :3] @ nominal
        return cls(errors, COMPLIANCE[1:].copy(), rows, nominal, actual)

    @property
    def names(self) -> tuple[str, ...]:
        """Of the joints."""
        return NAMES[-len(self.rows) :]

    @property
    def range(self) -> tuple[Floats, Floats]:
        """Lowest and highest angles, rad, m."""
        return LOW[-len(self.rows) :], HIGH[-len(self.rows) :]

    def frames(self, q: Floats, give: Floats) -> list[Floats]:
        """Return base_from_frame of the seven joints and the flange."""
        place, result = np.eye(4), []
        for k, (a, alpha, d, theta, kind, _, _) in enumerate(self.rows):
            x, y, rx, ry = self.geometry[k]
            place = place @ _turn(np.array([np.radians(alpha), 0.0, 0.0])) @ _shift(a, 0.0, 0.0) @ _shift(0.0, 0.0, d)
            tilt = _turn(np.array([rx, ry, 0.0]))
            if kind == "P":
                place = place @ _turn(np.array([0.0, 0.0, np.radians(theta)])) @ tilt @ _shift(0.0, 0.0, q[k] + give[k])
            else:
                turn = _turn(np.array([0.0, 0.0, q[k] + np.radians(theta) + give[k]]))
                place = place @ _shift(x, y, 0.0) @ tilt @ turn
            result.append(place)
        return [*result, place @ _shift(0.0, 0.0, 0.14)]

    def at_rest(self, q: Floats, force: Floats, payload: float) -> list[Floats]:
        """Return the frames under weight, a force at the flange's origin (base axes) and a payload 0.2 m before it."""
        n = len(self.rows)
        give = np.zeros(n)
        for _ in range(40):
            frames = self.frames(q, give)
            loads = [((frames[k] @ [*row[6], 1.0])[:3], row[5] * self.gravity, k) for k, row in enumerate(self.rows)]
            loads.append(((frames[n] @ [0.0, 0.0, 0.2, 1.0])[:3], payload * self.gravity, n))
            loads.append((frames[n][:3, 3], force, n))
            found = np.zeros(n)
            for k, row in enumerate(self.rows):
                axis, origin = frames[k][:3, 2], frames[k][:3, 3]
                for at, weight, body in loads:
                    if body >= k:
                        found[k] += axis @ (weight if row[4] == "P" else np.cross(at - origin, weight))
            found *= self.compliance
            if np.abs(found - give).max() < 1e-13:
                return frames
            give = found
        raise AssertionError("the simulated robot does not settle")

    def places(self, q: Floats, force: Floats, payload: float) -> Floats:
        """Return (3, 3) places of the targets, base axes."""
        flange = self.at_rest(q, force, payload)[-1]
        return np.array([(flange @ [*at, 1.0])[:3] for at in TARGETS.values()])


def _shift(x: float, y: float, z: float) -> Floats:
    result = np.eye(4)
    result[:3, 3] = x, y, z
    return result


def _turn(vector: Floats) -> Floats:
    """Rodrigues' formula."""
    angle, result = float(np.linalg.norm(vector)), np.eye(4)
    if angle > 0.0:
        x, y, z = vector / angle
        k = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        result[:3, :3] += np.sin(angle) * k + (1.0 - np.cos(angle)) * k @ k
    return result


def _tracker() -> Floats:
    left, _, right = np.linalg.svd(TRACKER[:3, :3])
    result = TRACKER.copy()
    result[:3, :3] = left @ right
    return result


def write_absolute(folder: Path, robot: Track, seed: int, n: int = 120, springs: str = "1, 2, 3, 4, 5, 6") -> Path:
    """Write a campaign of absolute places, in half of the poses with 150 kg; the rest of the model is the geometry."""
    rng = np.random.default_rng(seed)
    to_tracker = np.linalg.inv(_tracker())
    rows = []
    for _ in range(n):
        q, payload = rng.uniform(*robot.range), 150.0 * float(rng.integers(2))
        at = robot.places(q, np.zeros(3), payload)
        seen = at @ to_tracker[:3, :3].T + to_tracker[:3, 3] + SIGMA * rng.standard_normal((3, 3))
        rows.append([*_printed(robot, q), payload, *(1e3 * seen).ravel()])
    head = [*robot.names, "kg", *(f"{name}_{axis}" for name in TARGETS for axis in "xyz")]
    _write_table(folder, robot, head, rows)
    poses = "".join(
        f'[sources.table.poses.{name}]\nframe = "tracker"\nposition = ["{name}_x", "{name}_y", "{name}_z"]\n'
        f'units = {{ position = "mm" }}\nsigma = {{ position = {1e3 * SIGMA} }}\n'
        for name in TARGETS
    )
    frames = "".join(f'[frames.{name}]\nparent = "flange"\nestimate = true\n' for name in TARGETS)
    (folder / "campaign.toml").write_text(
        'schema = "stiffcal/campaign/1"\nrobot = "robot.toml"\n[frames.tracker]\nparent = "base"\nestimate = true\n'
        f'[frames.payload]\nparent = "flange"\nxyz_m = [0.0, 0.0, 0.2]\n{frames}[sources.table]\n'
        f'file = "raw/table.csv"\nsampling = "states"\n{_joints(robot)}'
        f'dead_weight = {{ mass_column = "kg", point = "payload" }}\n{poses}'
        '[[runs]]\nid = "poses"\nexperiment = "absolute"\n'
    )
    model = _effect("link-geometry", ", ".join(map(str, range(1, len(robot.rows) + 1)))) + _effect(
        "joint-compliance", springs
    )
    (folder / "model.toml").write_text(f'schema = "stiffcal/model/1"\n{model}')
    return folder


def write_loads(folder: Path, robot: Track, seed: int, n: int = 30) -> Path:
    """Write a campaign of displacements under forces at the flange's origin, six loads in each of n poses."""
    rng = np.random.default_rng(seed)
    rows = []
    for pose in range(n):
        q = rng.uniform(*robot.range)
        before = robot.places(q, np.zeros(3), 0.0)[0]
        for force in (*(800.0 * np.eye(3)), *(-800.0 * np.eye(3))):
            force = force + rng.uniform(-100.0, 100.0, 3)
            moved = robot.places(q, force, 0.0)[0] - before + SIGMA * rng.standard_normal(3)
            rows.append([pose + 1, *_printed(robot, q), *force, *(1e3 * moved)])
    _write_table(folder, robot, ["run", *robot.names, "Fx", "Fy", "Fz", "dx", "dy", "dz"], rows)
    (folder / "campaign.toml").write_text(
        'schema = "stiffcal/campaign/1"\nrobot = "robot.toml"\n[frames.target]\nparent = "flange"\n'
        'xyz_m = [0.06, -0.04, 0.10]\n[sources.table]\nfile = "raw/table.csv"\nrun = { column = "run" }\n'
        f'{_joints(robot)}wrench = {{ columns = ["Fx", "Fy", "Fz"], axes = "base", point = "flange" }}\n'
        '[sources.table.deflection]\ntranslation = ["dx", "dy", "dz"]\nunits = { translation = "mm" }\n'
        f'body = "target"\naxes = "base"\nsigma = {{ translation = {1e3 * SIGMA} }}\n'
    )
    return folder


def _joints(robot: Track) -> str:
    units = ", ".join('"mm"' if row[4] == "P" else '"deg"' for row in robot.rows)
    names = ", ".join(f'"{name}"' for name in robot.names)
    return f"joints = {{ position = [{names}], units = {{ position = [{units}] }} }}\n"


def _printed(robot: Track, q: Floats) -> list[float]:
    """Return joint values in mm and degrees."""
    return [
        1e3 * value if row[4] == "P" else float(np.degrees(value)) for row, value in zip(robot.rows, q, strict=True)
    ]


def _effect(name: str, joints: str) -> str:
    return f'[[effects]]\ntype = "{name}"\njoints = [{joints}]\n'


def _write_table(folder: Path, robot: Track, head: list[str], rows: list[list[float]]) -> None:
    (folder / "raw").mkdir(parents=True)
    lines = [",".join(head), *(",".join(f"{value:.7f}" for value in row) for row in rows)]
    (folder / "raw" / "table.csv").write_text("\n".join(lines) + "\n")
    text = 'schema = "stiffcal/robot/1"\nname = "arm on a track"\nconvention = "modified-dh"\n'
    text += f"gravity_mps2 = {robot.nominal_gravity.tolist()}\n"
    for name, (a, alpha, d, theta, kind, mass, com) in zip(robot.names, robot.rows, strict=True):
        text += f'[[joints]]\nname = "{name}"\na_m = {a}\nalpha_deg = {alpha}\nd_m = {d}\ntheta_deg = {theta}\n'
        text += 'type = "prismatic"\nlimits_m = [-0.5, 1.2]\n' if kind == "P" else "limits_deg = [-175, 175]\n"
        text += f"link = {{ mass_kg = {mass}, com_m = {list(com)} }}\n"
    (folder / "robot.toml").write_text(text + "[flange]\nxyz_m = [0.0, 0.0, 0.14]\n")
