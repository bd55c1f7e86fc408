"""What was measured of the targets' motion, whichever instrument measured it: positions, deflections, or gauges."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats, Integers
from stiffcal.measurements.load_states import LoadStates
from stiffcal.measurements.tracker_axes import each_tracker
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.kinematics import attached_poses, jacobians


@dataclass(frozen=True)
class MeasuredMotion:
    """Components of translation as measured: k of them in n states."""

    measured: Floats
    """(n, k) m, in the instrument's axes, NaN where not measured; an offset per run is without meaning."""
    axes: Floats
    """(n, k, 3) the direction that each component is counted along, base axes."""
    target: tuple[int, ...]
    """k indices of targets."""

    def columns(self, states: LoadStates, chain: Chain) -> Floats:
        """Return (n, k, J) how each component moves with the joints, m/rad."""
        angles = chain.model_angles(states.joints)
        by_target = {b: jacobians(chain, angles, states.setup.targets[b])[:, :3] for b in set(self.target)}
        return np.stack(
            [np.einsum("ni,nij->nj", self.axes[:, k], by_target[b]) for k, b in enumerate(self.target)], axis=1
        )

    def since(self, reference: NDArray[np.int64]) -> Floats:
        """Return (n, 3) the displacement since each state's reference, base axes; zero across what is not measured."""
        change = np.nan_to_num(self.measured - self.measured[reference])
        return np.asarray(np.einsum("nk,nki->ni", change, self.axes))


def motion_of(states: LoadStates, chain: Chain, all_targets: bool = False) -> MeasuredMotion:
    """Return the first target's translation; where only gauges were read, their readings along their directions.

    Parameters
    ----------
    all_targets : True for all targets, False for the first (the outermost) alone.
    """
    n = len(states)
    if states.has_poses or not states.setup.gauges:
        # in the instrument's own axes, in which one of its components may be dead
        displacement = states.deflection[:, :, :3] if states.deflection_given else states.position
        count = displacement.shape[1] if all_targets else 1
        measured, axes = np.empty((n, 3 * count)), np.empty((n, 3 * count, 3))
        for read, placed in each_tracker(states.setup.trackers, states.tracker):
            turn, place = placed[:3, :3], 0.0 if states.deflection_given else placed[:3, 3]
            measured[read] = ((displacement[read, :count] - place) @ turn).reshape(-1, 3 * count)
            axes[read] = np.tile(turn.T, (count, 1))
        return MeasuredMotion(measured, axes, tuple(np.repeat(np.arange(count), 3).tolist()))
    return MeasuredMotion(
        states.displacement.copy(), gauge_directions(states, chain), tuple(g.target for g in states.setup.gauges)
    )


def less_means_of_runs(values: Floats, run: Integers) -> Floats:
    """Return values (n, …) less the mean of what was measured of them in their run (n,); NaN stays NaN."""
    order = np.argsort(run, kind="stable")
    first = np.flatnonzero(np.diff(run[order], prepend=-1))
    counts = np.diff(first, append=run.size)
    sums = np.add.reduceat(np.nan_to_num(values)[order], first, axis=0)
    measured = np.add.reduceat(np.isfinite(values)[order], first, axis=0, dtype=np.int64)
    less = np.empty_like(values)
    less[order] = values[order] - np.repeat(sums / np.maximum(measured, 1), counts, axis=0)
    return less


def gauge_directions(states: LoadStates, chain: Chain) -> Floats:
    """Return (n, G, 3) the gauges' directions in base axes, kinematics alone."""
    angles = chain.model_angles(states.joints)
    directions = []
    for gauge in states.setup.gauges:
        if gauge.axes.body == 0:
            directions.append(np.broadcast_to(gauge.axes.transform[:3, :3] @ gauge.direction, (len(states), 3)))
        else:
            directions.append(attached_poses(chain, angles, gauge.axes)[1] @ gauge.direction)
    return np.stack(directions, axis=1)
