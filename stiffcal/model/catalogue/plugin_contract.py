"""What an effect of a campaign's own code gives: held to what `Effect` promises, so that a fault has the code's name.

A class that the code defines is used through a class derived from it here, whose methods look at each answer of the
code before anything is computed from it. Built-in and installed effects are used as they are.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any, get_args

import numpy as np

from stiffcal.campaign.toml.name_checks import odd_character
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import (
    Covariate,
    Effect,
    Geometry,
    Inputs,
    Instrument,
    Kind,
    Law,
    NodeLoads,
    ParameterRole,
    ParameterSpec,
    Place,
    PlaceKind,
    Term,
)
from stiffcal.model.motion import Motion
from stiffcal.model.scalar_laws import BalancingSpring, ScalarLaw

MEND = "correct the file"
_SYMBOL = re.compile(r"[^\W\d]\w{0,99}")
_UNIT = re.compile(r"[A-Za-z0-9·/() ⁰¹²³⁴⁵⁶⁷⁸⁹⁻]{1,60}")
_SI_SYMBOLS = {"m", "rad", "N", "s", "kg", "K", "A", "Pa", "J", "W", "Hz", "or"}
_TEXTS = ("summary", "fingerprint", "how_to_check")
_NAMES = ("includes", "excludes", "needs", "looks_like")
_FLAGS = ("has_memory", "in_drive", "general")
_MOST_TEXT = 10_000
# Far beyond every quantity in SI units; the sum of the squares of many is still a number.
_LARGEST = 1e100


def checked_class(member: type[Effect], file: str) -> type[Effect]:
    """Return a class like one of a campaign's code, which answers as an effect does or raises an `InputError`.

    Raises
    ------
    InputError : its attributes are not those of an effect.
    """
    classes = {kind: _held(kind, file) for kind in dict.fromkeys((member, *map(type, _forms(member, file))))}
    forms = tuple(checked_effect(classes[type(form)](), file) for form in member.forms)
    for one in classes.values():
        one.forms = forms
    return classes[member]


def _forms(member: type[Effect], file: str) -> Sequence[Effect]:
    """Return the forms of a class's law."""
    forms: Any = member.forms
    if isinstance(forms, tuple | list) and all(isinstance(form, Effect) for form in forms):
        return forms
    raise InputError.at(
        FaultCode.PLUGIN_INVALID, file, member.__name__, f"forms is not a tuple of effects: {_shown(forms)}", MEND
    )


def _held(member: type[Effect], file: str) -> type[Effect]:
    """Return a class like this one that answers as an effect does."""
    wrong = _wrong_attribute(member)
    if wrong:
        raise InputError.at(FaultCode.PLUGIN_INVALID, file, member.__name__, wrong, MEND)
    methods = {name: _checked(member, name, check, file) for name, check in _answers_of(member).items()}
    inner = {"__module__": member.__module__, "__qualname__": member.__qualname__, "__doc__": member.__doc__}
    kind: Callable[..., type[Effect]] = type(member)
    return kind(member.__name__, (member,), {**inner, **methods})


def checked_effect(effect: object, file: str) -> Effect:
    """Return an effect as code of a campaign has made it.

    Raises
    ------
    InputError : it is none, or cannot be compared with itself and found again.
    """
    if not isinstance(effect, Effect) or (effect == effect) is not True or not isinstance(hash(effect), int):
        raise InputError.at(FaultCode.PLUGIN_INVALID, file, "plugins", "its class does not create an effect", MEND)
    return effect


def _wrong_attribute(member: type[Effect]) -> str:
    """Return the fault of the constants of an effect, "" where nothing is."""
    name = member.name
    if not isinstance(name, str) or not 0 < len(name) <= 100:
        return f"name is not a text of 1 to 100 characters: {_shown(name)}"
    if odd := odd_character(name):
        return odd[0]
    if any("__getattribute__" in vars(base) or "__class__" in vars(base) for base in _own_bases(member)):
        return "replaces what every object has: __getattribute__ or __class__"
    if not issubclass(member, Law | Geometry | Instrument | Motion):
        return "is derived from none of Law, Geometry, Instrument and Motion"
    if not isinstance(member.kind, Kind):
        return f"kind is no Kind: {_shown(member.kind)}"
    if getattr(member, "place_kind", None) not in get_args(PlaceKind):
        return f"place_kind is none of {', '.join(get_args(PlaceKind))}: {_shown(getattr(member, 'place_kind', None))}"
    for text in _TEXTS:
        if not _is_text(getattr(member, text, None)):
            return f"{text} is not a text: {_shown(getattr(member, text, None))}"
    for names in _NAMES:
        declared = getattr(member, names)
        if not isinstance(declared, tuple | list) or not all(isinstance(word, str) for word in declared):
            return f"{names} is not a tuple of texts: {_shown(declared)}"
    for flag in _FLAGS:
        if not isinstance(getattr(member, flag, False), bool):
            return f"{flag} is neither True nor False: {_shown(getattr(member, flag))}"
    if not (member.__doc__ is None or isinstance(member.__doc__, str)):
        return f"__doc__ is not a text: {_shown(member.__doc__)}"
    for method in _answers_of(member):
        if not callable(getattr(member, method)):
            return f"{method} is not a method: {_shown(getattr(member, method))}"
    return _wrong_parameters(member.parameters)


def _own_bases(member: type[Effect]) -> list[type]:
    return [base for base in member.__mro__ if base.__module__ == member.__module__]


def _wrong_parameters(declared: Any) -> str:
    if not isinstance(declared, tuple | list) or not all(isinstance(spec, ParameterSpec) for spec in declared):
        return f"parameters is not a tuple of ParameterSpec: {_shown(declared)}"
    symbols = [spec.symbol for spec in declared]
    for spec in declared:
        if not isinstance(spec.symbol, str) or _SYMBOL.fullmatch(spec.symbol) is None:
            return f"the symbol of a parameter is not a name: {_shown(spec.symbol)}"
        if symbols.count(spec.symbol) > 1:
            return f"two parameters have the symbol {spec.symbol}"
        if not all(_is_text(text) for text in (spec.unit, spec.meaning, spec.source)):
            return f"unit, meaning or source of the parameter {spec.symbol} is not a text"
        if not is_si_unit(spec.unit):
            return (
                f"the unit of the parameter {spec.symbol} is not an SI unit: {_shown(spec.unit)}; write m, rad, N, "
                "N·m, s, kg, K and 1 with · and /, as rad/(N·m)"
            )
        sizes = (spec.lower, spec.typical, spec.upper)
        if not all(_is_real(size) for size in sizes) or not np.isfinite(spec.typical) or not spec.lower < spec.upper:
            return f"the parameter {spec.symbol} has no lower < upper with a typical size: {_shown(sizes)}"
        if not _is_real(spec.neutral):
            return f"the neutral value of the parameter {spec.symbol} is not a number: {_shown(spec.neutral)}"
        if not isinstance(spec.role, ParameterRole) or not all(
            isinstance(flag, bool) for flag in (spec.inverse, spec.compliance, spec.discrete, spec.scales_load)
        ):
            return f"sort, inverse, compliance or discrete of the parameter {spec.symbol} is none"
    return ""


def is_si_unit(unit: str) -> bool:
    """Return whether a unit is written with the symbols of SI: everything is computed and printed in these.

    Examples
    --------
    >>> [is_si_unit(unit) for unit in ("rad/(N·m)²", "1", "N·m·(s/rad)^power", "m/s or m/K")]
    [True, True, True, True]
    >>> [is_si_unit(unit) for unit in ("Nm/grad", "mm", "")]
    [False, False, False]
    """
    plain = re.sub(r"\^\w+", "", unit)
    return bool(unit) and bool(_UNIT.fullmatch(plain)) and set(re.findall(r"[A-Za-z]+", plain)) <= _SI_SYMBOLS


def _checked(member: type[Effect], name: str, check: Callable[..., str], file: str) -> Callable[..., Any]:
    def method(self: Effect, *arguments: Any, **named: Any) -> Any:
        answer = getattr(member, name)(self, *arguments, **named)
        wrong = check(self, answer, *arguments, **named)
        if wrong:
            raise InputError.at(FaultCode.PLUGIN_INVALID, file, f"{member.__name__}.{name}", f"returns {wrong}", MEND)
        return answer

    method.__name__, method.__doc__ = name, getattr(member, name).__doc__
    return method


def _terms(effect: Effect, answer: Any, place: Place, chain: Any, loads: Any, shape: Any) -> str:
    nodes, _, count = loads.wrench.shape
    amplitudes = {"", *(spec.symbol for spec in effect.parameters)}
    if not isinstance(answer, tuple | list):
        return f"no tuple of terms: {_shown(answer)}"
    for term in answer:
        if not isinstance(term, Term):
            return f"what is no Term: {_shown(term)}"
        if not (_is_whole(term.node) and 0 <= term.node < nodes):
            return f"a term at node {_shown(term.node)}, where there are nodes 0 to {nodes - 1}"
        if not (_is_whole(term.component) and 0 <= term.component < 6):
            return f"a term of component {_shown(term.component)}, which is none of 0 to 5"
        if not isinstance(term.symbol, str) or term.symbol not in amplitudes:
            return f"a term with the symbol {_shown(term.symbol)}, which no parameter has"
        if wrong := _wrong_array(term.value, (count,)):
            return f"a term whose value {wrong}"
    return ""


def _torque_columns(effect: Effect, answer: Any, velocity: Any, shape: Any) -> str:
    return _columns(effect, answer, velocity.shape)


def _motion_columns(effect: Effect, answer: Any, place: Place, chain: Any, motion: Any, shape: Any) -> str:
    return _columns(effect, answer, motion.velocity.shape)


def _motion_grid(effect: Effect, answer: Any, *arguments: Any, **named: Any) -> str:
    return _grid(effect, answer)


def _observation_columns(effect: Effect, answer: Any, place: Place, observed: Any, shape: Any) -> str:
    return _columns(effect, answer, observed.displacement.shape)


def _columns(effect: Effect, answer: Any, shape: tuple[int, ...]) -> str:
    symbols = [spec.symbol for spec in effect.parameters]
    if not isinstance(answer, Mapping):
        return f"no mapping of symbols to arrays: {_shown(answer)}"
    for symbol, column in answer.items():
        if symbol not in symbols:
            return f"a column of {_shown(symbol)}, which no parameter has"
        if wrong := _wrong_array(column, shape):
            return f"a column of {symbol} that {wrong}"
    return ""


def _observation_shift(effect: Effect, answer: Any, place: Place, observed: Any, values: Any) -> str:
    wrong = "" if answer is None else _wrong_array(answer, observed.displacement.shape)
    return f"a shift that {wrong}" if wrong else ""


def _inputs(effect: Effect, answer: Any, place: Place, inputs: Inputs, values: Any) -> str:
    if not isinstance(answer, Inputs):
        return f"no Inputs: {_shown(answer)}"
    for name in ("angles", "wrench"):
        if wrong := _wrong_array(getattr(answer, name), getattr(inputs, name).shape):
            return f"inputs whose {name} {wrong}"
    return "" if isinstance(answer.setup, type(inputs.setup)) else "inputs without a setup"


def _adjusted_chain(effect: Effect, answer: Any, *arguments: Any, **named: Any) -> str:
    return "" if isinstance(answer, Chain) else f"no Chain: {_shown(answer)}"


def _geometry_terms(effect: Effect, answer: Any, place: Place, chain: Any, angles: Any, shape: Any) -> str:
    nodes = np.broadcast_to(0.0, (2 * chain.n_joints + 2, 6, angles.shape[-1]))
    return _terms(effect, answer, place, chain, NodeLoads(nodes, angles), shape)


def _nonlinear_grid(effect: Effect, answer: Any, *arguments: Any, **named: Any) -> str:
    return _grid(effect, answer)


def _grid(effect: Effect, answer: Any) -> str:
    symbols = [spec.symbol for spec in effect.parameters]
    if not isinstance(answer, Mapping) or not all(symbol in symbols for symbol in answer):
        return f"no mapping of the parameters' symbols to arrays: {_shown(answer)}"
    for symbol, grid in answer.items():
        if not isinstance(grid, np.ndarray) or grid.ndim != 1:
            return f"a grid of {symbol} that is not an array of one axis"
        if wrong := _wrong_array(grid, grid.shape):
            return f"a grid of {symbol} that {wrong}"
    return ""


def _places(effect: Effect, answer: Any, chain: Any) -> str:
    right = isinstance(answer, tuple | list) and all(
        isinstance(place, Place) and place.kind == effect.place_kind for place in answer
    )
    return "" if right else f"no list of places of kind {effect.place_kind}: {_shown(answer)}"


def _covariate(effect: Effect, answer: Any, place: Place, chain: Any, loads: Any) -> str:
    if answer is None:
        return ""
    if not isinstance(answer, Covariate) or not (_is_text(answer.label) and _is_text(answer.unit)):
        return f"no Covariate: {_shown(answer)}"
    wrong = _wrong_array(answer.value, loads.wrench.shape[-1:])
    if not wrong and answer.parts is not None:
        wrong = _wrong_array(answer.parts, (np.shape(answer.parts)[0], loads.wrench.shape[-1]))
    return f"a covariate whose value {wrong}" if wrong else ""


def _motion_covariate(effect: Effect, answer: Any, place: Place, chain: Any, motion: Any) -> str:
    if not isinstance(answer, Covariate) or not (_is_text(answer.label) and _is_text(answer.unit)):
        return f"no Covariate: {_shown(answer)}"
    wrong = _wrong_array(answer.value, motion.velocity.shape)
    return f"a covariate whose value {wrong}" if wrong else ""


def _scalar_laws(effect: Effect, answer: Any, *arguments: Any, **named: Any) -> str:
    right = isinstance(answer, tuple | list) and all(isinstance(law, ScalarLaw) for law in answer)
    return "" if right else f"no list of ScalarLaw: {_shown(answer)}"


def _balancing_spring(effect: Effect, answer: Any, *arguments: Any, **named: Any) -> str:
    right = answer is None or isinstance(answer, BalancingSpring)
    return "" if right else f"neither a BalancingSpring nor None: {_shown(answer)}"


def _text(effect: Effect, answer: Any, *arguments: Any, **named: Any) -> str:
    return "" if _is_text(answer) else f"no text: {_shown(answer)}"


def _text_or_none(effect: Effect, answer: Any, *arguments: Any, **named: Any) -> str:
    return "" if answer is None or _is_text(answer) else f"neither a text nor None: {_shown(answer)}"


def _spec(effect: Effect, answer: Any, *arguments: Any, **named: Any) -> str:
    return "" if isinstance(answer, ParameterSpec) else f"no ParameterSpec: {_shown(answer)}"


# Method to the check of its answer, which returns what is wrong with it, "" where nothing is.
_ANSWERS: dict[str, Callable[..., str]] = {
    "terms": _terms,
    "scalar_laws": _scalar_laws,
    "balancing_spring": _balancing_spring,
    "torque_columns": _torque_columns,
    "motion_columns": _motion_columns,
    "motion_grid": _motion_grid,
    "motion_covariate": _motion_covariate,
    "lacking_motion": _text_or_none,
    "observation_columns": _observation_columns,
    "observation_shift": _observation_shift,
    "adjusted": _inputs,
    "adjusted_chain": _adjusted_chain,
    "geometry_terms": _geometry_terms,
    "nonlinear_grid": _nonlinear_grid,
    "places": _places,
    "covariate": _covariate,
    "describe": _text,
    "lacking": _text_or_none,
    "impossible": _text_or_none,
    "spec": _spec,
}


def _answers_of(member: type[Effect]) -> dict[str, Callable[..., str]]:
    """Return the checks of the methods that a class has."""
    return {name: check for name, check in _ANSWERS.items() if hasattr(member, name)}


def _wrong_array(value: Any, shape: tuple[int, ...]) -> str:
    """Return why a value is not an array of finite real numbers of this shape that can be squared, "" where it is."""
    if not isinstance(value, np.ndarray) or value.dtype.kind not in "fiu":
        return f"is no array of real numbers: {_shown(value)}"
    if value.shape != shape:
        return f"has the shape {value.shape}, not {shape}"
    if not np.isfinite(value).all():
        return "is not finite"
    return "" if (np.abs(value) <= _LARGEST).all() else f"holds a number beyond ±{_LARGEST:g}"


def _is_real(value: object) -> bool:
    return isinstance(value, float | int | np.floating | np.integer) and not isinstance(value, bool)


def _is_whole(value: object) -> bool:
    return isinstance(value, int | np.integer) and not isinstance(value, bool)


def _is_text(value: object) -> bool:
    return isinstance(value, str) and len(value) <= _MOST_TEXT


def _shown(value: object) -> str:
    """Return a short text of any object, whatever its own `__repr__` does."""
    if isinstance(value, str | int | float | bool | None):
        try:
            return repr(value)[:80]
        except Exception:
            pass
    return type(value).__name__
