"""Numbers, places and lists as people read them, for every medium; what is not known is a dash, never a zero.

Values come in SI units. Tables and values of terminal, report, notebook and page write a number in one way; `S.digits`
of view/words.js is `significant` once more, for what a page computes by itself (a test compares them).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Protocol

from stiffcal.quantity import ANGLE, LENGTH, USUAL, Measures, ShownUnit, Units, of_joint, of_measure


class PlacesOfEffect(Protocol):
    """The places of an effect, as answers hold them."""

    @property
    def joints(self) -> list[int] | None:
        """Numbers from 1."""

    @property
    def links(self) -> list[str] | None:
        """Names."""

    @property
    def pairs(self) -> list[list[int]] | None:
        """Of joints."""

    def items(self) -> Iterable[tuple[str, Any]]:
        """Return what is known, by name."""


DASH = "–"
AT_LIMIT = "at its limit"
"""Of a value that is at the limit of its range."""
MOST_WRITTEN_OUT = 15
"""Digits behind the point that are written; a double holds no more."""
_LOPSIDED = 0.1
"""Share of an interval's width by which its halves may differ and still be printed as one ±."""
_NARROW_SPACE = "\u202f"
_PREFIXES = {"m": 1e3, "µ": 1e6}
"""Of units that are a part of the SI unit: of these its billionth has a name."""
_ROUNDING = 1e-9
"""Relative change below which two fits of the same readings may differ."""
_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def significant(value: float | None, digits: int = 3) -> str:
    """Return a number with so many significant digits, a power of ten outside 10⁻⁴ … 10⁴, a true minus sign.

    Examples
    --------
    >>> [significant(x) for x in (0.0123456, 1.0, -999.6, 2.7196e6, 0.0, None)]
    ['0.0123', '1.00', '−1000', '2.72·10⁶', '0', '–']
    >>> significant(5e-324), significant(-1.7e308)
    ('4.94·10⁻³²⁴', '−1.70·10³⁰⁸')
    """
    if value is None or not math.isfinite(value):
        return DASH
    if value == 0:
        return "0"
    mantissa, exponent, rounded = _rounded(value, digits)
    if -4 <= exponent < 4:
        return f"{rounded:.{max(digits - 1 - exponent, 0)}f}".replace("-", "−")
    return f"{mantissa}·10{superscript(exponent)}".replace("-", "−")


def plus_minus(value: float, half_width: float) -> str:
    """Return a value with its half-width, both to the last digit that the half-width determines (two of its own).

    Examples
    --------
    >>> plus_minus(2.7000e6, 6.03e3), plus_minus(2.72e6, 4.4e5), plus_minus(-12.3456, 0.0995)
    ('(2.7000 ± 0.0060)·10⁶', '(2.72 ± 0.44)·10⁶', '−12.35 ± 0.10')
    >>> plus_minus(0.0012, 0.034), plus_minus(5.0, 0.0), plus_minus(3.0e5, 7.0e6)
    ('0.001 ± 0.034', '5.00 ± 0', '(0.3 ± 7.0)·10⁶')
    """
    if not half_width > 0.0 or not math.isfinite(half_width) or not math.isfinite(value):
        return f"{significant(value)} ± {significant(half_width)}".replace("-", "−")
    # rounded first: 0.0995 has its second digit where 0.10 has it
    _, last, half = _rounded(half_width, 2)
    leading = max(_rounded(value, 3)[1] if value else last, last)
    exponent = 0 if -4 <= leading < 4 else leading
    # powers of ten below 1e-308 are no numbers
    if not -300 < exponent < 300:
        return f"{significant(value)} ± {significant(half_width, 2)}".replace("-", "−")
    places = max(exponent - last + 1, 0)
    scale = 10.0**exponent
    text = f"{value / scale:.{places}f} ± {half / scale:.{places}f}".replace("-", "−")
    return f"({text})·10{superscript(exponent)}" if exponent else text


def estimate(value: float | None, interval: Sequence[float | None] | None, factor: float = 1.0) -> str:
    """Return an estimate with its 95 % interval: ± where it is nearly symmetric, else its ends.

    Parameters
    ----------
    value : the estimate; None where none was found. interval : its ends, None where one is open; None: not known.
    factor : of all three, to the unit that is printed.

    Examples
    --------
    >>> estimate(2.7e6, [2.694e6, 2.706e6]), estimate(2.72e6, [2.06e6, 4.01e6]), estimate(2.0, [1.0, None])
    ('(2.7000 ± 0.0060)·10⁶', '2.72 (2.06 … 4.01)·10⁶', '2.00 (above 1.00)')
    >>> estimate(2.7e6, [2.6999e6, 2.7003e6]), estimate(6.9e6, [3.7e6, 5.7e7]), estimate(0.0, [0.0, 0.25])
    ('2.70000 (2.69990 … 2.70030)·10⁶', '6.9 (3.7 … 57.0)·10⁶', '0.00 (0.00 … 0.25)')
    >>> estimate(2.06e5, [None, 3.1e5]), estimate(-0.02, [-0.03, 0.1]), estimate(0.0123, None, 1e3)
    ('2.06 (below 3.10)·10⁵', '−0.020 (−0.030 … 0.100)', '12.3')
    >>> estimate(None, [4.9e4, None]), estimate(None, None), estimate(0.1, [0.09, None], 1e3)
    ('above 4.90·10⁴', '–', '100 (above 90.0)')
    >>> estimate(0.0, [None, 3.1e-4]), estimate(1e-9, [None, 3.1e5])
    ('0 (below 0.000310)', '1.00·10⁻⁹ (below 3.10·10⁵)')
    """
    low, high = (None if end is None else end * factor for end in interval or (None, None))
    if value is None:
        return DASH if low is None else f"above {significant(low)}"
    return _with_interval(value * factor, low, high)


def _with_interval(value: float, low: float | None, high: float | None) -> str:
    """Return a value with an interval whose ends are None where they are open, all in the unit that is printed."""
    if low is None and high is None:
        return significant(value)
    below, above = (math.inf if low is None else value - low), (math.inf if high is None else high - value)
    if math.isfinite(below + above) and abs(above - below) <= _LOPSIDED * abs(above + below):
        return plus_minus(value, (below + above) / 2.0)
    is_open = not math.isfinite(below + above)
    sides = [side for side in (below, above) if 0.0 < side < math.inf] or [abs(value)]
    leading = _rounded(value or max(sides), 3)[1]
    exponent = 0 if -4 <= leading < 4 else leading
    # two digits of the distance to the nearer end; three of the value where one end is open
    last = leading - 2 if is_open else _rounded(min(sides), 2)[1] - 1
    numbers = [value, *(end for end in (low, high) if end is not None)]
    # with an end open the numbers may be decades apart: then no digits are common to them
    is_apart = is_open and any(not number or _rounded(number, 3)[1] != leading for number in numbers)
    # powers of ten below 1e-308 are no numbers
    if is_apart or not -300 < exponent < 300 or not all(map(math.isfinite, numbers)):
        texts, power = [significant(number) for number in numbers], ""
    else:
        places = min(max(exponent - last, 0), MOST_WRITTEN_OUT)
        texts = [f"{round(number / 10.0**exponent, places) + 0.0:.{places}f}" for number in numbers]
        power = f"·10{superscript(exponent)}" if exponent else ""
    open_end = "above " if high is None else "below " if low is None else ""
    return f"{texts[0]} ({open_end}{' … '.join(texts[1:])}){power}".replace("-", "−")


def _rounded(value: float, digits: int) -> tuple[str, int, float]:
    """Return mantissa, power of ten and value, rounded: 9.996 is of the next decade.

    By its text: powers of ten below 1e-308 are no numbers.
    """
    text = f"{value:.{digits - 1}e}"
    mantissa, _, power = text.partition("e")
    return mantissa, int(power), float(text)


def superscript(power: int) -> str:
    """Return an exponent.

    Examples
    --------
    >>> superscript(-12)
    '⁻¹²'
    """
    return str(power).translate(_SUPERSCRIPT)


def in_unit(value: float | None, unit: ShownUnit, digits: int = 3) -> str:
    """Return a number with its unit; what is some computation's rounding as below a billionth of the SI unit.

    Examples
    --------
    >>> in_unit(3.08e-5, LENGTH.usual), in_unit(2e-13, ANGLE.usual), in_unit(None, LENGTH.usual)
    ('0.0308 mm', 'below 1 nrad', '–')
    >>> from stiffcal.quantity import quantity_of
    >>> in_unit(2e-6 / 3600.0, quantity_of("m/s or m/K", "time").usual)  # 1 nm/s is no nanometre an hour
    '2.00 µm/h'
    """
    if value is None or not math.isfinite(value):
        return DASH
    if unit.factor == _PREFIXES.get(unit.name[:1]) and 0.0 < abs(value) < 1e-9:
        return f"below 1 n{unit.name[1:]}"
    return significant(value * unit.factor, digits) + unit.mark


def length(metres: float | None, units: Units = USUAL, digits: int = 3) -> str:
    """Return a length, in the unit of the answer that it stands in.

    Examples
    --------
    >>> length(0.0017254), length(1.234e-5), length(None), length(2e-6, Units([("m", [2e-6])]))
    ('1.73 mm', '0.0123 mm', '–', '2.00 µm')
    """
    return in_unit(metres, units.of(LENGTH), digits)


def angle(radians: float | None, units: Units = USUAL, digits: int = 3) -> str:
    """Return a small angle, in the unit of the answer that it stands in.

    Examples
    --------
    >>> angle(0.00123), angle(7.79e-5)
    ('1.23 mrad', '0.0779 mrad')
    """
    return in_unit(radians, units.of(ANGLE), digits)


def position(value: float, is_prismatic: bool = False) -> str:
    """Return where a joint stands, to a tenth of the unit.

    Examples
    --------
    >>> position(-0.5), position(0.25, is_prismatic=True)
    ('−28.6°', '250.0 mm')
    """
    unit = of_joint(is_prismatic).usual
    return f"{fixed_places(value * unit.factor, 1)}{unit.mark}"


def fixed_places(value: float, places: int) -> str:
    """Return a number with so many places behind the point, with a minus as printed.

    Examples
    --------
    >>> fixed_places(-3.14, 1), fixed_places(-0.01, 1)
    ('−3.1', '0.0')
    """
    return f"{round(value, places) + 0.0:.{places}f}".replace("-", "−")


def share(fraction: float | None, digits: int = 3) -> str:
    """Return a fraction in per cent, to so many significant digits.

    Examples
    --------
    >>> share(0.2156), share(None)
    ('21.6 %', '–')
    """
    return DASH if fraction is None or not math.isfinite(fraction) else f"{significant(100 * fraction, digits)} %"


def percent(fraction: float) -> str:
    """Return a fraction in whole per cent, as sentences have it.

    Examples
    --------
    >>> percent(0.2156), percent(0.0)
    ('22 %', '0 %')
    """
    return f"{100.0 * fraction:.0f} %"


def explained_in_words(fraction: float | None) -> str:
    """Return the share of the avoidable error that an effect explains, in whole percent as sentences have it.

    Examples
    --------
    >>> explained_in_words(0.9713), explained_in_words(1.04), explained_in_words(-0.2), explained_in_words(None)
    ('97 %', '100 %', '0 %', '–')
    """
    return DASH if fraction is None else percent(min(max(fraction, 0.0), 1.0))


def probability_in_words(p: float) -> str:
    """Return a probability in per cent: a digit more close to certainty, and no certainty.

    Examples
    --------
    >>> [probability_in_words(p) for p in (0.0001, 0.314, 0.972, 0.99993)]
    ['under 1 %', '31 %', '97.2 %', 'over 99.9 %']
    """
    if p < 0.01:
        return "under 1 %"
    if p >= 0.999:
        return "over 99.9 %"
    return f"{100.0 * p:.1f} %" if p >= 0.95 else percent(p)


def place_label(where: PlacesOfEffect) -> str:
    """Return a place as parameter names have it, several of them with commas.

    Examples
    --------
    >>> from stiffcal.model.summary import Where
    >>> place_label(Where(joints=[2, 4])), place_label(Where(pairs=[[5, 6]])), place_label(Where())
    ('j2, j4', 'j5-j6', 'setup')
    """
    labels = [f"j{joint}" for joint in where.joints or []]
    labels += where.links or []
    labels += ["-".join(f"j{joint}" for joint in pair) for pair in where.pairs or []]
    return ", ".join(labels) or "setup"


def measures(rms: Measures | None, of_motors: str = "", units: Units = USUAL) -> list[str]:
    """Return the known measures of an error ``{translation, rotation, …}``, each with its unit.

    Parameters
    ----------
    rms : the error. of_motors : added to the angle of motors where other measures are known too.
    units : of the answer that it stands in.

    Examples
    --------
    >>> measures({"translation": 0.0003721, "rotation": None, "length": 1.2e-6})
    ['0.372 mm', '0.00120 mm at the rods']
    """
    texts = []
    known = [(name, value) for name, value in (rms.items() if rms else ()) if value is not None]
    remarks = {"length": " at the rods", "motor_angle": of_motors if len(known) > 1 else ""}
    for name, value in known:
        texts.append(in_unit(value, units.of(of_measure(name))) + remarks.get(name, ""))
    return texts


def deviation(rms: Measures | None, units: Units = USUAL) -> str:
    """Return an error ``{translation, rotation, …}`` as one phrase; a dash for none.

    Parameters
    ----------
    rms : the error. units : of the answer that it stands in.

    Examples
    --------
    >>> deviation({"translation": 0.0003721, "rotation": 2.5e-4})
    '0.372 mm, 0.250 mrad'
    >>> deviation({"translation": 0.0003721, "rotation": None, "length": 1.2e-6})
    '0.372 mm, 0.00120 mm at the rods'
    """
    return ", ".join(measures(rms, units=units)) or DASH


def change_words(relative: float | None) -> str:
    """Return a relative change with its sign; what is rounding of a solver is none.

    Examples
    --------
    >>> change_words(1.19), change_words(-0.02), change_words(None), change_words(-4e-15)
    ('+119 %', '−2.00 %', '–', '0 %')
    """
    if relative is not None and abs(relative) < _ROUNDING:
        return share(0.0)
    return f"+{share(relative)}" if relative is not None and relative > 0 else share(relative)


def ranges(numbers: Sequence[int]) -> str:
    """Return numbers in order, three and more in a row as a range.

    Examples
    --------
    >>> ranges([1, 2, 3, 5, 6])
    '1–3, 5, 6'
    """
    rows: list[list[int]] = []
    for number in sorted(numbers):
        if rows and rows[-1][-1] == number - 1:
            rows[-1].append(number)
        else:
            rows.append([number])
    return ", ".join(f"{row[0]}–{row[-1]}" if len(row) > 2 else ", ".join(map(str, row)) for row in rows)


def place(where: PlacesOfEffect | Mapping[str, Sequence[Any]]) -> str:
    """Return a ``where`` in words.

    Examples
    --------
    >>> place({"joints": [1, 2, 3, 4, 6]}), place({"links": ["swing"]})
    ('joints 1–4, 6', 'link "swing"')
    >>> place({"pairs": [[5, 6]]}), place({})
    ('pairs 5-6', 'set-up')
    """
    words = []
    for kind, members in where.items():
        if not members:
            continue
        if kind == "pairs":
            names = ", ".join("-".join(str(joint) for joint in pair) for pair in members)
        else:  # quoted, as links have names that are words: swing, arm
            names = ranges(members) if kind == "joints" else ", ".join(f'"{name}"' for name in members)
        words.append(f"{kind[:-1] if len(members) == 1 and kind != 'pairs' else kind} {names}")
    return "; ".join(words) or "set-up"


def variable(follows: str) -> str:
    """Return what a remaining error depends on in words, from the name in ``structure`` of ``diagnose``.

    Examples
    --------
    >>> variable("branch"), variable("motor temperature")
    ('loading or unloading', 'motor temperature')
    """
    words = {
        "joint angle": "the joint angles",
        "load": "the load",
        "branch": "loading or unloading",
        "approach": "the direction of the last motion",
    }
    return words.get(follows, follows)


def count(number: int, singular: str, many: str = "") -> str:
    """Return how many, with the noun in its right form.

    Examples
    --------
    >>> count(1, "run"), count(12, "run"), count(2, "pose")
    ('1 run', '12 runs', '2 poses')
    """
    return f"{number:,} {singular if number == 1 else many or singular + 's'}".replace(",", _NARROW_SPACE)


def listing(names: Iterable[str], limit: int = 12) -> str:
    """Return names as a list in a sentence, shortened where there are many.

    Examples
    --------
    >>> listing(["a", "b", "c"]), listing(["a", "b", "c"], limit=2)
    ('a, b and c', 'a, b and 1 more')
    """
    words = list(names)
    if len(words) > limit:
        return f"{', '.join(words[:limit])} and {len(words) - limit} more"
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}" if words else DASH


def unused_columns(names: Sequence[str]) -> list[str]:
    """Return one sentence that names the columns of a table which nothing reads; none where there are none.

    Examples
    --------
    >>> unused_columns([]), unused_columns(["note", "Rx"])
    ([], ['columns note and Rx are not used'])
    """
    many = len(names) > 1
    words = f"column{'s' * many} {listing(names)} {'are' if many else 'is'} not used"
    return [words] if names else []


def lines_in_words(lines: Iterable[int], word: str = "line", limit: int = 5) -> str:
    """Return numbers of lines of a file, in ascending order, as a place in a message; of many stretches the first ones.

    `word`: what is counted.

    Examples
    --------
    >>> lines_in_words([4]), lines_in_words([3, 7, 8, 9]), lines_in_words([2, 4, 6], limit=2)
    ('line 4', 'lines 3, 7 to 9', 'lines 2, 4, …')
    """
    stretches: list[list[int]] = []
    for line in lines:
        if stretches and line == stretches[-1][1] + 1:
            stretches[-1][1] = line
        else:
            stretches.append([line, line])
    words = [f"{start}" if start == end else f"{start} to {end}" for start, end in stretches]
    many = "s" if len(stretches) > 1 or stretches[0][0] < stretches[0][1] else ""
    return f"{word}{many} {', '.join(words[:limit])}{', …' if len(words) > limit else ''}"
