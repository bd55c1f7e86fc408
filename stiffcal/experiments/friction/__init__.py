"""Friction of the drives: joints driven to and fro in the air, their torque read."""

from __future__ import annotations

from pathlib import Path

from stiffcal.experiments import ExperimentKind

KIND = ExperimentKind("friction", default_model=Path(__file__).with_name("default_model.toml"))
