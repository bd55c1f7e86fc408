"""The reference page of `stiffcal.effects_api`: every name that an effect of one's own may import, one line each."""

from __future__ import annotations

import ast
import inspect
from itertools import pairwise

from docs.markdown import cell, code, table
from stiffcal import effects_api
from stiffcal.effects_api import StateOrder

WITHOUT_DOCSTRING = {
    "BASE_NODE": "Node number of the base, 0.",
    **{f"T{axis}": f"Component: translation along {axis.lower()} of the node's axes, m; of a wrench force, N."
       for axis in "XYZ"},
    **{f"R{axis}": f"Component: rotation about {axis.lower()} of the node's axes, rad; of a wrench moment, N·m."
       for axis in "XYZ"},
    "Floats": "Type: numpy array of float64.",
    "PlaceKind": 'Type: "joints", "links", "pairs", "frames" or "setup".',
    "Values": "Type: mapping from symbol to value, SI.",
}  # fmt: skip
"""Constants and types, which carry no docstring of their own."""


def effects_api_page() -> str:
    """Every public name of `stiffcal.effects_api`, then the members of an effect of each kind."""
    rows = [(code(name), cell(line_of(name))) for name in effects_api.__all__]
    return "\n".join(
        [
            "# Names for your own effects\n",
            "What a plugin may import from `stiffcal.effects_api`; [Write your own effect](../../how-to/own-effect.md)",
            "shows their use.\n",
            table(("name", "what it is"), rows),
            "## What an effect consists of\n",
            "```{eval-rst}",
            *(
                f".. autoclass:: stiffcal.effects_api.{kind}\n   :members:\n"
                for kind in ("Effect", "Law", "Geometry", "Instrument", "Motion")
            ),
            ".. autoclass:: stiffcal.effects_api.ParameterSpec",
            "   :members:\n",
            ".. autoclass:: stiffcal.effects_api.NodeLoads",
            "   :members:",
            "```\n",
            "## What a law with a memory knows of the states\n",
            f"Members of `StateOrder`: {line_of('StateOrder')}\n",
            table(
                ("member", "what it is"), [(code(name), cell(text)) for name, text in documented_members(StateOrder)]
            ),
        ]
    )


def documented_members(described: type) -> list[tuple[str, str]]:
    """Return the public fields and properties of a class with their docstrings, in the order of its source."""
    (body,) = ast.parse(inspect.getsource(described)).body
    members: list[tuple[str, str]] = []
    for statement, following in pairwise([*body.body, ast.Pass()]) if isinstance(body, ast.ClassDef) else ():
        if isinstance(statement, ast.AnnAssign) and isinstance(statement.target, ast.Name):
            name, text = statement.target.id, _string_of(following)
        elif isinstance(statement, ast.FunctionDef) and _is_property(statement):
            name, text = statement.name, ast.get_docstring(statement)
        else:
            continue
        if not name.startswith("_"):
            members.append((name, (text or "").partition("\n\n")[0].replace("``", "")))
    return members


def _string_of(statement: ast.stmt) -> str | None:
    if isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant):
        return inspect.cleandoc(str(statement.value.value))
    return None


def _is_property(function: ast.FunctionDef) -> bool:
    return any(isinstance(mark, ast.Name) and mark.id == "property" for mark in function.decorator_list)


def line_of(name: str) -> str:
    """Return one line on a public name: the first of its docstring, without reStructuredText's marks."""
    text = WITHOUT_DOCSTRING.get(name)
    if text is None:
        first = (inspect.getdoc(getattr(effects_api, name)) or "").partition("\n\n")[0]
        text = first.replace("``", "")
    return text
