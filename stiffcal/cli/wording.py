"""Numbers as people read them: mm, µm, mrad, N·m/rad, three significant digits."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from stiffcal.measurements.rms import Rms
    from stiffcal.model.summary import Where

NOT_KNOWN = "–"
_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def significant(value: float | None, digits: int = 3) -> str:
    """Return `value` with so many significant digits and no exponent where that is readable.

    Examples
    --------
    >>> [significant(x) for x in (0.0123456, 1.0, 999.6, 2.7196e6, 0.0, None)]
    ['0.0123', '1.00', '1000', '2.72·10⁶', '0', '–']
    >>> significant(5e-324), significant(1.7e308)
    ('4.94·10⁻³²⁴', '1.70·10³⁰⁸')
    """
    if value is None or not math.isfinite(value):
        return NOT_KNOWN
    if value == 0:
        return "0"
    mantissa, _, power = f"{value:.{digits - 1}e}".partition("e")  # powers of ten below 1e-308 are no numbers
    exponent = int(power)
    if -4 <= exponent < 4:
        return f"{float(f'{mantissa}e{power}'):.{max(digits - 1 - exponent, 0)}f}"
    return f"{mantissa}·10{str(exponent).translate(_SUPERSCRIPT)}"


def length(metres: float | None) -> str:
    """Return a length in mm, in µm below 0.1 mm; below a nanometre it is some computation's rounding.

    Examples
    --------
    >>> length(0.0017254), length(1.234e-5), length(2e-13)
    ('1.73 mm', '12.3 µm', 'below 1 nm')
    """
    if metres is None:
        return NOT_KNOWN
    if 0 < abs(metres) < 1e-9:
        return "below 1 nm"
    if 0 < abs(metres) < 1e-4:
        return f"{significant(metres * 1e6)} µm"
    return f"{significant(metres * 1e3)} mm"


def angle(radians: float | None) -> str:
    """Return an angle in mrad, in µrad below 0.1 mrad; below a nanoradian it is some computation's rounding.

    Examples
    --------
    >>> angle(0.00123), angle(3e-14)
    ('1.23 mrad', 'below 1 nrad')
    """
    if radians is None:
        return NOT_KNOWN
    if 0 < abs(radians) < 1e-9:
        return "below 1 nrad"
    if 0 < abs(radians) < 1e-4:
        return f"{significant(radians * 1e6)} µrad"
    return f"{significant(radians * 1e3)} mrad"


def share(fraction: float | None) -> str:
    """Return a fraction in per cent.

    Examples
    --------
    >>> share(0.2156)
    '21.6 %'
    """
    return NOT_KNOWN if fraction is None else f"{significant(100 * fraction)} %"


def deviation(rms: Rms | Mapping[str, float | None] | None) -> str:
    """Return an rms `{translation, rotation, …}` as one phrase.

    Examples
    --------
    >>> deviation({"translation": 0.0003721, "rotation": 2.5e-4})
    '0.372 mm, 0.250 mrad'
    >>> deviation({"translation": 0.0003721, "rotation": None, "length": 1.2e-6})
    '0.372 mm, 1.20 µm at the rods'
    """
    if not rms:
        return NOT_KNOWN
    measures = []
    for name, value in rms.items():
        if value is not None and name == "torque":
            measures.append(f"{significant(value)} N·m")
        elif value is not None and name == "length":
            measures.append(f"{length(value)} at the rods")
        elif value is not None:
            measures.append(angle(value) if name in {"rotation", "motor_angle"} else length(value))
    return ", ".join(measures) or NOT_KNOWN


def interval(value: float | None, low: float | None, high: float | None) -> str:
    """Return `value ± half-width`, or the ends where the interval is lopsided or open, in the value's power of ten.

    Examples
    --------
    >>> interval(2.72e6, 2.28e6, 3.16e6)
    '2.72·10⁶ ± 0.44·10⁶'
    >>> interval(2.06e5, 1.06e5, None)
    '2.06·10⁵ (1.06·10⁵ … ∞)'
    """
    if value is None:
        return NOT_KNOWN
    if low is None or high is None or abs((high - value) - (value - low)) > 0.1 * (high - low):
        ends = f"{significant(low) if low is not None else '−∞'} … {significant(high) if high is not None else '∞'}"
        return f"{significant(value)} ({ends})"
    half = (high - low) / 2
    exponent = math.floor(math.log10(abs(value))) if value else 0
    if not -300 < exponent < 300:  # powers of ten beyond are no numbers
        return f"{significant(value)} ± {significant(half, 2)}"
    if -4 <= exponent < 4:
        return f"{significant(value)} ± {significant(half, 2)}"
    power = f"·10{str(exponent).translate(_SUPERSCRIPT)}"
    return f"{value / 10.0**exponent:.2f}{power} ± {significant(half / 10.0**exponent, 2)}{power}"


def places(where: Where | Mapping[str, Sequence[Any]]) -> str:
    """Return a `where` in words.

    Examples
    --------
    >>> places({"joints": [1, 2, 3, 4, 6]})
    'joints 1–4, 6'
    >>> places({"pairs": [[5, 6]]}), places({})
    ('pairs 5-6', 'set-up')
    """
    words = []
    for kind, items in where.items():
        if kind == "joints":
            names = runs_of([int(item) for item in items])
        elif kind == "pairs":
            names = ", ".join("-".join(str(member) for member in pair) for pair in items)
        else:
            names = ", ".join(str(item) for item in items)
        words.append(f"{kind[:-1] if len(items) == 1 and kind != 'pairs' else kind} {names}")
    return ", ".join(words) or "set-up"


def runs_of(numbers: Sequence[int]) -> str:
    """Return numbers with runs of three or more drawn together.

    Examples
    --------
    >>> runs_of([1, 2, 3, 5, 6])
    '1–3, 5, 6'
    """
    ranges: list[str] = []
    rest = sorted(numbers)
    while rest:
        n = 1
        while n < len(rest) and rest[n] == rest[0] + n:
            n += 1
        ranges += [f"{rest[0]}–{rest[n - 1]}"] if n > 2 else [str(number) for number in rest[:n]]
        rest = rest[n:]
    return ", ".join(ranges)
