"""The interfaces of physical effects: one class, one file, everything that the tool needs to know of one.

An effect acts at one *place* (a joint, a link, a pair of joints, or the set-up) and brings parameters. It is one of
four kinds, by what it acts on: a `Law` lets a node give under what it carries, a `Geometry` changes what the robot file
states, an `Instrument` changes what is read, and a `Motion` (`stiffcal.model.motion`) is a torque of a moving drive.
What few laws can do besides has interfaces of its own (`stiffcal.model.abilities`, `stiffcal.model.forms`). Parameters
are of three sorts:

- *amplitudes*: the small displacement at a node, or the shift of an observation, is proportional to them;
- *shape* parameters (a slip torque, the width of a crossing): the law bends with them;
- *set-up* parameters (a turned frame, an offset): they change what goes into the model.
"""

from __future__ import annotations

import copy
from abc import ABC, abstractmethod
from collections.abc import Sequence
from functools import cache
from typing import ClassVar

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
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
from stiffcal.model.scalar_laws import ScalarLaw
from stiffcal.model.state_order import StateOrder as StateOrder


class Effect(ABC):
    """A physical effect. Subclasses hold constants and pure functions; instances carry no state."""

    name: ClassVar[str]
    kind: ClassVar[Kind]
    """Where in the one equation it enters: each of the four interfaces has its own."""
    place_kind: ClassVar[PlaceKind]
    summary: ClassVar[str]
    parameters: ClassVar[tuple[ParameterSpec, ...]] = ()
    prismatic: ClassVar[tuple[ParameterSpec, ...] | str] = "it turns about its joint's axis"
    """The parameters at a prismatic joint (of a drive `specs_along_axis`), or why it cannot act there, in words."""
    forms: ClassVar[tuple[Effect, ...]] = ()
    """All forms of the law, the usual one first, where it can be written in several ways (`stiffcal.model.forms`)."""
    includes: ClassVar[tuple[str, ...]] = ()
    """Effects that it holds, and whose place it takes."""
    excludes: ClassVar[tuple[str, ...]] = ()
    """Effects that cannot be in a model with it."""
    general: ClassVar[bool] = False
    """True where the law holds whatever its place can do: it is no rival of what it holds as a special case."""
    needs: ClassVar[tuple[str, ...]] = ()
    looks_like: ClassVar[tuple[str, ...]] = ()
    fingerprint: ClassVar[str] = ""
    """How it shows in the residual."""
    how_to_check: ClassVar[str] = ""
    """How to check it on the machine."""

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

    def impossible(self, values: Values) -> str | None:
        """Return why these values cannot be, where bounds alone do not decide, or None."""
        return None

    def spec(self, symbol: str) -> ParameterSpec:
        """Return the parameter of that symbol; KeyError where there is none."""
        for parameter in self.parameters:
            if parameter.symbol == symbol:
                return parameter
        raise KeyError(symbol)

    def describe(self) -> str:
        """Return the effect's physics for a reader: the class docstring."""
        import inspect

        return inspect.getdoc(type(self)) or ""


class EffectAtRest(Effect):
    """What load states and absolute places can show; none of its own: a `Law`, a `Geometry` or an `Instrument`."""

    in_drive: ClassVar[bool] = False
    """True where clamped runs can show the effect: it acts in a drive, or on what such a bench measures."""

    def lacking(self, chain: Chain, states: LoadStates) -> str | None:
        """Return the data missing to determine this effect from these data, or None where it can be tried."""
        return None

    def covariate(self, place: Place, chain: Chain, loads: NodeLoads) -> Covariate | None:
        """Return the covariate that the residual of this effect follows."""
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


class Law(EffectAtRest):
    """The small displacement of nodes under the loads that they carry."""

    kind = Kind.NODE_LAW
    has_memory: ClassVar[bool] = False
    """True where the law depends on the states before."""

    @abstractmethod
    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """Return the finite constitutive law as a sum of terms.

        Parameters
        ----------
        place : where.
        loads : what the nodes carry.
        shape : values of the shape parameters by symbol.
        """

    def scalar_laws(self, place: Place, chain: Chain, values: Values) -> Sequence[ScalarLaw]:
        """Return the law as data, for controllers' code; only laws that are not proportional to their load need it.

        Parameters
        ----------
        place : where. chain : the robot.
        values : of amplitudes (`ParameterSpec.amplitude_of`) and shape parameters, by symbol.
        """
        return ()


class Geometry(EffectAtRest):
    """What the robot file states of the undeformed chain: its geometry, its angles, its masses."""

    kind = Kind.CONFIGURATION

    def adjusted_chain(self, place: Place, chain: Chain, values: Values) -> Chain:
        """Return the chain as its geometry or its masses are at these values; neutral values change nothing."""
        return chain

    def adjusted(self, place: Place, inputs: Inputs, values: Values) -> Inputs:
        """Return the inputs as changed by the set-up parameters; zero values change nothing."""
        return inputs

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


class Instrument(EffectAtRest):
    """What is read, and where the instruments sit."""

    kind = Kind.OBSERVATION

    def adjusted(self, place: Place, inputs: Inputs, values: Values) -> Inputs:
        """Return the inputs as changed by the set-up parameters; zero values change nothing."""
        return inputs

    def observation_columns(self, place: Place, observed: Observed, shape: Values) -> dict[str, Floats]:
        """Return amplitude symbol to (B, 6, n): what a unit of it adds to the displacement."""
        return {}


@cache
def at_prismatic_joint(effect: Effect) -> Effect:
    """Return an effect with its parameters at a prismatic joint; ValueError where it cannot act there."""
    parameters = effect.prismatic
    if isinstance(parameters, str):
        raise ValueError(f"{effect.name} cannot act at a prismatic joint: {parameters}")
    if parameters == effect.parameters:
        return effect
    form = copy.copy(effect)
    form.parameters = parameters  # type: ignore[misc]  # of this instance alone
    return form
