"""What all signals of a source share: columns, units, the rows they keep."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Annotated, ClassVar, TypeAlias

from pydantic import AfterValidator

from stiffcal.campaign.signals.row_filter import RowCondition, parse_rows
from stiffcal.campaign.toml.typed import TomlTable
from stiffcal.quantities import Unit, unit


def _check_rows(text: str) -> str:
    parse_rows(text)
    return text


Rows: TypeAlias = Annotated[str, AfterValidator(_check_rows)]
"""A condition such as ``test_nr < 100``."""


class Signal(TomlTable, ABC):
    """What all signals share; each kind of signal names the columns it reads.

    Attributes
    ----------
    rows : keeps only the rows for which this holds, e.g. ``test_nr < 100``.
    """

    quantity_of: ClassVar[dict[str, str]] = {}
    """Key of `units` to the quantity it is about."""

    rows: Rows | None = None

    @property
    def row_conditions(self) -> tuple[RowCondition, ...]:
        """Return the conditions of `rows`, all of which must hold; empty where none is written."""
        return parse_rows(self.rows) if self.rows is not None else ()

    def unit_of(self, key: str) -> Unit:
        """Return the unit of one of the signal's quantities, as written in `units` or SI.

        Parameters
        ----------
        key : a key of `units`: position, rotation, force, moment, …

        Examples
        --------
        >>> from stiffcal.campaign.signals.signals import Deflection
        >>> Deflection(translation=("x", "y", "z"), body="tool").unit_of("translation").factor
        1.0
        """
        units: TomlTable = getattr(self, "units")  # noqa: B009  (every concrete signal has its own units table)
        return unit(getattr(units, key), self.quantity_of[key])

    def sigma_columns(self) -> dict[str, tuple[str, ...]]:
        """Return the columns that hold the uncertainty of each reading, by quantity; none where a number is stated."""
        sigma = getattr(self, "sigma", None)
        stated = {} if sigma is None else {name: getattr(sigma, name) for name in type(sigma).model_fields}
        return {name: columns for name, columns in stated.items() if isinstance(columns, tuple)}

    @abstractmethod
    def column_names(self) -> tuple[str, ...]:
        """Return every column the signal reads, in order."""

    @abstractmethod
    def columns_with_units(self) -> dict[str, Unit]:
        """Return each column and the unit its numbers are in; columns without a unit are left out."""
