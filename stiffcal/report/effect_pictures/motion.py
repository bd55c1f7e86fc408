"""What an effect does to the torque of a moving drive, computed by its own law on a joint that turns to and fro."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.mechanics.chain import Chain
from stiffcal.model.catalogue.catalogue import built_in_effects
from stiffcal.model.drive_motion import DriveMotion
from stiffcal.model.effect import Covariate, Effect, Place
from stiffcal.model.motion import Motion, as_motion
from stiffcal.report.content import EffectPicture

# The effect is drawn as large as this share of the largest torque without it.
DRAWN_SIZE = 0.4
SPEED = 0.3
"""rad/s where the speed stays the same."""
WEIGHT = 200.0
"""N·m, the largest torque of the weight."""
WARMING = 20.0
"""K."""
REVERSAL = 0.01
"""rad to either side of a reversal."""


@dataclass(frozen=True)
class _Stroke:
    """A motion in which one quantity runs through its range."""

    motion: DriveMotion
    back: Booleans
    """(n,) True where the joint turns back."""


def torque_picture(effect: Effect, chain: Chain) -> EffectPicture | None:
    """Return the torque of a drive over what the effect follows, without and with it; None where it adds none."""
    places = effect.places(chain)
    if not isinstance(effect, Motion) or not places:
        return None
    place = places[0]
    strokes = _strokes()
    covariates = [effect.motion_covariate(place, chain, stroke.motion) for stroke in strokes]
    # The motion in which what the effect follows runs through its whole range.
    widest = int(np.argmax([np.ptp(covariate.value) for covariate in covariates]))
    added = _torque(effect, place, chain, strokes[widest].motion)
    return _picture(effect, place, chain, strokes[widest], covariates[widest], added) if added.any() else None


def _picture(
    effect: Effect, place: Place, chain: Chain, stroke: _Stroke, covariate: Covariate, added: Floats
) -> EffectPicture:
    base = built_in_effects()["joint-friction"]
    without = np.zeros(len(added))
    if effect.name != base.name:
        without = _torque(base, place, chain, stroke.motion)
        added = added * max(1.0, DRAWN_SIZE * float(np.abs(without).max()) / float(np.abs(added).max()))
    degrees = covariate.unit == "rad"
    text = (effect.fingerprint or effect.summary).rstrip(".")
    return EffectPicture(
        effect.name, f"{covariate.label} [{'°' if degrees else covariate.unit}]", "torque of the drive [N·m]",
        np.degrees(covariate.value) if degrees else covariate.value, without, without + added, stroke.back,
        f"Effect of {effect.name} on the torque of a moving drive, exaggerated: {text}.", back="reverse motion",
    )  # fmt: skip


def _torque(effect: Effect, place: Place, chain: Chain, motion: DriveMotion) -> Floats:
    """Return (n,) N·m of an effect at its usual size."""
    usual = {spec.symbol: spec.typical for spec in effect.parameters}
    columns = as_motion(effect).motion_columns(place, chain, motion, usual)
    return np.asarray(sum((usual[symbol] * column for symbol, column in columns.items()), np.zeros(len(motion))))


def _strokes() -> list[_Stroke]:
    """Return motions in which speed, angle and weight, temperature, or the travel after a reversal change."""
    n = 101
    ramp = np.linspace(0.0, 1.0, n)
    zero = np.zeros(n)
    far, first = np.full(n, 1.0), np.zeros(n, dtype=np.bool_)
    speeds = np.linspace(-1.0, 1.0, 2 * n)
    both = np.concatenate([zero, zero])
    sweep = DriveMotion(speeds, both, both, both, both, np.concatenate([far, far]))
    strokes = [_Stroke(sweep, np.zeros(2 * n, dtype=np.bool_))]
    there, backwards = np.concatenate([ramp, ramp[::-1]]), np.concatenate([first, ~first])
    velocity = np.where(backwards, -SPEED, SPEED)
    angle = np.pi * (there - 0.5)
    turn = DriveMotion(velocity, angle, WEIGHT * np.sin(angle), both, both, 1.0 + both)
    strokes.append(_Stroke(turn, backwards))
    warming = DriveMotion(velocity, both, both, WARMING * there, 3600.0 * there, 1.0 + both)
    strokes.append(_Stroke(warming, backwards))
    reversal = DriveMotion(0.1 * velocity, REVERSAL * there, both, both, both, REVERSAL * there)
    strokes.append(_Stroke(reversal, backwards))
    return strokes
