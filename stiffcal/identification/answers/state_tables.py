"""What was measured and the model's prediction of it, state by state, as a table of the store."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats
from stiffcal.identification.readings.row_layout import LENGTH, MOTOR, ROTATION
from stiffcal.measurements.columns import Values, table_of, values_of

if TYPE_CHECKING:
    import pyarrow as pa

    from stiffcal.identification.readings.observations import Observations
    from stiffcal.measurements.load_states import LoadStates


MOTOR_ANGLE = "motor{}_angle_rad"
COMPONENTS = ("dx_m", "dy_m", "dz_m", "rx_rad", "ry_rad", "rz_rad")


def observed_table(
    states: LoadStates,
    data: Observations,
    predicted: Floats,
    residual: Floats,
    of_states: Mapping[str, NDArray[Any]] | None = None,
) -> pa.Table:
    """Return one row per load state that was judged.

    Columns: ``state`` (index into the load states, from 0), ``run``, ``row``, and per target and component
    ``<target>_dx_m_measured``, ``…_predicted``, ``…_residual`` (displacement since the run's reference, base axes, m
    and rad), for each gauge ``<gauge>_displacement_m_…`` and each rod ``<rod>_length_m_…`` (changes likewise), for
    each drive of clamped runs ``motor<k>_angle_rad_…`` (at the joint's side).
    Measured is predicted plus residual: each run's free offset is taken out. NaN where not measured.

    Parameters
    ----------
    states : all load states of the campaign.
    data : the observations, m components of n states.
    predicted, residual : (m, n) m and rad.
    of_states : further columns, (all load states,) each, which stand after ``row``.
    """
    columns: dict[str, Values] = {
        "state": data.index,
        "run": [states.runs[number].name for number in data.run],
        "row": states.row[data.index],
        **{name: values[data.index] for name, values in (of_states or {}).items()},
    }
    for name, place, read in _named_rows(states, data):
        measured_mask = data.measured_mask[place] & read
        for kind, values in (
            ("measured", predicted[place] + residual[place]),
            ("predicted", predicted[place]),
            ("residual", residual[place]),
        ):
            columns[f"{name}_{kind}"] = np.where(measured_mask, values, np.nan)
    return table_of(columns)


def residual_columns(states: LoadStates, data: Observations, residual: Floats) -> dict[str, Floats]:
    """Return the residual columns of `observed_table` alone, by name, (n,) each.

    Parameters
    ----------
    states : all load states of the campaign.
    data : the observations, m components of n states.
    residual : (m, n) m and rad.
    """
    return {
        f"{name}_residual": np.where(data.measured_mask[place] & read, residual[place], np.nan)
        for name, place, read in _named_rows(states, data)
    }


def _named_rows(states: LoadStates, data: Observations) -> Iterator[tuple[str, int, NDArray[np.bool_]]]:
    """Give the name, the row and the (n,) states of each instrument's readings; gauges may share a row."""
    setup, everywhere = states.setup, np.ones(data.n_states, dtype=np.bool_)
    for place, (kind, body, component) in enumerate(zip(data.kind, data.body, data.component, strict=True)):
        if kind <= ROTATION:
            yield f"{setup.target_names[body]}_{COMPONENTS[component]}", place, everywhere
        elif kind == LENGTH:
            yield f"{setup.rods[body].names[component]}_length_m", place, everywhere
        elif kind == MOTOR:
            yield MOTOR_ANGLE.format(component + 1), place, everywhere
        elif data.layout.gauges is not None:
            for number, gauge in enumerate(setup.gauges):
                of_gauge = data.layout.gauges.gauge[component] == number
                if of_gauge.any():
                    yield f"{gauge.name}_displacement_m", place, of_gauge


def gauge_block(table: pa.Table, names: Sequence[str], directions: Floats, kind: str, n_states: int) -> Floats:
    """Return (n_states, 6): what gauges read, as displacements along their directions; NaN where none was read.

    Across a gauge's direction nothing was measured; those components are zero.

    Parameters
    ----------
    table : of `observed_table`.
    names : of the gauges.
    directions : (n_states, G, 3) base axes.
    kind, n_states : as in `component_block`.
    """
    block = np.full((n_states, 6), np.nan)
    where = values_of(table.column("state"))
    for number, gauge in enumerate(names):
        name = f"{gauge}_displacement_m_{kind}"
        if name in table.column_names:
            along = np.full(n_states, np.nan)
            along[where] = values_of(table.column(name))
            measured = np.isfinite(along)
            block[measured, :3] = along[measured, None] * directions[measured, number]
    return block


def motor_block(table: pa.Table, kind: str, n_states: int) -> Floats:
    """Return (n_states, 6): the angle of the moved motor in the first column, rad; NaN where none was read.

    The other components are zero.

    Parameters
    ----------
    table : of `observed_table`.
    kind, n_states : as in `component_block`.
    """
    block = np.full((n_states, 6), np.nan)
    where = values_of(table.column("state"))
    for name in table.column_names:
        if name.startswith("motor") and name.endswith(f"_angle_rad_{kind}"):
            angle = values_of(table.column(name))
            read = np.isfinite(angle)
            block[where[read]] = 0.0
            block[where[read], 0] = angle[read]
    return block


def component_block(table: pa.Table, target: str, kind: str, n_states: int) -> Floats:
    """Return (n_states, 6) of one target, NaN where not measured or not judged.

    Parameters
    ----------
    table : of `observed_table`.
    kind : "measured", "predicted" or "residual".
    n_states : how many load states the campaign has.
    """
    block = np.full((n_states, 6), np.nan)
    where = values_of(table.column("state"))
    for place, component in enumerate(COMPONENTS):
        name = f"{target}_{component}_{kind}"
        if name in table.column_names:
            block[where, place] = values_of(table.column(name))
    return block
