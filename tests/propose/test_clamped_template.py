"""`init --kind clamped`: what it writes can be rehearsed, from simulated logs to the missing backlash."""

from __future__ import annotations

from pathlib import Path

import pytest

from stiffcal.commands.diagnose import diagnose_campaign
from stiffcal.commands.identify import identify_campaign
from stiffcal.commands.simulate import simulate_campaign
from stiffcal.documents import document_of
from stiffcal.propose.templates import write_template
from tests.laboratory.few_effects import few_effects

BACKLASH = """
[[effects]]
type = "backlash"
joints = [3]
[effects.parameters]
"backlash.j3.width" = { value = 8.0e-4 }
"backlash.j3.band" = { value = 4.0 }
"""


def rehearsal(folder: Path, hidden: str = "") -> Path:
    """The template's rehearsal, with an effect that the analysed model lacks."""
    write_template(folder / "cell", "clamped")
    model = folder / "cell" / "model.toml"
    simplest = model.read_text(encoding="utf-8")
    model.write_text(simplest + hidden, encoding="utf-8")
    simulate_campaign(folder / "cell", folder / "rehearsal")
    (folder / "rehearsal" / "model.toml").write_text(simplest, encoding="utf-8")
    return folder / "rehearsal"


def test_the_model_begins_simple_and_is_identified(tmp_path: Path) -> None:
    folder = rehearsal(tmp_path)
    found = document_of(identify_campaign(folder))
    assert [effect["type"] for effect in found["model"]["effects"]] == ["joint-compliance"]
    values = {parameter["name"]: parameter for parameter in found["parameters"]}
    assert values["joint-compliance.j3.c"]["value"] == pytest.approx(3.3e-6, rel=0.01)
    # what was not driven is not identifiable, and that is stated
    assert values["joint-compliance.j5.c"]["value"] is None
    assert any("joint-compliance.j5.c" in entry["parameters"] for entry in found["not_identifiable"])
    # The encoder's step repeats alike in every cycle: it is part of the noise, and nothing is named for it.
    with few_effects():
        assert diagnose_campaign(folder).missing == []


def test_what_the_simplest_model_lacks_is_named(tmp_path: Path) -> None:
    with few_effects():
        missing = diagnose_campaign(rehearsal(tmp_path, BACKLASH)).missing
    assert [(entry.effect, entry.where.joints) for entry in missing] == [("backlash", [3])]
