"""Which poses are possible."""

from __future__ import annotations

import numpy as np
import pytest

from stiffcal.mechanics.kinematics import attached_poses, body_poses
from stiffcal.planning.candidates import Cell, Tracker, has_line_of_sight, is_free, possible_poses
from stiffcal.planning.capsules import distance_of_lines
from tests.laboratory.robots import force_sensor_setup, six_axes

CHAIN = six_axes()
TARGET = force_sensor_setup(CHAIN).targets[0]
LIMITS = np.radians([[-170, 170], [-140, 0], [-110, 150], [-200, 200], [-120, 120], [-300, 300]])
NO_BOXES = np.zeros((0, 2, 3))
WALL = np.array([[[6.0, -9.0, -9.0], [7.0, 9.0, 9.0]]])


def cell(**changes: object) -> Cell:
    return Cell(**{"limits": LIMITS, "boxes": NO_BOXES, "radius": 0.1, "lowest": None, "tracker": None, **changes})  # type: ignore[arg-type]


def test_poses_lie_within_the_limits_and_the_seed_chooses_them() -> None:
    first, again, other = (possible_poses(CHAIN, cell(), TARGET, (TARGET,), 300, seed)[0] for seed in (1, 1, 2))
    assert first.shape == (300, 6)
    assert (first >= LIMITS[:, 0]).all()
    assert (first <= LIMITS[:, 1]).all()
    np.testing.assert_array_equal(first, again)
    assert not np.allclose(first, other)


def test_no_part_of_the_robot_enters_a_box_or_goes_too_low() -> None:
    box = np.array([[[0.5, -2.0, 0.0], [2.0, 0.3, 1.2]]])
    joints, rejected = possible_poses(CHAIN, cell(boxes=box, lowest=0.2), TARGET, (TARGET,), 200, 0)
    assert rejected.collision > 0
    angles = CHAIN.model_angles(joints)
    origins, _ = body_poses(CHAIN, angles)
    tip, _ = attached_poses(CHAIN, angles, TARGET)
    nodes = np.concatenate([origins[:, 1:], tip[:, None]], axis=1)
    for share in np.linspace(0.0, 1.0, 41):
        points = nodes[:, :-1] + share * (nodes[:, 1:] - nodes[:, :-1])
        inside = ((points > box[0, 0] - 0.09) & (points < box[0, 1] + 0.09)).all(axis=2)
        assert not inside.any()
        assert (points[:, 1:, 2] >= 0.29).all()


def test_the_tracker_measures_every_pose() -> None:
    tracker = Tracker(np.array([3.0, 0.5, 1.0]), np.array([-1.0, 0.0, 0.0]), np.radians(25.0),
                      np.array([0.0, 0.0, 1.0]), np.radians(40.0))  # fmt: skip
    joints, rejected = possible_poses(CHAIN, cell(tracker=tracker), TARGET, (TARGET,), 100, 0)
    assert len(joints) == 100
    assert rejected.reflector > 0
    assert rejected.out_of_view > 0
    place, rotation = attached_poses(CHAIN, CHAIN.model_angles(joints), TARGET)
    beam = place - tracker.position
    beam /= np.linalg.norm(beam, axis=1, keepdims=True)
    assert np.degrees(np.arccos(-beam[:, 0])).max() <= 25.0
    assert np.degrees(np.arccos(-np.einsum("ni,ni->n", rotation[:, :, 2], beam))).max() <= 40.0


@pytest.mark.parametrize(
    ("changes", "counted"),
    [
        ({"boxes": np.array([[[-9.0, -9.0, -9.0], [9.0, 9.0, 9.0]]])}, "collision"),
        ({"tracker": Tracker(np.array([9.0, 0.0, 0.0]), np.array([1.0, 0.0, 0.0]), 0.5, None, 0.5)}, "out_of_view"),
        ({"tracker": Tracker(np.array([9.0, 0.0, 0.0]), None, 0.5, np.array([0.0, 0.0, 1.0]), 1e-9)}, "reflector"),
        ({"tracker": Tracker(np.array([9.0, 0.0, 1.0]), None, 0.5, None, 0.5), "boxes": WALL}, "obstructed"),
    ],
)
def test_where_nothing_is_possible_the_reason_is_counted(changes: dict[str, object], counted: str) -> None:
    joints, rejected = possible_poses(CHAIN, cell(**changes), TARGET, (TARGET,), 5, 0)
    assert joints.shape == (0, 6)
    assert getattr(rejected, counted) == rejected.drawn


def test_the_robot_in_the_beam_hides_the_target() -> None:
    """A stretched arm, the target at its tip: beams from in front and from the side are free, one through it is not."""
    stretched = np.radians([[0, -60, 0, 0, 20, 0]])
    place = attached_poses(CHAIN, CHAIN.model_angles(stretched), TARGET)[0][0]
    elbow = body_poses(CHAIN, CHAIN.model_angles(stretched))[0][0, 3]
    across = np.array([0.0, 2.5, 0.0])
    for position, free in ((place + (place - elbow), True), (place + across, True), (elbow - (place - elbow), False)):
        tracker = Tracker(position, None, 0.5, None, 0.5)
        assert has_line_of_sight(CHAIN, cell(), tracker, TARGET, (TARGET,), stretched).tolist() == [free]
    # a box between hides, one around the tracker does not
    between, around = (
        np.stack([centre - 0.2, centre + 0.2])[None] for centre in (place + 0.5 * across, place + across)
    )
    tracker = Tracker(place + across, None, 0.5, None, 0.5)
    for boxes, free in ((between, False), (around, True)):
        assert has_line_of_sight(CHAIN, cell(boxes=boxes), tracker, TARGET, (TARGET,), stretched).tolist() == [free]


def test_links_that_meet_are_no_pose() -> None:
    """The tool folded back onto the robot's own column, with no box anywhere."""
    folded, stretched = np.radians([[0, 0, 150, 0, 90, 0], [0, -90, 0, 0, 0, 0]])
    free = is_free(CHAIN, cell(radius=0.12), (TARGET,), np.stack([folded, stretched]))
    assert free.tolist() == [False, True]


def test_the_distance_of_two_lines_is_the_least_of_all_their_points() -> None:
    rng = np.random.default_rng(2)
    lines = rng.normal(size=(4, 200, 3))
    lines[1, :20] = lines[0, :20]  # a point
    lines[3, 20:40] = lines[2, 20:40] + 0.7 * (lines[1, 20:40] - lines[0, 20:40])  # parallel
    share = np.linspace(0.0, 1.0, 301)[:, None, None]
    one, other = (start + share * (end - start) for start, end in (lines[:2], lines[2:]))
    sampled = np.stack(
        [np.linalg.norm(one[:, None, k] - other[None, :, k], axis=2).min() for k in range(lines.shape[1])]
    )
    found = distance_of_lines(*lines)
    assert (found <= sampled + 1e-12).all()
    np.testing.assert_allclose(found, sampled, atol=0.02)
