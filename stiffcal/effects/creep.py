"""Deflection that goes on growing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Booleans, Floats, Integers
from stiffcal.measurements.load_states import LoadStates, members_of
from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import (
    Covariate,
    Law,
    NodeLoads,
    ParameterRole,
    ParameterSpec,
    Place,
    Term,
    Values,
)
from stiffcal.model.laws.drives import drive_terms, drive_torque
from stiffcal.model.laws.memory import first_of_run, relax
from stiffcal.model.laws.prismatic import specs_along_axis


class Creep(Law):
    """A part of the drive is viscoelastic: the deflection continues to grow under constant load, and returns slowly.

    Law: T dδ/dt = c τ − δ, a Kelvin–Voigt element (spring and damper side by side) about the joint's axis, in series
    with the rest; c is its final compliance, T its time constant. τ is the whole torque.

    Integrated over the run's time stamps, step by step and exactly for torque that is constant within the step: a load
    acts from the stamp before it until its own. Where the time for which the load was held is logged, it acts for that
    long before its stamp, and the load before it until then. Before the run, weight is taken as applied for a long
    time.

    In absolute runs whose rows follow each other directly (`approach = "direct"`) the poses are the loads: the drive
    continues to deflect under what it carried in the poses before, taken on the undeformed robot.

    Assumes that loads change quickly against T and that the stamp is the time of the reading. States without order, and
    all of a run in which a time is missing, count as fully relaxed.

    Limits: T is known only within the spans that were measured, from one dwell to one run; much shorter times look
    elastic, much longer ones like thermal drift.
    """

    name = "creep"
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
    prismatic = specs_along_axis(parameters)
    needs = ("time stamps of the states",)
    looks_like = ("friction-hysteresis", "thermal-drift")
    fingerprint = "the residual grows with the time under load, and decays slowly after unloading"
    how_to_check = (
        "Keep the largest load for ten minutes and log the target: it continues to move at a decreasing rate."
    )

    def lacking(self, chain: Chain, states: LoadStates) -> str | None:
        """Time is needed, and several states in a run, the time of each load, or poses that follow each other."""
        stamped = np.isfinite(states.time)
        direct = np.array([run.direct for run in states.runs], dtype=np.bool_)[states.run]
        if (stamped & direct).any():
            return None
        if not stamped.any():
            return "time stamps of the load states"
        if states.absolute.all():
            if direct.any():
                return 'time stamps of the rows of runs with approach = "direct"'
            return 'the order of approach: approach = "direct" in [[runs]] where the robot went from row to row'
        loads = ~states.absolute & _in_stamped_runs(states.run, states.time)
        if np.bincount(states.run[loads]).max(initial=0) < 2 and not np.isfinite(states.hold[loads]).any():
            return "several states in a run with the time stamp of each, or the time under load of each state"
        return None

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """δ_Rz = c × what a Kelvin–Voigt element makes of τ."""
        joint = place.joints[0]
        torque = drive_torque(chain, loads.wrench, joint)
        if loads.order is None:
            return drive_terms(chain, joint, "c", torque)
        order, time, followed = loads.order, shape["time"], torque.copy()
        weight = np.zeros_like(torque) if loads.weight is None else drive_torque(chain, loads.weight, joint)
        stamped = _in_stamped_runs(order.run, order.time)
        if stamped.any():
            first, times = first_of_run(order.run[stamped]), _Times(order.time[stamped], order.hold[stamped])
            followed[stamped] = _crept(torque[stamped], weight[stamped], first, times, time)
        history = order.history
        if history is not None:
            carried = history.torque[joint - 1]
            first, times = first_of_run(history.segment), _Times(history.time, history.hold)
            before = _crept(carried, carried, first, times, time)
            known = history.index >= 0
            followed[known] = before[history.index[known]]
        return drive_terms(chain, joint, "c", followed)

    def nonlinear_grid(self, place: Place, chain: Chain, loads: NodeLoads) -> dict[str, Floats]:
        """Times from a third of the shortest step to the longest run."""
        order = loads.order
        if order is None or order.time.size < 2:
            return {"time": np.zeros(0)}
        stamped = _in_stamped_runs(order.run, order.time)
        spans = [_spans(order.run[stamped], order.time[stamped])] if stamped.any() else []
        if order.history is not None:
            spans.append(_spans(order.history.segment, order.history.time))
        if not spans:
            return {"time": np.zeros(0)}
        steps, longest = np.concatenate([span[0] for span in spans]), max(span[1] for span in spans)
        if steps.size == 0:
            return {"time": np.zeros(0)}
        return {"time": np.clip(np.geomspace(float(steps.min()) / 3.0, max(longest, float(steps.min())), 6), 1e-2, 1e6)}

    def covariate(self, place: Place, chain: Chain, loads: NodeLoads) -> Covariate | None:
        """Time since the run's first state."""
        if loads.order is None:
            return None
        return Covariate("time since the reference", "s", loads.order.since_reference)


def _in_stamped_runs(run: Integers, time: Floats) -> Booleans:
    """Return (n,) True for states of runs whose states all have a time: what acted in between is known there."""
    return ~np.isin(run, run[~np.isfinite(time)])


@dataclass(frozen=True)
class _Times:
    """When n loads were read, and for how long they had been held, s; (n,) each, hold NaN where not known."""

    stamp: Floats
    hold: Floats


def _spans(run: Integers, time: Floats) -> tuple[Floats, float]:
    """Return the steps of time within runs that are above zero, and the longest run, s."""
    steps = np.diff(time)[~first_of_run(run)[1:]]
    _, number = np.unique(run, return_inverse=True)
    longest = max(float(np.ptp(time[members])) for members in members_of(number))
    return steps[steps > 0.0], longest


def _crept(torque: Floats, weight: Floats, first: Booleans, times: _Times, time: float) -> Floats:
    """Return (n,) the torque as the slow part has followed it at the stamps, N·m; ``first`` where a run begins."""
    step = np.where(first, 0.0, np.diff(times.stamp, prepend=times.stamp[:1]))
    step = np.maximum(step, 0.0)
    dwell = np.where(np.isfinite(times.hold), times.hold, step)
    # Within a run a load cannot have been held since before the stamp of the load before it.
    dwell = np.where(first, np.where(np.isfinite(times.hold), times.hold, 0.0), np.minimum(dwell, step))
    before = np.where(first, weight, np.roll(torque, 1))
    keep_before, keep_held = np.exp(-(step - np.where(first, 0.0, dwell)) / time), np.exp(-dwell / time)
    add = keep_held * (1.0 - keep_before) * before + (1.0 - keep_held) * torque
    return relax(keep_before * keep_held, add, first, weight)
