"""Logs that are shifted in time."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import Instrument, Observed, ParameterSpec, Place, Values


class ClockOffset(Instrument):
    """The clocks of two devices differ, so readings are paired with those of another time.

    Law: y_measured(t) = y(t + offset), with the offset in seconds by which the displacement is read later than the
    force that it is paired with. Over a sweep it adds offset × dy/dt, and opens a loop between loading and unloading
    that is wider the faster the load moves.

    Assumes clocks that run at the same rate over a run, and one offset for all runs.

    Limits: it shows in sweeps and ramps only. In load states, averaged at constant load, nothing moves, so it has no
    influence. The clocks are aligned before, when the logs are reduced (`ingest` reports clock_ahead_s): this effect
    can find the remaining error of that, or a wrong clock_ahead_s. A hysteresis loop is equally wide in slow and fast
    sweeps.
    """

    name = "clock-offset"
    place_kind = "setup"
    in_drive = True
    summary = "time offset between two logs"
    parameters = (
        ParameterSpec(
            "offset", "s", "how far the second log's clock is ahead", -3600.0, 3600.0, 0.5,
            "devices started one after another: tenths of a second to some seconds",
        ),
    )  # fmt: skip
    needs = ("sweeps or ramps logged at a rate",)
    looks_like = ("friction-hysteresis", "creep")
    fingerprint = "loading and unloading differ in proportion to the rate of loading, and not at constant load"
    how_to_check = (
        "Tap the tool: the tap must appear at the same time in all logs. Or repeat a sweep at half the speed."
    )

    def lacking(self, chain: Chain, states: LoadStates) -> str | None:
        """Loads that are held show no motion; of those that are swept the time is needed."""
        swept = np.array([run.swept for run in states.runs], dtype=np.bool_)[states.run]
        if not swept.any():
            return (
                "sweeps or ramps: load states are taken at constant load; ingest aligns the clocks and reports "
                "clock_ahead_s"
            )
        return None if np.isfinite(states.time[swept]).all() else "time stamps of the states of sweeps"

    def observation_columns(self, place: Place, observed: Observed, shape: Values) -> dict[str, Floats]:
        """Return dy/dt of the displacement in sweeps, m/s and rad/s; nothing where loads are held."""
        return {"offset": _rate(observed)}

    def measured_at(self, time: Floats, value: Floats, offset: float) -> Floats:
        """Return y(t + offset) of a logged signal, straight between readings, constant beyond its ends.

        Parameters
        ----------
        time : (n,) s, increasing.
        value : (n,) the signal.
        offset : s.
        """
        return np.asarray(np.interp(time + offset, time, value))


def _rate(observed: Observed) -> Floats:
    """Return (B, 6, n) the rate at which the displacement changes, by the states before and after in the same sweep.

    A sweep's first and last states are its rests.
    """
    order = observed.order
    rate = np.zeros_like(observed.displacement)
    if not order.swept.any():
        return rate
    for number in np.unique(order.run[order.swept]):
        in_run = np.flatnonzero(order.run == number)
        if in_run.size < 4:
            continue
        moving = in_run[1:-1]
        before, after = np.maximum(moving - 1, moving[0]), np.minimum(moving + 1, moving[-1])
        step = order.time[after] - order.time[before]
        rate[:, :, moving] = (observed.displacement[:, :, after] - observed.displacement[:, :, before]) / step
    return rate
