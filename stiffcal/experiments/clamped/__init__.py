"""The clamped robot: a fixture holds the flange, one motor after the other is driven, and torque is read over angle."""

from __future__ import annotations

from stiffcal.experiments import ExperimentKind

KIND = ExperimentKind("clamped")
