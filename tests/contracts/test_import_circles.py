"""No module imports itself through others, types included."""

from __future__ import annotations

import grimp
import pytest

KNOWN = frozenset({"stiffcal"})
"""What type checkers find in the package itself: the public names, which nothing below asks for when it runs."""


def circles(imports: dict[str, set[str]]) -> list[list[str]]:
    """Return groups of modules of which each imports all others, over some way (Kosaraju)."""
    order: list[str] = []
    visited: set[str] = set()
    for begin in imports:
        stack = [(begin, iter(sorted(imports[begin])))] if begin not in visited else []
        visited.add(begin)
        while stack:
            module, others = stack[-1]
            further = next((other for other in others if other not in visited), None)
            if further is None:
                order.append(stack.pop()[0])
            else:
                visited.add(further)
                stack.append((further, iter(sorted(imports[further]))))
    importers: dict[str, set[str]] = {module: set() for module in imports}
    for module, imported in imports.items():
        for other in imported:
            importers[other].add(module)
    left, found = set(imports), []
    for begin in reversed(order):
        group, waiting = [], [begin] if begin in left else []
        left.discard(begin)
        while waiting:
            group.append(waiting.pop())
            waiting += importers[group[-1]] & left
            left -= importers[group[-1]]
        found += [sorted(group)] if len(group) > 1 else []
    return found


@pytest.mark.parametrize(
    ("imports", "found"),
    [
        ({"a": {"b"}, "b": {"c"}, "c": set()}, []),
        ({"a": {"b"}, "b": {"c"}, "c": {"b"}, "d": {"a"}}, [["b", "c"]]),
        ({"a": {"b", "c"}, "b": {"a"}, "c": {"d"}, "d": {"c", "a"}}, [["a", "b", "c", "d"]]),
    ],
)
def test_circles_are_found(imports: dict[str, set[str]], found: list[list[str]]) -> None:
    assert circles(imports) == found


def test_no_module_imports_itself_through_others() -> None:
    graph = grimp.build_graph("stiffcal", cache_dir=None)
    modules = graph.modules - KNOWN
    assert circles({module: graph.find_modules_directly_imported_by(module) & modules for module in modules}) == []
