"""Recordings as tables: one row per reading, a unit in every column's name."""

from __future__ import annotations

from stiffcal.arrays import Floats
from stiffcal.campaign.manifest.source import Source
from stiffcal.reduction.logs.log_rows import LogRows

_SI = {
    "joints": "rad",
    "joints.command": "rad",
    "joints.velocity": "radps",
    "joints.torque": "Nm",
    "joints.current": "A",
    "joints.approach": "sign",
    "mass": "kg",
    "translation": "m",
    "rotation": "rad",
    "temperature": "K",
    "hold": "s",
}
_SIGMA = {"position": ("", "m"), "rotation": ("r", "rad")}


def recording_name(run: str, source: str) -> str:
    """Return the store's name for the table of a run's recording by a source.

    Examples
    --------
    >>> recording_name("pose 1", "ft"), recording_name("cold/1", "ft")
    ('recordings/pose 1/ft', 'recordings/cold%2F1/ft')
    """
    return "/".join(("recordings", *(name.replace("%", "%25").replace("/", "%2F") for name in (run, source))))


def recording_columns(source: Source, rows: LogRows) -> list[str]:
    """Return a recording's column names: time_s, then component and SI unit, as in ``Fx_N`` or ``target_x_m``."""
    names = ["time_s"]
    for signal, values in rows.signals.items():
        names += _column_names(source, signal, values.shape[0])
    return names


def recording_table(source: Source, rows: LogRows) -> dict[str, Floats]:
    """Return a recording's columns of one batch."""
    columns = {"time_s": rows.time}
    for signal, values in rows.signals.items():
        columns |= dict(zip(_column_names(source, signal, values.shape[0]), values, strict=True))
    return columns


def _column_names(source: Source, signal: str, width: int) -> list[str]:
    kind, _, component = signal.partition(".")
    if signal == "wrench":
        return ["Fx_N", "Fy_N", "Fz_N", "Mx_Nm", "My_Nm", "Mz_Nm"]
    if kind == "sigma":  # of a pose, by quantity and body; one for all axes, or one for each
        quantity, _, body = component.partition(".")
        prefix, unit = _SIGMA[quantity]
        components = [f"_{prefix}{axis}" for axis in "xyz"] if width > 1 else [f"_{prefix}" if prefix else ""]
        return [f"{body}{of_axis}_sigma_{unit}" for of_axis in components]
    if kind in ("position", "marker"):
        return [f"{component}_{axis}_m" for axis in "xyz"]
    if kind == "quaternion":
        return [f"{component}_q{axis}" for axis in "wxyz"]
    if kind in ("lengths", "displacement"):
        return [f"{component}_{'length' if kind == 'lengths' else kind}_m"]
    unit = _SI.get(signal, "")
    names = [f"{signal.replace('.', '_')}{k + 1}_{unit}" for k in range(width)]
    if kind == "joints" and source.joints is not None:
        columns = source.joints.groups().get(component or "position", ())
        if len(columns) == width:
            units = [unit] * width
            if component in (None, "", "position", "command"):
                of_columns = source.joints.position_units(width)
                units = ["m" if own.quantity == "length" else unit for own in of_columns]
            names = [f"{column}_{own}" for column, own in zip(columns, units, strict=True)]
    return names
