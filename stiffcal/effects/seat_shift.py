"""Something slipped."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import (
    Covariate,
    Instrument,
    NodeLoads,
    Observed,
    ParameterRole,
    ParameterSpec,
    Place,
    StateOrder,
    Values,
)
from stiffcal.model.laws.memory import first_of_run

_SOURCE = "a reflector nest repeats to about 10 µm; bolted joints slip by the clearance of their holes, 0.1 mm and more"


class SeatShift(Instrument):
    """A fixture, the reflector or the robot base slips once, suddenly, and stays displaced.

    Law: D += (x, y, z), base axes, from one state to the end of its run. `state` is the number of the first shifted
    state, counted through the campaign from 1 in the order of the states.

    Assumes one slip; the next run has a new reference and is not affected.

    Limits: a slip of what holds the reflector counts in the tool's axes, one of the base in the base's: within a run,
    where the pose stands still, the two are the same. A slip between runs leaves no trace at all.
    """

    name = "seat-shift"
    place_kind = "setup"
    summary = "sudden slip of a fixture, reflector or base between two states of a run"
    parameters = (
        ParameterSpec(
            "state", "1", "number of the first shifted state in the campaign, from 1", 1.0, 1e9, 2.0,
            "any state but the first of a run", ParameterRole.NONLINEAR, discrete=True,
        ),
        ParameterSpec("x", "m", "displacement along the base x axis", -0.1, 0.1, 5e-5, _SOURCE),
        ParameterSpec("y", "m", "displacement along the base y axis", -0.1, 0.1, 5e-5, _SOURCE),
        ParameterSpec("z", "m", "displacement along the base z axis", -0.1, 0.1, 5e-5, _SOURCE),
    )  # fmt: skip
    needs = ("several states in a run",)
    looks_like = ("thermal-drift", "friction-hysteresis")
    fingerprint = "in one run only, all residuals after one state are shifted by the same vector"
    how_to_check = (
        "Unload at the end of the run: the target does not return to its initial position. Tighten loose parts and "
        "repeat the run."
    )

    def lacking(self, chain: Chain, states: LoadStates) -> str | None:
        """A run needs states before and after the slip."""
        if np.bincount(states.run).max(initial=0) < 3:
            return "several states in a run: a step needs readings before and after it"
        return None

    def observation_columns(self, place: Place, observed: Observed, shape: Values) -> dict[str, Floats]:
        """Return the step along each base axis."""
        after = _after(observed.order, round(shape["state"]))
        columns = {}
        for component, symbol in enumerate(("x", "y", "z")):
            column = np.zeros_like(observed.displacement)
            column[:, component] = after
            columns[symbol] = column
        return columns

    def covariate(self, place: Place, chain: Chain, loads: NodeLoads) -> Covariate | None:
        """The state's number."""
        if loads.order is None or not loads.order.number.size:
            return None
        return Covariate("state of the campaign", "1", loads.order.number.astype(np.float64))

    def nonlinear_grid(self, place: Place, chain: Chain, loads: NodeLoads) -> dict[str, Floats]:
        """Every state but the first of each run."""
        if loads.order is None or not loads.order.number.size:
            return {"state": np.zeros(0)}
        return {"state": loads.order.number[~first_of_run(loads.order.run)].astype(np.float64)}


def _after(order: StateOrder, state: int) -> Floats:
    """Return (n,) 1 from the state to the end of its run, 0 elsewhere; a state set aside counts by its place."""
    place = int(np.searchsorted(order.number, state))
    result = np.zeros(len(order.run))
    if place < len(order.number) and (
        order.number[place] == state or (place > 0 and order.run[place - 1] == order.run[place])
    ):
        result[place:] = order.run[place:] == order.run[place]
    return result
