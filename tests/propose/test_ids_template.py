"""`init --kind ids`: what it writes can be rehearsed, from simulated logs of four devices to the link's stiffness."""

from __future__ import annotations

from pathlib import Path

import pytest

from stiffcal.commands.identify import identify_campaign
from stiffcal.commands.simulate import simulate_campaign
from stiffcal.documents import document_of
from stiffcal.propose.templates import write_template


@pytest.mark.long
def test_the_template_is_rehearsed_and_identified(tmp_path: Path) -> None:
    write_template(tmp_path / "cell", "ids")
    file = tmp_path / "cell" / "simulate.toml"
    text = file.read_text(encoding="utf-8")
    # shorter than written: one cycle at two levels, slower loggers
    for long, short in (
        ("levels = [0.33, 0.67, 1.0]\ncycles = 2\nhold_s = 2.0", "levels = [0.5, 1.0]\ncycles = 1\nhold_s = 1.6"),
        ("rate_hz = 100.0", "rate_hz = 50.0"),
        ("rate_hz = 50.0\nwhite = { length_m = 4e-7 }", "rate_hz = 25.0\nwhite = { length_m = 4e-7 }"),
    ):
        assert long in text
        text = text.replace(long, short)
    file.write_text(text, encoding="utf-8")
    manifest = tmp_path / "cell" / "campaign.toml"
    stated = manifest.read_text(encoding="utf-8").replace(
        'units = { length = "um" } }   #', 'units = { length = "um" }, sigma = { length = 0.3 } }   #'
    )
    manifest.write_text(stated, encoding="utf-8")
    simulate_campaign(tmp_path / "cell", tmp_path / "rehearsal")
    found = document_of(identify_campaign(tmp_path / "rehearsal"))
    values = {one["name"]: one["value"] for one in found["parameters"]}
    assert values["link-beam.swing.EI2"] == pytest.approx(6.9e6, rel=0.05)
    assert values["link-beam.swing.EI3"] == pytest.approx(8.0e6, rel=0.05)
    assert values["joint-compliance.j2.c"] == pytest.approx(2.0e-6, rel=0.03)
    assert found["rms"]["length"] < 0.4e-6
    assert not [fault for link in found["links"] for fault in link["faults"]]
