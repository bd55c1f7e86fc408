"""Load states: wrench and joint angles are known, the deflection is measured."""

from __future__ import annotations

from stiffcal.experiments import ExperimentKind

KIND = ExperimentKind("load")
