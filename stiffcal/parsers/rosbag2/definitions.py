"""The definitions of messages that a bag brings with it, checked before a library generates code from them.

rosbags makes Python source of the names, types and sizes in a definition and executes it. Here only what the read topic
needs is kept, constants and default values are dropped, and every name has to be a plain identifier, every type known
or defined, every size a number.
"""

from __future__ import annotations

import keyword
import re
from collections.abc import Iterable, Sequence
from typing import Any

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode

NUMBERS = frozenset(
    {"bool", "byte", "char", "float32", "float64"} | {f"{u}int{n}" for u in ("", "u") for n in (8, 16, 32, 64)}
)
MEND = "record the topic again with a plain definition, or export it to CSV"
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*", re.ASCII)
_TYPE = re.compile(r"[A-Za-z][A-Za-z0-9_]*(/[A-Za-z][A-Za-z0-9_]*){1,8}", re.ASCII)

Types = dict[str, tuple[list[Any], list[tuple[str, Any]]]]
"""Message type to (constants, fields); a field is (name, description), as rosbags parses them."""


def parsed_types(connections: Iterable[Any], display_name: str) -> Types:
    """Return the types that the definitions of some connections hold, as the library parses them.

    Raises
    ------
    InputError
        The name of a type is none.
    """
    from rosbags.interfaces import MessageDefinitionFormat
    from rosbags.typesys import get_types_from_idl, get_types_from_msg

    types: Types = {}
    parsed: set[tuple[str, str]] = set()
    for connection in connections:
        text, kind = connection.msgdef.data, connection.msgdef.format
        if kind == MessageDefinitionFormat.NONE or (connection.msgtype, text) in parsed:
            continue
        parsed.add((connection.msgtype, text))
        if kind == MessageDefinitionFormat.MSG:
            _check_type_name(connection.msgtype, display_name)
            types.update(get_types_from_msg(text, connection.msgtype))
            continue
        for definition in _idl_parts(text):
            types.update(get_types_from_idl(definition))
    return types


def checked_types(types: Types, wanted: str, display_name: str) -> Types:
    """Return a message type with all that it is made of, without constants, every part of it checked.

    Parameters
    ----------
    types : as parsed.
    wanted : the topic's message type.
    display_name : the file, for messages.

    Raises
    ------
    InputError
        A name is no identifier, a type is unknown, a size is no number.
    """
    checked: Types = {}
    waiting = [wanted]
    while waiting:
        name = waiting.pop()
        if name in checked:
            continue
        if name not in types:
            raise _refused(display_name, name, "no definition of this type")
        checked[name] = ([], _checked_fields(name, types[name][1], display_name))
        waiting += _inner_types(checked[name][1])
    if len({name.replace("/", "__") for name in checked}) < len(checked):
        raise _refused(display_name, wanted, "two of its types have one name")
    return checked


def _checked_fields(type_name: str, fields: Sequence[tuple[str, Any]], display_name: str) -> list[tuple[str, Any]]:
    _check_type_name(type_name, display_name)
    names: set[str] = set()
    checked: list[tuple[str, Any]] = []
    for name, description in fields:
        python_name = f"{name}_" if keyword.iskeyword(name) else name
        if not _NAME.fullmatch(name) or python_name in names or "__" in (name[-2:], name[:2]):
            raise _refused(display_name, type_name, f"a field has the name {name!r}")
        names.add(python_name)
        checked.append((name, _checked_description(type_name, name, description, display_name)))
    return checked


def _checked_description(type_name: str, name: str, description: Any, display_name: str) -> tuple[Any, Any]:
    """Return a field's description made anew of plain values."""
    from rosbags.interfaces import Nodetype

    node, content = description
    if node == Nodetype.BASE:
        base = content[0]
        if not isinstance(base, str) or (base not in NUMBERS and base != "string"):
            raise _refused(display_name, type_name, f"field {name!r} is of type {base}, which is not read")
        return Nodetype.BASE, (base, 0)
    if node == Nodetype.NAME:
        _check_type_name(content, display_name)
        return Nodetype.NAME, content
    if node not in (Nodetype.ARRAY, Nodetype.SEQUENCE) or content[0][0] not in (Nodetype.BASE, Nodetype.NAME):
        raise _refused(display_name, type_name, f"field {name!r} is an array of arrays")
    size = content[1]
    if type(size) is not int or size < (1 if node == Nodetype.ARRAY else 0):
        raise _refused(display_name, type_name, f"field {name!r} is an array of {size!r} elements")
    return node, (_checked_description(type_name, name, content[0], display_name), size)


def _inner_types(fields: Sequence[tuple[str, Any]]) -> list[str]:
    from rosbags.interfaces import Nodetype

    inner = [content[0] if node in (Nodetype.ARRAY, Nodetype.SEQUENCE) else (node, content)
             for _, (node, content) in fields]  # fmt: skip
    return [content for node, content in inner if node == Nodetype.NAME]


def _check_type_name(name: object, display_name: str) -> None:
    if not isinstance(name, str) or not _TYPE.fullmatch(name):
        raise _refused(display_name, str(name), "not a name of a message type")


def _idl_parts(text: str) -> list[str]:
    """Return the definitions that stand in one text, each under a line of its own, as recorders write them."""
    line = "=" * 80 + "\n"
    if not text.startswith(f"{line}IDL: "):
        return [text]
    return [definition.split("\n", 1)[1] if "\n" in definition else "" for definition in text.split(line)[1:]]


def _refused(display_name: str, type_name: str, reason: str) -> InputError:
    return InputError.at(FaultCode.FILE_DAMAGED, display_name, f"message type {type_name}", reason, MEND)
