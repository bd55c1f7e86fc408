"""Places and nodes, and the values that effects take and return.

Nodes are numbered along the chain: 0 the base, 2k − 1 joint k, 2k the outboard end of link k, 2J + 1 the tool.
A node's small displacement has six components in the node's axes: three translations, three rotations.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from typing import Literal, Self

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.measurements.load_states import MeasurementSetup
from stiffcal.mechanics.chain import Chain
from stiffcal.model.held_frame import HeldFrame
from stiffcal.model.state_order import StateOrder

PlaceKind = Literal["joints", "links", "pairs", "frames", "setup"]

# Components of a node's displacement and wrench.
TX, TY, TZ, RX, RY, RZ = range(6)
BASE_NODE = 0


class Kind(Enum):
    """Where in the one equation an effect enters (physics, section 1)."""

    NODE_LAW = "node law"
    COUPLING = "coupling"
    CONFIGURATION = "configuration"
    OBSERVATION = "observation"


@dataclass(frozen=True)
class Place:
    """Where an effect acts."""

    kind: PlaceKind
    """"joints", "links", "pairs", "frames" or "setup"."""
    joints: tuple[int, ...] = ()
    """Joint numbers from 1: one for a joint, two for a pair, none else."""
    link: str = ""
    """The link's name, or ""."""
    frame: str = ""
    """The name of a frame of the manifest, or ""."""

    @property
    def label(self) -> str:
        """The place in parameter names: ``j4``, ``swing``, ``j5-j6``, ``tracker`` (a frame) or ``setup``."""
        if self.kind == "links":
            return self.link
        if self.kind == "frames":
            return self.frame
        return "-".join(f"j{number}" for number in self.joints) or "setup"


@dataclass(frozen=True)
class Term:
    """One product ``amplitude × value`` that adds to one component of one node's displacement."""

    node: int
    """Node number."""
    component: int
    """0 … 5, translation then rotation, node axes."""
    symbol: str
    """The amplitude's symbol; "" for a term without a free parameter."""
    value: Floats
    """(n,) what the amplitude is multiplied with, per state."""


@dataclass(frozen=True)
class NodeLoads:
    """What the nodes carry in n states."""

    wrench: Floats
    """(2J + 2, 6, n) force and moment in each node's axes about its origin, N and N·m, weight included."""
    angles: Floats
    """(J, n) model joint angles, rad."""
    order: StateOrder | None = None
    """The states' order and time, or None where the states stand alone."""
    weight: Floats | None = None
    """(2J + 2, 6, n) the part of ``wrench`` that weight alone makes at no load, where a law needs it; else None."""
    reference_kelvin: Floats | None = None
    """(n,) K, the temperature of the run's reference state, for states under weight alone; else None."""

    @property
    def temperature(self) -> Floats:
        """(n,) K, of the first temperature channel; under weight alone at the run's reference; NaN where not known."""
        if self.order is not None:
            return self.order.kelvin
        return np.full(self.wrench.shape[-1], np.nan) if self.reference_kelvin is None else self.reference_kelvin


@dataclass(frozen=True)
class Inputs:
    """What goes into the balance, for effects that change it."""

    angles: Floats
    """(J, n) model joint angles, rad."""
    wrench: Floats
    """(6, n) as read, sensor axes."""
    setup: MeasurementSetup
    """Where the instruments sit."""
    loaded: bool = True
    """False for the weight-only state, where no sensor is read."""
    read: Booleans | None = None
    """(n,) False where no sensor is read: absolute places without a load; None: read in every state."""
    tracker: Integers | None = None
    """(n,) which of the set-up's trackers reads each state; None: the first."""
    tracker_error: Floats | None = None
    """(T, 4, 4) of each tracker, motion in base axes of what is reported against what is there, m, as it does not stand
    where the set-up has it; None: all do.
    """


@dataclass(frozen=True)
class Observed:
    """What observation effects act on."""

    displacement: Floats
    """(B, 6, n) predicted displacement of each target since the unloaded state, base axes, m and rad."""
    order: StateOrder
    """The states' order and time."""
    held: HeldFrame | None = None
    """The frame by which the robot is held in clamped runs; None where there are none."""


@dataclass(frozen=True)
class Covariate:
    """What the residual is to be plotted against."""

    label: str
    """Text of the axis."""
    unit: str
    """Unit of the axis."""
    value: Floats = field(default_factory=lambda: np.zeros(0))
    """(n,) its values."""
    parts: Floats | None = None
    """(k, n) the signed components of which ``value`` is the length; None where it has a sign of its own."""

    @classmethod
    def size_of(cls, label: str, unit: str, parts: Floats) -> Self:
        """Return the length of a moment or a force with components (k, n): residuals are drawn over it with a sign.

        Without them a curve over it would fold: opposite loads have one length.
        """
        return cls(label, unit, np.linalg.norm(parts, axis=0), parts)


def joint_node(joint: int) -> int:
    """Return the node number of joint k = 1 … J."""
    return 2 * joint - 1


def joint_nodes(chain: Chain) -> Integers:
    """Return (J,) the node numbers of all joints."""
    return 2 * np.arange(chain.n_joints) + 1


def link_node(joint: int) -> int:
    """Return the node number of the outboard end of the link that joint k moves."""
    return 2 * joint


def tool_node(chain: Chain) -> int:
    """Return the node number of the tool."""
    return 2 * chain.n_joints + 1
