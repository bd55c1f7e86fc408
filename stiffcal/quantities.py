"""Units of the laboratory: a closed table that refuses what it does not know.

Why a closed table: general unit parsers accept too much ("5 Nm" has been read as nanometres). Everything inside
stiffcal is SI; a value in the lab's unit becomes SI by ``value * factor + offset``.
"""

from __future__ import annotations

from dataclasses import dataclass
from difflib import get_close_matches
from math import pi

# CODATA/ISO 80000: exact definitions of the pound, the inch and standard gravity.
_POUND_KG = 0.45359237
_INCH_M = 0.0254
_STANDARD_GRAVITY = 9.80665
_POUND_FORCE_N = _POUND_KG * _STANDARD_GRAVITY

_LENGTH = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "nm": 1e-9, "in": _INCH_M}
# Of a rod's length; what a rod reads follows with it.
_STRAIN = {"m/m": 1.0, "mm/m": 1e-3, "um/m": 1e-6, "nm/m": 1e-9}
_ANGLE = {
    "rad": 1.0,
    "mrad": 1e-3,
    "urad": 1e-6,
    "deg": pi / 180.0,
    "gon": pi / 200.0,
    "arcmin": pi / 10_800.0,
    "arcsec": pi / 648_000.0,
    "rev": 2.0 * pi,
}
_FORCE = {"N": 1.0, "mN": 1e-3, "uN": 1e-6, "daN": 10.0, "kN": 1e3, "kgf": _STANDARD_GRAVITY, "lbf": _POUND_FORCE_N}
_MOMENT = {
    "N*m": 1.0,
    "mN*m": 1e-3,
    "uN*m": 1e-6,
    "N*mm": 1e-3,
    "N*cm": 1e-2,
    "kN*m": 1e3,
    "lbf*in": _POUND_FORCE_N * _INCH_M,
    "lbf*ft": _POUND_FORCE_N * 12.0 * _INCH_M,
}
_TIME = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0, "day": 86400.0}
_TEMPERATURE = {"K": 1.0, "degC": 1.0, "degF": 5.0 / 9.0}
_MASS = {"kg": 1.0, "g": 1e-3, "t": 1e3, "lb": _POUND_KG}
_VELOCITY = {"rad/s": 1.0, "deg/s": pi / 180.0, "mrad/s": 1e-3, "rev/s": 2.0 * pi, "rpm": pi / 30.0}
_CURRENT = {"A": 1.0, "mA": 1e-3}

_OFFSETS = {"degC": 273.15, "degF": 459.67 * 5.0 / 9.0}

_TABLES: dict[str, dict[str, float]] = {
    "length": _LENGTH,
    "position": _LENGTH,
    "translation": _LENGTH,
    "strain": _STRAIN,
    "angle": _ANGLE,
    "rotation": _ANGLE,
    "force": _FORCE,
    "moment": _MOMENT,
    "torque": _MOMENT,
    "time": _TIME,
    "temperature": _TEMPERATURE,
    "mass": _MASS,
    "velocity": _VELOCITY,
    "current": _CURRENT,
}

# Other spellings of the same unit, per table, so that "C" is a temperature and nothing else.
_ALIASES: dict[int, dict[str, str]] = {
    id(_LENGTH): {"inch": "in", "micron": "um"},
    id(_STRAIN): dict.fromkeys(("microstrain", "ustrain", "uε", "uϵ", "ue"), "um/m"),
    id(_ANGLE): {"°": "deg", "º": "deg", "Grad": "deg", "turn": "rev", "turns": "rev"},
    id(_TEMPERATURE): {"°C": "degC", "C": "degC", "°F": "degF", "kelvin": "K"},
    id(_TIME): {"sec": "s", "h": "h"},
    id(_VELOCITY): {"°/s": "deg/s", "1/min": "rpm", "rev/min": "rpm"},
    id(_MOMENT): {
        "Nm": "N*m",
        "Nmm": "N*mm",
        "Ncm": "N*cm",
        "mNm": "mN*m",
        "kNm": "kN*m",
        "lbf*inch": "lbf*in",
        "in*lbf": "lbf*in",
        "ft*lbf": "lbf*ft",
    },
}


# Units written out, in whatever case, as programs of motion capture and LabVIEW write them.
_WORDS: dict[str, str] = {
    **dict.fromkeys(("meter", "meters", "metre", "metres"), "m"),
    **dict.fromkeys(("millimeter", "millimeters", "millimetre", "millimetres", "毫米", "ミリ"), "mm"),
    **dict.fromkeys(("centimeter", "centimeters", "centimetre", "centimetres"), "cm"),
    **dict.fromkeys(("micrometer", "micrometers", "micrometre", "micrometres", "microns"), "um"),
    **dict.fromkeys(("inch", "inches", "zoll", "pollici", "pulgadas", "pouces"), "in"),
    "мм": "mm",
    "мкм": "um",
    "см": "cm",
    **dict.fromkeys(("radian", "radians", "рад"), "rad"),
    **dict.fromkeys(("newton", "newtons", "牛", "牛顿", "н"), "N"),
    "кн": "kN",
    "н*м": "N*m",
    "с": "s",
    "мс": "ms",
    "град": "deg",
    **dict.fromkeys(("newtonmeter", "newton-meter", "newton-meters", "newtonmeters"), "N*m"),
    **dict.fromkeys(("second", "seconds", "sekunde", "sekunden", "seconde", "secondes", "segundo", "segundos"), "s"),
    **dict.fromkeys(("secondo", "secondi", "秒"), "s"),
    **dict.fromkeys(("millisecond", "milliseconds", "millisekunden", "millisecondes", "毫秒", "ミリ秒"), "ms"),
    **dict.fromkeys(("minute", "minutes", "minuten"), "min"),
    **dict.fromkeys(("days", "tag", "tage", "jour", "jours", "dia", "dias", "giorno", "giorni", "日", "天"), "day"),
    **dict.fromkeys(("celsius", "°celsius"), "degC"),
    **dict.fromkeys(("degree", "degrees", "degré", "degrés", "grado", "grados", "gradi", "graus", "度"), "deg"),
}


class UnknownUnitError(ValueError):
    """A unit or quantity that the table does not hold.

    Attributes
    ----------
    reason : what is wrong, with the name that was found.
    mend : the units that are known.
    """

    def __init__(self, reason: str, mend: str) -> None:
        super().__init__(f"{reason}; {mend}")
        self.reason = reason
        self.mend = mend


@dataclass(frozen=True)
class Unit:
    """A unit of one quantity: SI value = value * factor + offset."""

    name: str
    """The unit's canonical name."""
    quantity: str
    """The quantity asked for."""
    factor: float
    """From the unit to SI (m, rad, N, N·m, s, K, kg, rad/s, A)."""
    offset: float = 0.0
    """Added after ``factor``, SI."""

    def to_si(self, value: float) -> float:
        """Turn a number in this unit into SI.

        Examples
        --------
        >>> unit("degC", "temperature").to_si(20.0)
        293.15
        """
        return value * self.factor + self.offset


def quantities() -> tuple[str, ...]:
    """Return the names of all quantities.

    Examples
    --------
    >>> "force" in quantities()
    True
    """
    return tuple(_TABLES)


def unit_names(quantity: str) -> tuple[str, ...]:
    """Return the canonical unit names of a quantity, its SI unit first.

    Examples
    --------
    >>> unit_names("time")
    ('s', 'ms', 'us', 'ns', 'min', 'h', 'day')
    """
    return tuple(_table(quantity))


def unit(name: str, quantity: str) -> Unit:
    """Look up a unit by name.

    Parameters
    ----------
    name : as the lab writes it: ``N*m``, ``Nm``, ``N m``, ``N-m`` and ``N·m`` are one unit; ``µm`` is ``um``.
        Case counts.
    quantity : one of `quantities()`.

    Raises
    ------
    UnknownUnitError
        The table does not hold that unit for that quantity; nothing is guessed.

    Examples
    --------
    >>> unit("mm", "length").factor
    0.001
    >>> unit("N m", "moment").name
    'N*m'
    """
    table = _table(quantity)
    canonical = _canonical(name, table)
    if canonical in table:
        offset = _OFFSETS.get(canonical, 0.0) if table is _TEMPERATURE else 0.0
        return Unit(canonical, quantity, table[canonical], offset)
    raise UnknownUnitError(f'"{name}" is not a known unit of {quantity}', _advice(name, quantity))


def is_known(name: str, quantity: str) -> bool:
    """Return whether `unit` would find a unit; of ten thousand headers each cell is asked for.

    Examples
    --------
    >>> is_known("mm", "length"), is_known("mm", "force")
    (True, False)
    """
    table = _table(quantity)
    return _canonical(name, table) in table


def si_unit(name: str) -> str:
    """Return the SI unit of what a unit measures; "" of a name that is no unit of any quantity.

    Examples
    --------
    >>> si_unit("deg"), si_unit("kNm"), si_unit("degF"), si_unit("m/A")
    ('rad', 'N*m', 'K', '')
    """
    return next((next(iter(table)) for table in _TABLES.values() if _canonical(name, table) in table), "")


def factor_between(name: str, other: str) -> float | None:
    """Return the factor from one unit to another of the same quantity; None where they have none in common.

    Scales of temperature have zeros of their own: no factor leads from one to another.

    Examples
    --------
    >>> factor_between("m", "mm"), factor_between("s", "min"), factor_between("m", "N"), factor_between("K", "degC")
    (1000.0, 0.016666666666666666, None, None)
    """
    for table in _TABLES.values():
        first, second = _canonical(name, table), _canonical(other, table)
        if first in table and second in table and _OFFSETS.get(first) == _OFFSETS.get(second):
            return table[first] / table[second]
    return None


def _table(quantity: str) -> dict[str, float]:
    if quantity not in _TABLES:
        raise UnknownUnitError(f'"{quantity}" is not a known quantity', "use one of " + ", ".join(_TABLES))
    return _TABLES[quantity]


def _canonical(name: str, table: dict[str, float]) -> str:
    """Spell a unit the table's way: one sign for micro, one for multiplication."""
    text = name.strip().replace("µ", "u").replace("μ", "u")  # micro sign and Greek mu
    for product in ("·", "⋅", "×", " * ", "* ", " *", ".", " "):
        text = text.replace(product, "*")
    text = _ALIASES.get(id(table), {}).get(text, text)
    word = _WORDS.get(text.lower())
    if word in table:
        return str(word)
    factors = text.replace("-", "*").split("*")  # makers of force sensors write N-m, those of force plates mm.N
    products = ("*".join(own) for own in (factors, factors[::-1]) if len(own) > 1)
    return next((product for product in products if product in table), text)


def _advice(name: str, quantity: str) -> str:
    known = unit_names(quantity)
    if _TABLES[quantity] is _LENGTH and _canonical(name, _STRAIN) in _STRAIN:
        return "that is a strain, which rods under [ids] alone can read; use one of " + ", ".join(known)
    suggestions = get_close_matches(name.lower(), [text.lower() for text in known], n=1)
    for other_quantity, table in _TABLES.items():
        if table is not _TABLES[quantity] and _canonical(name, table) in table:
            return f"that is a unit of {other_quantity}; use one of " + ", ".join(known)
    if suggestions:
        guess = next(text for text in known if text.lower() == suggestions[0])
        return f'did you mean "{guess}"? Known are ' + ", ".join(known)
    return "use one of " + ", ".join(known)
