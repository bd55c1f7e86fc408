"""What a diagnosis leaves for the report: not made, of the present fit with evidence for what was added, stale."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np

from stiffcal.commands.diagnose import diagnose_campaign
from stiffcal.commands.edit_model import edit_model
from stiffcal.commands.history import read_history
from stiffcal.commands.identify import identify_campaign
from stiffcal.measurements.columns import values_of
from stiffcal.report.content import ReportContent
from stiffcal.report.gathering.content import report_content
from stiffcal.report.gathering.diagnosis import with_diagnosis
from stiffcal.report.provenance_content import ReportProvenance
from stiffcal.stages.steps import RunContext, up_to_date_states
from stiffcal.stages.validation import up_to_date_validation
from tests.laboratory.few_effects import few_effects

NOTHING = ReportContent(ReportProvenance("x", "y", "2026-11-21"), (), ())


def test_not_made_made_and_stale(campaign: Path) -> None:
    data = up_to_date_states(campaign, RunContext())
    identified = identify_campaign(campaign)
    assert with_diagnosis(NOTHING, data, identified).not_diagnosed == "not diagnosed: run stiffcal diagnose"
    edit_model(campaign, "add", "bearing-tilt", where={"joints": "2"})
    with few_effects():
        diagnose_campaign(campaign)
    data, identified = up_to_date_states(campaign, RunContext()), identify_campaign(campaign)
    content = report_content(
        data, identified, up_to_date_validation(data, identified, RunContext()), read_history(campaign)
    )
    assert content.diagnose is not None
    tilt = next(figure for figure in content.evidence if figure.evidence.effect == "bearing-tilt")
    assert not tilt.missing
    assert [parameter.name.rpartition(".")[2] for parameter in tilt.parameters] == ["x", "y"]
    assert tilt.picture is not None
    assert len(tilt.value) == len(tilt.run) == len(tilt.branch) == np.count_nonzero(data.states.used)
    table = data.store.read_table("evidence")
    assert len(values_of(table.column("driver"))) == sum(len(one.value) for one in content.evidence)
    # The campaign's own files stand among the sources with their digests.
    digests = {one.file: one.sha256 for one in content.provenance.sources}
    for name in ("campaign.toml", "robot.toml", "model.toml"):
        assert digests[name] == hashlib.sha256((campaign / name).read_bytes()).hexdigest()
    edit_model(campaign, "remove", "bearing-tilt", where={"joints": "2"})
    identified = identify_campaign(campaign)
    stale = with_diagnosis(NOTHING, up_to_date_states(campaign, RunContext()), identified)
    assert stale.diagnose is None
    assert "stale (it is of fit 2)" in stale.not_diagnosed
