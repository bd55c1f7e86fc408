"""The catalogue of effects."""

from __future__ import annotations

import difflib
import math
from pathlib import Path

from stiffcal.campaign.loading import load_campaign
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.model.catalogue.campaign_effects import plugin_code
from stiffcal.model.catalogue.catalogue import find_effects
from stiffcal.model.catalogue.plugin_code import PluginCode
from stiffcal.model.effect import Effect
from stiffcal.model.motion import Motion
from stiffcal.results.command_results import EffectDescription, EffectParameter, EffectsResult

# How an effect of moving joints enters the model, where others have their `Kind`.
IN_MOTION = "torque in motion"


def describe_effects(name: str | None = None, plugins: PluginCode | None = None) -> EffectsResult:
    """Return the description of the effects that a model can hold.

    Parameters
    ----------
    name : only this one; all where None.
    plugins : a campaign's own code (`read_plugins`), which the user has allowed.

    Raises
    ------
    InputError : there is no effect of that name, or the code is not trusted.

    Examples
    --------
    >>> describe_effects("joint-compliance").effects[0].parameters[0].unit
    'rad/(N·m)'
    """
    catalogue = find_effects(plugins)
    if name is None:
        chosen = list(catalogue.values())
    elif name in catalogue:
        chosen = [catalogue[name]]
    else:
        suggestions = difflib.get_close_matches(name, catalogue, n=1)
        mend = f"did you mean {suggestions[0]}?" if suggestions else f"choose one of: {', '.join(sorted(catalogue))}"
        mend += "" if plugins is not None else "; for an effect of a campaign add --from DIR"
        raise InputError.at(FaultCode.EFFECT_UNKNOWN, "command line", "NAME", f"unknown effect {name}", mend)
    return EffectsResult(warnings=[], effects=[_describe(effect) for effect in chosen])


def code_of_campaign(folder: Path) -> PluginCode:
    """Return the code of a campaign's own effects, none of which has run.

    Raises
    ------
    InputError : the folder holds no campaign, or a listed file cannot be read.
    """
    return plugin_code(load_campaign(Path(folder), check_files=False))


def _describe(effect: Effect) -> EffectDescription:
    return EffectDescription(
        name=effect.name,
        place={"setup": "set-up"}.get(effect.place_kind, effect.place_kind),
        kind=IN_MOTION if isinstance(effect, Motion) else effect.kind.value,
        summary=effect.summary,
        physics=effect.describe(),
        parameters=[
            EffectParameter(
                symbol=spec.symbol,
                unit=spec.unit,
                meaning=spec.meaning,
                bounds=[_finite(spec.lower), _finite(spec.upper)],
                typical=spec.typical,
                source=spec.source,
            )
            for spec in effect.parameters
        ],
        needs=list(effect.needs),
        includes=list(effect.includes),
        excludes=list(effect.excludes),
        fingerprint=effect.fingerprint,
        looks_like=list(effect.looks_like),
        check=effect.how_to_check,
    )


def _finite(bound: float) -> float | None:
    return bound if math.isfinite(bound) else None
