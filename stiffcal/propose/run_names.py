"""Names of files that several devices wrote: what in them is the run's name, and the pattern that finds it.

``pose01_force.csv`` and ``pose01_tracker.csv``, ``F_01.dat`` and ``L_01.dat``, ``P3/force.csv``: within the files of
one device something differs, and the same differs within those of the others. That is the run. What differs in one
device alone, as the time at which a file was begun, does not count.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from stiffcal.campaign.manifest.file_patterns import ANY, RUN
from stiffcal.natural_order import NameKey, natural_key

_TOKENS = re.compile(r"[0-9]+|[^\W\d_]+|[\W_]")


def tokens_of(path: str) -> tuple[str, ...]:
    """Return numbers, words and the signs between them.

    Examples
    --------
    >>> tokens_of("raw/pose01_Kräfte.csv")
    ('raw', '/', 'pose', '01', '_', 'Kräfte', '.', 'csv')
    """
    return tuple(_TOKENS.findall(path))


def shape_of(path: str, *, words: bool = False) -> tuple[str, ...]:
    """Return a path with its numbers left out, and with `words` its words too: what names of one make share.

    Examples
    --------
    >>> shape_of("raw/pose01_force.csv") == shape_of("raw/pose2_force.csv")
    True
    """
    return tuple("#" if token.isdigit() else "@" if words and token.isalpha() else token for token in tokens_of(path))


def _is_sign(token: str) -> bool:
    return not token.isalnum()


@dataclass(frozen=True)
class _Span:
    """Consecutive tokens, `start` to `stop`, of all names of a device."""

    start: int
    stop: int


class _Names:
    """The names of a device's files that share their shape, as a table of tokens."""

    def __init__(self, files: Sequence[str]) -> None:
        shapes = Counter(shape_of(file, words=True) for file in files)
        most = max(shapes.values())
        shape = next(shape for shape in shapes if shapes[shape] == most)
        self.files = [file for file in files if shape_of(file, words=True) == shape]
        self.tokens = [tokens_of(file) for file in self.files]
        self.width = len(shape)
        self.varies = [len({row[k] for row in self.tokens}) > 1 for k in range(self.width)]
        slashes = [k for k in range(self.width) if self.tokens[0][k] == "/"]
        self.parts = [
            range(start + 1, stop) for start, stop in zip([-1, *slashes], [*slashes, self.width], strict=True)
        ]
        dots = [k for k in self.parts[-1] if self.tokens[0][k] == "."]
        self.ending = dots[-1] if dots else self.width

    def part_of(self, position: int) -> range:
        """Return the positions of the folder or file name that a token is in; of a file without its ending."""
        part = next(part for part in self.parts if position in part)
        return range(part.start, min(part.stop, self.ending))

    def spans(self) -> Iterator[_Span]:
        """Yield every stretch, within one folder's or the file's name, that is different in most files.

        Two files of one run are no reason to look for another name: they are named when the runs are gathered.
        """
        for part in self.parts:
            varying = [k for k in part if self.varies[k] and k < self.ending]
            for n, start in enumerate(varying):
                for stop in varying[n:]:
                    span = _Span(start, stop + 1)
                    if 2 * len(self.keys(span)) > len(self.files):
                        yield span

    def text(self, row: int, span: _Span) -> str:
        """Return what stands in a stretch of one name."""
        return "".join(self.tokens[row][span.start : span.stop])

    def keys(self, span: _Span) -> set[NameKey]:
        """Return what stands in a stretch, as names of runs are compared."""
        return {natural_key(self.text(row, span)) for row in range(len(self.files))}

    def common(self, position: int) -> str | None:
        """Return a token that all names have, None where they differ."""
        return None if self.varies[position] else self.tokens[0][position]

    def pattern(self, span: _Span) -> str:
        """Return the pattern of the device's files, with the run's name in a stretch."""
        templates = {self._template(row, span) for row in range(len(self.files))}
        if len(templates) == 1:
            return templates.pop()
        pieces: list[str] = []
        free = self._free(span)
        for k, token in enumerate(self.tokens[0]):
            piece = RUN if span.start <= k < span.stop else ANY if k in free else token
            if piece in (RUN, ANY) and pieces and pieces[-1] == piece:
                continue
            pieces.append(piece)
        return "".join(pieces)

    def _template(self, row: int, span: _Span) -> str:
        """Return one name with the run's name left out wherever it stands as a whole."""
        name = self.tokens[row][span.start : span.stop]
        pieces, k, tokens = [], 0, self.tokens[row]
        while k < len(tokens):
            if tokens[k : k + len(name)] == name and (k == span.start or k < self.ending):
                pieces.append(RUN)
                k += len(name)
            else:
                pieces.append(tokens[k])
                k += 1
        return "".join(pieces)

    def _free(self, span: _Span) -> set[int]:
        """Return the positions that do not count: what varies, with the numbers next to it, as of a date."""
        free: set[int] = set()
        for k in range(self.width):
            if not self.varies[k] or span.start <= k < span.stop:
                continue
            free.add(k)
            part = self.parts[next(n for n, part in enumerate(self.parts) if k in part)]
            for step in (-1, 1):
                reached, position = k, k + step
                while position in part and not span.start <= position < span.stop and position < self.ending:
                    token = self.tokens[0][position]
                    if token.isdigit():
                        reached = position
                    elif (
                        len(token) > 1 and not self.varies[position]
                    ):  # one letter may stand in a date: 20261120T101530
                        break
                    position += step
                free.update(range(min(k, reached), max(k, reached) + 1))
        return free


def patterns_of_devices(devices: Mapping[str, Sequence[str]], place: str = "") -> dict[str, str]:
    """Return the pattern of each device's files; devices whose files share no names with the others' have none.

    Parameters
    ----------
    devices : the files of each, by any name; paths with forward slashes.
    place : the folder that all of them lie in, which is no run's name.

    Examples
    --------
    >>> patterns_of_devices({"a": ["raw/pose1_F.csv", "raw/pose2_F.csv"], "b": ["raw/pose2_T.txt", "raw/pose1_T.txt"]})
    {'a': 'raw/{run}_F.csv', 'b': 'raw/{run}_T.txt'}
    >>> files = {"a": ["1_101530_F_P1.d", "1_111530_F_P2.d"], "b": ["1_101502_P1.d", "1_111502_P2.d"]}
    >>> patterns_of_devices(files)
    {'a': '*_F_{run}.d', 'b': '*_{run}.d'}
    """
    names = {device: _Names(files) for device, files in devices.items() if files}
    if names and all(len(own.files) == 1 for own in names.values()):
        spans = _shared_by_single_files(names, len(place.split("/")) if place else 0)
    else:
        spans = _extended(names, _agreeing(names))
    return {device: names[device].pattern(span) for device, span in spans.items()}


def _agreeing(names: Mapping[str, _Names]) -> dict[str, _Span]:
    """Return for each device the stretch of its names in which most agree with those of the others."""
    candidates = {
        device: [(span, own.keys(span)) for span in own.spans()] for device, own in names.items() if len(own.files) > 1
    }
    best: dict[str, _Span] = {}
    highest = (0, 0)
    for anchor in candidates:
        for span, keys in candidates[anchor]:
            chosen, agreeing, length = {anchor: span}, len(keys), span.stop - span.start
            for device, others in candidates.items():
                if device == anchor or not others:
                    continue
                other, shared = max(
                    ((other, len(keys & own)) for other, own in others),
                    key=lambda found: (found[1], found[0].stop - found[0].start),
                )
                if shared:
                    chosen[device] = other
                    agreeing += shared
                    length += other.stop - other.start
            if (agreeing, length) > highest:
                best, highest = chosen, (agreeing, length)
    return best


def _extended(names: Mapping[str, _Names], spans: Mapping[str, _Span]) -> dict[str, _Span]:
    """Return the stretches with the text around them that stands in the names of all devices: pose01 for 01."""
    spans = dict(spans)
    for step in (-1, 1):
        while True:
            nexts = {
                device: span.start - 1 if step < 0 else span.stop
                for device, span in spans.items()
                if (span.start - 1 if step < 0 else span.stop) in names[device].part_of(span.start)
            }
            tokens = {names[device].common(position) for device, position in nexts.items()}
            if not spans or len(nexts) < len(spans) or len(tokens) > 1 or None in tokens:
                break
            spans = {
                device: _Span(span.start - 1, span.stop) if step < 0 else _Span(span.start, span.stop + 1)
                for device, span in spans.items()
            }
    return {device: _trimmed(names[device], span) for device, span in spans.items()}


def _trimmed(own: _Names, span: _Span) -> _Span:
    """Return a stretch without signs at its ends."""
    start, stop = span.start, span.stop
    while start < stop - 1 and _is_sign(own.tokens[0][start]):
        start += 1
    while stop > start + 1 and _is_sign(own.tokens[0][stop - 1]):
        stop -= 1
    return _Span(start, stop)


def _shared_by_single_files(names: Mapping[str, _Names], above: int) -> dict[str, _Span]:
    """Return the longest text that one file of each device has in its name or a folder's; none where there is none.

    The first folders, `above` of them, are no run's name.
    """
    if len(names) < 2:
        return {}
    texts = {device: own.tokens[0] for device, own in names.items()}
    first = next(iter(names.values()))
    best: dict[str, _Span] = {}
    longest = 0
    for part in first.parts[above:]:
        for start in part:
            for stop in range(start + 1, min(part.stop, first.ending) + 1):
                wanted = first.tokens[0][start:stop]
                if _is_sign(wanted[0]) or _is_sign(wanted[-1]) or len("".join(wanted)) <= longest:
                    continue
                spans = {device: _find(texts[device], wanted, names[device]) for device in names}
                found = {device: span for device, span in spans.items() if span is not None}
                if len(found) == len(names):
                    best, longest = found, len("".join(wanted))
    return best


def _find(tokens: Sequence[str], wanted: Sequence[str], own: _Names) -> _Span | None:
    for start in range(min(len(tokens), own.ending) - len(wanted) + 1):
        if tuple(tokens[start : start + len(wanted)]) == tuple(wanted):
            return _Span(start, start + len(wanted))
    return None
