"""Which columns of a table are an orientation: a quaternion, a rotation matrix, a homogeneous transformation."""

from __future__ import annotations

import re

import numpy as np

from stiffcal.campaign.columns.column_names import component_of
from stiffcal.campaign.columns.column_words import NUMBERED_QUATERNION, QUATERNIONS, words_of
from stiffcal.propose.column_roles import Role
from stiffcal.propose.table_sniffing import SniffedColumn


def quaternion_of(columns: tuple[SniffedColumn, ...], plain: dict[str, str]) -> Role | None:
    """Find an orientation: four columns w, x, y, z of one name, or numbered, whose squares add up to 1."""
    by_name = {plain[column.header]: column for column in columns}
    for known in QUATERNIONS:
        if all(name in by_name for name in known):
            return Role(tuple(by_name[name] for name in known))
    # of ABB the components are q1 to q4
    numbered = (_NUMBERED,) if "q4" not in by_name else () if {"q0", "q5"} & by_name.keys() else (_FROM_ONE,)
    for names in (*(tuple(f"{name[:-1]}{c}" for c in "wxyz") for name in by_name if name[-1:] == "w"), *numbered):
        if all(own in by_name for own in names):
            role = Role(tuple(by_name[own] for own in names), body=_body(by_name[names[1]].name))
            if _is_unit_length(role):
                return role
    return None


def _body(name: str) -> str:
    """Return the words of a component's name before what it is a component of."""
    words = words_of(name)[0]
    return " ".join(words[:-2])


def _is_unit_length(role: Role) -> bool:
    """Return whether the squares of four columns add up to 1 in each row, to the digits that are written.

    Values that are not known yet, NaN, do not speak against it.
    """
    n_rows = {len(column.values) for column in role.columns}
    if len(n_rows) != 1 or not next(iter(n_rows)):
        return False
    rows = zip(*(column.values for column in role.columns), strict=True)
    return not any(abs(sum(value * value for value in row) - 1.0) >= _UNIT_LENGTH for row in rows)


_NUMBERED: tuple[str, ...] = NUMBERED_QUATERNION
_FROM_ONE = ("q1", "q2", "q3", "q4")
_UNIT_LENGTH = 0.1  # four numbers of one decimal, each off by half a digit
_MATRIX = re.compile(r"r(?:ot|otation|matrix)?([0-3])([0-3])")
_TRANSFORM = re.compile(r"([a-z]{1,16})([0-4])([0-4])")
_NUMBERED_ELEMENT = re.compile(r"([A-Za-z][A-Za-z_ .]{0,60}?)[ _.]?\[?(\d{1,2})\]?")
_ORTHONORMAL = 0.02  # elements of two decimals, each off by half a digit
# Qualisys, as IMUSim's reader takes its 6D exports: Rot[0], [1], [2] are the first column.
_BY_COLUMN = re.compile(r"(.{0,200})Rot\[0\]")


def matrix_of(columns: list[SniffedColumn], plain: dict[str, str]) -> Role | None:
    """Find nine elements of a rotation matrix, numbered from 0 or 1; those of `_BY_COLUMN` count down its columns."""
    by_header = {column.header: column for column in columns if column.values}
    for header in by_header:
        if (match := _BY_COLUMN.fullmatch(header)) is not None:
            names = [f"{match[1]}Rot[{row + 3 * k}]" for row in range(3) for k in range(3)]
            if all(name in by_header for name in names):
                place = component_of(f"{match[1]}X", None)
                return Role(tuple(by_header[name] for name in names), body=place.body if place is not None else "")
    found = {
        (match[1], match[2]): column
        for column in columns
        if column.values and (match := _MATRIX.fullmatch(plain[column.header])) is not None
    }
    for numbers in ("012", "123"):
        elements = [(row, column) for row in numbers for column in numbers]
        if all(element in found for element in elements):
            return Role(tuple(found[element] for element in elements))
    return None


def transformation_of(columns: list[SniffedColumn], plain: dict[str, str]) -> tuple[Role, Role] | None:
    """Find twelve elements of a homogeneous transformation: its rotation and its position.

    Its elements are numbered from 0 or 1, by row and column (T03) or all sixteen one after another (M3).

    The position stands in the last column, or in the last row of one that is written for rows as vectors.
    """
    by_stem: dict[str, dict[str, SniffedColumn]] = {}
    numbered: dict[str, dict[int, SniffedColumn]] = {}
    for column in columns:
        if column.values and (match := _TRANSFORM.fullmatch(plain[column.header])) is not None:
            by_stem.setdefault(match[1], {})[match[2] + match[3]] = column
        if column.values and (match := _NUMBERED_ELEMENT.fullmatch(column.header)) is not None:
            numbered.setdefault(match[1], {})[int(match[2])] = column
    for stem, own in numbered.items():
        if sorted(own) in (list(range(16)), list(range(1, 17))):
            by_stem[f"{stem} "] = {f"{k // 4}{k % 4}": own[number] for k, number in enumerate(sorted(own))}
    for elements in by_stem.values():
        for numbers in ("0123", "1234"):
            three, last = numbers[:3], numbers[3]
            for is_row in (False, True):
                place = [last + k if is_row else k + last for k in three]
                turned = [column + row if is_row else row + column for row in three for column in three]
                if not all(name in elements for name in (*place, *turned)):
                    continue
                rotation, position = (Role(tuple(elements[name] for name in own)) for own in (turned, place))
                if any(any(column.values) for column in position.columns) and _is_rotation(rotation):
                    return rotation, position
    return None


def _is_rotation(role: Role) -> bool:
    """Return whether the rows of nine elements are orthogonal unit vectors, to the digits that are written."""
    if len({len(column.values) for column in role.columns}) != 1:
        return False
    matrices = np.array([column.values for column in role.columns]).T.reshape(-1, 3, 3)
    return bool(np.all(np.abs(matrices @ matrices.transpose(0, 2, 1) - np.eye(3)) < _ORTHONORMAL))
