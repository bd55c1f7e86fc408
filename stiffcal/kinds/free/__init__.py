"""Poses without load, which place the frames that are estimated; nothing is identified from them."""

from __future__ import annotations

from stiffcal.kinds import ExperimentKind
from stiffcal.measurements.state_measures import StateMeasure

KIND = ExperimentKind("free", measures=StateMeasure.FRAME)
