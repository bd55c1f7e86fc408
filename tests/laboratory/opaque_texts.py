"""Commands with their words taken away: `python -m tests.laboratory.opaque_texts [--opaque] FOLDER` prints their JSON.

With ``--opaque`` every module of stiffcal is compiled such that what is written as a sentence in its code (a text of
three words or more, or one with values put into it) becomes a token that says nothing: a digest of the text. Equal
texts have equal tokens, and nothing can be found in them, cut from them or asked of their beginning.
"""

from __future__ import annotations

import ast
import contextlib
import hashlib
import io
import json
import re
import sys
from collections.abc import Sequence
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder, SourceFileLoader
from types import ModuleType
from typing import Any

COMMANDS = ("ingest", "identify", "validate", "diagnose")
PREFIX = "opaque-"
_SENTENCE = re.compile(r"[^\W\d_]+[,;:]? [^\W\d_]+[,;:]? [^\W\d_]+")
_WORDS = re.compile(r"[^\W\d_]{2,}")


def opaque(text: str) -> str:
    """Return the token of a text."""
    return PREFIX + hashlib.sha256(text.encode("utf-8", "surrogateescape")).hexdigest()[:16]


class _Blinding(ast.NodeTransformer):
    """Puts every sentence of a module into a call of `opaque`; what is no sentence for people stays."""

    def _document(self, node: Any) -> Any:
        body = node.body
        kept = body[:1] if ast.get_docstring(node, clean=False) is not None else []
        node.body = kept + [self.visit(statement) for statement in body[len(kept) :]]
        return node

    visit_Module = _document

    def visit_ClassDef(self, node: ast.ClassDef) -> ast.AST:
        return self._document(node)  # type: ignore[no-any-return]

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        node.args.defaults = [self.visit(default) for default in node.args.defaults]
        return self._document(node)  # type: ignore[no-any-return]

    def visit_AnnAssign(self, node: ast.AnnAssign) -> ast.AST:
        if node.value is not None and not _is_alias(node.annotation):
            node.value = self.visit(node.value)
        return node

    def visit_Expr(self, node: ast.Expr) -> ast.AST:
        # A literal under a field is its description.
        return node if isinstance(node.value, ast.Constant) else self.generic_visit(node)

    def visit_Subscript(self, node: ast.Subscript) -> ast.AST:
        return node if isinstance(node.value, ast.Name) and node.value.id == "Literal" else self.generic_visit(node)

    def visit_Call(self, node: ast.Call) -> ast.AST:
        function = node.func
        if isinstance(function, ast.Attribute) and isinstance(function.value, ast.Name) and function.value.id == "re":
            return node
        return self.generic_visit(node)

    def visit_MatchValue(self, node: ast.MatchValue) -> ast.AST:
        return node

    def visit_FormattedValue(self, node: ast.FormattedValue) -> ast.AST:
        node.value = self.visit(node.value)
        return node

    def visit_JoinedStr(self, node: ast.JoinedStr) -> ast.AST:
        node.values = [value if isinstance(value, ast.Constant) else self.visit(value) for value in node.values]
        text = "".join(str(value.value) if isinstance(value, ast.Constant) else "0" for value in node.values)
        return _call(node) if " " in text and len(_WORDS.findall(text)) >= 2 else node

    def visit_Constant(self, node: ast.Constant) -> ast.AST:
        return _call(node) if isinstance(node.value, str) and _SENTENCE.search(node.value) else node


def _is_alias(annotation: ast.expr) -> bool:
    return isinstance(annotation, ast.Name) and annotation.id == "TypeAlias"


def _call(node: ast.expr) -> ast.expr:
    call = ast.Call(func=ast.Name(id="__opaque__", ctx=ast.Load()), args=[node], keywords=[])
    return ast.copy_location(call, node)


class _Loader(SourceFileLoader):
    def source_to_code(self, data: Any, path: Any, *, _optimize: int = -1) -> Any:  # type: ignore[override]
        tree = _Blinding().visit(ast.parse(data, path))
        return compile(ast.fix_missing_locations(tree), path, "exec", dont_inherit=True)

    def get_code(self, fullname: str) -> Any:
        path = self.get_filename(fullname)
        return self.source_to_code(self.get_data(path), path)  # never from a cache, nor into one

    def exec_module(self, module: ModuleType) -> None:
        vars(module)["__opaque__"] = opaque
        super().exec_module(module)


class _Finder(MetaPathFinder):
    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if fullname.partition(".")[0] != "stiffcal":
            return None
        spec = PathFinder.find_spec(fullname, path, target)
        if spec is not None and isinstance(spec.loader, SourceFileLoader):
            spec.loader = _Loader(spec.loader.name, spec.loader.path)
        return spec


def answers(folder: str) -> dict[str, Any]:
    """Return the JSON document of each command on a campaign."""
    from stiffcal.cli.app import main

    found: dict[str, Any] = {}
    for command in COMMANDS:
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            try:
                main([command, folder, "--json"])
            except SystemExit as end:
                found[f"{command} exit code"] = end.code
        found[command] = json.loads(out.getvalue())
    return found


if __name__ == "__main__":
    *options, campaign = sys.argv[1:]
    if options == ["--opaque"]:
        sys.meta_path.insert(0, _Finder())
    sys.stdout.write(json.dumps(answers(campaign)))
