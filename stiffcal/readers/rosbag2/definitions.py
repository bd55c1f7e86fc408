"""The definitions of messages that a bag brings with it, checked before a library generates code from them.

rosbags makes Python source of the names, types and sizes in a definition and executes it. Here only what the read topic
needs is kept, constants and default values are dropped, and every name has to be a plain identifier, every type known,
every size within bounds. Its parser, too, is kept from texts on which it would not come to an end.
"""

from __future__ import annotations

import keyword
import re
from collections.abc import Iterable, Sequence
from typing import Any

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode

MOST_TEXT = 4 << 20  # bytes of one definition; the largest of ROS itself has below 100 kB
MOST_TEXT_IN_ALL = 64 << 20
MOST_TYPES = 5000
MOST_FIELDS = 5000  # of one message
MOST_NAME = 255
MOST_LEVELS = 64  # messages in messages
MOST_UNROLLED = 20_000  # elements of arrays of messages or words: the library writes lines of code for each
MOST_ELEMENTS = 1 << 30
NUMBERS = frozenset(
    {"bool", "byte", "char", "float32", "float64"} | {f"{u}int{n}" for u in ("", "u") for n in (8, 16, 32, 64)}
)
MEND = "record the topic again with a plain definition, or export it to CSV"
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*", re.ASCII)
_TYPE = re.compile(r"[A-Za-z][A-Za-z0-9_]*(/[A-Za-z][A-Za-z0-9_]*){1,8}", re.ASCII)
# What may stand in an IDL definition without being one: texts, letters, remarks.
_NO_CODE = re.compile(r'"(?:\\.|[^"\\])*+"|\'[^\']{0,2}\'|//[^\n]*|/[*](?:[^*]|[*](?!/))*+[*]/', re.DOTALL)
_ANNOTATED = re.compile(r"@\s*[A-Za-z_][A-Za-z0-9_:]*\s*\([^()]*\)", re.ASCII)  # @default (value=1)
_MOST_MODULES = 32

Types = dict[str, tuple[list[Any], list[tuple[str, Any]]]]
"""Message type to (constants, fields); a field is (name, description), as rosbags parses them."""


def parsed_types(connections: Iterable[Any], display_name: str) -> Types:
    """Return the types that the definitions of some connections hold, as the library parses them.

    Raises
    ------
    InputError
        A definition is too long, or one on which the library's parser would not come to an end.
    """
    from rosbags.interfaces import MessageDefinitionFormat
    from rosbags.typesys import get_types_from_idl, get_types_from_msg

    types: Types = {}
    parsed: set[tuple[str, str]] = set()
    total = 0
    for connection in connections:
        text, kind = connection.msgdef.data, connection.msgdef.format
        if kind == MessageDefinitionFormat.NONE or (connection.msgtype, text) in parsed:
            continue
        parsed.add((connection.msgtype, text))
        total += len(text)
        if len(text) > MOST_TEXT or total > MOST_TEXT_IN_ALL:
            raise _refused(display_name, connection.msgtype, f"the definition has {len(text) / 1e6:.1f} MB")
        if kind == MessageDefinitionFormat.MSG:
            _check_type_name(connection.msgtype, display_name)
            types.update(get_types_from_msg(text, connection.msgtype))
            continue
        for definition in _idl_parts(text):
            _check_idl(definition, connection.msgtype, display_name)
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
        A name is no identifier, a type is unknown or holds itself, a size is beyond all use.
    """
    checked: Types = {}
    levels: dict[str, int] = {}
    waiting: list[tuple[str, tuple[str, ...]]] = [(wanted, ())]
    while waiting:
        name, above = waiting.pop()
        if name in above:
            raise _refused(display_name, name, "the message contains itself")
        if len(above) > MOST_LEVELS:
            raise _refused(display_name, name, f"more than {MOST_LEVELS} nested messages")
        if levels.get(name, -1) >= len(above):
            continue
        levels[name] = len(above)
        if name not in checked:
            if name not in types:
                raise _refused(display_name, name, "no definition of this type")
            checked[name] = ([], _checked_fields(name, types[name][1], display_name))
            if len(checked) > MOST_TYPES:
                raise _refused(display_name, name, f"more than {MOST_TYPES} types")
        waiting += [(inner, (*above, name)) for inner in dict.fromkeys(_inner_types(checked[name][1]))]
    if len({name.replace("/", "__") for name in checked}) < len(checked):
        raise _refused(display_name, wanted, "two of its types have one name")
    return checked


def _checked_fields(type_name: str, fields: Sequence[tuple[str, Any]], display_name: str) -> list[tuple[str, Any]]:
    _check_type_name(type_name, display_name)
    if len(fields) > MOST_FIELDS:
        raise _refused(display_name, type_name, f"more than {MOST_FIELDS} fields")
    unrolled, names = 0, set()
    checked: list[tuple[str, Any]] = []
    for name, description in fields:
        python_name = f"{name}_" if keyword.iskeyword(name) else name
        if not _NAME.fullmatch(name) or len(name) > MOST_NAME or python_name in names or "__" in (name[-2:], name[:2]):
            raise _refused(display_name, type_name, f"a field has the name {name!r}")
        names.add(python_name)
        plain, count = _checked_description(type_name, name, description, display_name)
        unrolled += count
        if unrolled > MOST_UNROLLED:
            raise _refused(display_name, type_name, f"arrays of more than {MOST_UNROLLED} messages or words")
        checked.append((name, plain))
    return checked


def _checked_description(type_name: str, name: str, description: Any, display_name: str) -> tuple[Any, int]:
    """Return a field's description made anew of plain values, and how many elements are written out as code."""
    from rosbags.interfaces import Nodetype

    node, content = description
    if node == Nodetype.BASE:
        base = content[0]
        if not isinstance(base, str) or (base not in NUMBERS and base != "string"):
            raise _refused(display_name, type_name, f"field {name!r} is of type {base}, which is not read")
        return (Nodetype.BASE, (base, 0)), 0
    if node == Nodetype.NAME:
        _check_type_name(content, display_name)
        return (Nodetype.NAME, content), 0
    if node not in (Nodetype.ARRAY, Nodetype.SEQUENCE) or content[0][0] not in (Nodetype.BASE, Nodetype.NAME):
        raise _refused(display_name, type_name, f"field {name!r} is an array of arrays")
    inner, _ = _checked_description(type_name, name, content[0], display_name)
    size = content[1]
    fixed = node == Nodetype.ARRAY
    if type(size) is not int or not (1 if fixed else 0) <= size <= MOST_ELEMENTS:
        raise _refused(display_name, type_name, f"field {name!r} is an array of {size!r} elements")
    in_code = fixed and (inner[0] == Nodetype.NAME or inner[1][0] == "string")
    return (node, (inner, size)), size if in_code else 0


def _inner_types(fields: Sequence[tuple[str, Any]]) -> list[str]:
    from rosbags.interfaces import Nodetype

    inner = [content[0] if node in (Nodetype.ARRAY, Nodetype.SEQUENCE) else (node, content)
             for _, (node, content) in fields]  # fmt: skip
    return [content for node, content in inner if node == Nodetype.NAME]


def _check_type_name(name: object, display_name: str) -> None:
    if not isinstance(name, str) or not _TYPE.fullmatch(name) or len(name) > MOST_NAME:
        raise _refused(display_name, str(name), "not a name of a message type")


def _idl_parts(text: str) -> list[str]:
    """Return the definitions that stand in one text, each under a line of its own, as recorders write them."""
    line = "=" * 80 + "\n"
    if not text.startswith(f"{line}IDL: "):
        return [text]
    return [definition.split("\n", 1)[1] if "\n" in definition else "" for definition in text.split(line)[1:]]


def _check_idl(text: str, type_name: str, display_name: str) -> None:
    """Refuse what the library's parser takes for ever for, or computes beyond all memory."""
    code = _NO_CODE.sub(" ", text)
    # Each bracket around a value multiplies the parser's time by a hundred.
    if re.search(r"[()]", _ANNOTATED.sub(" ", code)):
        raise _refused(display_name, type_name, "the definition has values in brackets")
    level = deepest = 0
    for mark in re.findall(r"[{}]", code):
        level += 1 if mark == "{" else -1
        deepest = max(deepest, level)
    if level != 0 or deepest > _MOST_MODULES:
        raise _refused(display_name, type_name, "brackets are nested too deeply, or not closed")
    if re.search(r"<<|[*]", code):
        raise _refused(display_name, type_name, "the definition computes its sizes (* or <<)")


def _refused(display_name: str, type_name: str, reason: str) -> InputError:
    return InputError.at(FaultCode.FILE_DAMAGED, display_name, f"message type {type_name}", reason, MEND)
