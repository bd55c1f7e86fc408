"""Poses without load, which place the frames that are estimated; nothing is identified from them."""

from __future__ import annotations

from stiffcal.experiments import ExperimentKind

KIND = ExperimentKind("free")
