"""Laws that can be written in several ways: each form is an effect of its own, with a common name for the user.

A model has the form whose parameters it names, a search compares those that add to a model, and two kinds of form are
asked for otherwise: the curve of a straight law, by the user, and a whole form, which takes the place of others.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence

from stiffcal.arrays import Floats, Integers
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import Effect, EffectAtRest, Law, Place, Values, at_prismatic_joint


class WholeForm(Law, ABC):
    """A form that takes the place of the usual one and of what it includes, with as many parameters.

    It is no addition: a search fits it once the law is in the model, and keeps whichever errs less. `lacking` is where
    it does not hold.
    """

    @abstractmethod
    def start(self, torque: Floats, angle: Floats) -> dict[str, float]:
        """Return values from which its fit starts.

        Parameters
        ----------
        torque : (n,) about the joint, N·m.
        angle : (n,) rad, by which the usual form and what this one includes let the joint turn.
        """


class TorqueCurve(WholeForm, ABC):
    """The whole curve of a drive, τ = p1 φ + p2 φ² + p3 φ³: three parameters, in this order."""


class MotorFriction(WholeForm, ABC):
    """Friction between a clamped drive's motor and its spring: the drive's other laws act on what is left."""

    @abstractmethod
    def spring_torque(
        self, place: Place, torque: Floats, run: Integers, weight: Floats | None, values: Values
    ) -> Floats | None:
        """Return (n,) torque that reaches the drive's springs from its motor, N·m, or None where all of it does.

        Parameters
        ----------
        torque : (n,) the motor's torque on the drive of the place's joint, N·m, in the order in which it acted.
        run : (n,) run number; states of a run contiguous.
        weight : (n,) torque of the weight alone, N·m, which acts before a run begins; None: none.
        values : of all parameters, by symbol.
        """


def symbols_of(effect: Effect) -> tuple[str, ...]:
    """Return the symbols of an effect's parameters."""
    return tuple(spec.symbol for spec in effect.parameters)


def form_of(effect: Effect, symbols: Iterable[str]) -> Effect:
    """Return the form of the law that these parameters are of, at the same kind of joint."""
    wanted = set(symbols)
    if wanted <= set(symbols_of(effect)):
        return effect
    best = max((effect, *effect.forms), key=lambda form: len(wanted.intersection(symbols_of(form))))
    return same_joint(effect, best)


def same_joint(effect: Effect, form: Effect) -> Effect:
    """Return another form of an effect's law with the parameters of the kind of joint that the effect is at."""
    return at_prismatic_joint(form) if effect.parameters == effect.prismatic else form


def curve_of(effect: Effect) -> Effect | None:
    """Return the curved form of a straight law, which has all of its parameters and more; None without one."""
    straight = set(symbols_of(effect))
    return next((form for form in effect.forms if straight < set(symbols_of(form))), None)


def added_forms(effect: EffectAtRest) -> Sequence[EffectAtRest]:
    """Return the forms among which a search chooses, the usual one first: those that add to a model."""
    curve = curve_of(effect)
    forms = (form for form in effect.forms if form is not curve and not isinstance(form, WholeForm))
    return [form for form in forms if isinstance(form, EffectAtRest)] or [effect]


def whole_form(effect: Effect, chain: Chain, states: LoadStates) -> WholeForm | None:
    """Return the form that replaces others of its place in these states; None without one."""
    forms = (form for form in effect.forms if isinstance(form, WholeForm))
    return next((form for form in forms if form.lacking(chain, states) is None), None)


def torque_curve(effect: Effect) -> TorqueCurve | None:
    """Return the form as torque over angle; None without one."""
    return next((form for form in effect.forms if isinstance(form, TorqueCurve)), None)
