"""`init --kind clamped`: what it writes can be rehearsed, from simulated logs to play and curve."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiffcal.campaign.templates import write_template
from stiffcal.documents import document_of
from stiffcal.workflow.diagnose import diagnose_campaign
from stiffcal.workflow.identify import identify_campaign
from stiffcal.workflow.simulate import simulate_campaign


def test_the_template_is_rehearsed_and_identified(tmp_path: Path) -> None:
    write_template(tmp_path / "cell", "clamped")
    file = tmp_path / "cell" / "simulate.toml"
    file.write_text(file.read_text(encoding="utf-8").replace("rest_s = 1.5", "rest_s = 1.5\npoints = 60"))
    simulate_campaign(tmp_path / "cell", tmp_path / "rehearsal")
    found = document_of(identify_campaign(tmp_path / "rehearsal"))
    values = {one["name"]: one for one in found["parameters"]}
    assert values["backlash.j3.width"]["value"] == pytest.approx(8e-4, abs=np.deg2rad(0.001))
    assert values["cubic-stiffness.j3.p1"]["value"] == pytest.approx(3e5, rel=0.02)
    # what was not driven is not told, and that is said
    assert (
        values["cubic-stiffness.j5.p1" if "cubic-stiffness.j5.p1" in values else "cubic-stiffness.j5.c2"]["value"]
        is None
    )
    assert any("cubic-stiffness.j5" in name for one in found["not_identifiable"] for name in one["parameters"])
    # The encoder's step repeats alike in every cycle: it is part of the noise, and nothing is named for it.
    assert diagnose_campaign(tmp_path / "rehearsal").missing == []
