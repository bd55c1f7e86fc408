"""Chains of any kind, drawn at random, with places that targets on them are measured at.

Prismatic axes anywhere, parallel and meeting axes, some of them off by what a URDF's six decimals leave, joints that
follow others, angles that are displayed as sums, axes that never move.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.campaign.robot.geometry import chain_of
from stiffcal.campaign.robot.robot_file import RobotFile
from stiffcal.effects.joint_offset import JointOffset
from stiffcal.effects.link_geometry import LinkGeometry
from stiffcal.estimation.distinguish import SAME_REGRESSOR
from stiffcal.measurements.load_states import Attachment, LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.assembled.measured_frames import placed_frame
from tests.laboratory.absolute_places import absolute_states
from tests.laboratory.robots import shifted, turned

N_POSES = 60
ROUNDED = np.degrees(1.5708) - 90.0
"""deg by which a right angle is off in a URDF with four decimals."""


ROUNDING = 1e-5
"""Singular value, of the largest, that a URDF's decimals and forward differences leave of none."""


@dataclass(frozen=True)
class DrawnChain:
    """A robot with frames and geometry to be found, and poses in which its targets were measured."""

    robot: CompliantRobot
    """Frames that are estimated, link-geometry and zeros of joints."""
    states: LoadStates
    """Places at zero: only their columns count."""


def draw_chain(seed: int) -> DrawnChain:
    """Draw a robot, what of it is estimated, what is measured of it, and its poses."""
    rng = np.random.default_rng(seed)
    chain = chain_of(RobotFile.model_validate(_robot_file(rng)), Path())
    n_targets, with_turns = int(rng.integers(1, 4)), bool(rng.uniform() < 0.3)
    names = tuple(f"target{k + 1}" for k in range(n_targets))
    tracker = bool(rng.uniform() < 0.8)
    effects: list[PlacedEffect] = [placed_frame(name, with_turns) for name in names if rng.uniform() < 0.8]
    effects += [placed_frame("tracker", True)] if tracker else []
    kinds: list[list[Any]] = [[LinkGeometry()], [JointOffset()], [LinkGeometry(), JointOffset()]]
    for kind in kinds[int(rng.integers(3))]:
        effects += [PlacedEffect(kind.at(place, chain), place) for place in kind.places(chain)]
    return DrawnChain(CompliantRobot(chain, tuple(effects)), _states(rng, chain, names, with_turns))


def _robot_file(rng: np.random.Generator) -> dict[str, Any]:
    joints: list[dict[str, Any]] = []
    for k in range(int(rng.integers(3, 9))):
        slides = rng.uniform() < 0.3
        entry: dict[str, Any] = {
            "name": f"A{k + 1}",
            "a_m": float(rng.choice([0.0, rng.uniform(-0.5, 0.5)])),
            "alpha_deg": float(rng.choice([0.0, 90.0, -90.0, 180.0, rng.uniform(-180, 180)])),
            "d_m": float(rng.choice([0.0, rng.uniform(-0.5, 0.5)])),
            "theta_deg": float(rng.choice([0.0, 90.0, rng.uniform(-180, 180)])),
        }
        entry["alpha_deg"] += float(rng.choice([0.0, 0.0, ROUNDED]))
        if slides:
            entry |= {"type": "prismatic", "limits_m": [-0.4, 0.6]}
        elif k >= 2 and rng.uniform() < 0.15:
            before = [joint["name"] for joint in joints if joint.get("type") is None][-2:]
            own = {} if rng.uniform() < 0.5 else {entry["name"]: 1.0}  # it follows, or is displayed as a sum
            logged = own | dict.fromkeys(before, float(rng.choice([-1.0, 1.0])))
            entry |= {"logged": logged} if logged else {}
        joints.append(entry)
    return {"schema": "stiffcal/robot/1", "convention": "modified-dh", "joints": joints}


def _states(rng: np.random.Generator, chain: Chain, names: tuple[str, ...], with_turns: bool) -> LoadStates:
    low, high = (np.where(chain.prismatic, chain.limits[:, k], 5.0 * k - 2.5) for k in (0, 1))
    joints = rng.uniform(low, high, (N_POSES, chain.n_joints))
    stands = rng.uniform(size=chain.n_joints) < 0.1
    joints[:, stands] = joints[0, stands]
    states = absolute_states(chain, 1, 0)
    targets = tuple(
        Attachment(chain.n_joints + 1, turned(shifted(*rng.uniform(-0.2, 0.2, 3)), 0, float(rng.uniform(-1, 1))))
        for _ in names
    )
    setup = replace(states.setup, targets=targets, target_names=names)
    n, b = N_POSES, len(names)
    states = states.select(np.zeros(n, dtype=np.int64))
    rotation = np.tile(np.eye(3), (n, b, 1, 1)) if with_turns else np.full((n, b, 3, 3), np.nan)
    return replace(
        states, joints=joints, position=np.zeros((n, b, 3)), rotation=rotation, setup=setup, run=np.arange(n),
        runs=tuple(replace(states.runs[0], name=f"row {k + 1}") for k in range(n)),
    )  # fmt: skip


def columns_of(robot: CompliantRobot, states: LoadStates) -> tuple[tuple[str, ...], Floats]:
    """Return names and (rows, p) columns of the undeformed robot, per m and rad, of all free parameters."""
    from stiffcal.estimation.unknowns import free_columns
    from stiffcal.identification.derivatives.observation import evaluate, observe

    data, free = observe(states, robot.chain), free_columns(robot)
    found = np.concatenate([block.columns for block in evaluate(replace(robot, deformed=False), data, free)], axis=2)
    names = tuple(robot.placed[column.placed].parameter_name(column.symbol) for column in free)
    return names, np.moveaxis(found, 0, -1).reshape(-1, len(free))


@dataclass(frozen=True)
class Ranked:
    """What is free of a drawn robot, against the singular values of its columns."""

    rank: int
    """Of the columns of unit length, all conventions fixed, by numpy."""
    free: int
    """How many parameters a fit solves for."""
    lost_by_conventions: int
    """Directions that count among all columns, and are rounding with all conventions fixed."""
    more_residual: float
    """By how much the residual of what is free exceeds that of these columns, of the latter; readings at 10 µm."""
    unclear: bool
    """Whether a singular value is just below the threshold: a direction that is held for less than rounding."""


def ranked(drawn: DrawnChain, seed: int) -> Ranked:
    """Return what a fit would solve for, and how well that does."""
    from stiffcal.estimation.identifiability import check_identifiability
    from stiffcal.estimation.triangular import triangular
    from stiffcal.estimation.undetermined import Undetermined
    from stiffcal.estimation.unknowns import OpenBefore, Unknowns
    from stiffcal.identification.derivatives.observation import observe
    from stiffcal.identification.fitting.gauge import redundant_geometry

    names, columns = columns_of(drawn.robot, drawn.states)
    p = len(names)
    length = np.linalg.norm(columns, axis=0)
    unit = columns / np.where(length > 0.0, length, 1.0)
    conventions = redundant_geometry(drawn.robot, observe(drawn.states, drawn.robot.chain), frozenset())
    open_to_data = unit[:, [name not in conventions for name in names]]
    of_every_column, singular = (np.linalg.svd(matrix, compute_uv=False) for matrix in (unit, open_to_data))
    before = OpenBefore().with_causes(conventions, Undetermined.SAME_MOTION)
    found = check_identifiability(triangular(columns), Unknowns.plain(names, open_before=before))
    rng = np.random.default_rng(seed)
    readings = columns @ rng.normal(0.0, 1e-3, p) + rng.normal(0.0, 1e-5, len(columns))
    free = unit[:, ~found.left_at_neutral]
    of_all, of_free = (float(np.linalg.norm(_residual(matrix, readings))) for matrix in (open_to_data, free))
    rank = int(np.count_nonzero(singular > SAME_REGRESSOR * singular[0]))
    unclear = any(
        bool(np.any((values > ROUNDING * values[0]) & (values <= SAME_REGRESSOR * values[0])))
        for values in (of_every_column, singular)
    )
    of_all_columns = np.count_nonzero(of_every_column > SAME_REGRESSOR * of_every_column[0])
    kept = np.count_nonzero(singular > ROUNDING * singular[0])
    lost = max(0, int(of_all_columns) - int(kept))
    return Ranked(rank, free.shape[1], lost, of_free / of_all - 1.0, unclear)


def _residual(matrix: Floats, readings: Floats) -> Floats:
    """Return the residual of plain least squares."""
    rest: Floats = readings - matrix @ np.linalg.lstsq(matrix, readings, rcond=SAME_REGRESSOR)[0]
    return rest
