"""The types that manifest, robot file and model file are made of: strict tables, vectors, columns, units.

Why own validators: pydantic's text for a wrong value is written for programmers. `WrongValueError` carries a
reason and a mend in the lab's words; `stiffcal.campaign.toml.explain` turns everything into faults with file and key
path.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from typing import Annotated, Any, ClassVar, TypeAlias

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, WithJsonSchema

from stiffcal.fault_codes import FaultCode
from stiffcal.quantities import UnknownUnitError, unit, unit_names

MOST_COLUMNS = 1000  # of one signal: a robot has a handful of joints, the widest tables of rods a hundred


class WrongValueError(ValueError):
    """A wrong value in a user's file: the fault's `code`, and in words its `reason` and `mend`."""

    def __init__(self, reason: str, mend: str, code: FaultCode = FaultCode.VALUE_INVALID) -> None:
        super().__init__(f"{reason}; {mend}")
        self.code = code
        self.reason = reason
        self.mend = mend


class TomlTable(BaseModel):
    """A table of a user's file: keys that are not known are refused, values are not converted.

    `aliases` names keys that people use for another one, for the message only.
    """

    # defer_build: what a command does not read is not built, and a table that lies in another one is not built twice
    model_config = ConfigDict(
        extra="forbid", frozen=True, strict=True, allow_inf_nan=False, populate_by_name=True, defer_build=True
    )

    look_alikes: ClassVar[dict[str, str]] = {}

    def options_under(self, name: str) -> dict[str, object]:
        """Return what is written in the table that lies under a key of this one, empty where there is none."""
        options = getattr(self, name, None) if name in type(self).model_fields else None
        return dict(options.model_dump(exclude_unset=True)) if isinstance(options, TomlTable) else {}


def at_most(count: int, mend: str) -> AfterValidator:
    """Make a check that a list has at most `count` entries: more than any robot needs, and few enough to work on."""

    def check(values: Sequence[Any]) -> Sequence[Any]:
        if len(values) > count:
            raise WrongValueError(f"found {len(values)} entries, more than {count}", mend)
        return values

    return AfterValidator(check)


def _numbers(value: object, count: int) -> tuple[float, ...]:
    if not isinstance(value, list | tuple) or not all(
        isinstance(item, int | float) and not isinstance(item, bool) for item in value
    ):
        raise WrongValueError(f"found {value!r}", f"write {count} numbers in square brackets")
    if not value:
        raise WrongValueError("not filled in yet", f"write {count} numbers")
    if len(value) != count:
        raise WrongValueError(f"found {len(value)} numbers", f"write {count}")
    return tuple(float(item) for item in value)


def vector_of(count: int) -> Callable[[object], tuple[float, ...]]:
    """Make a check that a value is so many finite numbers."""

    def check(value: object) -> tuple[float, ...]:
        return _numbers(value, count)

    return check


def array_schema(count: int) -> dict[str, Any]:
    """Return the JSON schema of so many numbers."""
    return {"type": "array", "items": {"type": "number"}, "minItems": count, "maxItems": count}


def _matrix3(value: object) -> tuple[tuple[float, ...], ...]:
    if not isinstance(value, list | tuple) or len(value) != 3:
        raise WrongValueError("a rotation matrix has three rows", "write [[…], […], […]]")
    return tuple(_numbers(row, 3) for row in value)


Vector3: TypeAlias = Annotated[
    tuple[float, float, float], BeforeValidator(vector_of(3)), WithJsonSchema(array_schema(3))
]
"""Three numbers."""

Quaternion: TypeAlias = Annotated[
    tuple[float, float, float, float], BeforeValidator(vector_of(4)), WithJsonSchema(array_schema(4))
]
"""Four numbers w, x, y, z; that its length is one is checked with the frames."""

Interval: TypeAlias = Annotated[tuple[float, float], BeforeValidator(vector_of(2)), WithJsonSchema(array_schema(2))]
"""Two numbers, low and high."""

Pair: TypeAlias = Interval
"""Two numbers, in no order."""

Matrix3: TypeAlias = Annotated[
    tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]],
    BeforeValidator(_matrix3),
    WithJsonSchema({"type": "array", "items": array_schema(3), "minItems": 3, "maxItems": 3}),
]
"""Three rows of three numbers; orthogonality is checked with the frames."""


_DIGITS = "0123456789"
_MOST_DIGITS = 30  # of a number in a column's name


def expand_columns(value: object) -> tuple[str, ...]:
    """Turn ``"A1..A6"``, one column's name, or a list of both into column names.

    Raises
    ------
    WrongValueError
        The range is not one (other stem, falling numbers), a name is empty or stands there twice.

    Examples
    --------
    >>> expand_columns("A1..A3")
    ('A1', 'A2', 'A3')
    >>> expand_columns(["s", "ids08..ids10", "q[0]..q[1]"])
    ('s', 'ids08', 'ids09', 'ids10', 'q[0]', 'q[1]')
    """
    items = [value] if isinstance(value, str) else value
    if not isinstance(items, list | tuple) or not all(isinstance(item, str) for item in items):
        raise WrongValueError(f"found {value!r}", 'write column names: ["A1", "A2"] or "A1..A6"')
    names: list[str] = []
    for item in items:
        names.extend(_expand_range(str(item)))
        if len(names) > MOST_COLUMNS:
            raise WrongValueError(f"more than {MOST_COLUMNS} columns", "list only those that are needed")
    if not names or "" in names:
        raise WrongValueError("a column without a name", "write the column name as in the header of the file")
    twice = sorted(name for name, times in Counter(names).items() if times > 1)
    if twice:
        raise WrongValueError(f'column "{twice[0]}" is given twice', "list each column once")
    return tuple(names)


_CLOSING = ("]", ")", "}")
"""What may stand behind the number of a column: q[0]..q[5]."""


def _expand_range(text: str) -> list[str]:
    if ".." not in text:
        return [text]
    begin, _, end = text.rpartition("..")
    tail = next((mark for mark in _CLOSING if begin.endswith(mark) and end.endswith(mark)), "")
    begin, end = begin.removesuffix(tail), end.removesuffix(tail)
    stem, stem_of_end = begin.rstrip(_DIGITS), end.rstrip(_DIGITS)
    first, last = begin[len(stem) :], end[len(stem_of_end) :]
    if not (
        1 <= len(first) <= _MOST_DIGITS
        and 1 <= len(last) <= _MOST_DIGITS
        and stem_of_end in ("", stem)
        and int(first) <= int(last)
    ):
        raise WrongValueError(f'"{text}" is not a range of columns', 'write a range like "A1..A6"')
    if int(last) - int(first) >= MOST_COLUMNS:
        raise WrongValueError(f'"{text}" names more than {MOST_COLUMNS} columns', "correct the range's end")
    width = len(first) if first.startswith("0") else 0
    return [f"{stem}{k:0{width}d}{tail}" for k in range(int(first), int(last) + 1)]


def columns_of_count(*counts: int) -> Callable[[tuple[str, ...]], tuple[str, ...]]:
    """Make a check that the number of columns is one of `counts`."""

    def check(names: tuple[str, ...]) -> tuple[str, ...]:
        if len(names) not in counts:
            wanted = " or ".join(str(count) for count in counts)
            raise WrongValueError(
                f"found {len(names)} column{'s' if len(names) != 1 else ''}", f"give {wanted} columns"
            )
        return names

    return check


_COLUMNS_SCHEMA: dict[str, Any] = {
    "anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}, "minItems": 1}]
}

Columns: TypeAlias = Annotated[tuple[str, ...], BeforeValidator(expand_columns), WithJsonSchema(_COLUMNS_SCHEMA)]
"""One or more column names; a range such as ``"A1..A6"`` is written out."""

Columns3: TypeAlias = Annotated[Columns, AfterValidator(columns_of_count(3)), WithJsonSchema(_COLUMNS_SCHEMA)]
Columns4: TypeAlias = Annotated[Columns, AfterValidator(columns_of_count(4)), WithJsonSchema(_COLUMNS_SCHEMA)]
Columns9: TypeAlias = Annotated[Columns, AfterValidator(columns_of_count(9)), WithJsonSchema(_COLUMNS_SCHEMA)]

Positive: TypeAlias = Annotated[float, Field(gt=0)]
NotNegative: TypeAlias = Annotated[float, Field(ge=0)]
Counting: TypeAlias = Annotated[int, Field(ge=1)]
Name: TypeAlias = Annotated[str, Field(min_length=1)]


def _known_unit(quantity: str) -> Callable[[str], str]:
    def check(name: str) -> str:
        try:
            return unit(name, quantity).name
        except UnknownUnitError as error:
            raise WrongValueError(error.reason, error.mend, FaultCode.UNIT_UNKNOWN) from error

    return check


def _unit_schema(quantity: str) -> dict[str, Any]:
    return {"type": "string", "examples": list(unit_names(quantity))}


LengthUnit: TypeAlias = Annotated[str, AfterValidator(_known_unit("length")), WithJsonSchema(_unit_schema("length"))]
AngleUnit: TypeAlias = Annotated[str, AfterValidator(_known_unit("angle")), WithJsonSchema(_unit_schema("angle"))]
ForceUnit: TypeAlias = Annotated[str, AfterValidator(_known_unit("force")), WithJsonSchema(_unit_schema("force"))]
MomentUnit: TypeAlias = Annotated[str, AfterValidator(_known_unit("moment")), WithJsonSchema(_unit_schema("moment"))]
TimeUnit: TypeAlias = Annotated[str, AfterValidator(_known_unit("time")), WithJsonSchema(_unit_schema("time"))]
MassUnit: TypeAlias = Annotated[str, AfterValidator(_known_unit("mass")), WithJsonSchema(_unit_schema("mass"))]
CurrentUnit: TypeAlias = Annotated[str, AfterValidator(_known_unit("current")), WithJsonSchema(_unit_schema("current"))]


def _rod_unit(name: str) -> str:
    try:
        return unit(name, "strain").name
    except UnknownUnitError:
        return _known_unit("length")(name)


RodUnit: TypeAlias = Annotated[
    str,
    AfterValidator(_rod_unit),
    WithJsonSchema({"type": "string", "examples": [*unit_names("length"), *unit_names("strain")]}),
]
"""The unit of rods' length changes: a length, or a strain, of each rod's length."""


def _joint_unit(name: object) -> str:
    for quantity in ("angle", "length"):
        try:
            return unit(str(name), quantity).name
        except UnknownUnitError:
            continue
    return _known_unit("angle")(str(name))


def _joint_units(value: object) -> str | tuple[str, ...]:
    return tuple(map(_joint_unit, value)) if isinstance(value, list | tuple) else _joint_unit(value)


_JOINT_UNIT_SCHEMA: dict[str, Any] = {"type": "string", "examples": [*unit_names("angle"), *unit_names("length")]}
JointUnit: TypeAlias = Annotated[
    str | tuple[str, ...],
    BeforeValidator(_joint_units),
    WithJsonSchema({"anyOf": [_JOINT_UNIT_SCHEMA, {"type": "array", "items": _JOINT_UNIT_SCHEMA, "minItems": 1}]}),
]
"""The unit of joint positions, or one for each joint: prismatic joints have a length."""
VelocityUnit: TypeAlias = Annotated[
    str, AfterValidator(_known_unit("velocity")), WithJsonSchema(_unit_schema("velocity"))
]
TemperatureUnit: TypeAlias = Annotated[
    str, AfterValidator(_known_unit("temperature")), WithJsonSchema(_unit_schema("temperature"))
]


class Placement(TomlTable):
    """A rigid transform: place `xyz_m` and at most one of the three ways to write a rotation.

    Attributes
    ----------
    xyz_m : m, in the parent's axes.
    quaternion_wxyz : unit quaternion, scalar first.
    rpy_deg : turns about the parent's fixed x, y and z axes, in this order.
    matrix : parent_from_frame rotation.
    """

    xyz_m: Vector3 = (0.0, 0.0, 0.0)
    quaternion_wxyz: Quaternion | None = None
    rpy_deg: Vector3 | None = None
    matrix: Matrix3 | None = None

    look_alikes: ClassVar[dict[str, str]] = {
        "xyz": "xyz_m", "xyz_mm": "xyz_m", "rpy": "rpy_deg", "quaternion": "quaternion_wxyz", "rotation": "rpy_deg",
        "quaternion_xyzw": "quaternion_wxyz", "position": "xyz_m",
    }  # fmt: skip

    def rotations(self) -> tuple[str, ...]:
        """Return the keys under which a rotation is written."""
        keys = ("quaternion_wxyz", "rpy_deg", "matrix")
        return tuple(key for key in keys if getattr(self, key) is not None)

    def rotation_mistake(self) -> tuple[str, WrongValueError] | None:
        """Return the key and what is wrong with the rotation, or None."""
        written = self.rotations()
        if len(written) > 1:
            return written[1], WrongValueError(
                f"the rotation is given twice, as {' and '.join(written)}", "keep one of them"
            )
        if self.quaternion_wxyz is not None:
            length = sum(component * component for component in self.quaternion_wxyz) ** 0.5
            if abs(length - 1.0) > ROTATION_TOLERANCE:
                return "quaternion_wxyz", WrongValueError(
                    f"the quaternion's length is {length:.6g}, not 1", "write a unit quaternion, scalar w first"
                )
        if self.matrix is not None:
            return _matrix_mistake(self.matrix)
        return None


# Numbers printed with four digits still pass; anything worse is a slip of the pen. What passes is made exact.
ROTATION_TOLERANCE = 1e-3


def _matrix_mistake(matrix: Sequence[Sequence[float]]) -> tuple[str, WrongValueError] | None:
    """Check that the rows of a 3×3 matrix are orthogonal unit vectors and right-handed."""
    worst = 0.0
    for i, first in enumerate(matrix):
        for j, second in enumerate(matrix):
            product = sum(a * b for a, b in zip(first, second, strict=True))
            worst = max(worst, abs(product - (1.0 if i == j else 0.0)))
    if worst > ROTATION_TOLERANCE:
        return "matrix", WrongValueError(
            f"the rotation matrix is not orthogonal: R Rᵀ differs from the identity by {worst:.3g}",
            "correct its rows, or write the rotation as quaternion_wxyz or rpy_deg",
        )
    (a, b, c), (d, e, f), (g, h, i_) = matrix
    if a * (e * i_ - f * h) - b * (d * i_ - f * g) + c * (d * h - e * g) < 0:
        return "matrix", WrongValueError(
            "the rotation matrix is a mirror image (determinant −1)", "correct the sign of an axis"
        )
    return None
