"""Load states of a plan: poses and loads, before anything is read."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.load_states import LoadStates, MeasurementSetup, RunInfo


def unread_states(angles: Floats, wrench: Floats, setup: MeasurementSetup, full_pose: bool = True) -> LoadStates:
    """Return states (poses, loads, 6) without readings; the first of each pose is its reference."""
    poses, per_run = wrench.shape[:2]
    n = poses * per_run
    run = np.repeat(np.arange(poses), per_run)
    return LoadStates(
        runs=tuple(RunInfo(f"pose{k + 1:02d}") for k in range(poses)),
        run=run,
        time=8.0 * np.arange(n) + 120.0 * run,
        hold=np.full(n, np.nan),
        joints=angles[run],
        wrench=wrench.reshape(-1, 6),
        position=np.zeros((n, 1, 3)),
        rotation=np.tile(np.eye(3), (n, 1, 1, 1)) if full_pose else np.full((n, 1, 3, 3), np.nan),
        deflection=np.full((n, 1, 6), np.nan),
        reference=np.concatenate([[True], np.diff(run) != 0]),
        temperature=np.zeros((n, 0)),
        row=np.arange(1, n + 1),
        n_readings=np.ones(n, dtype=np.int64),
        wrench_scatter=np.full((n, 6), np.nan),
        position_scatter=np.full((n, 1, 3), np.nan),
        set_aside=np.full(n, "", dtype=np.str_),
        setup=setup,
    )
