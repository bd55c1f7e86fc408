"""Ways of spoiling a valid input: its bytes, its lines and cells, its document."""

from __future__ import annotations

import copy
import random
import string
from collections.abc import Callable
from contextlib import suppress
from typing import Any

NASTY_WORDS = (
    "", " ", "-", ".", "nan", "NaN", "inf", "-inf", "1e999", "-1e-999", "9" * 400, "1_000", "0x10", "1,5", "1;5", "١٢",
    "１２", "\u202e12", "\ufeff", "\x00", "\x1a", "\x7f", '"', '""', "'", '"a\nb"', "\r", "\n", "\t", "#", "null",
    "None", "True", "2026-11-21T08:15:30Z", "9999-12-31T23:59:59.999999999Z", "2026-13-45T99:00:00", "ä" * 3,
    "😀", "A1",
    "t", "Fx", "mm", "[mm]", "%s%n", "{0}", "$(rm)", "../../x", "1e308", "-0", "+1", "1e", "1E+5",
    "x" * 5000, "0x" + "f" * 5000,
)  # fmt: skip
NASTY_NUMBERS: tuple[Any, ...] = (
    0, -1, 1, 2, 7, 1e-320, -1e308, 1e308, float("nan"), float("inf"), float("-inf"), 10**6, 2**31, 2**63, -(2**63),
    10**30, 10**400, 0.1, 90.0, 1e-12, 1e12,
)  # fmt: skip
NASTY_TEXTS = (
    "", " ", "base", "flange", "tracker", "tool", "target", "all", "A1..A6", "A6..A1", "A1..A999999999", "x0..x9999999",
    "../x", "/etc/passwd", "raw/x.csv", "C:/x", "\\\\host\\x", "raw/\x00", "mm", "m", "kN", "N*m", "iso8601", "swing",
    "Größe [mm]", "😀", "\u202e", "x" * 3000, "a\nb", "1-2", "5-5", "9999999-1", "test < 1", "a == ", "csv", "hdf5", "s3://x/y",
    "file:///etc", "joint-compliance", "link-beam", "huber", "dh", "modified-dh", "schema", "\ud7ff", "\x7f",
)  # fmt: skip
INTEGERS = (
    b"\xff" * 4,
    b"\xff" * 8,
    b"\x7f" + b"\xff" * 7,
    b"\xff" * 3 + b"\x7f",
    bytes(8),
    b"\x01" + bytes(7),
    b"\x80" * 5,
)


def spoilt_bytes(chance: random.Random, data: bytes) -> bytes:
    """Flip, cut, double, insert or overwrite pieces of a file."""
    found = bytearray(data)
    for _ in range(chance.choice((1, 1, 1, 2, 3, 8))):
        if not found:
            return bytes(found)
        at = chance.randrange(len(found))
        length = min(chance.choice((1, 1, 2, 4, 8, 64, 512)), len(found) - at)
        match chance.randrange(9):
            case 0:
                found[at] ^= 1 << chance.randrange(8)
            case 1:
                found[at] = chance.randrange(256)
            case 2:
                del found[at:]
            case 3:
                del found[at : at + length]
            case 4:
                found[at:at] = found[at : at + length]
            case 5:
                found[at:at] = chance.randbytes(length)
            case 6:
                number = chance.choice(INTEGERS)
                found[at : at + len(number)] = number
            case 7:
                found[at : at + length] = bytes(length)
            case _:
                other = chance.randrange(len(found))
                found[at : at + length] = found[other : other + length]
    return bytes(found)


def spoilt_lines(chance: random.Random, text: str, delimiter: str = ",") -> bytes:
    """Spoil cells, lines, the header or the encoding of a table of text."""
    lines = text.split("\n")
    for _ in range(chance.choice((1, 1, 2, 4))):
        at = chance.randrange(len(lines))
        line = min(chance.choice((0, 0, 1, at, at)), len(lines) - 1)
        cells = lines[line].split(delimiter)
        cell = chance.randrange(len(cells))
        match chance.randrange(12):
            case 0 | 1 | 2:
                cells[cell] = chance.choice(NASTY_WORDS)
            case 3:
                cells[cell] += chance.choice(NASTY_WORDS)
            case 4:
                cells.insert(cell, chance.choice(cells))
            case 5:
                del cells[cell]
            case 6:
                cells = cells * chance.choice((2, 50))
            case 7:
                cells = [chance.choice(";\t| ").join(cells)]
            case 8:
                cells = [*cells, *[""] * chance.choice((1, 3))]
            case 9:
                cells[cell] = chance.choice(string.printable) * chance.choice((1, 10, 200_000))
        lines[line] = delimiter.join(cells)
        match chance.randrange(8):
            case 0:
                lines.insert(at, lines[0])
            case 1:
                del lines[at]
            case 2:
                lines.insert(at, "")
            case 3:
                lines[at:at] = lines[at : at + 2] * 3
        if not lines:
            lines = [""]
    ending = chance.choice(("\n",) * 6 + ("\r\n", "\r", "\n\r"))
    coding = chance.choice(("utf-8",) * 8 + ("utf-16", "utf-8-sig", "latin-1", "utf-32"))
    return ending.join(lines).encode(coding, "replace")


def places_of(document: Any, here: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Return the way to every value inside a document."""
    entries = (
        document.items() if isinstance(document, dict) else enumerate(document) if isinstance(document, list) else ()
    )
    found = [here] if here else []
    for key, value in entries:
        found += places_of(value, (*here, key))
    return found


def _nasty_value(chance: random.Random, depth: int = 0) -> Any:
    kinds: list[Callable[[], Any]] = [
        lambda: chance.choice(NASTY_NUMBERS),
        lambda: chance.choice(NASTY_NUMBERS),
        lambda: chance.choice(NASTY_TEXTS),
        lambda: chance.choice(NASTY_TEXTS),
        lambda: chance.random() < 0.5,
        list,
        dict,
    ]
    if depth < 3:
        kinds += [
            lambda: [_nasty_value(chance, depth + 1) for _ in range(chance.choice((1, 2, 3, 6, 200)))],
            lambda: {chance.choice(("xyz_m", "file", "columns", "id", "")): _nasty_value(chance, depth + 1)},
        ]
    return chance.choice(kinds)()


def spoilt_document(chance: random.Random, document: dict[str, Any]) -> dict[str, Any]:
    """Put values of a wrong kind or size to random places, remove keys, exchange values, double entries."""
    changed = copy.deepcopy(document)
    for _ in range(chance.choice((1, 1, 2, 3))):
        places = places_of(changed)
        if not places:
            break
        *outer, last = chance.choice(places)
        here: Any = changed
        for part in outer:
            here = here[part]
        match chance.randrange(8):
            case 0:
                del here[last]
            case 1 if isinstance(here[last], list) and here[last]:
                here[last] = here[last] * chance.choice((2, 40))
            case 2 if isinstance(here, dict):
                here[chance.choice(NASTY_TEXTS)] = here.pop(last)
            case 3:
                *others, end = chance.choice(places)
                there: Any = document
                try:
                    for part in others:
                        there = there[part]
                    here[last] = copy.deepcopy(there[end])
                except (KeyError, IndexError, TypeError):
                    pass
            case 4 if isinstance(here[last], int | float):
                with suppress(OverflowError):  # a whole number of 400 digits
                    here[last] = here[last] * chance.choice((-1, 0, 1e3, 1e-9, 1e300))
            case _:
                here[last] = _nasty_value(chance)
    return changed


def toml_of(value: Any) -> str:
    """Write a value as TOML on one line (tables in line)."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{_quoted(str(key))} = {toml_of(held)}" for key, held in value.items()) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(toml_of(held) for held in value) + "]"
    if isinstance(value, float):
        return repr(value)
    return str(value) if isinstance(value, int) else _quoted(str(value))


def _quoted(text: str) -> str:
    return '"' + "".join(c if c.isprintable() and c not in '"\\' else f"\\u{ord(c):04x}" for c in text) + '"'


def toml_text(document: dict[str, Any]) -> str:
    """Write a document as TOML, a line for each of its own keys."""
    return "".join(f"{_quoted(key)} = {toml_of(value)}\n" for key, value in document.items())


def spoilt_toml(chance: random.Random, text: str, document: dict[str, Any]) -> bytes:
    """Spoil a TOML file: mostly its document, else its lines, its bytes, or with what no one writes by hand."""
    kind = chance.randrange(20)
    if kind < 13:
        return toml_text(spoilt_document(chance, document)).encode()
    if kind < 15:
        return spoilt_lines(chance, text, " ")
    if kind < 18:
        return spoilt_bytes(chance, text.encode())
    deep = chance.choice((50, 500, 20_000))
    match chance.randrange(6):
        case 0:
            extra = "x = " + "[" * deep + "]" * chance.choice((deep, 1))
        case 1:
            extra = "x = " + "{ a = " * deep + "1" + " }" * deep
        case 2:
            extra = "[" + ".".join(["a"] * deep) + "]\nb = 1"
        case 3:
            extra = "x = " + "9" * chance.choice((400, 5000))
        case 4:
            extra = 'x = "' + "y" * 2_000_000 + '"'
        case _:
            extra = "\n".join(f"k{n} = {n}" for n in range(deep))
    return (extra + "\n" + text if chance.random() < 0.5 else text + "\n" + extra).encode()
