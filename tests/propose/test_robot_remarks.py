"""`init --from`: what the robot's file leaves open is stated, with the joints and links that it is of."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from stiffcal.commands.init import init_campaign

ROBOT = Path(__file__).parents[2] / "campaigns" / "absolute" / "02" / "robot.toml"
POSES = "A1,A2,A3,A4,A5,A6,X,Y,Z\n" + "".join(
    f"{10 * k},{-60 - 2 * k},{10 + 3 * k},{5 * k},{4 * k},{-3 * k},{1500 + k},20,{900 + k}\n" for k in range(5)
)
URDF = """<robot name="two"><link name="base"/><link name="b"/>
<link name="a"><inertial><mass value="3"/></inertial></link>
<joint name="q1" type="revolute"><parent link="base"/><child link="a"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="q2" type="continuous"><parent link="a"/><child link="b"/><origin xyz="0.5 0 0"/><axis xyz="0 1 0"/></joint>
</robot>"""


def warned(folder: Path, robot: str) -> list[str]:
    """Return what `init` warns of for poses and the text of a robot file."""
    (folder / "poses.csv").write_text(POSES)
    (folder / "own.toml").write_text(robot)
    return init_campaign(folder / "cell", tables=[folder / "poses.csv"], robot=str(folder / "own.toml")).warnings


def test_a_robot_with_limits_and_masses_needs_no_warning(tmp_path: Path) -> None:
    assert warned(tmp_path, ROBOT.read_text()) == []


@pytest.mark.parametrize(
    ("pattern", "instead", "words"),
    [
        (r"limits_deg = .*\n", "", "no limits of joints A1, A2, A3, A4, A5 and A6: plan and simulate may choose any"),
        (r", mass_kg = 180.0, com_m = \[.*?\]", "", "no mass of link swing: weight is not modelled"),
        (
            r"(?s)(name = \"A2\".*?limits_deg = )\[.*?\]",
            r"\1[-63.0, 90.0]",
            "2 of 5 values are beyond the limits of joint A2",
        ),
    ],
)
def test_what_is_missing_or_contradicts_the_table_is_named(
    tmp_path: Path, pattern: str, instead: str, words: str
) -> None:
    text = re.sub(pattern, instead, ROBOT.read_text())
    assert text != ROBOT.read_text()
    (warning,) = warned(tmp_path, text)
    assert words in warning


def test_of_a_urdf_too(tmp_path: Path) -> None:
    (tmp_path / "two.urdf").write_text(URDF)
    (tmp_path / "poses.csv").write_text("q1,q2,X,Y,Z\n" + "".join(f"0.{k},1.{k},500,{k},{9 + k}\n" for k in range(5)))
    made = init_campaign(tmp_path / "cell", tables=[tmp_path / "poses.csv"], urdf=tmp_path / "two.urdf")
    assert [line.partition(":")[2].partition(":")[0] for line in made.warnings] == [
        " no limits of joint q2", " no mass of link b"
    ]  # fmt: skip
