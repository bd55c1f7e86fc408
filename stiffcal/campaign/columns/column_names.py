"""What three columns x, y and z hold, by their names: a force, a moment, a displacement, a rotation or a place.

One vocabulary for `init`, for the tables that commands read, and for the comparison of a header with the manifest.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from types import MappingProxyType

from stiffcal.campaign.columns.column_headers import is_unit_of, is_unit_word
from stiffcal.campaign.columns.column_words import JOINT_STEMS, TIMES, XYZ, words_of

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
                if not of_unit and is_unit_word(written):
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
