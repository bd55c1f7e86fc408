"""`init --kind`: the folders load once their logs exist; the bundled robots reach where they should."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from stiffcal.campaign.frames.frames import measurement_setup, resolve_frames
from stiffcal.campaign.loading import load_campaign, load_robot
from stiffcal.campaign.robot.geometry import chain_of
from stiffcal.commands.simulate import simulate_campaign
from stiffcal.errors import InputError
from stiffcal.ingest.checks.loaded import check_campaign
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.rotations import rotation_from_rpy, rotation_from_vector
from stiffcal.propose.templates import bundled_robot, bundled_robots, write_template


@pytest.mark.parametrize("kind", ["absolute", "load", "clamped", "ids", "friction"])
def test_template_loads_once_its_logs_exist(tmp_path: Path, kind: str) -> None:
    written = write_template(tmp_path / "cell", kind)
    more = {"model.toml", "simulate.toml"} if kind != "load" else set()
    assert {path.name for path in written} == {"campaign.toml", "robot.toml", "README.txt"} | more
    manifest = tmp_path / "cell" / "campaign.toml"
    head, mark, stated = manifest.read_text(encoding="utf-8").partition("# [report]")
    manifest.write_text(head + (mark + stated).replace("\n# ", "\n").removeprefix("# "), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load_campaign(tmp_path / "cell")
    for fault in caught.value.faults:
        assert fault.reason.startswith("no such file: raw/")
        (tmp_path / "cell" / fault.reason.removeprefix("no such file: ")).write_text("")
    campaign = load_campaign(tmp_path / "cell")
    setup = measurement_setup(campaign.manifest, campaign.chain, resolve_frames(campaign.manifest, campaign.chain))
    assert setup.moments_measured == (kind not in ("friction", "absolute"))
    assert campaign.manifest.report.serial_number
    assert campaign.manifest.report.instruments[0].certificate


@pytest.mark.long  # a table is simulated, and geometry and springs are fitted to it
def test_rehearsal_of_absolute_places_is_ready(tmp_path: Path) -> None:
    """What the template simulates is a campaign that `check` accepts, without a change."""
    write_template(tmp_path / "arm", "absolute")
    rehearsal = tmp_path / "arm" / "simulate.toml"
    rehearsal.write_text(rehearsal.read_text(encoding="utf-8").replace("poses = 60", "poses = 20"), encoding="utf-8")
    simulate_campaign(tmp_path / "arm", tmp_path / "rehearsal")
    result = check_campaign(tmp_path / "rehearsal")
    assert result.ready
    assert result.n_states == 20


def test_table_proposed_in_the_load_template_is_understood(tmp_path: Path) -> None:
    write_template(tmp_path / "cell", "load")
    text = (tmp_path / "cell" / "campaign.toml").read_text(encoding="utf-8")
    head, rest = text.split("# ---- Sources", 1)
    table = rest[rest.index("# [sources.table]") : rest.index("# exclude")].replace("\n# ", "\n")[2:]
    (tmp_path / "cell" / "campaign.toml").write_text(head + table, encoding="utf-8")
    (tmp_path / "cell" / "raw" / "table.csv").write_text("")
    assert load_campaign(tmp_path / "cell").manifest.sources["table"].is_states


def test_nothing_is_overwritten(tmp_path: Path) -> None:
    write_template(tmp_path, "load")
    before = (tmp_path / "campaign.toml").read_text(encoding="utf-8")
    with pytest.raises(InputError, match="already exists"):
        write_template(tmp_path, "clamped")
    assert (tmp_path / "campaign.toml").read_text(encoding="utf-8") == before
    with pytest.raises(InputError, match='no kind "weight"'):
        write_template(tmp_path / "other", "weight")
    assert not (tmp_path / "other").exists()


def flange(chain: Chain, logged_deg: list[float]) -> NDArray[np.float64]:
    here = np.eye(4)
    for fixed, angle in zip(chain.fixed, chain.model_angles(np.deg2rad([logged_deg]))[0], strict=True):
        turn = np.eye(4)
        turn[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
        here = here @ fixed @ turn
    return np.asarray(here @ chain.flange)


@pytest.mark.parametrize("name", bundled_robots())
def test_bundled_robot_loads(tmp_path: Path, name: str) -> None:
    (tmp_path / "robot.toml").write_text(bundled_robot(name), encoding="utf-8")
    chain = chain_of(load_robot(tmp_path / "robot.toml"), tmp_path)
    assert chain.n_joints == (7 if name == "panda" else 6)
    if name in ("irb4400", "kr125", "r2000ic"):
        assert {"swing", "arm"} <= set(chain.beams)
    # of whom the maker publishes masses
    assert bool(np.all(chain.link_mass > 0.0)) == name.startswith("ur")


def test_bundled_robots_stand_as_their_data_sheets_draw_them(tmp_path: Path) -> None:
    """Lower arm upright, forearm level: reach and height add up from the drawings' lengths."""
    for name, logged, place in (
        ("irb4400", [0, 0, 0, 0, 0, 0], [0.20 + 0.88 + 0.14, 0, 0.68 + 0.89 + 0.15]),
        ("kr125", [0, -90, 90, 0, 0, 0], [0.41 + 1.0 + 0.21, 0, 0.865 + 1.0 + 0.045]),
        ("r2000ic", [0, 0, 0, 0, 0, 0], [0.312 + 1.28 + 0.215, 0, 0.67 + 1.075 + 0.225]),
    ):
        (tmp_path / "robot.toml").write_text(bundled_robot(name), encoding="utf-8")
        found = flange(chain_of(load_robot(tmp_path / "robot.toml"), tmp_path), [float(angle) for angle in logged])
        np.testing.assert_allclose(found[:3, 3], place, atol=1e-12, err_msg=name)
        np.testing.assert_allclose(found[:3, 2], [1, 0, 0], atol=1e-12, err_msg=f"{name}: the flange looks forward")


@dataclass(frozen=True)
class Described:
    """An arm as a ROS description of it states it."""

    joints: tuple[tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]], ...]
    """By joint: xyz, m, and roll, pitch, yaw, rad, of its frame in the one before, and its axis."""
    flange: tuple[tuple[float, float, float], tuple[float, float, float]] = ((0, 0, 0), (0, 0, 0))
    """In the last frame."""
    on_axis_3: float = 0.0
    """Share of axis 2 that joint 3 of the description has, where the controller shows it against the horizontal."""

    def place(self, joints: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the flange by homogeneous transforms, for joint angles, rad, as the controller shows them."""
        turned = joints.copy()
        turned[2] += self.on_axis_3 * joints[1]
        here = np.eye(4)
        for (xyz, rpy, axis), angle in zip(self.joints, turned, strict=True):
            here = here @ moved(xyz, rotation_from_rpy(np.array(rpy)))
            here = here @ moved((0, 0, 0), rotation_from_vector(angle * np.array(axis, dtype=np.float64)))
        return here @ moved(self.flange[0], rotation_from_rpy(np.array(self.flange[1])))


@dataclass(frozen=True)
class Tabled:
    """An arm as a table of Denavit and Hartenberg's convention states it."""

    rows: tuple[tuple[float, float, float, float, float], ...]
    """By joint: a, m, alpha, rad, d, m, theta, rad, and the sense in which the controller counts."""

    def place(self, joints: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the flange by homogeneous transforms, for joint angles, rad, as the controller shows them."""
        here = np.eye(4)
        for (a, alpha, d, theta, sense), angle in zip(self.rows, joints, strict=True):
            here = here @ moved((0, 0, 0), rotation_from_vector(np.array([0, 0, sense * angle + theta])))
            here = here @ moved((a, 0, d), rotation_from_vector(np.array([alpha, 0, 0])))
        return here


def moved(xyz: tuple[float, float, float], rotation: NDArray[np.float64]) -> NDArray[np.float64]:
    result = np.eye(4)
    result[:3, :3], result[:3, 3] = rotation, xyz
    return result


RIGHT = np.pi / 2
X, Y, Z, STRAIGHT = (1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 0, 0)
BACK_X, BACK_Y = (-1, 0, 0), (0, -1, 0)


def ur(shoulder: float, upper_arm: float, forearm: float, wrist_1: float, wrist_2: float, wrist_3: float) -> Described:
    return Described(
        (
            ((0, 0, shoulder), STRAIGHT, Z),
            ((0, 0, 0), (RIGHT, 0, 0), Z),
            ((upper_arm, 0, 0), STRAIGHT, Z),
            ((forearm, 0, wrist_1), STRAIGHT, Z),
            ((0, wrist_2, 0), (RIGHT, 0, 0), Z),
            ((0, wrist_3, 0), (RIGHT, np.pi, np.pi), Z),
        )
    )


# ur_description (config/*/default_kinematics.yaml), franka_description (panda_arm.xacro), and of ROS-Industrial
# abb_irb4400_support (irb4400_macro.xacro) and fanuc_r2000ic_support (r2000ic165f_macro.xacro)
# and of FreeCAD src/Mod/Robot/Lib/Kuka/kr_125.csv
DESCRIBED: dict[str, Described | Tabled] = {
    "kr125": Tabled(
        (
            (0.41, -RIGHT, 0.865, 0, -1),
            (1.0, 0, 0, 0, 1),
            (0.045, RIGHT, 0, -RIGHT, 1),
            (0, -RIGHT, -1.0, 0, 1),
            (0, RIGHT, 0, 0, 1),
            (0, np.pi, -0.21, np.pi, 1),
        )
    ),
    "ur5e": ur(0.1625, -0.425, -0.3922, 0.1333, -0.0997, 0.0996),
    "ur10e": ur(0.1807, -0.6127, -0.57155, 0.17415, -0.11985, 0.11655),
    "panda": Described(
        (
            ((0, 0, 0.333), STRAIGHT, Z),
            ((0, 0, 0), (-RIGHT, 0, 0), Z),
            ((0, -0.316, 0), (RIGHT, 0, 0), Z),
            ((0.0825, 0, 0), (RIGHT, 0, 0), Z),
            ((-0.0825, 0.384, 0), (-RIGHT, 0, 0), Z),
            ((0, 0, 0), (RIGHT, 0, 0), Z),
            ((0.088, 0, 0), (RIGHT, 0, 0), Z),
        ),
        ((0, 0, 0.107), STRAIGHT),
    ),
    "irb4400": Described(
        (
            ((0, 0, 0), STRAIGHT, Z),
            ((0.2, 0, 0.68), STRAIGHT, Y),
            ((0, 0, 0.89), STRAIGHT, Y),
            ((0, 0, 0.15), STRAIGHT, X),
            ((0.88, 0, 0), STRAIGHT, Y),
            ((0, 0, 0), STRAIGHT, X),
        ),
        ((0.14, 0, 0), (0, RIGHT, 0)),
        on_axis_3=-1.0,
    ),
    "r2000ic": Described(
        (
            ((0, 0, 0.67), STRAIGHT, Z),
            ((0.312, 0, 0), STRAIGHT, Y),
            ((0, 0, 1.075), STRAIGHT, BACK_Y),
            ((0, 0, 0.225), STRAIGHT, BACK_X),
            ((1.28, 0, 0), STRAIGHT, BACK_Y),
            ((0.215, 0, 0), STRAIGHT, BACK_X),
        ),
        ((0, 0, 0), (np.pi, -RIGHT, 0)),
        on_axis_3=1.0,
    ),
}


@pytest.mark.parametrize("name", bundled_robots())
def test_bundled_robots_reach_where_a_second_source_says(tmp_path: Path, name: str) -> None:
    """In random poses, within a millimetre and a milliradian."""
    (tmp_path / "robot.toml").write_text(bundled_robot(name), encoding="utf-8")
    chain = chain_of(load_robot(tmp_path / "robot.toml"), tmp_path)
    rng = np.random.default_rng(7)
    for _ in range(5):
        low, high = np.clip(chain.limits, -np.pi, np.pi).T
        joints = np.asarray(rng.uniform(low, high, chain.n_joints))
        found, there = flange(chain, np.rad2deg(joints).tolist()), DESCRIBED[name].place(joints)
        assert np.abs(found[:3, 3] - there[:3, 3]).max() < 1e-3
        assert np.abs(found[:3, 2] - there[:3, 2]).max() < 1e-3
        # FANUC's own flange is turned about its axis against the description's
        assert name == "r2000ic" or np.abs(found[:3, :3] - there[:3, :3]).max() < 1e-3


def test_unknown_robot() -> None:
    with pytest.raises(InputError, match="use one of irb4400, kr125"):
        bundled_robot("irb44")
