"""From the model file to the modelled robot: effects found in the catalogue, placed and given values."""

from __future__ import annotations

import difflib
from collections.abc import Mapping

from stiffcal.campaign.model.model_file import MODEL_FILE, EffectEntry, ModelFile
from stiffcal.errors import Fault, InputError, raise_faults
from stiffcal.fault_codes import FaultCode
from stiffcal.mechanics.chain import Chain
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import Effect, Place
from stiffcal.model.forms import form_of

# A fitted value on a bound may have been written down with three digits.
ROUNDED = 1e-3


def compliant_robot(
    chain: Chain, model: ModelFile, catalogue: Mapping[str, Effect], values: Mapping[str, float] | None = None
) -> CompliantRobot:
    """Place the model file's effects on the chain.

    Parameters
    ----------
    chain : the robot.
    model : what model.toml states.
    catalogue : effects by name (`find_effects`).
    values : parameter values by full name, over those of the model file.

    Raises
    ------
    InputError : an effect, a place or a parameter that does not exist, a value that cannot be, or effects that exclude
        each other.
    """
    faults: list[Fault] = []
    placed: list[PlacedEffect] = []
    settings = {name: setting.value for name, setting in model.parameter_settings().items()}
    for number, entry in enumerate(model.effects, start=1):
        effect = catalogue.get(entry.type)
        where = f"[[effects]] {number}, type"
        if effect is None:
            suggestions = difflib.get_close_matches(entry.type, catalogue, n=1)
            mend = (
                f"did you mean {suggestions[0]}?" if suggestions else f"choose one of: {', '.join(sorted(catalogue))}"
            )
            faults.append(Fault(FaultCode.EFFECT_UNKNOWN, MODEL_FILE, where, f"unknown effect {entry.type}", mend))
            continue
        for place in _places(effect, entry, chain, f"[[effects]] {number}, {entry.type}", faults):
            stem = PlacedEffect(effect, place).parameter_name("")
            symbols = [name.removeprefix(stem) for name in settings if name.startswith(stem)]
            placed.append(PlacedEffect(form_of(effect, symbols).at(place, chain), place))
    faults.extend(_conflict_faults(placed))
    raise_faults(faults)
    robot = CompliantRobot(chain, tuple(placed), model.balance == "deformed")
    _check_settings(robot, settings)
    return robot.with_values({**settings, **(values or {})})


def fixed_parameters(model: ModelFile) -> frozenset[str]:
    """Return the full names of parameters that model.toml holds at their values."""
    return frozenset(name for name, setting in model.parameter_settings().items() if setting.fixed)


def _places(effect: Effect, entry: EffectEntry, chain: Chain, where: str, faults: list[Fault]) -> list[Place]:
    possible = effect.places(chain)
    if effect.place_kind == "setup":
        places = [Place("setup")]
    elif effect.place_kind == "links":
        places = [Place("links", (), name) for name in entry.links or ()]
    elif effect.place_kind == "pairs":
        places = [Place("pairs", (min(pair), max(pair))) for pair in entry.pairs or ()]
    else:
        places = [Place("joints", (joint,)) for joint in entry.joints or ()]
    labels = ", ".join(place.label for place in possible) or "none on this robot"
    if not places:
        mend = f"add {effect.place_kind} = […]; possible: {labels}"
        faults.append(Fault(FaultCode.PLACE_INVALID, MODEL_FILE, where, f"no {effect.place_kind} given", mend))
    for place in places:
        if place not in possible:
            reason = f"{effect.name} cannot act at {place.label}"
            if chain.prismatic_joints.intersection(place.joints) and isinstance(effect.prismatic, str):
                reason += f", a prismatic joint: {effect.prismatic}"
            faults.append(Fault(FaultCode.PLACE_INVALID, MODEL_FILE, where, reason, f"possible: {labels}"))
    return [place for place in places if place in possible]


def _conflict_faults(placed: list[PlacedEffect]) -> list[Fault]:
    """Return a fault for each effect that stands twice at a place, and for each pair that exclude each other there."""
    faults = []
    at_place: dict[str, dict[str, Effect]] = {}
    twice: set[tuple[str, str]] = set()
    for placed_effect in placed:
        label, effect = placed_effect.place.label, placed_effect.effect
        effects_here = at_place.setdefault(label, {})
        if effect.name in effects_here:
            if (label, effect.name) not in twice:
                faults.append(
                    Fault(
                        FaultCode.EFFECT_CONFLICT, MODEL_FILE, effect.name, f"is given twice at {label}", "remove one"
                    )
                )
            twice.add((label, effect.name))
            continue
        for earlier in effects_here.values():
            if earlier.name in (*effect.includes, *effect.excludes) or effect.name in (
                *earlier.includes,
                *earlier.excludes,
            ):
                reason = f"{effect.name} and {earlier.name} cannot both act at {label}"
                faults.append(Fault(FaultCode.EFFECT_CONFLICT, MODEL_FILE, effect.name, reason, "remove one"))
        effects_here[effect.name] = effect
    return faults


def _check_settings(robot: CompliantRobot, settings: Mapping[str, float]) -> None:
    specs = {placed.parameter_name(spec.symbol): spec for placed in robot.placed for spec in placed.effect.parameters}
    faults = []
    for name, value in settings.items():
        place, spec = f"parameters.{name}", specs.get(name)
        if spec is None:
            suggestions = difflib.get_close_matches(name, specs, n=1)
            mend = f"did you mean {suggestions[0]}?" if suggestions else f"this model has: {', '.join(specs)}"
            faults.append(
                Fault(FaultCode.PARAMETER_UNKNOWN, MODEL_FILE, place, "the model has no such parameter", mend)
            )
        elif not spec.lower - ROUNDED * abs(spec.lower) <= value <= spec.upper + ROUNDED * abs(spec.upper):
            reason = f"{value:g} {spec.unit} is out of range: possible from {spec.lower:g} to {spec.upper:g}"
            faults.append(
                Fault(
                    FaultCode.VALUE_INVALID,
                    MODEL_FILE,
                    place,
                    reason,
                    f"write a value in this range; {spec.typical:g} is typical",
                )
            )
    if faults:
        raise InputError(*faults)
