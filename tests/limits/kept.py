"""What was found of numbers that were varied, kept in a file so that a call that was ended goes on."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from tests.limits.numbers import PACKAGE
from tests.limits.page import Moved


def digest(files: Iterable[Path]) -> str:
    """Return one of all that stands in files."""
    whole = hashlib.sha256()
    for file in files:
        whole.update(file.read_bytes())
    return whole.hexdigest()


@dataclass(frozen=True)
class Kept:
    """A file with a line for each log, named by its contents, and for each number that was varied with it."""

    path: Path
    """Of the file, whose first line is of which code it is."""

    @classmethod
    def of_this_code(cls, path: Path) -> Kept:
        """Return the file; it begins anew where the code is another one than it was found with."""
        own = [Path(__file__).with_name(name) for name in ("numbers.py", "varying.py")]
        head = json.dumps({"code": digest([*sorted(PACKAGE.rglob("*.py")), *own])}) + "\n"
        path.parent.mkdir(parents=True, exist_ok=True)
        text = path.read_text(encoding="utf-8") if path.exists() else ""
        whole = text if text.startswith(head) else head
        # the last line may have been cut off
        path.write_text(whole[: whole.rindex("\n") + 1], encoding="utf-8")
        return cls(path)

    def asked(self, log: str) -> tuple[frozenset[str], frozenset[str]] | None:
        """Return the numbers that one log asks for when it is reduced, and others when it is identified; or None."""
        own = (line for line in self._lines() if line["log"] == log and "reduced" in line)
        return next(((frozenset(line["reduced"]), frozenset(line["identified"])) for line in own), None)

    def moved(self, log: str) -> dict[str, tuple[Moved, Moved]]:
        """Return by place how answers of one log move, smaller and larger."""
        own = [line for line in self._lines() if line["log"] == log and "place" in line]
        return {line["place"]: (Moved(**line["less"]), Moved(**line["more"])) for line in own}

    def keep_asked(self, log: str, reduced: frozenset[str], identified: frozenset[str], seconds: float) -> None:
        """Add the numbers that one log asks for, as `asked` returns them, and the processor time that this took."""
        self._add({"log": log, "reduced": sorted(reduced), "identified": sorted(identified), "seconds": seconds})

    def keep_moved(self, log: str, place: str, moved: tuple[Moved, Moved], seconds: float) -> None:
        """Add how answers of one log move with one number, and the processor time that this took."""
        less, more = (asdict(one) for one in moved)
        self._add({"log": log, "place": place, "less": less, "more": more, "seconds": seconds})

    def seconds(self) -> float:
        """Return the processor time that all lines took."""
        return float(sum(line["seconds"] for line in self._lines()))

    def _add(self, line: dict[str, Any]) -> None:
        with self.path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(line) + "\n")

    def _lines(self) -> Iterator[dict[str, Any]]:
        """Give what was kept."""
        yield from map(json.loads, self.path.read_text(encoding="utf-8").splitlines()[1:])
