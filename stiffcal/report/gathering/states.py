"""The load states as the report and the plots draw them: forces, directions, what was measured and predicted."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats
from stiffcal.identification.answers.state_tables import component_block, gauge_block
from stiffcal.identification.readings.state_loads import branch_words, force_since_reference
from stiffcal.measurements.load_states import members_of
from stiffcal.reduction.loads.cycles import LoadCycles, find_load_cycles
from stiffcal.reduction.loads.motion import gauge_directions
from stiffcal.report.content import ReportStates
from stiffcal.stages.steps import FIT_STATES, HELDOUT_STATES, Ingested

if TYPE_CHECKING:
    from stiffcal.measurements.load_states import LoadStates
    from stiffcal.mechanics.chain import Chain


def report_states_of(data: Ingested) -> ReportStates:
    """Return the load states as the report draws them: first target, base axes; of gauges what they read alone."""
    states, chain = data.states, data.campaign.chain
    fit, heldout = data.store.read_table(FIT_STATES), data.store.read_table(HELDOUT_STATES)
    block = partial(component_block, target=states.setup.target_names[0], n_states=len(states))
    along = None
    if not states.has_poses and states.setup.gauges:
        along = gauge_directions(states, chain)
        names = [gauge.name for gauge in states.setup.gauges]
        block = partial(gauge_block, names=names, directions=along, n_states=len(states))
    measured, predicted = block(fit, kind="measured"), block(fit, kind="predicted")
    heldout_measured, heldout_residual = block(heldout, kind="measured"), block(heldout, kind="residual")
    # Runs held out of the fit are in the second table alone.
    outside = ~np.isfinite(measured).any(axis=1)
    measured[outside] = heldout_measured[outside]
    predicted[outside] = block(heldout, kind="predicted")[outside]
    measured = _with_states_set_aside(states, measured)
    rotations = bool(np.isfinite(measured[:, 3:]).any())
    width = 6 if rotations else 3
    force, direction, branch = _loads(states, chain)
    return ReportStates(
        run=states.run,
        force=force,
        load=np.linalg.norm(force, axis=1),
        direction=direction,
        branch=branch,
        measured=measured[:, :width],
        predicted=predicted[:, :width],
        predicted_heldout=(measured - heldout_residual)[:, :width],
        set_aside=states.set_aside,
        reference=states.reference & (not states.deflection_given) & ~states.absolute,
        along=None if along is None else _read_directions(states, along),
    )


def _read_directions(states: LoadStates, directions: Floats) -> Floats:
    """Return (n, 3) the direction of the gauge that was read in each state; zero where none was."""
    read = np.isfinite(states.displacement)
    return np.asarray(np.einsum("ng,ngi->ni", read.astype(np.float64), directions))


def _with_states_set_aside(states: LoadStates, measured: Floats) -> Floats:
    """Fill in what was read in states that were not judged: displacement on the offset of their run."""
    if states.deflection_given:
        raw = states.deflection[:, 0]
        return np.where(np.isfinite(measured), measured, raw)
    raw = np.full_like(measured, np.nan)
    raw[:, :3] = states.position[:, 0]
    filled = measured.copy()
    for members in members_of(states.run):
        difference = raw[members, :3] - measured[members, :3]
        measured_mask = np.isfinite(difference).all(axis=1)
        if measured_mask.any():
            missing = members[~np.isfinite(measured[members, :3]).all(axis=1)]
            filled[missing, :3] = raw[missing, :3] - difference[measured_mask].mean(axis=0)
    return filled


def _loads(states: LoadStates, chain: Chain) -> tuple[Floats, NDArray[np.str_], NDArray[np.str_]]:
    """Return force less the reference's (n, 3), of absolute rows the whole force; direction labels, branches."""
    force, cycles = force_since_reference(states, chain), find_load_cycles(states)
    return force, _direction_labels(states, force, cycles), branch_words(cycles)


def _direction_labels(states: LoadStates, force: Floats, cycles: LoadCycles) -> NDArray[np.str_]:
    """Return (n,) one label for each direction of a run: the base axis that its force points along most.

    A direction between two axes keeps one label, and two directions nearest to the same axis are kept apart.
    """
    labels = np.full(len(force), "", dtype="<U24")
    for in_run in members_of(states.run):
        taken: list[str] = []
        for direction in np.unique(cycles.direction[in_run][cycles.direction[in_run] >= 0]):
            members = in_run[cycles.direction[in_run] == direction]
            total = force[members].sum(axis=0)
            axis = int(np.argmax(np.abs(total)))
            word = f"near {'+' if total[axis] > 0.0 else '−'}{'xyz'[axis]}"
            taken.append(word)
            # a second direction nearest to the same axis
            again = taken.count(word)
            labels[members] = word if again == 1 else f"another {word}" + (f" ({again})" if again > 2 else "")
    return labels
