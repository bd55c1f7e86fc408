"""Friction over velocity, joint by joint: what was read, and the fitted curve."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.kinds.friction.answers.results import FrictionSection
from stiffcal.kinds.friction.logs.readings import SteadyReadings
from stiffcal.kinds.measured import MeasuredRuns
from stiffcal.kinds.results import IdentifiedModel
from stiffcal.measurements.columns import values_of
from stiffcal.presentation.values import UnusedReadings
from stiffcal.uncertainty import NORMAL_95

FRICTION_FIT, FRICTION_HELDOUT = "friction_fit", "friction_heldout"


@dataclass(frozen=True)
class FrictionCurve:
    """Friction of one drive over its velocity."""

    joint: str
    """The joint's name."""
    steady: bool
    """True where passes at constant velocity were measured, False for samples of other motion."""
    velocity: Floats
    """(n,) rad/s, signed."""
    friction: Floats
    """(n,) N·m, as measured, weight, inertia and zeros taken off."""
    speed: Floats
    """(m,) rad/s, rising, of the fitted curve."""
    fitted: Floats
    """(m,) N·m, the fitted curve."""
    std: Floats
    """(m,) N·m, its standard uncertainty."""
    parameters: tuple[tuple[str, float, float | None, str], ...]
    """(symbol, value, half width of the 95 % interval, unit) of what is known; half width None where held."""
    remarks: tuple[str, ...]
    """What is not measured, and why."""
    rms: float
    """N·m, rms residual."""
    noise: float | None
    """N·m, of one reading; None where no repeats determine it."""
    rows: Integers | None = None
    """(n,) where the readings stand in the table of the fit."""


def friction_curves(
    data: MeasuredRuns, section: FrictionSection, identified: IdentifiedModel
) -> tuple[FrictionCurve, ...]:
    """Return the friction of every joint that the present fit holds.

    Parameters
    ----------
    data : the campaign, with the fit's rows among its tables.
    section : of ``identify``. identified : the whole answer.
    """
    if not section.joints or FRICTION_FIT not in data.tables:
        return ()
    table = data.tables[FRICTION_FIT]
    names = np.array(table.column("joint").to_pylist(), dtype=np.str_)
    velocity, friction = (values_of(table.column(name)) for name in ("velocity_radps", "friction_measured_Nm"))
    curves = []
    for joint in section.joints:
        of_joint = names == joint.name
        laws = set(section.effects or ())
        parameters = [
            parameter
            for parameter in identified.parameters
            if parameter.effect in laws and parameter.where.joints == [joint.joint]
        ]
        curves.append(
            FrictionCurve(
                joint=joint.name,
                steady=joint.n_speeds is not None,
                velocity=velocity[of_joint],
                friction=friction[of_joint],
                speed=joint.curve.velocity,
                fitted=joint.curve.torque,
                std=joint.curve.std,
                parameters=tuple(
                    (
                        parameter.name.rsplit(".", 1)[-1],
                        parameter.value,
                        None if parameter.std is None else NORMAL_95 * parameter.std,
                        parameter.unit,
                    )
                    for parameter in parameters
                    if parameter.value is not None
                ),
                remarks=tuple(f"{parameter.name}: {parameter.remark}" for parameter in parameters if parameter.remark),
                rms=joint.rms,
                noise=joint.noise,
                rows=np.flatnonzero(of_joint),
            )
        )
    return tuple(curves)


def unused_passes(steady: SteadyReadings | None) -> tuple[UnusedReadings, ...]:
    """Return the passes of friction runs that were not used, by run and cause."""
    if steady is None:
        return ()
    rows: dict[tuple[str, str], list[int]] = defaultdict(list)
    text_of: dict[str, str] = {}
    count: dict[str, int] = defaultdict(int)
    for k, code in enumerate(steady.set_aside_code.tolist()):
        name = steady.runs[int(steady.run[k])].name
        count[name] += 1
        if code:
            rows[name, code].append(count[name])
            text_of[code] = str(steady.set_aside[k])
    return tuple(
        UnusedReadings(name, tuple(numbers), f"the pass {text_of[code]}") for (name, code), numbers in rows.items()
    )
