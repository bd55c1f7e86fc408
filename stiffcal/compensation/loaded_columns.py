"""Columns of every table that `predict` and `compensate` write: joints, wrench and deflection with its uncertainty."""

from __future__ import annotations

from collections.abc import Sequence

from stiffcal.arrays import Floats
from stiffcal.compensation.table_columns import AXES
from stiffcal.quantity import of_component


def loaded_columns(
    names: Sequence[str],
    units: Sequence[str],
    positions: Floats,
    wrench: Floats,
    deflection: Floats,
    std: Floats,
    what: str,
) -> dict[str, Floats]:
    """Return columns of n loaded poses, each with its unit in its name.

    Parameters
    ----------
    names, units : of the joints. positions : (n, J) of them, in these units.
    wrench : (n, 6) N and N·m. deflection, std : (n, 6) m and rad, written in mm and mrad.
    what : what stands behind a component's name where it is the standard uncertainty.
    """
    columns = {f"{name} [{unit}]": positions[:, k] for k, (name, unit) in enumerate(zip(names, units, strict=True))}
    columns |= {f"{axis} [{'N' if k < 3 else 'N*m'}]": wrench[:, k] for k, axis in enumerate(AXES)}
    for k, name in enumerate(("dx", "dy", "dz", "rx", "ry", "rz")):
        unit = of_component(k).usual
        columns[unit.in_brackets(name)] = unit.factor * deflection[:, k]
        columns[unit.in_brackets(f"{name} {what}")] = unit.factor * std[:, k]
    return columns
