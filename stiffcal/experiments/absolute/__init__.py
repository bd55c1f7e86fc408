"""Absolute places: joint angles and where a target is in the tracker's frame, each pose once.

The states are those of load campaigns, one run per row; what is predicted is the place itself, not a difference.
"""

from __future__ import annotations

from pathlib import Path

from stiffcal.experiments import ExperimentKind

KIND = ExperimentKind("absolute", default_model=Path(__file__).with_name("default_model.toml"))
