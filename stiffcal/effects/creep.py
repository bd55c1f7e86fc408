"""Deflection that goes on growing."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mechanics.chain import Chain
from stiffcal.model.drives import drive_terms, drive_torque
from stiffcal.model.effect import (
    Covariate,
    DocumentedEffect,
    Kind,
    NodeLoads,
    ParameterRole,
    ParameterSpec,
    Place,
    StateOrder,
    Term,
    Values,
)
from stiffcal.model.memory import first_of_run, relax


class Creep(DocumentedEffect):
    """A part of the drive is viscoelastic: the deflection continues to grow under constant load, and returns slowly.

    Law: T dδ/dt = c τ − δ, a Kelvin–Voigt element (spring and damper side by side) about the joint's axis, in series
    with the rest; c is its final compliance, T its time constant. τ is the whole torque.

    Integrated over the run's time stamps, step by step and exactly for torque that is constant within the step: a load
    acts from the stamp before it until its own. Where the time for which the load was held is logged, it acts for that
    long before its stamp, and the load before it until then. Before the run, weight is taken as applied for a long
    time.

    Assumes that loads change quickly against T and that the stamp is the time of the reading. States without order or
    time count as fully relaxed.

    Limits: T is known only within the spans that were measured, from one dwell to one run; much shorter times look
    elastic, much longer ones like thermal drift.
    """

    name = "creep"
    kind = Kind.NODE_LAW
    place_kind = "joints"
    in_drive = True
    summary = "the deflection continues to grow under constant load"
    has_memory = True
    parameters = (
        ParameterSpec(
            "c", "rad/(N·m)", "final compliance of the slow part", 0.0, 1e-3, 1e-7,
            "a few per cent of a drive's compliance of 2e-6 (Wang, Zhang and Fuhlbrigge 2009, section III.C)",
        ),
        ParameterSpec(
            "time", "s", "time constant (63 % of the final value)", 1e-2, 1e6, 30.0,
            "Wang, Zhang and Fuhlbrigge 2009 wait one minute at each load, Schneider et al. 2014 a few seconds",
            ParameterRole.NONLINEAR,
        ),
    )  # fmt: skip
    needs = ("time stamps of the states",)
    looks_like = ("friction-hysteresis", "thermal-drift")
    fingerprint = "the residual grows with the time under load, and decays slowly after unloading"
    how_to_check = (
        "Keep the largest load for ten minutes and log the target: it continues to move at a decreasing rate."
    )

    def lacking(self, chain: Chain, states: LoadStates) -> str | None:
        """Time is needed, and several states in a run or the time for which each load was held."""
        if not np.isfinite(states.time).any():
            return "time stamps of the load states"
        if np.bincount(states.run).max(initial=0) < 2 and not np.isfinite(states.hold).any():
            return "several states in a run, or the time under load of each state"
        return None

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """δ_Rz = c × what a Kelvin–Voigt element makes of τ."""
        joint = place.joints[0]
        torque = drive_torque(chain, loads.wrench, joint)
        if loads.order is None or not np.isfinite(loads.order.time).all():
            return drive_terms(chain, joint, "c", torque)
        weight = np.zeros_like(torque) if loads.weight is None else drive_torque(chain, loads.weight, joint)
        return drive_terms(chain, joint, "c", _crept(torque, weight, loads.order, shape["time"]))

    def nonlinear_grid(self, place: Place, chain: Chain, loads: NodeLoads) -> dict[str, Floats]:
        """Times from a third of the shortest step to the longest run."""
        if loads.order is None or not np.isfinite(loads.order.time).all() or loads.order.time.size < 2:
            return {"time": np.zeros(0)}
        inside = ~first_of_run(loads.order.run)[1:]
        steps = np.diff(loads.order.time)[inside]
        steps = steps[steps > 0.0]
        if steps.size == 0:
            return {"time": np.zeros(0)}
        _, number = np.unique(loads.order.run, return_inverse=True)
        longest = max(float(np.ptp(loads.order.time[number == k])) for k in range(number.max() + 1))
        return {"time": np.clip(np.geomspace(float(steps.min()) / 3.0, max(longest, float(steps.min())), 6), 1e-2, 1e6)}

    def covariate(self, place: Place, chain: Chain, loads: NodeLoads) -> Covariate | None:
        """Time since the run's first state."""
        if loads.order is None:
            return None
        return Covariate("time since the reference", "s", loads.order.since_reference)


def _crept(torque: Floats, weight: Floats, order: StateOrder, time: float) -> Floats:
    """Return (n,) the torque as the slow part has followed it at the states' stamps, N·m."""
    first = first_of_run(order.run)
    step = np.where(first, 0.0, np.diff(order.time, prepend=order.time[:1]))
    step = np.maximum(step, 0.0)
    dwell = np.where(np.isfinite(order.hold), order.hold, step)
    # Within a run a load cannot have been held since before the stamp of the load before it.
    dwell = np.where(first, np.where(np.isfinite(order.hold), order.hold, 0.0), np.minimum(dwell, step))
    before = np.where(first, weight, np.roll(torque, 1))
    keep_before, keep_held = np.exp(-(step - np.where(first, 0.0, dwell)) / time), np.exp(-dwell / time)
    add = keep_held * (1.0 - keep_before) * before + (1.0 - keep_held) * torque
    return relax(keep_before * keep_held, add, first, weight)
