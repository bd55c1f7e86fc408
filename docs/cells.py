"""Runs the Python cells of a page one after another in one process, as a notebook does; a script, not a module.

Standard input: a JSON list of sources. Standard output: a JSON list of what each printed; the value of an expression at
the end of a cell counts as printed.
"""

import ast
import contextlib
import io
import json
import sys


def run_cells(sources: list[str]) -> list[str]:
    """Return what each cell prints; all share one namespace."""
    names: dict[str, object] = {"__name__": "__main__"}
    return [_printed(source, names) for source in sources]


def _printed(source: str, names: dict[str, object]) -> str:
    body = ast.parse(source).body
    last = body.pop() if body and isinstance(body[-1], ast.Expr) else None
    with contextlib.redirect_stdout(io.StringIO()) as out:
        exec(compile(ast.Module(body, []), "<cell>", "exec"), names)
        if isinstance(last, ast.Expr):
            value = eval(compile(ast.Expression(last.value), "<cell>", "eval"), names)
            if value is not None:
                out.write(f"{value}\n")
    return out.getvalue()


if __name__ == "__main__":
    json.dump(run_cells(json.load(sys.stdin)), sys.stdout)
