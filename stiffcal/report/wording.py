"""Numbers and names in the words of the people who read the report: mm, µm, mrad, three significant digits.

Everything comes in SI units; what is not known is a dash, never a zero.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from stiffcal.measurements.rms import Rms
    from stiffcal.model.summary import Where

from stiffcal.measurements.rms import Rms
from stiffcal.model.summary import Where

DASH = "–"
_NARROW_SPACE = "\u202f"
MOST_WRITTEN_OUT = 15  # digits before the point; a double holds no more


class Placed(Protocol):
    """A result that names an effect and its place."""

    @property
    def effect(self) -> str:
        """The effect's name."""

    @property
    def where(self) -> Where:
        """Its place."""


def digits(value: float | None, significant: int = 3) -> str:
    """Write a number with so many significant digits, thousands apart by a narrow space.

    Examples
    --------
    >>> digits(0.0417), digits(1.2249), digits(-0.5), digits(0.0)
    ('0.0417', '1.22', '−0.500', '0')
    >>> digits(731820.0).replace(chr(0x202F), " ")
    '732 000'
    >>> digits(5e-324), digits(-2.5e300)
    ('4.94·10⁻³²⁴', '−2.50·10³⁰⁰')
    """
    if value is None or not math.isfinite(value):
        return DASH
    if value == 0:
        return "0"
    # Rounded first: 9.996 is of the next decade. By its text: powers of ten below 1e-308 are no numbers.
    mantissa, _, power = f"{value:.{significant - 1}e}".partition("e")
    size = int(power)
    if not -6 < size < MOST_WRITTEN_OUT:
        return f"{mantissa.replace('-', '−')}·10{_superscript(size)}"
    rounded = round(value, significant - 1 - size)
    decimals = max(0, significant - 1 - size)
    return f"{rounded:,.{decimals}f}".replace(",", _NARROW_SPACE).replace("-", "−")


def _superscript(power: int) -> str:
    return str(power).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def length(metres: float | None) -> str:
    """Write a length: mm, and µm below a tenth of a millimetre.

    Examples
    --------
    >>> length(0.0012249), length(4.17e-5), length(None)
    ('1.22 mm', '41.7 µm', '–')
    """
    if metres is None or not math.isfinite(metres):
        return DASH
    return f"{digits(metres * 1e3)} mm" if abs(metres) >= 1e-4 or metres == 0 else f"{digits(metres * 1e6)} µm"


def angle(radians: float | None) -> str:
    """Write a small angle in mrad.

    Examples
    --------
    >>> angle(7.79e-5)
    '0.0779 mrad'
    """
    return DASH if radians is None or not math.isfinite(radians) else f"{digits(radians * 1e3)} mrad"


def both(measure: Rms | Mapping[str, Any] | None) -> str:
    """Write an error ``{translation, rotation, …}`` in one phrase.

    Examples
    --------
    >>> both({"translation": 4.17e-5, "rotation": 7.79e-5})
    '41.7 µm and 0.0779 mrad'
    >>> both({"translation": 4.17e-5, "rotation": None}), both(None)
    ('41.7 µm', '–')
    """
    known = {} if not measure else {name: value for name, value in measure.items() if value is not None}
    parts = [length(known["translation"])] if "translation" in known else []
    if "rotation" in known:
        parts.append(angle(known["rotation"]))
    if "length" in known:
        parts.append(f"{length(known['length'])} at the rods")
    if "motor_angle" in known:
        parts.append(f"{angle(known['motor_angle'])} of the motors")
    if "torque" in known:
        parts.append(f"{digits(float(known['torque']))} N·m")
    return " and ".join(parts) or DASH


def part(measure: Rms | Mapping[str, Any] | None, key: str) -> float | None:
    """Take one entry of ``{translation, rotation, …}``, None where it is missing or null."""
    value = dict(measure.items()).get(key) if measure else None
    return None if value is None else float(value)


def percent(share: float | None) -> str:
    """Write a share as a percentage.

    Examples
    --------
    >>> percent(0.0341), percent(None)
    ('3.41 %', '–')
    """
    return DASH if share is None or not math.isfinite(share) else f"{digits(share * 100)} %"


def count(number: int, singular: str, many: str = "") -> str:
    """Write how many, with the noun in its right form.

    Examples
    --------
    >>> count(1, "run"), count(12, "run"), count(2, "pose")
    ('1 run', '12 runs', '2 poses')
    """
    return f"{number:,} {singular if number == 1 else many or singular + 's'}".replace(",", _NARROW_SPACE)


def in_sheets(members: Sequence[int], most: int, multiple: int = 1) -> list[Sequence[int]]:
    """Cut a row into sheets of nearly equal size, none above `most`, each but the last a multiple of `multiple`.

    Examples
    --------
    >>> in_sheets(range(10), 8), in_sheets(range(43), 20, multiple=5)
    ([range(0, 5), range(5, 10)], [range(0, 15), range(15, 30), range(30, 43)])
    """
    if not members:
        return []
    sheets = -(-len(members) // most)
    size = -(-len(members) // sheets)
    size = min(most, -(-size // multiple) * multiple)
    return [members[start : start + size] for start in range(0, len(members), size)]


def listing(names: Iterable[str], limit: int = 12) -> str:
    """Write names as a list in a sentence, shortened where there are many.

    Examples
    --------
    >>> listing(["a", "b", "c"]), listing(["a", "b", "c"], limit=2)
    ('a, b and c', 'a, b and 1 more')
    """
    words = list(names)
    if len(words) > limit:
        return f"{', '.join(words[:limit])} and {len(words) - limit} more"
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}" if words else DASH


def place(where: Where | Mapping[str, Sequence[Any]]) -> str:
    """Write a ``where`` in words.

    Examples
    --------
    >>> place({"joints": [4]}), place({"pairs": [[5, 6]]}), place({}), place({"joints": [1, 2, 3, 5]})
    ('joint 4', 'joints 5–6', 'set-up', 'joints 1–3, 5')
    """
    words = []
    for key, members in where.items():
        if key == "pairs":
            words.append("joints " + ", ".join("–".join(str(joint) for joint in pair) for pair in members))
        elif members:
            noun = key[:-1] if len(members) == 1 and key.endswith("s") else key
            words.append(f"{noun} {_ranges(members)}")
    return "; ".join(words) or "set-up"


def effect_at(effect: Placed) -> str:
    """Write an effect with its place."""
    return f"{effect.effect} ({place(effect.where)})"


def _ranges(members: Sequence[Any]) -> str:
    """Write numbers with runs of three and more drawn together: 1–6, 8."""
    parts: list[list[Any]] = []
    for member in members:
        if parts and isinstance(member, int) and parts[-1][-1] == member - 1:
            parts[-1].append(member)
        else:
            parts.append([member])
    words = [f"{stretch[0]}–{stretch[-1]}" if len(stretch) > 2 else ", ".join(map(str, stretch)) for stretch in parts]
    return ", ".join(words)


def unit_words(unit: str) -> str:
    """Write a unit of a JSON document as it is printed.

    Examples
    --------
    >>> unit_words("rad/(N*m)"), unit_words("N*m^2")
    ('rad/(N·m)', 'N·m²')
    """
    return unit.replace("*", "·").replace("^2", "²").replace("^3", "³").replace("degC", "°C")


def effect_text(entry: Any) -> str:
    """Write one entry of a model's list of effects: a name, or its table from model.toml.

    Examples
    --------
    >>> effect_text("backlash 4"), effect_text({"type": "backlash", "joints": [4]})
    ('backlash 4', 'backlash, joint 4')
    >>> effect_text({"type": "joint-compliance", "joints": "all"})
    'joint-compliance, all joints'
    """
    if isinstance(entry, str):
        return entry
    name = str(entry.get("type") or entry.get("effect") or "effect")
    where = entry.get("where") or {key: entry[key] for key in ("joints", "links", "pairs") if entry.get(key)}
    if not where:
        return name
    every = [f"all {key}" for key, members in where.items() if members == "all"]
    return f"{name}, {every[0] if every else place(where)}"


def model_change(before: Any, after: Any) -> str:
    """Write what a model gained (+) and lost (−) against the one before, "" where it is the same.

    Examples
    --------
    >>> one = {"effects": [{"type": "joint-compliance", "joints": [1, 2]}]}
    >>> two = {"effects": [*one["effects"], {"type": "backlash", "joints": [4]}]}
    >>> model_change(one, two), model_change(two, one), model_change(one, one)
    ('+ backlash, joint 4', '− backlash, joint 4', '')
    """
    old, new = _single_places(before), _single_places(after)
    gained = [f"+ {name}" for name in new if name not in old]
    lost = [f"− {name}" for name in old if name not in new]
    return "; ".join([*gained, *lost])


def _single_places(model: Any) -> list[str]:
    """List a model's effects place by place."""
    effects = model.get("effects", []) if isinstance(model, dict) else model
    texts: list[str] = []
    for entry in [effects] if isinstance(effects, str) else effects or []:
        single: list[Any] = [entry]
        if isinstance(entry, dict):
            kinds = [kind for kind in ("joints", "links", "pairs") if isinstance(entry.get(kind), list)]
            parts = [{"type": entry["type"], kind: [member]} for kind in kinds for member in entry[kind]]
            single = parts or single
        texts += [effect_text(effect) for effect in single]
    return texts


def model_words(model: Any) -> str:
    """Write a model (list of effects, or a table with ``effects``) as one phrase.

    Examples
    --------
    >>> model_words({"balance": "deformed", "effects": [{"type": "joint-compliance", "joints": [1, 2]}]})
    'joint-compliance, joints 1, 2'
    """
    effects = model.get("effects", []) if isinstance(model, dict) else model
    if isinstance(effects, str):
        return effects
    return "; ".join(effect_text(entry) for entry in effects or []) or "no effect"
