"""Tables of Python hold the same numbers as terminal and report."""

from __future__ import annotations

from stiffcal.python.model_diagnosis import ModelDiagnosis
from tests.report.test_diagnosis_pages import diagnosed, proposed


def test_the_ranking_states_the_same_share_as_the_report() -> None:
    assert ModelDiagnosis(diagnosed(explained_by_missing=0.971), None).ranking["explains"].tolist() == [0.971]
    two = [proposed(), proposed()]
    assert ModelDiagnosis(diagnosed(explained_by_missing=0.971, missing=two), None).ranking["explains"].tolist() == [
        0.98
    ]
