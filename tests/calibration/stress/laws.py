"""Laws that neither the catalogue nor the mix holds: an effect of the catalogue that is named for them is wrong."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import RX, RY, TX, TY, TZ, NodeLoads, Place, Term, Values, joint_node, link_node, tool_node
from stiffcal.model.laws.drives import drive_terms, drive_torque
from stiffcal.model.laws.memory import clamped_between, first_of_run
from stiffcal.model.state_order import StateOrder
from tests.rates.outside import InventedLaw, amplitude, number

CROSSING = 0.05
"""Width of a step over its threshold: a step without width has no balance."""


class DriveLaw(InventedLaw, ABC):
    """A law by which a joint gives along its drive."""

    place_kind = "joints"

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """C times the law."""
        joint = place.joints[0]
        given = self.gives(drive_torque(chain, loads.wrench, joint), loads.angles[joint - 1], loads.order, shape)
        return () if given is None else (*drive_terms(chain, joint, "c", given),)

    @abstractmethod
    def gives(self, torque: Floats, angle: Floats, order: StateOrder | None, shape: Values) -> Floats | None:
        """Return the law's values (n,) by the joint's torque and angle (n,); None where it does not act.

        Parameters
        ----------
        order : of the states; None: a weight alone acts.
        """


class HertzContact(DriveLaw):
    """Rolling bodies that touch in points flatten by the power 2/3 of what they carry."""

    name = "hertz-contact"

    def gives(self, torque: Floats, angle: Floats, order: StateOrder | None, shape: Values) -> Floats | None:
        """c sign(τ) |τ|^(2/3)."""
        return np.asarray(np.sign(torque) * np.abs(torque) ** (2.0 / 3.0))


class WarmingSpring(DriveLaw):
    """A joint becomes softer while the robot warms up over the campaign."""

    name = "warming-spring"
    parameters = (amplitude(), number("warm", 1000.0))

    def gives(self, torque: Floats, angle: Floats, order: StateOrder | None, shape: Values) -> Floats | None:
        """c (1 − exp(−t / warm)) τ, t the time of the campaign, s; a weight alone acts in the cold robot."""
        return None if order is None else np.asarray((1.0 - np.exp(-order.time / shape["warm"])) * torque)


class CableBent(DriveLaw):
    """A cable that is bent beyond an angle pulls back in proportion to the angle: there the joint gives less."""

    name = "cable-bent"
    parameters = (amplitude(), number("angle", 0.0))

    def gives(self, torque: Floats, angle: Floats, order: StateOrder | None, shape: Values) -> Floats | None:
        """−c max(q − angle, 0) τ."""
        return np.asarray(-np.maximum(angle - shape["angle"], 0.0) * torque)


class QuillGuide(InventedLaw):
    """The guide of an axis that slides tilts under a moment, the more the further the axis is out."""

    name = "quill-guide"
    place_kind = "joints"

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


class MagnetSlip(InventedLaw):
    """The magnet that holds the target is tilted while the force is above a threshold."""

    name = "magnet-slip"
    place_kind = "setup"
    parameters = (amplitude(), number("force", 100.0), number("turn", 0.0))

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """C along a direction across the tool's axis where the force, N, is above the threshold."""
        node = tool_node(chain)
        force = np.sqrt(sum(loads.wrench[node, component] ** 2 for component in (TX, TY, TZ)))
        beyond = 0.5 + 0.5 * np.tanh((force / shape["force"] - 1.0) / CROSSING)
        return (
            Term(node, TX, "c", np.cos(shape["turn"]) * beyond),
            Term(node, TY, "c", np.sin(shape["turn"]) * beyond),
        )


class LinkTwistedByHeat(InventedLaw):
    """One side of a link becomes warm in the course of a run: the link twists without any load."""

    name = "link-twisted-by-heat"
    place_kind = "links"
    parameters = (amplitude(), number("warm", 100.0))

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """c (1 − exp(−t / warm)) about the link's axis, t the time since the run's first state, s."""
        if loads.order is None:
            return ()
        node = link_node(chain.beams[place.link].joint)
        return (Term(node, RX, "c", 1.0 - np.exp(-loads.order.since_reference / shape["warm"])),)


class ServoResidue(DriveLaw):
    """The integrator of a position loop keeps a residue of the load before, and loses it from state to state."""

    name = "servo-residue"
    has_memory = True
    parameters = (amplitude(), number("kept", 0.5))

    def gives(self, torque: Floats, angle: Floats, order: StateOrder | None, shape: Values) -> Floats | None:
        """C Σ kept^(k−1) τ_(i−k), over the states before in the run."""
        if order is None:
            return None
        first, residue = first_of_run(order.run), np.zeros_like(torque)
        for state in range(1, len(torque)):
            if not first[state]:
                residue[state] = shape["kept"] * residue[state - 1] + torque[state - 1]
        return residue


class StribeckUnderLoad(DriveLaw):
    """Friction holds a joint back, most of all where it is hardly loaded: the loop narrows with the load."""

    name = "stribeck-under-load"
    has_memory = True
    parameters = (amplitude(), number("slip", 1.0), number("falls", 1.0))

    def gives(self, torque: Floats, angle: Floats, order: StateOrder | None, shape: Values) -> Floats | None:
        """C times the torque as it comes through a play of slip · exp(−|τ| / falls), N·m."""
        play = shape["slip"] * np.exp(-np.abs(torque) / shape["falls"])
        if order is None:
            return np.asarray(torque - np.clip(torque, -play, play))
        return clamped_between(torque - play, torque + play, order.run, torque[first_of_run(order.run)])
