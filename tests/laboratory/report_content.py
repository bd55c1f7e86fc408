"""Content for report tests that needs no files."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.report.content import ReportContent, ReportRun, ReportStates
from stiffcal.report.provenance_content import ReportProvenance
from tests.laboratory.report_documents import documents


def made_up_states(n_runs: int = 2, per_run: int = 5, rotation: bool = False) -> ReportStates:
    """One load cycle along x, y, z in each run, a linear robot, noise of 10 µm per axis."""
    rng = np.random.default_rng(7)
    width = 6 if rotation else 3
    ramp = np.concatenate([np.linspace(0, 300, per_run // 2 + 1), np.linspace(300, 0, per_run // 2 + 1)[1:]])
    force = np.concatenate([np.outer(ramp, axis) for _ in range(n_runs) for axis in np.eye(3)])
    compliance = rng.normal(0.0, 2e-6, (width, 3)) + np.eye(width, 3) * 8e-6
    predicted = force @ compliance.T
    measured = predicted + rng.normal(0.0, 1e-5, predicted.shape)
    run = np.repeat(np.arange(n_runs), 3 * len(ramp))
    rising = np.tile(np.arange(len(ramp)) <= per_run // 2, 3 * n_runs)
    return ReportStates(
        run=run,
        force=force,
        load=np.linalg.norm(force, axis=1),
        direction=np.tile(np.repeat(np.array(["near +x", "near +y", "near +z"]), len(ramp)), n_runs),
        branch=np.where(rising, "loading", "unloading"),
        measured=measured,
        predicted=predicted,
    )


def made_up_content(n_runs: int = 2, per_run: int = 5, rotation: bool = False) -> ReportContent:
    """Content of a made-up campaign of a robot with three joints."""
    states = made_up_states(n_runs, per_run, rotation)
    stick: Floats = np.array([[0, 0, 0], [0, 0, 0.4], [0.1, 0, 0.8], [0.6, 0.1, 0.9], [0.7, 0.1, 0.9]], dtype=float)
    runs = tuple(ReportRun(f"run_{i}", np.zeros(3), stick, stick[-1]) for i in range(n_runs))
    made = documents(
        ("A1", "A2", "A3"), np.array([1e-6, 2e-6, 3e-6]), np.diag([1e-16] * 3), states, [r.name for r in runs], None
    )
    origin = ReportProvenance("made-up", "test robot", "2026-11-21", (("stiffcal", "0.1.0"),))
    return ReportContent(provenance=origin, runs=runs, joint_names=("A1", "A2", "A3"), states=states, **made)
