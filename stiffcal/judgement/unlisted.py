"""Laws that nobody has written down: flexible functions of what a joint carries and of how the robot stands.

Each is a sum of a few columns of like size. What it follows is its name.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.identification.fitting.regressors import Linearised
from stiffcal.judgement.memory import of_memory
from stiffcal.judgement.numbers import (
    BEYOND_USUAL,
    LEVER_OF_NODE,
    STEPS,
    THRESHOLDS,
    USUAL_LOAD,
    WARMING,
    WIDTH_OF_STEP,
)
from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import (
    BASE_NODE,
    RX,
    TX,
    TZ,
    Law,
    NodeLoads,
    ParameterSpec,
    Place,
    Term,
    Values,
    joint_node,
    tool_node,
)
from stiffcal.model.laws.drives import drive_terms, drive_torque

ALL_IT_CARRIES = "all that the joint carries"
INSTRUMENT, CROSS_TALK = "instrument", "a component of the load that is read in another"


@dataclass(frozen=True)
class UnlistedLaw:
    """A law that is none of the catalogue's."""

    place: str
    """As `stiffcal.judgement.priors.where`."""
    follows: str
    """In words, what it follows."""
    columns: Floats
    """(q, m, n) displacements, of any size."""


def unlisted_laws(state: Linearised, driven: frozenset[int] | None = None) -> Iterator[UnlistedLaw]:
    """Give the laws about a robot at rest.

    Parameters
    ----------
    driven : joints that were driven with the robot clamped: its readings show laws of these drives alone. None: loaded.
    """
    chain = state.robot.chain
    for joint in sorted(driven) if driven is not None else range(1, chain.n_joints + 1):
        for follows, functions in _followed(state, driven is not None).items():
            count = len(functions(chain, joint, state.loads))
            if not count:
                continue
            regressor = state.regressor(_Drive(functions, count), Place("joints", (joint,)), {})
            if regressor.columns.any():
                yield UnlistedLaw(f"joint {joint}", follows, regressor.columns)
        if driven is not None:
            continue
        own = int(chain.drive_components[joint - 1])
        of_node: dict[str, Law] = {ALL_IT_CARRIES: _Node(own)}
        if joint in chain.prismatic_joints:
            of_node["what it carries and its extension"] = _Guide(own)
        for follows, law in of_node.items():
            regressor = state.regressor(law, Place("joints", (joint,)), {})
            if regressor.columns.any():
                yield UnlistedLaw(f"joint {joint}", follows, regressor.columns)
    if driven is None:
        for place, node in (("base", BASE_NODE), ("tool", tool_node(chain))):
            regressor = state.regressor(_Bent(node), Place("setup"), {})
            if regressor.columns.any():
                yield UnlistedLaw(place, "the size of its load", regressor.columns)
        columns = _of_cross_talk(state)
        if columns.any():
            yield UnlistedLaw(INSTRUMENT, CROSS_TALK, columns)


def _of_cross_talk(state: Linearised) -> Floats:
    """Return (30, m, n) what it makes when each component of the wrench as read holds a part of each other."""
    wrench = state.data.wrench
    slope = state.tangents.reading_rows()
    # forces among each other, and moments, have one full scale
    scales = [float(np.quantile(np.abs(part).max(axis=0), USUAL_LOAD)) for part in np.split(wrench, [RX])]
    scale = np.repeat(scales, 3)
    apart = [(reads, other) for reads in range(6) for other in range(6) if reads != other]
    return np.array([scale[reads] * slope[:, reads] * _unit(wrench[other]) for reads, other in apart])


def _followed(state: Linearised, clamped: bool) -> dict[str, Callable[[Chain, int, NodeLoads], list[Floats]]]:
    """Return the functions by what a law follows: at the other joints of a clamped robot nothing stays but noise."""
    found = FUNCTIONS | (OF_PLACES if state.data.absolute.any() else {})
    return {name: one for name, one in found.items() if not (clamped and one is _of_other_torques)}


def _unit(values: Floats) -> Floats:
    """Return loads of order one; a load far beyond all others, as in a run of another unit, is no larger than these."""
    usual = float(np.quantile(np.abs(values), USUAL_LOAD)) or float(np.abs(values).max(initial=0.0))
    return np.clip(values / usual, -BEYOND_USUAL, BEYOND_USUAL) if usual > 0.0 else values


def _torque(chain: Chain, joint: int, loads: NodeLoads) -> Floats:
    return _unit(drive_torque(chain, loads.wrench, joint))


def _of_torque(chain: Chain, joint: int, loads: NodeLoads) -> list[Floats]:
    """Return powers and steps of the drive's own torque."""
    u = _torque(chain, joint, loads)
    return [np.abs(u), u**2, u**3, u**5, *(np.tanh(k * u) for k in STEPS)]


def _of_contact(chain: Chain, joint: int, loads: NodeLoads) -> list[Floats]:
    """Return the power 2/3 of the torque, by which bodies flatten that roll on points (Hertz 1881)."""
    u = _torque(chain, joint, loads)
    return [np.sign(u) * np.cbrt(u) ** 2]


def _of_angle(chain: Chain, joint: int, loads: NodeLoads) -> list[Floats]:
    """Return waves of the joint's own angle, times torque."""
    u, q = _torque(chain, joint, loads), loads.angles[joint - 1]
    return [u * wave(k * q) for k in (0.5, 1.0, 2.0, 3.0, 4.0) for wave in (np.sin, np.cos)]


def _of_angle_alone(chain: Chain, joint: int, loads: NodeLoads) -> list[Floats]:
    """Return waves of the joint's own angle."""
    q = loads.angles[joint - 1]
    return [wave(k * q) for k in (1.0, 2.0, 3.0, 4.0) for wave in (np.sin, np.cos)]


def _of_other_angles(chain: Chain, joint: int, loads: NodeLoads) -> list[Floats]:
    """Return waves of each other joint's angle, times torque."""
    u = _torque(chain, joint, loads)
    others = [q for k, q in enumerate(loads.angles, start=1) if k != joint]
    return [u * wave(k * q) for q in others for k in (1.0, 2.0) for wave in (np.sin, np.cos)]


def _of_other_torques(chain: Chain, joint: int, loads: NodeLoads) -> list[Floats]:
    """Return each other joint's torque, its square, and products with the own torque."""
    u = _torque(chain, joint, loads)
    values: list[Floats] = []
    for k in range(1, chain.n_joints + 1):
        if k != joint:
            w = _torque(chain, k, loads)
            values += [w, w**2, np.abs(w) * u, w * u]
    return values


def _of_time(chain: Chain, joint: int, loads: NodeLoads) -> list[Floats]:
    """Return the torque as the time of the campaign goes on, at once and by and by; nothing without a clock."""
    u, order = _torque(chain, joint, loads), loads.order
    passed = None if order is None else _from_none_to_one(order.time)
    return [] if passed is None else [u * passed, u * passed**2, *(u * np.expm1(-k * passed) for k in WARMING)]


def _of_temperature(chain: Chain, joint: int, loads: NodeLoads) -> list[Floats]:
    """Return the torque as the temperature rises; nothing where it is not logged."""
    u, order = _torque(chain, joint, loads), loads.order
    rise = None if order is None else _from_none_to_one(order.kelvin)
    return [] if rise is None else [u * rise, u * rise**2]


def _from_none_to_one(values: Floats) -> Floats | None:
    """Return values over their range, from zero on; None where they are not known or stay."""
    if not len(values) or not np.isfinite(values).all() or np.ptp(values) <= 0.0:
        return None
    return np.asarray((values - values.min()) / np.ptp(values))


def _of_past(chain: Chain, joint: int, loads: NodeLoads) -> list[Floats]:
    """Return what the drive carried before."""
    return of_memory(_torque(chain, joint, loads), None if loads.order is None else loads.order.run)


Functions = Callable[[Chain, int, NodeLoads], list[Floats]]
"""Of the loads (n,) of a drive, by its joint from 1; each of order one."""
FUNCTIONS: dict[str, Functions] = {
    "its own torque": _of_torque,
    "its own torque to the power 2/3": _of_contact,
    "its own angle": _of_angle,
    "another joint's angle": _of_other_angles,
    "another joint's torque": _of_other_torques,
    "its own torque and the time": _of_time,
    "its own torque and the temperature": _of_temperature,
    "what it carried before": _of_past,
}
"""By what a law of them follows …"""
OF_PLACES: dict[str, Functions] = {"its own angle, whatever it carries": _of_angle_alone}
"""… and where places are absolute: displacements under load do not show what the load does not change."""


def _size(symbol: str) -> ParameterSpec:
    return ParameterSpec(symbol, "rad", "size", -1.0, 1.0, 1e-4, "")


def _even(moved: int) -> float:
    """Return a shift, or a turn, as large at the tool as the other."""
    return 1.0 if moved >= RX else LEVER_OF_NODE


class _Drive(Law):
    """A drive that gives by a sum of functions of its loads."""

    name = "unlisted"
    place_kind = "joints"

    def __init__(self, functions: Functions, count: int) -> None:
        self.functions = functions
        self.parameters = tuple(_size(f"a{k}") for k in range(count))  # type: ignore[misc]

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """Return the functions, each with an amplitude of its own."""
        joint = place.joints[0]
        values = self.functions(chain, joint, loads)
        return [term for k, value in enumerate(values) for term in drive_terms(chain, joint, f"a{k}", value)]


class _Node(Law):
    """A joint that gives in any direction under any load on it."""

    name = "unlisted-node"
    place_kind = "joints"

    def __init__(self, own: int) -> None:
        self.moves = [(moved, load) for moved in range(6) for load in range(6) if moved != own]
        self.parameters = tuple(_size(f"a{moved}{load}") for moved, load in self.moves)  # type: ignore[misc]

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """Return each turn and shift but the drive's own, proportional to each force and moment."""
        node = joint_node(place.joints[0])
        return [
            Term(node, moved, f"a{moved}{load}", _even(moved) * _unit(loads.wrench[node, load]))
            for moved, load in self.moves
        ]


class _Guide(Law):
    """A joint that slides in a guide, which gives the more the further it is out."""

    name = "unlisted-guide"
    place_kind = "joints"

    def __init__(self, own: int) -> None:
        self.moved = [moved for moved in range(6) if moved != own]
        self.parameters = tuple(_size(f"a{moved}{k}") for moved in self.moved for k in (1, 2))  # type: ignore[misc]

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """Return each turn and shift but the drive's own, by the load on it times the extension and its square."""
        joint = place.joints[0]
        node, out = joint_node(joint), _unit(loads.angles[joint - 1])
        return [
            Term(node, moved, f"a{moved}{k}", _even(moved) * _unit(loads.wrench[node, moved]) * out**k)
            for moved in self.moved
            for k in (1, 2)
        ]


class _Bent(Law):
    """A part of the set-up that gives along each component by curves and steps of the load on it."""

    name = "unlisted-setup"
    place_kind = "setup"

    def __init__(self, node: int) -> None:
        self.node = node
        functions = 3 + len(THRESHOLDS)
        self.parameters = tuple(_size(f"a{moved}{k}") for moved in range(6) for k in range(functions))  # type: ignore[misc]

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """Return of each component its own load's size, square and cube, and steps where the force is large."""
        wrench = loads.wrench[self.node]
        force = _unit(np.linalg.norm(wrench[TX : TZ + 1], axis=0))
        steps = [np.tanh((force / least - 1.0) / WIDTH_OF_STEP) for least in THRESHOLDS]
        found = []
        for moved in range(6):
            u = _unit(wrench[moved])
            values = enumerate((np.abs(u), u**2, u**3, *steps))
            found += [Term(self.node, moved, f"a{moved}{k}", _even(moved) * value) for k, value in values]
        return found
