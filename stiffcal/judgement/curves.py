"""Curves of laws that nobody has written down: by how much a joint gives beyond all else, over what the law follows.

At the coefficients of the most probable set with the law, in the states of the campaign. A law of other joints has the
curve over that of them to which most of it belongs; one of the past, of all that a joint carries or of a weight none.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.judgement.ground_of_states import GroundOfStates
from stiffcal.judgement.judge import Judged
from stiffcal.judgement.numbers import CURVE_POINTS, LEAST_LOADED
from stiffcal.judgement.unlisted import FUNCTIONS, OF_PLACES, unlisted_laws
from stiffcal.model.laws.drives import drive_torque


@dataclass(frozen=True)
class LawCurve:
    """How a joint gives by a law, over what it follows."""

    over: str
    """``torque:4`` or ``angle:2``, as ``plot --against`` takes it."""
    per_load: bool
    """Whether the values are over the drive's own load: the law is one of compliance."""
    at: Floats
    """(k,) N·m (N), rad (m of prismatic joints), ascending."""
    value: Floats
    """(k,) rad (m of prismatic joints), or that over the load."""


OVER: Mapping[str, tuple[str, bool, bool]] = MappingProxyType({
    "its own torque": ("torque", False, False),
    "its own torque to the power 2/3": ("torque", False, False),
    "its own angle": ("angle", False, True),
    "its own angle, whatever it carries": ("angle", False, False),
    "another joint's angle": ("angle", True, True),
    "another joint's torque": ("torque", True, False),
})  # fmt: skip
"""By what a law follows: torque or angle, whether of another joint, and whether it is one of compliance."""


def curve_of(judged: Judged, name: str) -> LawCurve | None:
    """Return the curve of a law, by its member's name; None where it has none."""
    ground, members = judged.ground, judged.members
    number = next(i for i, one in enumerate(members) if one.name == name)
    member = members[number]
    if member.share.family not in OVER or not isinstance(ground, GroundOfStates):
        return None
    what, of_other, per_load = OVER[member.share.family]
    chain, loads = ground.state.robot.chain, ground.state.loads
    joint = int(member.share.place.split()[-1])
    parts = _amplitudes(judged, ground, number)[:, None] * np.array(
        (FUNCTIONS | OF_PLACES)[member.share.family](chain, joint, loads)
    )
    about = joint
    if of_other:
        others = [k for k in range(1, chain.n_joints + 1) if k != joint]
        of_each = parts.reshape(len(others), -1, parts.shape[1]).sum(axis=1)
        most = int(np.argmax(np.sum(of_each**2, axis=1)))
        about, turn = others[most], of_each[most]
    else:
        turn = parts.sum(axis=0)
    over = drive_torque(chain, loads.wrench, about) if what == "torque" else loads.angles[about - 1]
    shown = np.ones(len(turn), dtype=np.bool_)
    if per_load:
        torque = drive_torque(chain, loads.wrench, joint)
        shown = np.abs(torque) > LEAST_LOADED * np.abs(torque).max(initial=0.0)
        turn = turn / np.where(shown, torque, 1.0)
    at, value = _means(np.asarray(over)[shown], turn[shown])
    return LawCurve(f"{what}:{about}", per_load, at, value)


def _amplitudes(judged: Judged, ground: GroundOfStates, number: int) -> Floats:
    """Return the coefficients (q,) of a law's functions in the most probable set with it."""
    evidence, log, member = judged.weighed.evidence, judged.weighed.log, judged.members[number]
    key = max((key for key in log if number in key), key=lambda k: log[k])
    _, solution = evidence.coefficients(key)
    first = sum(len(evidence.members[i].rows) for i in key[: key.index(number)])
    law = next(one for one in unlisted_laws(ground.state) if f"{one.place}: {one.follows}" == member.name)
    size = np.linalg.norm(ground.space.rows(law.columns)) / np.linalg.norm(member.columns.rows)
    return np.asarray(solution[first : first + len(member.columns.rows)] / size)


def _means(at: Floats, value: Floats) -> tuple[Floats, Floats]:
    """Return means over as many states each, ascending."""
    order = np.argsort(at, kind="stable")
    groups = np.array_split(order, min(CURVE_POINTS, len(np.unique(at))))
    means = [(float(at[own].mean()), float(value[own].mean())) for own in groups if len(own)]
    return np.array([a for a, _ in means]), np.array([b for _, b in means])
