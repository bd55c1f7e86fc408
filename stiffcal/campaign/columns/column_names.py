"""What the name of a column says: what it holds, along which axis, and in which unit.

One vocabulary for `init`, for the tables that commands read, and for the comparison of a header with the manifest.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import lru_cache
from types import MappingProxyType

from stiffcal.quantities import is_known, quantities

# Words that say where, not what; they are noted and taken off the name.
PLACES = ("base", "world", "robot", "tool", "tcp", "flange", "sensor", "ft", "fts", "wrench", "mean", "avg")
JOINT_STEMS = (
    *("a", "axis", "achse", "axe", "j", "joint", "q", "theta", "θ", "th", "gelenk", "angle", "winkel", "achswinkel"),
    *("axisa", "axisacta", "axisact", "axisposact", "actualq", "actualj", "jointangle", "jointposition", "achsea"),
    *("gelenkwinkel", "gelenkposition", "achsposition", "eixo", "junta"),
    *("rax", "robax", "jt"),  # ABB's jointtarget, Kawasaki's axes
    *("eje", "articulacion", "articulation", "asse", "giunto", "angolo", "angulo"),
    *("jointa", "aiposa", "fieldposition", "positiona", "positionj", "positionjoint", "positionq", "positiontheta"),
    *("軸", "関節", "関節角", "関節角度", "角度", "轴", "关节", "关节角", "关节角度"),
    *("jointpositions", "jointangles", "jointpos", "actualjointpositions", "joints", "axes"),
)
MEASURED_AT = "headerstamp"
"""The time of a message of ROS, which the driver of the instrument has written."""
TIMES = (
    *("t", "time", "zeit", "timestamp", "zeitstempel", "datetime", "elapsedtime", "zeitpunkt", "timeseconds", "xvalue"),
    *("uhrzeit", "heure", "hora", "ora", "timeofday"),
    *("čas", "czas", "tid", "tijd", "aika", "ido", "sure", "zaman", "время", "χρονος"),
    *("laufzeit", "messzeit", "tempsecoule", "tiempotranscurrido", "tempotrascorso"),
    *("経過時間", "測定時間", "測定時刻", "测量时间", "采样时间", "采集时间"),
    *("temps", "tiempo", "tempo", "時間", "時刻", "日時", "时间", "시간", "일시", "epochtime", "systemtime", "ipoc"),
    *("stamp", "unixtime", "epoch", "ts", "timesec", "timems", "elapsed", "sec", "secs"),
    *(TIMES_BY_UNIT := ("ms", "us", "ns", "seconds", "sekunden", "milliseconds", "millisekunden")),
)
"""The likeliest first. The last ones are units, after which nothing but a time is called: s may be a travel, min a
least value."""
DATES = ("date", "datum", "fecha", "日付", "日期")
"""Words for a day, which is a time where it grows from row to row: spreadsheets count days with their fractions."""
FRACTIONS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "ns": ("ns", "nsec", "nsecs", "nanosec", "nanosecs", "nanosecond", "nanoseconds", "nanosekunden"),
        "us": ("us", "usec", "usecs", "microsec", "microsecond", "microseconds", "mikrosekunden"),
        "ms": ("ms", "msec", "msecs", "millis", "millisec", "millisecond", "milliseconds", "millisekunden", "millitm"),
    }
)
"""By their unit the words for what is added to whole seconds that stand in another column."""
QUATERNIONS = (*(("q0", "qx", "qy", "qz"), ("qw", "qx", "qy", "qz"), ("quatw", "quatx", "quaty", "quatz")),)
NUMBERED_QUATERNION = ("q0", "q1", "q2", "q3")
"""Names of a quaternion's components, the scalar first, where numbers show one: the squares add up to 1."""
XYZ = "xyz"

_NARROW = str.maketrans(
    {chr(0xFEE0 + code): chr(code) for code in range(0x21, 0x7F)} | dict(zip("\u3010\u3011{}", "[][]", strict=True))
)
"""Braces, and signs of double width, as Japanese and Chinese keyboards write them, to usual ones."""
_LONGEST_NAME = 300  # characters; in a longer one no unit is looked for, which takes the square of its length
_BRACKETED = re.compile(r"^(?P<name>.*?)(?:\[(?P<a>[^\]]*+)\]|\((?P<b>[^)]*+)\))\s*+$")
# A unit behind a slash (DIN 1313: "F / kN"), a dash, a word, an underscore or a blank: else part of the name.
_SEPARATED = re.compile(
    r"^(?P<name>.*?\S)(?:(?:\s*/\s*|\s+[-–]\s+)(?P<ratio>[^\s/]++)|(?:\s+in\s+|,\s*|(?P<loose>_|\s+))(?P<unit>[^\s_,]++))\s*+$"
)
_COVERAGE = re.compile(r"k ?= ?\d|\d\d ?%")
# A tracked target, also one of several.
_TARGET = re.compile(r"(led|marker|smr|reflector|reflektor|probe|tmac|tprobe|p|pt|point|punkt)\d*")
_LEAST_AXIS_FIRST = 3
"""Letters of a word that may follow its axis ("x_force"); of shorter ones the axis is the end ("fx")."""


class Reading(StrEnum):
    """What three columns x, y, z hold; the values are the names of `Roles`."""

    FORCE = "force"
    MOMENT = "moment"
    DEFLECTION = "deflection"
    ROTATION = "rotation"
    POSITION = "position"


QUANTITY: Mapping[Reading, str] = MappingProxyType(
    {
        Reading.FORCE: "force",
        Reading.MOMENT: "moment",
        Reading.DEFLECTION: "translation",
        Reading.ROTATION: "angle",
        Reading.POSITION: "position",
    }
)
"""The quantity of a reading's unit."""
STEMS: Mapping[Reading, tuple[str, ...]] = MappingProxyType(
    {
        Reading.FORCE: (
            *("f", "force", "kraft", "load", "last", "effort", "charge", "fuerza", "carga", "forza", "carico"),
            *("forca", "sila", "siła", "kracht", "voima", "ero", "kuvvet", "сила", "δυναμη"),
            *("力", "荷重", "载荷"),
        ),
        Reading.MOMENT: (
            *("t", "m", "torque", "moment", "drehmoment", "tau", "mom", "couple", "momento", "coppia"),
            *("トルク", "モーメント", "力矩", "扭矩"),
        ),
        Reading.DEFLECTION: (
            *("d", "delta", "u", "disp", "displacement", "defl", "deflection", "verschiebung", "def", "weg"),
            *("durchbiegung", "auslenkung", "deplacement", "fleche", "desplazamiento", "flecha", "spostamento"),
            *("freccia", "deslocamento", "verformung", "verlagerung", "durchsenkung", "cedimento", "deformatie"),
            *("deformation", "deformacion", "deformazione", "deformacao", "odksztalcenie", "прогиб", "деформация"),
            *("変位", "変位量", "たわみ", "変形", "変形量", "位移", "位移量", "变形", "变形量", "挠度"),
            "t",
        ),
        Reading.ROTATION: (
            *("dr", "deltar", "drot", "rot", "rotation", "orientation", "phi", "dphi", "verdrehung", "回転", "转角"),
            "r",
        ),
        Reading.POSITION: (
            *("", "p", "pos", "position", "target", "point", "messpunkt", "measurement", "measured"),
            *("punkt", "koordinate", "coordinate", "posicion", "posizione", "coordonnee", "coordenada", "coordinata"),
            *("位置", "座標", "坐标"),
            *("m", "t"),
        ),
    }
)
"""What stands before x, y or z, the likeliest first. A unit decides where a stem belongs to several readings: Tx is a
moment, and a translation where a unit of length stands by it."""
WORDS_OF_SIGNS = tuple(
    word for words in (JOINT_STEMS, TIMES, *STEMS.values()) for word in words if word and word[0] >= "\u2e80"
)
"""Those of them in Chinese, Japanese and Korean."""
WORDS_OF_LETTERS = (
    *("čas", "síla", "siła", "sił", "süre", "erő", "idő", "время", "сила", "kräfte", "größe", "prüf", "über", "für"),
    *("déplacement", "écoulé", "numéro", "précision", "posición", "ángulo", "força", "posição", "läge", "mått"),
    *("[°", "(°", "°c", "µm", "µε", "[µ", "(µ"),
)
"""Of tables in languages of Europe the words and units with a letter that no two code pages write with one byte."""
_TRAVELS = frozenset(("weg", "deplacement", "desplazamiento", "spostamento", "deslocamento", "位移", "位移量"))
"""Words for a displacement under load that are as usual for how far an axis has moved."""
_RAW = frozenset(("raw", "roh", "rohwert", "brut", "crudo", "grezzo", "bruto"))
"""Words for what a sensor reads before its zero, or its calibration."""
TRAVEL = "displacements under load, or travels of axes"
RAW = "raw: are calibration and unit those of the load?"
_OPEN: Mapping[str, tuple[Reading, ...]] = MappingProxyType({"r": (Reading.ROTATION, Reading.MOMENT, Reading.FORCE)})
"""Stems that mean several things about as often (Rx: a rotation, a reaction); without a unit it is a question."""


@dataclass(frozen=True)
class ColumnHeader:
    """A column's header, taken apart."""

    name: str
    """Without the unit."""
    unit: str | None
    """As written; None where there is none."""


@dataclass(frozen=True)
class Component:
    """One of three columns."""

    reading: Reading
    axis: int
    """0, 1, 2 for x, y, z."""
    stem: str
    """What stands before the axis."""
    places: frozenset[str]
    """Words in the name that say where ("base", "tool", …)."""
    body: str = ""
    """Words before the stem that name what is measured ("plate" of "plate Position X"), small; "" without."""
    is_open: bool = False
    """Whether the name and the missing unit leave open which reading it is."""
    doubt: str = ""
    """What a word of the name leaves open: `TRAVEL` or `RAW`; "" where none does."""


def header_parts(header: str) -> ColumnHeader:
    """Return a header's name and the unit that stands in it.

    Examples
    --------
    >>> headers = "Fx [kN]", "F / N", "Fx/kN", "dx_mm", "Kraft X in kN", "v_deg/s", "Fx_N", "F_N", "ms", "note"
    >>> for parts in map(header_parts, headers):
    ...     print(parts.name, parts.unit, sep=", ")
    Fx, kN
    F, N
    Fx, kN
    dx, mm
    Kraft X, kN
    v, deg/s
    Fx, N
    F_N, None
    ms, ms
    note, None
    """
    if len(header) > _LONGEST_NAME:
        return ColumnHeader(header, None)
    if header.lower() in TIMES_BY_UNIT and is_unit(header):
        return ColumnHeader(header, header)
    header = header.translate(_NARROW)
    bracketed = _BRACKETED.match(header)
    within = (bracketed["a"] or bracketed["b"] or "").strip() if bracketed is not None else ""
    if bracketed is not None and not within.isdigit() and not _COVERAGE.fullmatch(within):  # q[0] is a name
        return ColumnHeader(bracketed["name"].strip(), within or None)
    separated = _SEPARATED.match(header)
    if separated is not None:
        written, name = separated["ratio"] or separated["unit"], separated["name"]
        # one letter after an underscore or a blank completes a name, as in F_N, unless an axis or a number is its end
        complete = len(written) > 1 or separated["loose"] is None or name[-1].lower() in XYZ or name[-1].isdigit()
        complete = complete or (written == "s" and plain_name(name) in TIMES)
        if complete and is_unit(written):
            return ColumnHeader(name.strip(), written)
    return ColumnHeader(header, None)


@lru_cache(maxsize=4096)
def is_unit(text: str) -> bool:
    """Return whether a text is a unit of any quantity."""
    return any(is_unit_of(text, quantity) for quantity in quantities())


# Units of what is not computed with, as rows of units hold them too; with those of mechanics also as parts of products.
_OTHER_UNITS = frozenset(
    (
        *("s", "sec", "ms", "us", "ns", "min", "h", "n", "kn", "mn", "nm", "knm", "nmm", "ncm", "m", "mm", "cm", "um"),
        *("deg", "°", "rad", "mrad", "urad", "rev", "turn", "a", "ma", "v", "mv", "w", "kw", "degc", "°c", "c", "k"),
        *("kg", "g", "hz", "khz", "rpm", "pa", "kpa", "mpa", "bar", "mbar", "lbf", "in", "%", "iso8601", "counts"),
    )
)


def _is_unit_word(text: str) -> bool:
    """Return whether a cell is a unit, also one that nothing is computed with, or a product of units; no number is."""
    factors = [factor.rstrip("²³23^-") for factor in re.split(r"[*·./ ]", text.lower().replace("µ", "u")) if factor]
    return is_unit(text) or (bool(factors) and all(factor in _OTHER_UNITS for factor in factors))


def is_unit_of(text: str, quantity: str) -> bool:
    """Return whether a text is a unit of a quantity."""
    return is_known(text, quantity)


def bare_unit(cell: str) -> str:
    """Return a cell of a row of units without brackets."""
    return cell.translate(_NARROW).strip("[]() ")


def is_unit_row(row: Sequence[str]) -> bool:
    """Return whether every cell of a row is a unit or empty, and some are units."""
    cells = [bare_unit(cell) for cell in row]
    without = {"-", "[-]", "(-)", "[1]", "(1)"}  # of a number without a dimension
    return any(map(_is_unit_word, cells)) and all(
        not cell or written in without or _is_unit_word(cell) for cell, written in zip(cells, row, strict=True)
    )


def words_of(name: str) -> tuple[list[str], frozenset[str]]:
    """Take a name apart: its words in small letters, and those among them that say where."""
    words = [word for word in re.split(r"[\W_]+", _without_accents(name.lower())) if word]
    places = frozenset(word for word in words if word in PLACES)
    return [word for word in words if word not in places], places


def _without_accents(text: str) -> str:
    """Return a text whose Latin letters have no accents: "déplacement" and "deplacement" are one word."""
    if text.isascii():
        return text
    # composed again: signs of other scripts come apart as well
    return unicodedata.normalize("NFC", _ACCENTS.sub("", unicodedata.normalize("NFD", text)))


_ACCENTS = re.compile("[\u0300-\u036f]")


def plain_name(name: str) -> str:
    """Return a name's letters and digits, small, without words that say where.

    Examples
    --------
    >>> plain_name("Base_Fx"), plain_name("Axis 1")
    ('fx', 'axis1')
    """
    return "".join(words_of(name)[0])


def component_of(name: str, written: str | None) -> Component | None:
    """Return which of three columns a name is, None where it is none.

    Parameters
    ----------
    name : without its unit. written : the unit, None where none is stated.

    Examples
    --------
    >>> for name, written in (("Mx", None), ("Tx", None), ("Tx", "mm"), ("wrench.torque.z", None), ("x_force", None)):
    ...     found = component_of(name, written)
    ...     print(found.reading, found.axis)
    moment 0
    moment 0
    deflection 0
    moment 2
    force 0
    >>> component_of("Rx", None).is_open, component_of("Rx", "rad").is_open, component_of("note", None)
    (True, False, None)
    """
    kept, places = words_of(name)
    if _OTHER_QUANTITIES & set(kept) or (written is not None and is_unit_of(written, "strain")):
        return None
    raw = RAW if _RAW & set(kept) else ""
    kept = [word for word in kept if word not in _BETWEEN and word not in _RAW]
    kept = _without_channel(kept)
    for first in range(len(kept)):
        for stem, axis in _stems_and_axes("".join(kept[first:])):
            readings = _OPEN.get(stem) or tuple(
                reading
                for reading, stems in STEMS.items()
                if stem in stems or ("target" in stems and _TARGET.fullmatch(stem))
            )
            if first and len(stem) == 1:
                # "tilt x" is no moment, while "Kraft Fx" states twice what it is
                before = "".join(kept[:first])
                readings = tuple(reading for reading in readings if before in STEMS[reading])
            if not readings:
                continue
            of_unit = [
                reading for reading in readings if written is not None and is_unit_of(written, QUANTITY[reading])
            ]
            if not stem and written is not None and not of_unit:  # nothing but an axis: its unit states what it is
                of_unit = [own for own in (Reading.FORCE, Reading.MOMENT) if is_unit_of(written, QUANTITY[own])]
                if not of_unit and _is_unit_word(written):
                    continue
                stem = STEMS[of_unit[0]][0] if of_unit else stem
            found = (of_unit or readings)[0]
            if raw and found not in (Reading.FORCE, Reading.MOMENT):
                return None
            is_open = stem in _OPEN and not of_unit
            doubt = TRAVEL if stem in _TRAVELS else raw
            return Component(found, axis, stem, places, " ".join(kept[:first]), is_open=is_open, doubt=doubt)
    return None


_ELEMENT = re.compile(r"(.{1,200})\[([0-9])\]|(.{0,200}pose)_([0-9])")
_OF_TOOL_CENTRE = frozenset(("tcp", "tool"))  # which a controller computes of its joints' angles
_WRENCHES = ("wrench", "ft", "forcetorque", "force")


def components_of_arrays(names: Iterable[str]) -> dict[str, str]:
    """Return of elements of arrays, numbered from 0 or from 1 (MATLAB), the names with x, y, z that they stand for.

    They are three of one kind, three forces before three moments, or of a pose the place before three that turn it.

    Examples
    --------
    >>> components_of_arrays(["t", "pos[0]", "pos[1]", "pos[2]"])
    {'pos[0]': 'pos x', 'pos[1]': 'pos y', 'pos[2]': 'pos z'}
    """
    elements: dict[str, dict[int, str]] = {}
    for name in names:
        if (match := _ELEMENT.fullmatch(name)) is not None:
            elements.setdefault(match[1] or match[3], {})[int(match[2] or match[4])] = name
    meant: dict[str, str] = {}
    for stem, numbered in elements.items():
        if sorted(numbered) not in (list(range(len(numbered))), list(range(1, len(numbered) + 1))):
            continue
        array = [numbered[k] for k in sorted(numbered)]
        if len(array) == 3:
            meant |= {name: f"{stem} {axis}" for name, axis in zip(array, XYZ, strict=True)}
        elif len(array) == 6 and "".join(re.split(r"[\W_]+", stem.lower())).endswith(_WRENCHES):
            kinds = ("force", "torque")
            meant |= {name: f"{kinds[k // 3]} {XYZ[k % 3]}" for k, name in enumerate(array)}
        elif len(array) == 6 and words_of(stem)[0][-1:] == ["pose"] and not _OF_TOOL_CENTRE & words_of(stem)[1]:
            meant |= {name: f"position {axis}" for name, axis in zip(array, XYZ, strict=False)}
    return meant


# Words of what is no force, moment, displacement or place, though it has components x, y and z.
_OTHER_QUANTITIES = frozenset(
    (
        *("vel", "velocity", "speed", "geschwindigkeit", "acc", "accel", "acceleration", "beschleunigung", "jerk"),
        *("gyro", "imu", "mag", "magnet", "magnetic", "angular", "linear", "rpy", "euler", "quat", "tilt", "gain"),
        *("error", "err", "std", "cmd", "command", "commanded", "soll", "setpoint", "desired", "residual", "quality"),
        *("offset", "bias", "voltage", "current", "temp", "temperature", "id", "rms"),
        "cop",  # where on a force plate the load acts
        *("rist", "rsol"),  # RSI of KUKA: where the controller believes the tool to be, from its own joints
    )
)


_CHANNELS = frozenset(("ai", "ch", "chan", "channel", "kanal", "voie", "canal", "canale", "input", "eingang"))


def _without_channel(words: list[str]) -> list[str]:
    """Return the words of a name without those of an amplifier's channel or a sensor's type around one component.

    A name has several words, one of which is a component written with its letter: "MX840_CH1 Fx", "Fx 9129AA".
    """
    named = [word for word in words if len(word) == 2 and word[0] in _LETTERS and word[1] in XYZ]
    others = [word for word in words if word not in named]
    is_channel = [word in _CHANNELS or any(map(str.isdigit, word)) for word in others]
    return named if len(named) == 1 and all(is_channel) else words


_LETTERS = "fmtd"
_BETWEEN = frozenset(
    (
        *("in", "en", "along", "entlang", "selon", "suivant", "lungo", "nach"),
        *("richtung", "direction", "direccion", "direzione", "direcao"),
    )
)
"""Words between what is measured and its axis, or behind that: "Kraft in X-Richtung"."""
_DIRECTION = ("方向", "向", "軸", "轴", "richtung", "direction")
"""What may stand between an axis and what is measured along it."""


def _stems_and_axes(word: str) -> Iterable[tuple[str, int]]:
    if word and word[-1] in XYZ:
        yield word[:-1], XYZ.index(word[-1])
    if word and word[0] in XYZ:
        rest = next((word[1 + len(own) :] for own in _DIRECTION if word.startswith(own, 1)), word[1:])
        if len(word) > _LEAST_AXIS_FIRST or not rest.isascii():  # one sign is a word of other scripts
            yield rest, XYZ.index(word[0])
