"""The interface of a physical effect: one class, one file, everything that the tool needs to know of it.

An effect acts at one *place* (a joint, a link, a pair of joints, or the set-up) and brings parameters. Its parameters
are of three sorts:

- *amplitudes*: the small displacement at a node, or the shift of an observation, is proportional to them;
- *shape* parameters (a slip torque, the width of a crossing): the law bends with them;
- *set-up* parameters (a turned frame, an offset): they change what goes into the model.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import ClassVar

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.model.drive_motion import DriveMotion
from stiffcal.model.effect_values import BASE_NODE as BASE_NODE
from stiffcal.model.effect_values import RX as RX
from stiffcal.model.effect_values import RY as RY
from stiffcal.model.effect_values import RZ as RZ
from stiffcal.model.effect_values import TX as TX
from stiffcal.model.effect_values import TY as TY
from stiffcal.model.effect_values import TZ as TZ
from stiffcal.model.effect_values import Covariate as Covariate
from stiffcal.model.effect_values import Inputs as Inputs
from stiffcal.model.effect_values import Kind as Kind
from stiffcal.model.effect_values import NodeLoads as NodeLoads
from stiffcal.model.effect_values import Observed as Observed
from stiffcal.model.effect_values import Place as Place
from stiffcal.model.effect_values import PlaceKind as PlaceKind
from stiffcal.model.effect_values import Term as Term
from stiffcal.model.effect_values import joint_node as joint_node
from stiffcal.model.effect_values import joint_nodes as joint_nodes
from stiffcal.model.effect_values import link_node as link_node
from stiffcal.model.effect_values import tool_node as tool_node
from stiffcal.model.parameters import ParameterRole as ParameterRole
from stiffcal.model.parameters import ParameterSpec as ParameterSpec
from stiffcal.model.parameters import Values as Values
from stiffcal.model.parameters import usual_grid
from stiffcal.model.prismatic import at_prismatic_joint
from stiffcal.model.scalar_laws import BalancingSpring, ScalarLaw
from stiffcal.model.state_order import StateOrder as StateOrder


class Effect(ABC):
    """A physical effect. Subclasses hold constants and pure functions; instances carry no state."""

    name: ClassVar[str]
    kind: ClassVar[Kind]
    place_kind: ClassVar[PlaceKind]
    summary: ClassVar[str]
    includes: ClassVar[tuple[str, ...]] = ()
    excludes: ClassVar[tuple[str, ...]] = ()
    parameters: ClassVar[tuple[ParameterSpec, ...]] = ()
    needs: ClassVar[tuple[str, ...]] = ()
    looks_like: ClassVar[tuple[str, ...]] = ()
    forms: ClassVar[tuple[Effect, ...]] = ()
    """All forms of the law, the usual one first, where it can be written in several ways (`stiffcal.model.forms`)."""
    how_to_check: ClassVar[str] = ""
    fingerprint: ClassVar[str] = ""
    has_memory: ClassVar[bool] = False
    in_motion: ClassVar[bool] = False
    """True where the effect shows in the torque of a moving drive (`motion_columns`), and never at rest."""
    general: ClassVar[bool] = False
    """True where the law holds whatever its place can do: it is no rival of what it holds as a special case."""
    in_drive: ClassVar[bool] = False
    """True where clamped runs can show the effect: it acts in a drive, or on what such a bench measures."""
    prismatic: ClassVar[tuple[ParameterSpec, ...] | str] = "it turns about its joint's axis"
    """The parameters at a prismatic joint (of a drive `specs_along_axis`), or why it cannot act there, in words."""

    def places(self, chain: Chain) -> list[Place]:
        """Return the places on this robot at which the effect can act."""
        revolute = [k for k in range(1, chain.n_joints + 1) if k not in chain.prismatic_joints]
        if self.place_kind == "joints":
            joints = revolute if isinstance(self.prismatic, str) else range(1, chain.n_joints + 1)
            return [Place("joints", (k,)) for k in joints]
        if self.place_kind == "pairs":
            return [Place("pairs", (a, b)) for a in revolute for b in revolute if a < b]
        if self.place_kind == "links":
            return [Place("links", (), name) for name in chain.beams]
        return [Place("setup")]

    def at(self, place: Place, chain: Chain) -> Effect:
        """Return the effect as it is at one of its places: at a prismatic joint its parameters may be others."""
        prismatic = place.kind == "joints" and place.joints[0] in chain.prismatic_joints
        return at_prismatic_joint(self) if prismatic else self

    def lacking(self, chain: Chain, states: LoadStates) -> str | None:
        """Return the data missing to determine this effect from these data, or None where it can be tried."""
        return None

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """Return the finite constitutive law as a sum of terms (empty for effects that act elsewhere).

        Parameters
        ----------
        place : where.
        loads : what the nodes carry.
        shape : values of the shape parameters by symbol.
        """
        return ()

    def scalar_laws(self, place: Place, chain: Chain, values: Values) -> Sequence[ScalarLaw]:
        """Return the law as data, for controllers' code; only laws that are not proportional to their load need it.

        Parameters
        ----------
        place : where. chain : the robot.
        values : of amplitudes (`ParameterSpec.amplitude_of`) and shape parameters, by symbol.
        """
        return ()

    def balancing_spring(self, place: Place, chain: Chain, values: Values) -> BalancingSpring | None:
        """Return the spring that makes `joint_torque`, as data, for controllers' code, or None."""
        return None

    def adjusted_chain(self, place: Place, chain: Chain, values: Values) -> Chain:
        """Return the chain as its geometry or its masses are at these values; neutral values change nothing."""
        return chain

    def geometry_terms(self, place: Place, chain: Chain, angles: Floats, shape: Values) -> Sequence[Term]:
        """Return how far a unit of each amplitude moves the node outboard of it, at no load: derivatives, no law.

        For effects that change the undeformed chain (`adjusted_chain`) or its angles (`adjusted`): what they do is in
        the chain already, and these terms only say in which direction it goes.

        Parameters
        ----------
        place : where.
        chain : the robot.
        angles : (J, n) model joint angles, rad.
        shape : values of the shape parameters by symbol.
        """
        return ()

    def shape_slopes(self, place: Place, chain: Chain, loads: NodeLoads, values: Values) -> Sequence[Term]:
        """Return the derivatives of the law by shape parameters, as terms with their symbols.

        Parameters whose derivative is not among them are differentiated by difference.

        Parameters
        ----------
        place : where.
        chain : the robot.
        loads : what the nodes carry.
        values : of shape parameters and amplitudes, by symbol.
        """
        return ()

    def joint_torque(self, place: Place, chain: Chain, angles: Floats, values: Values) -> Floats | None:
        """Return (n,) torque that acts in parallel with the drive of the place's joint, N·m, or None."""
        return None

    def torque_columns(self, velocity: Floats, shape: Values) -> dict[str, Floats]:
        """Return amplitude symbol to (n,) torque of the drive per unit of it, in motion at velocities (n,), rad/s."""
        return {}

    def motion_columns(self, place: Place, chain: Chain, motion: DriveMotion, shape: Values) -> dict[str, Floats]:
        """Return amplitude symbol to (n,) torque of the place's drive per unit of it, in n samples of free motion.

        Laws of velocity alone need `torque_columns` only.
        """
        return self.torque_columns(motion.velocity, shape)

    def motion_grid(self, place: Place, chain: Chain, motion: DriveMotion) -> dict[str, Floats]:
        """Return values of the shape parameters to start or profile from, as `nonlinear_grid`, for free motion."""
        return usual_grid(self.parameters)

    def motion_covariate(self, place: Place, chain: Chain, motion: DriveMotion) -> Covariate:
        """Return the covariate that the residual of this effect follows in free motion."""
        return Covariate("velocity", "rad/s", motion.velocity)

    def lacking_motion(self, chain: Chain, motion: DriveMotion) -> str | None:
        """Return the data missing to determine this effect from one drive's free motion, or None."""
        return None

    def adjusted(self, place: Place, inputs: Inputs, values: Values) -> Inputs:
        """Return the inputs as changed by the set-up parameters; zero values change nothing."""
        return inputs

    def observation_columns(self, place: Place, observed: Observed, shape: Values) -> dict[str, Floats]:
        """Return amplitude symbol to (B, 6, n): what a unit of it adds to the displacement."""
        return {}

    def observation_shift(self, place: Place, observed: Observed, values: Values) -> Floats | None:
        """Return (B, 6, n) the finite shift of the observation, or None where it is the sum of amplitude × column.

        For observation laws that bend: `observation_columns` is then the slope at the measured displacement.
        """
        return None

    def nonlinear_grid(self, place: Place, chain: Chain, loads: NodeLoads) -> dict[str, Floats]:
        """Return values of the shape parameters to start or profile from, by symbol, in the light of the data.

        Parameters
        ----------
        place : where.
        chain : the robot.
        loads : what the nodes carry in the campaign's states.

        Returns
        -------
        Symbol to increasing values within the bounds; a law that no load in these data brings out gives an empty array.
        """
        return usual_grid(self.parameters)

    def impossible(self, values: Values) -> str | None:
        """Return why these values cannot be, where bounds alone do not decide, or None."""
        return None

    def covariate(self, place: Place, chain: Chain, loads: NodeLoads) -> Covariate | None:
        """Return the covariate that the residual of this effect follows."""
        return None

    def spec(self, symbol: str) -> ParameterSpec:
        """Return the parameter of that symbol; KeyError where there is none."""
        for parameter in self.parameters:
            if parameter.symbol == symbol:
                return parameter
        raise KeyError(symbol)

    @abstractmethod
    def describe(self) -> str:
        """Return the effect's physics for a reader: the class docstring."""


class DocumentedEffect(Effect):
    """An effect whose description is its docstring; the base of all built-in effects."""

    def describe(self) -> str:
        """Return the class docstring."""
        import inspect

        return inspect.getdoc(type(self)) or ""
