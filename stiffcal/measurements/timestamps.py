"""Times as logs have them, words or a clock's steps, as seconds since 1970-01-01 UTC."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import UTC, datetime
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode

_PER_SECOND = {"W": 1 / 604800, "D": 1 / 86400, "h": 1 / 3600, "m": 1 / 60, "s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}

_LARGEST = 9e12  # the year 287 000: no log's, but what becomes of a database's infinity


DAY_FIRST, MONTH_FIRST = "day-first", "month-first"
"""How numbers of a date are ordered whose year stands last."""

_LOCAL = re.compile(
    r"'?(?:(?P<first>\d{1,4})(?P<mark>[-./ ])(?P<second>\d{1,2}|[^\W\d_]{3,9}\.?)(?P=mark)"
    r"(?P<third>\d{4}|\d{1,2})(?:[ T,]+|$))?"
    r"(?:(?P<hour>\d{1,2}):(?P<minute>\d{2})(?::(?P<second_of>\d{2})(?:[.,:](?P<fraction>\d+))?)?"
    r"\s*(?P<half>[AaPp]\.?[Mm]\.?)?\s*(?P<zone>Z|UTC|GMT|[+-]\d{2}:?\d{2})?)?"
)
# Other ways to write a date or a time of day; each is rewritten to one above.
_CLOCK = r"(?P<clock>\d{1,2}:\d{2}(?::\d{2}(?:[.,:]\d{1,9})?)?(?: ?[AaPp]\.?[Mm]\.?)?)"
_MONTH = r"(?P<month>[^\W\d_]{3,9}\.?)"
_DIGITS = r"(?P<year>\d{4})-?(?P<month>\d{2})-?(?P<day>\d{2})[ _T-]"
_YEAR_LAST, _YEAR_FIRST = r"\g<day>-\g<month>-\g<year> \g<clock>", r"\g<year>-\g<month>-\g<day> \g<clock>"
_OTHER_WAYS = tuple(
    (re.compile(pattern), template)
    for pattern, template in (
        (
            rf"(?P<year>\d{{4}})[年년] ?(?P<month>\d{{1,2}})[月월] ?(?P<day>\d{{1,2}})[日일][ T]{{0,2}}{_CLOCK}?",
            _YEAR_FIRST,
        ),
        (rf"(?P<year>\d{{4}})\. ?(?P<month>\d{{1,2}})\. ?(?P<day>\d{{1,2}})\. ?{_CLOCK}?", _YEAR_FIRST),  # Korean
        (rf"(?P<day>\d{{1,2}})\. ?{_MONTH} (?P<year>\d{{4}}),? ?{_CLOCK}?", _YEAR_LAST),
        (rf"(?P<day>\d{{1,2}}) de {_MONTH} de (?P<year>\d{{4}}),? ?{_CLOCK}?", _YEAR_LAST),  # Spanish, Portuguese
        (rf"{_MONTH} (?P<day>\d{{1,2}}),? (?P<year>\d{{4}}),? ?{_CLOCK}?", _YEAR_LAST),
        (rf"[A-Za-z]{{3}} {_MONTH} {{1,2}}(?P<day>\d{{1,2}}) {_CLOCK} (?P<year>\d{{4}})", _YEAR_LAST),  # C, Unix
        (rf"{_DIGITS}{_CLOCK}", _YEAR_FIRST),
        # as names of files have it, in which there is no colon
        (
            rf"{_DIGITS}(?P<hour>\d{{2}})[-_.]?(?P<minute>\d{{2}})[-_.]?(?P<second>\d{{2}}(?:[.,]\d{{1,9}})?)(?P<zone>Z?)",
            r"\g<year>-\g<month>-\g<day> \g<hour>:\g<minute>:\g<second>\g<zone>",
        ),
        # minutes and seconds, as a spreadsheet writes times below an hour
        (r"(?P<minute>\d{1,2}):(?P<second>\d{2}[.,]\d{1,9})", r"0:\g<minute>:\g<second>"),
    )
)
# Halves of the day that stand before the clock: Korean, Chinese, Japanese.
_HALVES = {"오전": "AM", "오후": "PM", "上午": "AM", "下午": "PM", "午前": "AM", "午後": "PM"}
_HALF_FIRST = re.compile(
    rf"(?P<date>[^:]{{0,20}}?) ?(?P<half>{'|'.join(_HALVES)}) ?(?P<clock>\d{{1,2}}:[\d:.,]{{2,16}})"
)
# A day of the week before a date, or behind one in Chinese, Japanese and Korean: the date says it already.
_WEEKDAY = re.compile(
    r"(?:mon|tue|wed|thu|fri|sat|sun|mo|di|mi|do|fr|sa|so|lun|mar|mer|jeu|ven|sam|dim|mié|mie|jue|vie|sáb|sab|dom|gio)"
    r"[^\W\d_]{0,8}\.?,? (?=\d)",
    re.IGNORECASE,
)
_WEEKDAY_BEHIND = re.compile(
    r"(?<=[日일]) ?(?:[(（][月火水木金土日월화수목금토일][)）]|[月火水木金土日]曜日?|[월화수목금토일]요일"
    r"|(?:星期|周)[一二三四五六日天])"
)
_CLOCK_OF_SIGNS = re.compile(r"(\d{1,2})[时時시] ?(\d{2})[分분] ?(\d{2}(?:[.,]\d{1,9})?)[秒초]")
# The first letters of months' names, as loggers in English, German, French, Spanish, Italian, Portuguese and Dutch
# write them; four before three.
_MONTHS = {
    name: number
    for number, names in enumerate(
        (
            *("jan ene gen", "feb fév fev", "mar mär mrz mrt", "apr avr abr", "mai may mag mei", "jun juin giu"),
            *("jul juil lug", "aug aoû aou ago", "sep set", "oct okt ott out", "nov", "dec dez déc dic"),
        ),
        start=1,
    )
    for name in names.split()
}


def in_usual_form(text: str) -> str:
    """Return a date or time of day as loggers write it, where it is written in another way.

    Examples
    --------
    >>> [in_usual_form(text) for text in ("2026年11月20日 10:15:30", "Nov 20, 2026 1:15 PM", "20261120_101530", "x")]
    ['2026-11-20 10:15:30', '20-Nov-2026 1:15 PM', '2026-11-20 10:15:30', 'x']
    >>> in_usual_form("05:30.25"), in_usual_form("20261120T101530.5Z")
    ('0:05:30.25', '2026-11-20 10:15:30.5Z')
    >>> in_usual_form("2026. 11. 20. 오후 1:15:30")
    '2026-11-20 1:15:30 PM'
    >>> in_usual_form("Fr 20.11.2026 10:15:30"), in_usual_form("2026年11月20日(金) 10時15分30秒")
    ('20.11.2026 10:15:30', '2026-11-20 10:15:30')
    """
    if (match := _WEEKDAY.match(text)) is not None:
        date = in_usual_form(text[match.end() :])
        found = _LOCAL.fullmatch(date)
        if found is not None and found["first"] is not None:
            return date
    if not text.isascii():
        text = _CLOCK_OF_SIGNS.sub(r"\1:\2:\3", _WEEKDAY_BEHIND.sub("", text))
    if (match := _HALF_FIRST.fullmatch(text)) is not None:
        text = f"{match['date']} {match['clock']} {_HALVES[match['half']]}".strip()
    for pattern, template in _OTHER_WAYS:
        if (match := pattern.fullmatch(text)) is not None:
            return match.expand(template).strip()
    return text


def seconds_of_times(
    texts: Sequence[str], display_name: str, name: str, first_row: int, order: str = ""
) -> NDArray[np.float64]:
    """Return times in words as seconds since 1970-01-01 UTC (without a zone: taken as UTC).

    Besides ISO 8601 what loggers write in their country's way: ``20.11.2026 10:15:30,000`` (with points the day stands
    first everywhere), ``2026/11/20 10:15:30``, ``20-Nov-2026 10:15:30``, ``11/20/2026 10:15:30 AM``, and times of a day
    without a date, as seconds since midnight. Where the order of day and month is not known, it must follow from one
    of the dates.

    Parameters
    ----------
    texts : n times, such as ``2026-11-21T08:15:30.250Z`` or ``2026-11-21 08:15:30,25+01:00``.
    order : `DAY_FIRST` or `MONTH_FIRST`, where it is known; "" otherwise.

    Raises
    ------
    InputError
        At the first that is none, or that can be read in two ways.

    Examples
    --------
    >>> seconds_of_times(["1970-01-02T00:00:00.5Z", "1970-01-02 01:00:01+01:00"], "log.csv", "t", 1)
    array([86400.5, 86401. ])
    >>> seconds_of_times(["02.01.1970 00:00:00,500", "1/2/1970 12:00:01 AM"], "log.csv", "t", 1, "month-first")
    array([86400.5, 86401. ])
    """
    seconds = np.empty(len(texts))
    epoch = datetime(1970, 1, 1, tzinfo=UTC)
    follows: str | None = order or None  # looked for once, as that reads all of them
    for index, text in enumerate(texts):
        try:
            seconds_text, nanoseconds = _split_fraction(text.strip())
            moment = datetime.fromisoformat(seconds_text)
            elapsed = (moment if moment.tzinfo else moment.replace(tzinfo=UTC)) - epoch
            # Python reads a fraction behind a colon, or behind nothing, too
            seconds[index] = elapsed.days * 86400 + elapsed.seconds + elapsed.microseconds * 1e-6 + nanoseconds
        except ValueError:
            place = (display_name, f"row {first_row + index}, column {name}")
            if not follows and (follows is None or any(_numbers_of_date(text))):
                follows = _order_in(texts, text, *place)
            seconds[index] = _local_seconds(in_usual_form(text.strip()), follows, *place)
    return seconds


def unit_of_times(texts: Sequence[str]) -> str:
    """Return the unit of a time column that holds these times: ``iso8601``, or the order of day and month.

    Raises
    ------
    InputError
        They can be read in two ways.

    Examples
    --------
    >>> unit_of_times(["20.11.2026 10:15:30,000"]), unit_of_times(["2026-11-20"]), unit_of_times(["11/20/2026"])
    ('day-first', 'iso8601', 'month-first')
    """
    match = _LOCAL.fullmatch(in_usual_form(texts[0].strip()))
    if match is None or match["first"] is None or len(match["first"]) == 4 or not match["second"].isdigit():
        return "iso8601"
    return DAY_FIRST if match["mark"] == "." else _order_in(texts, texts[0], "", "")


def _local_seconds(text: str, order: str, display_name: str, place: str) -> float:
    """Return a time that is written in a country's way as seconds."""
    match = _LOCAL.fullmatch(text)
    if match is None or (match["first"] is None and match["second_of"] is None):
        raise _no_time(text, display_name, place)
    hour = int(match["hour"] or 0)
    if match["half"] is not None:
        hour = hour % 12 + 12 * (match["half"][0] in "Pp")
    clock = 3600 * hour + 60 * int(match["minute"] or 0) + int(match["second_of"] or 0)
    of_day = clock + float(f"0.{match['fraction'] or 0}") - _zone_of(match["zone"] or "")
    if match["first"] is None:
        return of_day
    first, second, third = match["first"], match["second"], match["third"]
    if not second.isdigit():
        month = _MONTHS.get(second.lower()[:4].rstrip("."), 0) or _MONTHS.get(second.lower()[:3], 0)
        year, day = (first, third) if len(first) == 4 else (third, first)
    elif len(first) == 4:
        year, month, day = first, int(second), third
    elif order == MONTH_FIRST and match["mark"] != ".":
        year, month, day = third, int(first), second
    else:
        year, month, day = third, int(second), first
    try:
        date = datetime(int(year) + 2000 * (len(year) < 3), month, int(day), tzinfo=UTC)
        if hour > 23:
            raise ValueError(text)
    except ValueError:
        raise _no_time(text, display_name, place) from None
    return (date - datetime(1970, 1, 1, tzinfo=UTC)).days * 86400 + of_day


def _zone_of(text: str) -> int:
    """Return how much later a zone's clock is than UTC's, s; 0 of a zone that is UTC, or none."""
    if text[:1] not in ("+", "-"):
        return 0
    return int(f"{text[0]}1") * (3600 * int(text[1:3]) + 60 * int(text[-2:]))


def _order_in(texts: Sequence[str], text: str, display_name: str, place: str) -> str:
    """Return in which order dates hold day and month, by one of them that has a day above 12.

    Raises
    ------
    InputError
        None has, or they contradict each other.
    """
    orders: set[str] = set()
    for own in texts:
        first, second = _numbers_of_date(own)
        orders |= {DAY_FIRST} if first > 12 else set()
        orders |= {MONTH_FIRST} if second > 12 else set()
    if len(orders) == 1:
        return orders.pop()
    day, month = _numbers_of_date(text)
    if not day:
        return ""
    reason = f"{text!r} is day {day} of month {month}, or day {month} of month {day}"
    mend = 'give the time column unit = "day-first" or unit = "month-first"'
    raise InputError.at(FaultCode.TIME_AMBIGUOUS, display_name, place, reason, mend)


def _numbers_of_date(text: str) -> tuple[int, int]:
    """Return the first two numbers of a date whose order they leave open; zeros of any other text."""
    match = _LOCAL.fullmatch(in_usual_form(text.strip()))
    if match is None or match["first"] is None or match["mark"] == "." or len(match["first"]) == 4:
        return 0, 0
    return (int(match["first"]), int(match["second"])) if match["second"].isdigit() else (0, 0)


def _no_time(text: str, display_name: str, place: str) -> InputError:
    mend = "write times like 2026-11-21T08:15:30.250Z, or give the column's unit as s, ms, us or ns"
    return InputError.at(FaultCode.NUMBER_INVALID, display_name, place, f"{text!r} is no date or time of day", mend)


def _split_fraction(text: str) -> tuple[str, float]:
    """Return the time without its decimal fraction, and that in seconds: any number of digits, point or comma."""
    if len(text) < 10 or not text[:4].isdigit():
        raise ValueError(text)
    for mark in ".,":
        head, separator, tail = text.partition(mark)
        if separator:
            digits = len(tail) - len(tail.lstrip("0123456789"))
            if not digits:
                raise ValueError(text)
            return head + tail[digits:], float("0." + tail[:digits])
    return text, 0.0


def seconds_of_timestamps(moments: NDArray[Any]) -> NDArray[np.float64]:
    """Return moments (n,) of any step as seconds; what is none as NaN, what a database calls infinite so.

    Examples
    --------
    >>> seconds_of_timestamps(np.array(["1970-01-02T00:00:00.5", "NaT"], dtype="datetime64[us]"))
    array([86400.5,     nan])
    """
    unit, count = np.datetime_data(moments.dtype)
    if unit not in _PER_SECOND:  # months and years are of no one length
        unit, count, moments = "s", 1, moments.astype("datetime64[s]")
    steps = moments.astype(np.int64)
    seconds = steps * float(count) / _PER_SECOND[unit]
    return np.where(np.isnat(moments), np.nan, np.where(np.abs(seconds) > _LARGEST, np.inf, seconds))
