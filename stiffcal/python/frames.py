"""Tables of pandas: made from results and from the store's tables, a unit at the end of every column's name.

pandas is a dependency and no extra: of some 600 MB that an installation takes it is 84, and a quarter of a second of a
processor that is paid when the first table is asked for; tables are what notebooks and scripts ask for first.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from stiffcal.documents import Number
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.identification.answers.fit_results import IdentifiedParameter
from stiffcal.quantities import factor_between, si_unit
from stiffcal.wording import place_label

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow as pa


def frame_of(values: Any, **options: Any) -> pd.DataFrame:
    """Return a table of pandas, as `pandas.DataFrame` makes it: pandas is imported here and nowhere else."""
    import pandas as pd

    return pd.DataFrame(values, **options)


def frame_of_table(table: pa.Table) -> pd.DataFrame:
    """Return a table of the store; what is written next to its columns is left out."""
    return frame_of({name: table.column(name).to_numpy(zero_copy_only=False) for name in table.column_names})


def frame_of_rows(rows: Iterable[Mapping[str, Any]], columns: Sequence[str] = ()) -> pd.DataFrame:
    """Return rows of plain values; `columns` are there even where no row is."""
    frame = frame_of([dict(row) for row in rows])
    return frame if len(frame.columns) else frame_of(None, columns=list(columns))


def parameters_frame(parameters: Iterable[IdentifiedParameter], shifted: Collection[str] | None = None) -> pd.DataFrame:
    """Return the parameters of a fit, one a row, by their full names; unknown numbers are NaN.

    Parameters
    ----------
    parameters : of the fit. shifted : names of values that adding what the model lacks moves beyond their intervals;
        None: not diagnosed.
    """
    rows = []
    for parameter in parameters:
        low, high = parameter.interval or (None, None)
        row: dict[str, str | float | bool | None] = {
            "parameter": parameter.name,
            "effect": parameter.effect,
            "place": place_label(parameter.where),
            "symbol": parameter.name.rpartition(".")[2],
            "value": _number(parameter.value),
            "std": _number(parameter.std),
            # The end of an interval is open where the value is at a limit of its range.
            "low_95": -math.inf if low is None and high is not None else _number(low),
            "high_95": math.inf if high is None and low is not None else _number(high),
            "unit": parameter.unit,
            "from_geometry": _number(parameter.from_geometry),
            "fixed": parameter.fixed,
            "identifiable": parameter.identifiable,
            "at_bound": parameter.at_bound,
            "shifted": None if shifted is None else parameter.name in shifted,
        }
        low, high = (parameter.stiffness_interval if parameter.is_compliance else None) or (None, None)
        row |= {
            "stiffness": _number(parameter.stiffness),
            "stiffness_std": _number(parameter.stiffness_std),
            "stiffness_low_95": _number(low),
            # The interval of a stiffness has no upper end where its compliance may be zero.
            "stiffness_high_95": math.inf if low is not None and high is None else _number(high),
            "stiffness_unit": parameter.quantity.reciprocal().si if parameter.is_compliance else "",
        }
        rows.append(row)
    return frame_of_rows(rows, ("parameter",)).set_index("parameter")


def _number(value: Number) -> float:
    return math.nan if value is None or not math.isfinite(value) else float(value)


def column_values(frame: pd.DataFrame, name: str) -> tuple[np.ndarray[Any, np.dtype[Any]], str]:
    """Return the values of a column that is named with or without its unit, or in another unit, and its label.

    Parameters
    ----------
    frame : its columns end in their unit, as ``load_N``.
    name : ``tau_4_Nm``, ``tau_4``, ``A1_rad``, ``A1_deg``.

    Raises
    ------
    InputError : there is no such column.

    Examples
    --------
    >>> import pandas
    >>> angles = pandas.DataFrame({"A1_rad": [0.0, math.pi]})
    >>> column_values(angles, "A1_deg"), column_values(angles, "A1")[1]
    ((array([  0., 180.]), 'A1 [deg]'), 'A1 [rad]')
    """
    stem, _, asked = name.rpartition("_")
    for column in map(str, frame.columns):
        own, _, unit = column.rpartition("_")
        if column == name or (own == name and si_unit(unit)):
            return frame[column].to_numpy(), _label(column)
        factor = factor_between(unit, asked) if own == stem else None
        if factor is not None:
            return frame[column].to_numpy() * factor, _label(name)
    known_names = ", ".join(map(str, frame.columns))
    raise InputError.at(
        FaultCode.COLUMN_MISSING, "residuals", name, "there is no such column", f"columns: {known_names}"
    )


def _label(column: str) -> str:
    """Return a column's name with its unit in brackets."""
    name, _, unit = column.rpartition("_")
    return f"{name} [{unit.replace('Nm', 'N·m')}]" if name and si_unit(unit) else column
