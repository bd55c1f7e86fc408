"""Whether load states hold a displacement at all: without one there is no stiffness, whatever a solver answers."""

from __future__ import annotations

import numpy as np

from stiffcal.campaign.found.experiment_kinds import kinds_that_measure
from stiffcal.errors import Fault
from stiffcal.escapes import toml_text
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.load_states import LoadStates
from stiffcal.measurements.state_measures import StateMeasure
from stiffcal.mechanics.like_poses import SAME_POSE_RAD, pose_groups


def check_displacement_measured(states: LoadStates, file: str = "campaign.toml") -> list[Fault]:
    """Return a fault where no run of these states holds a displacement.

    A displacement is a difference: two readings of the target, a rod or a gauge in one run, a ``deflection`` that the
    campaign gives, or the motors' angles of a clamped run.

    Parameters
    ----------
    states : all load states; those set aside do not count.
    file : the manifest, for the fault.
    """
    if len(states) == 0 or states.deflection_given or states.clamped.any():
        return []
    measured = _measured(states) & states.used
    per_run = np.bincount(states.run[measured], minlength=len(states.runs))
    present = np.unique(states.run)
    loads = np.array([run.measures is StateMeasure.DISPLACEMENT for run in states.runs], dtype=np.bool_)
    if (per_run > 1).any() or not loads[present].any():
        return []
    reason = f"{_what_is_there(states, present.size)}; {_what_is_missing(states, measured)}"
    return [Fault(FaultCode.DATA_MISSING, file, "runs", reason, _what_would_serve(states))]


def _measured(states: LoadStates) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Return (n,) where something was read that moves under load."""
    n = len(states)
    readings = (states.position.reshape(n, -1), states.lengths, states.displacement)
    return np.asarray(np.isfinite(np.concatenate(readings, axis=1)).any(axis=1))


def _what_is_there(states: LoadStates, n_runs: int) -> str:
    contents = ["joint angles"]
    if np.any(states.wrench):
        contents.append("loads")
    if np.isfinite(states.position).any():
        contents.append("places of the target")
    if np.isfinite(states.lengths).any():
        contents.append("lengths of rods")
    if np.isfinite(states.displacement).any():
        contents.append("readings of gauges")
    return f"{_count(len(states), 'load state')} in {_count(n_runs, 'run')}, with {', '.join(contents)}"


def _what_is_missing(states: LoadStates, measured: np.ndarray[tuple[int], np.dtype[np.bool_]]) -> str:
    needs = "stiffness requires each pose unloaded and loaded"
    if not measured.any():
        return f"no displacement under load was measured: {needs}"
    if np.bincount(states.run).max() == 1:
        return f"every run has only one state and no deflection is given: {needs}"
    return f"no run has two usable states in which the target was measured, and no deflection is given: {needs}"


def _what_would_serve(states: LoadStates) -> str:
    groups = pose_groups(states.joints, SAME_POSE_RAD) if np.isfinite(states.joints).all() else np.arange(len(states))
    shared = np.flatnonzero(np.bincount(groups) > 1)
    if shared.size and np.bincount(states.run).max() == 1:
        rows = ", ".join(str(row) for row in states.row[groups == shared[0]][:4])
        mend = (
            f"rows {rows} have the same joint angles: give states of one pose one run, "
            'with a column of its number and run = { column = "pose" }, say'
        )
    else:
        mend = "measure each pose unloaded too, as two states of one run"
    body = next(iter(states.setup.target_names), "flange")
    taken: dict[str, toml_text.TomlValue] = {
        "translation": ["dx", "dy", "dz"],
        "units": {"translation": "mm"},
        "body": body,
    }
    mend += f"; or write displacements already taken as {toml_text.pair('deflection', taken)}, say"
    of_places = kinds_that_measure(StateMeasure.PLACE)[:1]
    return "; or ".join([mend, *(toml_text.pair("experiment", kind) for kind in of_places)])


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'' if number == 1 else 's'}"
