"""What was measured and what the model says of it, state by state, as a table of the store."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiffcal.store import table_of, values_of

if TYPE_CHECKING:
    import pyarrow as pa

    from stiffcal.identification.observation import Observations
    from stiffcal.measurements.load_states import LoadStates

Floats = NDArray[np.float64]

COMPONENTS = ("dx_m", "dy_m", "dz_m", "rx_rad", "ry_rad", "rz_rad")


def observed_table(states: LoadStates, data: Observations, predicted: Floats, residual: Floats) -> pa.Table:
    """Return one row per load state that was judged.

    Columns: ``state`` (index into the load states, from 0), ``run``, ``row``, and per target and component
    ``<target>_dx_m_measured``, ``…_predicted``, ``…_residual`` (displacement since the run's reference, base axes, m
    and rad). Measured is predicted plus residual: each run's free offset is taken out. NaN where not measured.

    Parameters
    ----------
    states : all load states of the campaign.
    data : the observations, m components of n states.
    predicted, residual : (m, n) m and rad.
    """
    columns: dict[str, Any] = {
        "state": data.index,
        "run": [states.runs[number].name for number in data.run],
        "row": states.row[data.index],
    }
    for place in range(len(data.measured)):
        name = f"{states.setup.target_names[data.body[place]]}_{COMPONENTS[data.component[place]]}"
        seen = data.seen[place]
        for kind, values in (
            ("measured", predicted[place] + residual[place]),
            ("predicted", predicted[place]),
            ("residual", residual[place]),
        ):
            columns[f"{name}_{kind}"] = np.where(seen, values, np.nan)
    return table_of(columns)


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
