"""MATLAB's MAT files: version 5 to 7, and 7.3, which is HDF5 inside."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Any, Protocol

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.log_columns import Options, damaged_file_errors, nearest_name
from stiffcal.parsers.mat_classes import PLAIN_CLASSES
from stiffcal.parsers.named_columns import NamedColumn, OpenColumns
from stiffcal.parsers.signatures import begins_like_hdf5

OF_TABLES = {"table": "writetable", "timetable": "writetimetable"}
"""What writes a table of MATLAB as text."""


def in_matlab(kind: str, name: str) -> str:
    """Return the line that exports a variable which only MATLAB can read.

    Examples
    --------
    >>> in_matlab("timetable", "log")
    "in MATLAB: writetimetable(log, 'log.csv')"
    """
    if kind in OF_TABLES:
        return f"in MATLAB: {OF_TABLES[kind]}({name}, 'log.csv')"
    return "in MATLAB: save what is in it as vectors of numbers or cells of words"


@contextmanager
def open_log(path: Path, options: Options, display_name: str) -> Iterator[OpenColumns]:
    """Open a log.

    Raises
    ------
    InputError
        For a damaged file, one that leads to others, a variable that is not there or that holds no vectors.
    """
    variable = str(options.get("variable") or "")
    place = f"variable {variable}" if variable else ""
    mend = "copy it again from its origin, or save it again"
    with damaged_file_errors("MAT file", display_name, mend), _open_tree(path, display_name) as tree:
        yield OpenColumns(_columns(tree, options, display_name), display_name, place, _unreadable(tree))


def tables(path: Path, display_name: str) -> list[Options]:
    """Return the options that choose each struct, or the file itself, that holds vectors; errors as of `open_log`."""
    with damaged_file_errors("MAT file", display_name), _open_tree(path, display_name) as tree:
        paths = list(_paths_with_vectors(tree, tree.top, "", _MOST_LEVELS))
    return [{"variable": own} if own else {} for own in paths] if len(paths) > 1 else [{}]


# Of structs in structs.
_MOST_LEVELS = 4


def _paths_with_vectors(tree: Tree, item: Any, path: str, levels: int) -> Iterator[str]:
    members = tree.members(item) or {}
    lengths = [vector.n_rows for member in members.values() for vector in tree.vectors(member).values()]
    if any(n_rows > 1 for n_rows in lengths):
        yield path
    for name, member in members.items() if levels else ():
        yield from _paths_with_vectors(tree, member, f"{path}.{name}".strip("."), levels - 1)


def _open_tree(path: Path, display_name: str) -> AbstractContextManager[Tree]:
    if begins_like_hdf5(path):
        from stiffcal.parsers import mat73

        return mat73.open_tree(path, display_name)
    from stiffcal.parsers import mat5

    return mat5.open_tree(path)


class Tree(Protocol):
    """What a file holds, by name: variables, and structs with fields."""

    top: Any
    """The file itself, whose members are its variables."""

    def members(self, item: Any) -> dict[str, Any] | None:
        """Return the fields of a struct, or the variables of the file; None of anything else."""

    def kind(self, item: Any) -> str:
        """Return MATLAB's name of an item's class."""

    def vectors(self, item: Any) -> dict[str, NamedColumn]:
        """Return the columns of a matrix by number from 1, of a vector by the empty name."""


def _columns(tree: Tree, options: Options, display_name: str) -> dict[str, NamedColumn]:
    """Return the columns that the options point at."""
    variable, names = str(options.get("variable") or ""), options.get("columns")
    item, path = tree.top, ""
    for step in variable.split(".") if variable else []:
        inside_item = tree.members(item)
        if inside_item is None or step not in inside_item:
            inside = f" in {path!r}" if path else ""
            mend = nearest_name(step, list(inside_item or ()))
            raise InputError.at(
                FaultCode.LOG_PART_MISSING, display_name, "mat.variable", f"no variable {step!r}{inside}", mend
            )
        item, path = inside_item[step], f"{path}.{step}".strip(".")
    members = tree.members(item)
    if members is not None and not variable and len(members) == 1 and not names:
        (only,) = members
        inner = tree.members(members[only])
        members, path = (inner, only) if inner is not None else (members, path)
    if members is None:
        return _matrix_columns(tree, item, names, path, display_name)
    if names:
        raise InputError.at(
            FaultCode.OPTION_CONFLICT,
            display_name,
            "mat.columns",
            "column names apply to a matrix only",
            "give the matrix: mat.variable",
        )
    columns = {}
    for name, member in members.items():
        for column, vector in tree.vectors(member).items():
            columns[name if not column else f"{name}[{column}]"] = vector
    if not columns:
        opaque = [name for name, member in members.items() if tree.kind(member) not in PLAIN_CLASSES]
        if opaque:
            reason = f"{opaque[0]!r} is a MATLAB {tree.kind(members[opaque[0]])}, which only MATLAB can read"
            mend = in_matlab(tree.kind(members[opaque[0]]), opaque[0])
            raise InputError.at(FaultCode.CONTENT_UNSUPPORTED, display_name, f"variable {opaque[0]}", reason, mend)
        listed = ", ".join(repr(name) for name in list(members)[:12]) or "nothing"
        raise InputError.at(
            FaultCode.FILE_EMPTY,
            display_name,
            "",
            "contains no vectors",
            f"give a struct or matrix: mat.variable; the file has {listed}",
        )
    return columns


def _unreadable(tree: Tree) -> str:
    """Return a sentence on the first variable that only MATLAB can read, "" where there is none."""
    for name, member in (tree.members(tree.top) or {}).items():
        if (kind := tree.kind(member)) not in PLAIN_CLASSES:
            return f"if it is in the {kind} {name!r}: {in_matlab(kind, name)}"
    return ""


def _matrix_columns(tree: Tree, item: Any, names: object, path: str, display_name: str) -> dict[str, NamedColumn]:
    if tree.kind(item) not in PLAIN_CLASSES:
        reason = f"it is a MATLAB {tree.kind(item)}, which only MATLAB can read"
        mend = in_matlab(tree.kind(item), path)
        raise InputError.at(FaultCode.CONTENT_UNSUPPORTED, display_name, f"variable {path}", reason, mend)
    vectors = tree.vectors(item)
    if not isinstance(names, list) or len(names) != len(vectors):
        counts = f"{len(names)} names for " if isinstance(names, list) else "its columns have no names: "
        mend = 'write mat.columns = ["Fx", "Fy", "Fz"], say, one name per column'
        raise InputError.at(
            FaultCode.SHAPE_MISMATCH, display_name, f"variable {path}", f"{counts}{len(vectors)} columns", mend
        )
    return {str(name): vector for name, vector in zip(names, vectors.values(), strict=True)}
