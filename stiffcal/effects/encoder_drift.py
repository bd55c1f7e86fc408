"""Motor angles that wander while nothing turns."""

from __future__ import annotations

from typing import ClassVar

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

_SOURCE = "an encoder's mount and disk that warm up: 10 µrad in ten minutes, or in five kelvin"


class EncoderDrift(Instrument):
    """The encoder reading of a joint drifts with time or temperature while the joint is at rest.

    Law: q_read = q + rad_per_s (t − t_ref), with q the joint's angle and q_read the logged one; or q_read = q +
    rad_per_K (T − T_ref) in the form that a model with [rad_per_K] takes; t_ref and T_ref (the campaign's first
    temperature) are those of the run's reference state. In clamped runs it appears as compliance of the drive.

    Assumes a constant rate of drift; a drift that settles within a run is not a straight line over time.

    Limits: it shows in clamped runs, whose motor angles are read to microradians. Each run begins at its own zero. A
    load that only grows cannot separate it from compliance: sweep there and back. Where temperature rises linearly with
    time, the two forms cannot be distinguished.
    """

    name = "encoder-drift"
    place_kind = "joints"
    in_drive = True
    summary = "the encoder reading of a joint drifts with time or temperature"
    parameters: ClassVar[tuple[ParameterSpec, ...]] = (
        ParameterSpec("rad_per_s", "rad/s", "drift of the reading over time", -1e-3, 1e-3, 2e-8, _SOURCE),
    )
    needs = ("clamped runs with time stamps or a temperature",)
    looks_like = ("creep", "friction-hysteresis", "clock-offset")
    fingerprint = "the loop of torque over angle does not close: each cycle is shifted by the same amount"
    how_to_check = "Leave the clamped robot at rest for the duration of a run, with the brakes on, and log the angle."

    def lacking(self, chain: Chain, states: LoadStates) -> str | None:
        """Clamped runs, and time stamps or a temperature, whichever the form is over, that change within one."""
        if not states.clamped.any():
            return "clamped runs: in other runs the motor angles are not fitted"
        if not _varies_in_a_run(states, self._logged(states)):
            return "time stamps or a temperature that change within a clamped run"
        return None

    def observation_columns(self, place: Place, observed: Observed, shape: Values) -> dict[str, Floats]:
        """Return what the reading of the joint, running ahead, takes off the held frame's motion."""
        (spec,) = self.parameters
        column = np.zeros_like(observed.displacement)
        held = observed.held
        if held is not None:
            column[held.target] = -held.jacobian[:, place.joints[0] - 1] * self._since(observed.order)
        return {spec.symbol: column}

    def covariate(self, place: Place, chain: Chain, loads: NodeLoads) -> Covariate | None:
        """Time since the reference."""
        if loads.order is None:
            return None
        return Covariate("time since the reference", "s", self._since(loads.order))

    def _since(self, order: StateOrder) -> Floats:
        return np.nan_to_num(order.since_reference)

    def _logged(self, states: LoadStates) -> Floats:
        return states.time


def _varies_in_a_run(states: LoadStates, value: Floats) -> bool:
    """Return whether values (n,) change within a clamped run."""
    clamped = states.clamped
    return any(varies(value[members]) for members in members_of(states.run) if clamped[members[0]])


class _OverTemperature(EncoderDrift):
    __doc__ = EncoderDrift.__doc__

    parameters = (
        ParameterSpec("rad_per_K", "rad/K", "drift of the reading over temperature", -1e-2, 1e-2, 2e-6, _SOURCE),
    )

    def covariate(self, place: Place, chain: Chain, loads: NodeLoads) -> Covariate | None:
        """Temperature since the reference."""
        if loads.order is None:
            return None
        return Covariate("temperature since the reference", "K", self._since(loads.order))

    def _since(self, order: StateOrder) -> Floats:
        return np.nan_to_num(order.temperature)

    def _logged(self, states: LoadStates) -> Floats:
        return states.temperature[:, 0] if states.temperature.shape[1] else np.full(len(states), np.nan)


EncoderDrift.forms = (EncoderDrift(), _OverTemperature())
