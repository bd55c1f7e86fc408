"""Analysed clamped runs whose sweeps follow a stated law."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np

from stiffcal.kinds.clamped.answers.analysis import ClampedRun
from stiffcal.kinds.clamped.logs.sweeps import Sweeps
from stiffcal.kinds.clamped.loops.torque_angle import TorqueAngleLaw, play_segment
from stiffcal.kinds.clamped.loops.torque_angle_fit import fit_series
from tests.laboratory.torque_angle_laws import ENCODER, branches


def clamped_run(
    name: str, law: TorqueAngleLaw, seed: int = 1, noise: float = 0.5, joint: int = 3, **changed: Any
) -> ClampedRun:
    """Return a run of one joint whose sweeps follow a law."""
    data = branches(law, noise, seed)
    fit = fit_series(data)
    chain: Any = SimpleNamespace(source="force sensor")
    run = ClampedRun(
        name=name, joint=joint, holdout=False, chain=chain,
        sweeps=Sweeps(np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.bool_), 6), branches=data, fit=fit,
        segment=play_segment(fit.law) if fit.play_found else None, cycle_spread=float("nan"),
        motion=float(np.ptp(data.angle)), encoder_step=ENCODER, resolution=ENCODER, reversal=None, saturation=None,
        others_share=0.0,
    )  # fmt: skip
    return replace(run, **changed)
