"""What experiments add to the answers is written to documents, and read back from them."""

from __future__ import annotations

import json

import numpy as np

from stiffcal.documents import document_of, section_of
from stiffcal.kinds.friction.answers.results import (
    BetweenDirections,
    FittedCurve,
    FrictionSection,
    JointFrictionResult,
    SymbolCovariance,
)


def one_joint() -> JointFrictionResult:
    return JointFrictionResult(
        joint=2,
        name="A2",
        method="steady velocities",
        n_readings=40,
        n_speeds=10,
        lowest_speed=0.01,
        highest_speed=1.5,
        rms=0.2,
        noise=None,
        between_directions=BetweenDirections(mean=1.0, low=0.5, high=1.5, weight_possible=True),
        curve=FittedCurve(velocity=np.array([0.01, 1.5]), torque=np.array([9.0, 12.0]), std=np.array([0.1, 0.2])),
        covariance=SymbolCovariance(symbols=["coulomb"], matrix=np.array([[0.04]])),
    )


def test_friction_is_the_same_after_writing_and_reading() -> None:
    section = FrictionSection(effects=["joint-friction"], joints=[one_joint()], lack_of_fit=None, bearings=[])
    document = {"friction": json.loads(json.dumps(document_of(section)))}
    assert list(document["friction"]) == ["effects", "joints", "lack_of_fit", "bearings"]
    read = section_of(FrictionSection, document, "friction")
    assert read is not None
    assert read.joints[0].curve.torque.tolist() == [9.0, 12.0]
    assert document_of(read) == document["friction"]


def test_friction_that_no_model_holds_leaves_out_what_only_a_fit_knows() -> None:
    assert document_of(FrictionSection(joints=[])) == {"joints": []}


def test_a_campaign_without_friction_runs_has_no_section() -> None:
    assert section_of(FrictionSection, {"parameters": []}, "friction") is None
