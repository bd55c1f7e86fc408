"""What the fields of an answer mean: the docstring after each field, else the first line of its type's."""

from __future__ import annotations

import ast
import inspect
import textwrap
import types
from dataclasses import is_dataclass
from functools import cache
from typing import Any, get_args, get_origin, get_type_hints

from stiffcal.documents import results_by_name


@cache
def meanings_of(kind: type) -> dict[str, str]:
    """Return field to meaning of a dataclass and of what it derives from; a field of which nothing is written: ""."""
    hints = get_type_hints(kind)
    written: dict[str, str] = {}
    for base in reversed([base for base in kind.__mro__ if is_dataclass(base)]):
        written |= _docstrings(base)
    own = {name: written.get(name) or _of_type(hint) for name, hint in hints.items()}
    return own | {name: _of_type(hint) for name, hint in results_by_name(kind).items()}


def _docstrings(kind: type) -> dict[str, str]:
    """Return field to the text that stands after it in the class."""
    (body,) = ast.parse(textwrap.dedent(inspect.getsource(kind))).body
    assert isinstance(body, ast.ClassDef)
    found = {}
    for field, text in zip(body.body, body.body[1:], strict=False):
        if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name):
            value = text.value if isinstance(text, ast.Expr) else None
            if isinstance(value, ast.Constant) and isinstance(value.value, str):
                found[field.target.id] = " ".join(value.value.split())
    return found


def _of_type(hint: Any) -> str:
    """Return the first line of the docstring of the dataclass that a type holds, "" where it holds none."""
    if isinstance(hint, type) and is_dataclass(hint):
        return (inspect.getdoc(hint) or "").partition("\n\n")[0]
    inner = get_args(hint) if get_origin(hint) is not None or isinstance(hint, types.UnionType) else ()
    return next((text for one in inner if (text := _of_type(one))), "")
