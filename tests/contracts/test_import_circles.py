"""No module and no folder of a room imports itself through others, types included."""

from __future__ import annotations

import grimp
import pytest

KNOWN = frozenset({"stiffcal"})
"""What type checkers find in the package itself: the public names, which nothing below asks for when it runs."""


MEETING = frozenset({"stiffcal.mistakes"})
"""A mistake asks the table in which it is tried for springs or places; the table, for the mistake that it offers."""


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


def folders(imports: dict[str, set[str]]) -> dict[str, dict[str, set[str]]]:
    """Return by room which of its folders imports which; modules of a room itself belong to no folder."""
    found: dict[str, dict[str, set[str]]] = {}
    for module, imported in imports.items():
        for other in imported:
            one, two = module.split("."), other.split(".")
            k = next((k for k, (a, b) in enumerate(zip(one, two, strict=False)) if a != b), 0)
            if k > 1 and min(len(one), len(two)) > k + 1:
                room = found.setdefault(".".join(one[:k]), {})
                room.setdefault(one[k], set()).add(two[k])
                room.setdefault(two[k], set())
    return found


def test_folders_of_a_room_that_import_each_other_are_found() -> None:
    imports = {"s.r.a.x": {"s.r.b.y", "s.q"}, "s.r.b.z": {"s.r.a.x", "s.r.top"}, "s.r.top": {"s.r.a.x"}}
    assert folders(imports) == {"s.r": {"a": {"b"}, "b": {"a"}}}


@pytest.fixture(scope="module")
def imports() -> dict[str, set[str]]:
    graph = grimp.build_graph("stiffcal", cache_dir=None)
    modules = graph.modules - KNOWN
    return {module: graph.find_modules_directly_imported_by(module) & modules for module in modules}


def test_no_module_imports_itself_through_others(imports: dict[str, set[str]]) -> None:
    assert circles(imports) == []


def test_no_folder_of_a_room_imports_itself_through_others(imports: dict[str, set[str]]) -> None:
    found = {room: circles(inner) for room, inner in folders(imports).items()}
    assert {room: groups for room, groups in found.items() if groups and room not in MEETING} == {}
