"""Targets that wander with time or temperature."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import LoadStates, members_of
from stiffcal.measurements.varying import varies
from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import (
    Covariate,
    Instrument,
    NodeLoads,
    Observed,
    ParameterSpec,
    Place,
    StateOrder,
    Values,
)

_MOVE = "0.2 mm in an hour: a robot or a tracker stand that warms up"
_TURN = "0.2 mm at one metre in an hour"
_SYMBOLS = ("x", "y", "z", "rx", "ry", "rz")


class ThermalDrift(Instrument):
    """The target drifts without load, because robot, stand or instrument warm up or settle.

    Law: D += r (t − t_ref), with r the drift's rate; D += r (T − T_ref) where the campaign logs a temperature (its
    first channel), in base axes, t_ref and T_ref being those of the run's reference state; where orientation is
    measured, the target also turns at its own rate. One rate for the whole campaign, on its one clock.

    Assumes a constant rate of drift over the campaign. ISO 9283 has a test of its own for the drift of a warming robot,
    which is quicker at first; then the runs at the beginning show it more.

    Absolute positions have no reference: time counts from the first row.

    Limits: only what happens between a run's reference and its states shows. Runs in which load and time rise
    together cannot separate drift from compliance: measure unloaded states in between and at the end.
    """

    name = "thermal-drift"
    place_kind = "setup"
    summary = "the target drifts with time or temperature"
    parameters = tuple(
        ParameterSpec(symbol, "m/s or m/K", f"drift along the base {symbol} axis", -1e-3, 1e-3, 5e-8, _MOVE)
        if len(symbol) == 1
        else ParameterSpec(
            symbol, "rad/s or rad/K", f"rotation about the base {symbol[1]} axis", -1e-2, 1e-2, 5e-8, _TURN
        )
        for symbol in _SYMBOLS
    )
    needs = ("time stamps or a temperature",)
    looks_like = ("creep", "seat-shift")
    fingerprint = "the residual depends on time (or temperature) within a run, independent of the load"
    how_to_check = "Leave the robot unloaded and log the target for the duration of a run: it moves in the same way."

    def lacking(self, chain: Chain, states: LoadStates) -> str | None:
        """Time or temperature, and states of a run that differ in it."""
        for value in (states.temperature[:, 0] if states.temperature.shape[1] else None, states.time):
            if value is None or not np.isfinite(value).any():
                continue
            if any(varies(value[members]) for members in members_of(states.run)) or varies(value[states.absolute]):
                return None
        return "time stamps or a temperature that change within a run"

    def observation_columns(self, place: Place, observed: Observed, shape: Values) -> dict[str, Floats]:
        """Return one component per symbol, proportional to the time or temperature since the reference."""
        since = _since_reference(observed.order)
        columns = {}
        for component, symbol in enumerate(_SYMBOLS):
            column = np.zeros_like(observed.displacement)
            column[:, component] = since
            columns[symbol] = column
        return columns

    def covariate(self, place: Place, chain: Chain, loads: NodeLoads) -> Covariate | None:
        """Time or temperature since the reference."""
        if loads.order is None:
            return None
        label, unit = ("temperature", "K") if loads.order.logs_temperature else ("time", "s")
        return Covariate(f"{label} since the reference", unit, _since_reference(loads.order))


def _since_reference(order: StateOrder) -> Floats:
    warmer = order.temperature
    return np.nan_to_num(warmer if np.isfinite(warmer).any() else order.since_reference)
