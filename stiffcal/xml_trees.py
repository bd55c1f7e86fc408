"""XML of files that anybody may have written, as a tree: no document type and so no entities, bounded in depth."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.limits import Limit

MOST_NESTED = 100
"""Elements in elements: a robot has five."""


class _Builder(ElementTree.TreeBuilder):
    """Builds the tree; refuses what is none of its kind before it takes the machine's memory."""

    def __init__(self, display_name: str, kind: str, most: Limit | None) -> None:
        super().__init__()
        self._display_name, self._kind, self._most = display_name, kind, most
        self._nodes = self._depth = 0

    def doctype(self, *_: str | None) -> None:
        """Refuse a document type: its entities can be as large as one likes, or name other files."""
        reason = f"{self._kind} must not have a document type"
        mend = "delete it and its entities"
        raise InputError.at(FaultCode.SYNTAX_INVALID, self._display_name, "<!DOCTYPE>", reason, mend)

    def start(self, tag: str, attributes: dict[str, str], /) -> ElementTree.Element:
        """Count an element in."""
        self._nodes += 1
        self._depth += 1
        if self._most is not None:
            self._most.check(self._nodes, self._display_name)
        if self._depth > MOST_NESTED:
            reason = f"more than {MOST_NESTED} nested elements"
            raise InputError.at(FaultCode.SIZE_EXCEEDED, self._display_name, f"<{tag}>", reason, "reduce the nesting")
        return super().start(tag, attributes)

    def end(self, tag: str, /) -> ElementTree.Element:
        """Leave an element."""
        self._depth -= 1
        return super().end(tag)


def tree_of(content: bytes, display_name: str, kind: str, most: Limit | None = None) -> ElementTree.Element:
    """Return the root of a document.

    Parameters
    ----------
    content : the file. kind : what it is to be, with its article, for faults.
    most : elements; None: as many as memory holds.

    Raises
    ------
    InputError
        It is no XML, has a document type, or more elements, or deeper ones, than are allowed.
    """
    try:
        parser = ElementTree.XMLParser(target=_Builder(display_name, kind, most))
        parser.feed(content)
        return parser.close()
    except ElementTree.ParseError as error:
        line, column = error.position
        place, reason = f"line {line}, column {column + 1}", f"not valid XML: {str(error).split(':')[0]}"
        raise InputError.at(FaultCode.SYNTAX_INVALID, display_name, place, reason, "correct that line") from None
    except (ValueError, LookupError) as error:  # of an encoding that Python does not know
        reason, mend = f"not valid XML: {error}", "save the file as UTF-8"
        raise InputError.at(FaultCode.SYNTAX_INVALID, display_name, "line 1", reason, mend) from None
