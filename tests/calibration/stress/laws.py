"""Laws that neither the catalogue nor the mix holds: whoever names an effect of the catalogue for them is wrong."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.mechanics.chain import Chain
from stiffcal.model.drives import drive_terms, drive_torque
from stiffcal.model.effect import (
    RX,
    RY,
    TX,
    TY,
    TZ,
    DocumentedEffect,
    Kind,
    NodeLoads,
    ParameterRole,
    ParameterSpec,
    Place,
    Term,
    Values,
    joint_node,
    link_node,
    tool_node,
)
from stiffcal.model.memory import clamped_between, first_of_run

CROSSING = 0.05
"""Width of a step over its threshold: a step without width has no balance."""


def _amplitude() -> ParameterSpec:
    return ParameterSpec("c", "1", "size", -np.inf, np.inf, 1e-9, "invented")


def _number(symbol: str, value: float) -> ParameterSpec:
    return ParameterSpec(symbol, "1", "shape", -np.inf, np.inf, value, "invented", ParameterRole.NONLINEAR)


class HertzContact(DocumentedEffect):
    """Rolling bodies that touch in points flatten by the power 2/3 of what they carry."""

    name = "hertz-contact"
    kind = Kind.NODE_LAW
    place_kind = "joints"
    summary = "outside"
    parameters = (_amplitude(),)

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """c sign(τ) |τ|^(2/3)."""
        torque = drive_torque(chain, loads.wrench, place.joints[0])
        return (*drive_terms(chain, place.joints[0], "c", np.sign(torque) * np.abs(torque) ** (2.0 / 3.0)),)


class WarmingSpring(DocumentedEffect):
    """A joint becomes softer while the robot warms up over the campaign."""

    name = "warming-spring"
    kind = Kind.NODE_LAW
    place_kind = "joints"
    summary = "outside"
    parameters = (_amplitude(), _number("warm", 1000.0))

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """c (1 − exp(−t / warm)) τ, t the time of the campaign, s; a weight alone acts in the cold robot."""
        if loads.order is None:
            return ()
        softer = 1.0 - np.exp(-loads.order.time / shape["warm"])
        torque = drive_torque(chain, loads.wrench, place.joints[0])
        return (*drive_terms(chain, place.joints[0], "c", softer * torque),)


class CableBent(DocumentedEffect):
    """A cable that is bent beyond an angle pulls back in proportion to the angle: there the joint gives less."""

    name = "cable-bent"
    kind = Kind.NODE_LAW
    place_kind = "joints"
    summary = "outside"
    parameters = (_amplitude(), _number("angle", 0.0))

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """−c max(q − angle, 0) τ."""
        joint = place.joints[0]
        bent = np.maximum(loads.angles[joint - 1] - shape["angle"], 0.0)
        return (*drive_terms(chain, joint, "c", -bent * drive_torque(chain, loads.wrench, joint)),)


class QuillGuide(DocumentedEffect):
    """The guide of an axis that slides tilts under a moment, the more the further the axis is out."""

    name = "quill-guide"
    kind = Kind.NODE_LAW
    place_kind = "joints"
    summary = "outside"
    parameters = (_amplitude(),)

    def places(self, chain: Chain) -> list[Place]:
        """Axes that slide."""
        return [Place("joints", (joint,)) for joint in sorted(chain.prismatic_joints)]

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """C q (Mx, My) about x and y of the joint's frame."""
        joint = place.joints[0]
        node, out = joint_node(joint), np.asarray(loads.angles[joint - 1])
        return (
            Term(node, RX, "c", out * loads.wrench[node, RX]),
            Term(node, RY, "c", out * loads.wrench[node, RY]),
        )


class MagnetSlip(DocumentedEffect):
    """The magnet that holds the target lies askew while the force is above a threshold."""

    name = "magnet-slip"
    kind = Kind.NODE_LAW
    place_kind = "setup"
    summary = "outside"
    parameters = (_amplitude(), _number("force", 100.0), _number("turn", 0.0))

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """C along a direction across the tool's axis where the force, N, is above the threshold."""
        node = tool_node(chain)
        force = np.sqrt(sum(loads.wrench[node, component] ** 2 for component in (TX, TY, TZ)))
        beyond = 0.5 + 0.5 * np.tanh((force / shape["force"] - 1.0) / CROSSING)
        return (
            Term(node, TX, "c", np.cos(shape["turn"]) * beyond),
            Term(node, TY, "c", np.sin(shape["turn"]) * beyond),
        )


class LinkTwistedByHeat(DocumentedEffect):
    """One side of a link becomes warm in the course of a run: the link twists without any load."""

    name = "link-twisted-by-heat"
    kind = Kind.NODE_LAW
    place_kind = "links"
    summary = "outside"
    parameters = (_amplitude(), _number("warm", 100.0))

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """c (1 − exp(−t / warm)) about the link's axis, t the time since the run's first state, s."""
        if loads.order is None:
            return ()
        node = link_node(chain.beams[place.link].joint)
        return (Term(node, RX, "c", 1.0 - np.exp(-loads.order.since_reference / shape["warm"])),)


class ServoResidue(DocumentedEffect):
    """The integrator of a position loop keeps a residue of the load before, and loses it from state to state."""

    name = "servo-residue"
    kind = Kind.NODE_LAW
    place_kind = "joints"
    summary = "outside"
    has_memory = True
    parameters = (_amplitude(), _number("kept", 0.5))

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """C Σ kept^(k−1) τ_(i−k), over the states before in the run."""
        if loads.order is None:
            return ()
        torque = drive_torque(chain, loads.wrench, place.joints[0])
        first, residue = first_of_run(loads.order.run), np.zeros_like(torque)
        for state in range(1, len(torque)):
            if not first[state]:
                residue[state] = shape["kept"] * residue[state - 1] + torque[state - 1]
        return (*drive_terms(chain, place.joints[0], "c", residue),)


class StribeckUnderLoad(DocumentedEffect):
    """Friction holds a joint back, most of all where it is hardly loaded: the loop narrows with the load."""

    name = "stribeck-under-load"
    kind = Kind.NODE_LAW
    place_kind = "joints"
    summary = "outside"
    has_memory = True
    parameters = (_amplitude(), _number("slip", 1.0), _number("falls", 1.0))

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """C times the torque as it comes through a play of slip · exp(−|τ| / falls), N·m."""
        torque = drive_torque(chain, loads.wrench, place.joints[0])
        play = shape["slip"] * np.exp(-np.abs(torque) / shape["falls"])
        if loads.order is None:
            through: Floats = torque - np.clip(torque, -play, play)
        else:
            run = loads.order.run
            first = torque[first_of_run(run)]
            through = clamped_between(torque - play, torque + play, run, first)
        return (*drive_terms(chain, place.joints[0], "c", through),)
