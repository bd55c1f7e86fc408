"""Words in the names of columns: for joints, times and quaternions, and for where something is measured."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Mapping
from types import MappingProxyType

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
