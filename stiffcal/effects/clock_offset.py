"""Logs that are shifted in time."""

from __future__ import annotations

import numpy as np

from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import DocumentedEffect, Floats, Kind, ParameterSpec, Sort


class ClockOffset(DocumentedEffect):
    """Two devices log on clocks that do not agree, so that readings are paired with those of another moment.

    Law: y_seen(t) = y(t + offset), the offset in seconds by which the second clock is ahead of the first. Over a sweep
    it makes the residual offset × dy/dt, and opens a loop between loading and unloading that is wider the faster the
    load moves.

    Assumes clocks that run at the same rate over a run.

    Limits: it is seen in sweeps and ramps only. In load states, averaged while the load is held, nothing moves, and
    nothing is left of it; the clocks are aligned before, when the logs are reduced (`ingest` reports clock_ahead_s).
    """

    name = "clock-offset"
    kind = Kind.OBSERVATION
    place_kind = "setup"
    summary = "two logs are shifted in time"
    parameters = (
        ParameterSpec(
            "offset", "s", "how far the second log's clock is ahead", -3600.0, 3600.0, 0.5,
            "devices started one after another: tenths of a second to some seconds", Sort.SETUP,
        ),
    )  # fmt: skip
    needs = ("sweeps or ramps logged at a rate",)
    looks_like = ("friction-hysteresis", "creep")
    fingerprint = "loading and unloading run apart, the more the faster the load moves, and not at all while it is held"
    how_to_check = "Tap the tool: the tap must show at the same time in all logs. Or repeat a sweep at half the speed."

    def lacking(self, chain: Chain, states: LoadStates) -> str | None:
        """Load states hold no motion."""
        return "sweeps or ramps: load states are held still; ingest aligns the clocks and reports clock_ahead_s"

    def seen_at(self, time: Floats, value: Floats, offset: float) -> Floats:
        """Return y(t + offset) of a logged signal, straight between readings, constant beyond its ends.

        Parameters
        ----------
        time : (n,) s, increasing. value : (n,) the signal. offset : s.
        """
        return np.asarray(np.interp(time + offset, time, value))
