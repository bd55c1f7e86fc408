"""The evidence for effects of moving joints: what is left without an effect and with it, against what drives it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.kinds.drawn_rows import DrawnVariable
from stiffcal.kinds.friction.fitting.joint_fits import fit_friction
from stiffcal.kinds.friction.fitting.torque_rows import FrictionRows, together
from stiffcal.mechanics.chain import Chain
from stiffcal.model.assembled.composite import PlacedEffect
from stiffcal.model.effect import Effect, Place
from stiffcal.model.motion import as_motion
from stiffcal.presentation.values import Digits, Marks, Panel, Picture, Words

HEIGHT_MM = 48.0
# Pictures of a page: those of missing effects come first.
MOST_PICTURES = 8


def evidence_pictures(
    rows: FrictionRows,
    chain: Chain,
    placed: tuple[PlacedEffect, ...],
    missing: Sequence[PlacedEffect],
    basic: Sequence[str],
) -> list[Picture]:
    """Return a picture for each missing effect, and for each in the model that comes on top of the basic ones.

    Parameters
    ----------
    rows : that the model is fitted to. chain : the robot. placed : the model's effects of moving joints.
    missing : effects that a diagnosis names. basic : names of effects that every model begins with.
    """
    on_top = [effect for effect in placed if effect.effect.name not in basic]
    shown = [*((effect, "missing") for effect in missing), *((effect, "in the model") for effect in on_top)]
    pictures = []
    for effect, status in shown[:MOST_PICTURES]:
        joint = effect.place.joints[0]
        group = next((group for group in together(rows) if (rows.joint[group] == joint).any()), None)
        if group is None:
            continue
        own = rows.select(group)
        others = tuple(other for other in (*placed, *missing) if other.parameter_name("") != effect.parameter_name(""))
        pictures.append(_evidence_picture(own, chain, others, effect, status))
    return pictures


def _evidence_picture(
    rows: FrictionRows, chain: Chain, others: tuple[PlacedEffect, ...], effect: PlacedEffect, status: str
) -> Picture:
    joint = effect.place.joints[0]
    left = [_left_of(rows, chain, model, joint) for model in (others, (*others, effect))]
    driver = driver_of(rows, chain, effect.effect, effect.place)
    of_joint = rows.joint == joint
    reach = 1.1 * max(float(np.abs(values).max(initial=0.0)) for values in left) or 1.0
    panels = tuple(
        _panel(
            title, f"{driver.label} [{driver.unit}]", driver.values[of_joint], values, rows.velocity[of_joint], reach
        )
        for title, values in zip((f"without {effect.effect.name}", f"with {effect.effect.name}"), left, strict=True)
    )
    before, after = (float(np.sqrt(np.mean(values**2))) for values in left)
    caption: Words = (
        (f"Evidence for {effect.effect.name} of joint {joint} ({status}): residual of a fit with all other effects "
        "of the model and all missing ones, without it and with it, over its driving variable: "),
        Digits(before), " and ", Digits(after), " N·m rms.",
    )  # fmt: skip
    return Picture(panels, columns=2, height=HEIGHT_MM, caption=caption)


def driver_of(rows: FrictionRows, chain: Chain, effect: Effect, place: Place) -> DrawnVariable:
    """Return what an effect at a joint follows, the mean of each row's samples; NaN in the rows of other joints."""
    joint = place.joints[0]
    samples = rows.joint[rows.row] == joint
    covariate = as_motion(effect).motion_covariate(place, chain, rows.motion_of(joint))
    count = np.bincount(rows.row[samples], minlength=len(rows))
    mean = np.bincount(rows.row[samples], weights=covariate.value, minlength=len(rows)) / np.maximum(count, 1)
    mean[rows.joint != joint] = np.nan
    # angles are read in degrees in all figures
    values, unit = (np.degrees(mean), "°") if covariate.unit == "rad" else (mean, covariate.unit)
    return DrawnVariable("driver", covariate.label, unit, values)


def _left_of(rows: FrictionRows, chain: Chain, model: tuple[PlacedEffect, ...], joint: int) -> Floats:
    """Return (k,) N·m that a fit leaves of a joint's rows; the torque as read where no effect acts in it."""
    if not any(effect.place.joints[0] == joint for effect in model):
        return np.asarray(rows.torque[rows.joint == joint])
    fit = fit_friction(rows, model, chain)
    return np.asarray(fit.residual[fit.rows.joint == joint])


def _panel(title: str, label: str, x: Floats, y: Floats, velocity: Floats, reach: float) -> Panel:
    series = []
    for direction, marker, colour, name in ((1.0, "^", 0, "forward"), (-1.0, "v", 1, "backward")):
        chosen = np.sign(velocity) == direction
        series.append(Marks(x[chosen], y[chosen], marker, colour, size=2.4, edge=0.5, label=name))
    return Panel(
        title, label, "residual [N·m]", tuple(series), y_limits=(-reach, reach), x_ticks=5, has_zero_lines=True
    )
