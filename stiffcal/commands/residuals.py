"""What was measured, predicted and left over in every load state, with what the state carries, as columns."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stiffcal.model.catalogue.campaign_effects import placed_robot
from stiffcal.stages.steps import Ingested

if TYPE_CHECKING:
    from stiffcal.measurements.columns import Values
    from stiffcal.results.identify_result import IdentifyResult


def residual_columns(data: Ingested, identified: IdentifyResult, table: str) -> dict[str, Values]:
    """Return a table of the store as columns, (m,) each, with joint angles, times, noise, and what the states carry.

    Parameters
    ----------
    data : the campaign.
    identified : its fit.
    table : "fit" or "unseen".
    """
    from stiffcal.identification.readings.state_loads import LOAD, load_columns

    judged, states = data.store.read_table(table), data.states
    stored = {name: judged.column(name).to_numpy(zero_copy_only=False) for name in judged.column_names}
    index = stored.pop("state")
    carried = {}
    if LOAD not in stored:  # the table of the fit
        robot = placed_robot(data.campaign).with_values(identified.robot_values())
        carried = {name: values[index] for name, values in load_columns(states, robot).items()}
    slides = data.campaign.chain.prismatic
    angles = {
        f"{name}_{'m' if slides[k] else 'rad'}": states.joints[index, k] for k, name in enumerate(data.joint_names)
    }
    noise = None if identified.noise is None else identified.noise.translation
    return {
        "state": index,
        "run": stored.pop("run"),
        "row": stored.pop("row"),
        **carried,
        **{
            name: values
            for name, values in stored.items()
            if not name.endswith(("_measured", "_predicted", "_residual"))
        },
        **angles,
        "time_s": states.time[index],
        "hold_s": states.hold[index],
        "noise_m": np.full(len(index), np.nan if noise is None else noise),
        **{name: values for name, values in stored.items() if name.endswith(("_measured", "_predicted", "_residual"))},
    }
