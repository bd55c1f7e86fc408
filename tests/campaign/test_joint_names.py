"""Names of joints in the columns of a table: where they are letters, a time may be called like one of them."""

from __future__ import annotations

import pytest

from stiffcal.campaign.columns.joint_names import numbered_joints

LETTERS = ("S", "L", "U", "R", "B", "T")
SMALL = tuple(letter.lower() for letter in LETTERS)

OF_ROBOTS = ("position.joint_a{}", "position.panda_joint{}", "/joint_states/fr3_joint{}/position")


@pytest.mark.parametrize("name", OF_ROBOTS)
def test_joints_of_messages_by_the_names_of_a_robot(name: str) -> None:
    """Where the field is that of angles; its speeds and torques have the same names."""
    joints = tuple(name.format(k) for k in range(1, 8))
    others = tuple(name.replace("position", other).format(k) for other in ("velocity", "effort") for k in range(1, 8))
    assert numbered_joints(("header.stamp", *others, *joints)) == joints
    assert numbered_joints(("header.stamp", *others)) == ()
    # which of two arms was measured no name states
    left, right = (tuple(one.replace("joint", f"{side}_joint") for one in joints) for side in ("left", "right"))
    assert numbered_joints((*left, *right)) == ()


@pytest.mark.parametrize(
    ("names", "joints"),
    [
        (("t", *LETTERS), LETTERS),
        ((*LETTERS, "t"), LETTERS),
        (("T", *SMALL), SMALL),
        ((*SMALL, "T"), SMALL),
        (("t", *LETTERS[:-1]), ()),
        (("t", *(f"Joint{letter}" for letter in LETTERS)), tuple(f"Joint{letter}" for letter in LETTERS)),
        (("t", *(f"{letter}角度" for letter in LETTERS)), tuple(f"{letter}角度" for letter in LETTERS)),
        (("t", *(f"joint_{letter}_pos" for letter in SMALL)), tuple(f"joint_{letter}_pos" for letter in SMALL)),
    ],
)
def test_letters_are_joints_in_one_case(names: tuple[str, ...], joints: tuple[str, ...]) -> None:
    assert numbered_joints(names) == joints
