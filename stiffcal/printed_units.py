"""Units as people read them: the same in terminal, report and view."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    pass


_DRIFTS = {
    ("m/s or m/K", False): ("µm/h", 3.6e9),
    ("m/s or m/K", True): ("µm/K", 1e6),
    ("rad/s or rad/K", False): ("mrad/h", 3.6e6),
    ("rad/s or rad/K", True): ("mrad/K", 1e3),
}


def drift_unit(unit: str, by_temperature: bool) -> tuple[str, float] | None:
    """Return the unit in which a rate of drift is read, and the factor to it; None for what is no such rate.

    Parameters
    ----------
    unit : of the JSON document. by_temperature : whether it follows a temperature; else it follows the time.

    Examples
    --------
    >>> drift_unit("m/s or m/K", by_temperature=False), drift_unit("rad", by_temperature=True)
    (('µm/h', 3600000000.0), None)
    """
    return _DRIFTS.get((unit, by_temperature))


_PRINTED = {
    "rad": ("mrad", 1e3),
    "m": ("mm", 1e3),
    "rad/(N·m)": ("µrad/(N·m)", 1e6),
    "m/N": ("µm/N", 1e6),
    "rad/N": ("µrad/N", 1e6),
    "N/m": ("N/µm", 1e-6),
    "N/rad": ("N/mrad", 1e-3),
}


LINK_COMPLIANCE: Final = (
    (0, 0, "stretch per force along x1", "m/N"),
    (1, 1, "u2 per force along x2", "m/N"),
    (5, 5, "rotation about x3 per moment", "rad/(N*m)"),
    (2, 2, "u3 per force along x3", "m/N"),
    (4, 4, "rotation about x2 per moment", "rad/(N*m)"),
    (3, 3, "twist per moment", "rad/(N*m)"),
)
"""Elements of a link's 6×6 compliance that are printed, those of a beam alone: row, column, words, unit."""


def printed_unit(unit: str, drift_follows: str | None = None) -> tuple[str, float]:
    """Return the unit in which people read a value, and the factor to it: the same in terminal and report.

    Parameters
    ----------
    unit : of the JSON document. drift_follows : of a rate of drift what it is counted by; None of others.

    Examples
    --------
    >>> printed_unit("rad"), printed_unit("m/s or m/K", "time"), printed_unit("N*m")
    (('mrad', 1000.0), ('µm/h', 3600000000.0), ('N·m', 1.0))
    >>> printed_unit("m/N"), printed_unit("N/m")
    (('µm/N', 1000000.0), ('N/µm', 1e-06))
    """
    words = unit_words(unit)
    drift = None if drift_follows is None else drift_unit(words, drift_follows == "temperature")
    return drift or _PRINTED.get(words, ("" if words == "1" else words, 1.0))


def unit_words(unit: str) -> str:
    """Return a unit of a JSON document as it is printed.

    Examples
    --------
    >>> unit_words("rad/(N*m)"), unit_words("N*m^2")
    ('rad/(N·m)', 'N·m²')
    """
    return unit.replace("*", "·").replace("^2", "²").replace("^3", "³").replace("degC", "°C")
