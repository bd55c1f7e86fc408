"""The loop ends with what is hidden in the robot: that effect, at that place, and nothing else."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.workflow.improve import improve_campaign
from tests.laboratory.small_campaign import MODEL, write_small_campaign

COUPLED = """
[[effects]]
type = "axis-coupling"
pairs = [[5, 6]]
[effects.parameters]
"axis-coupling.j5-j6.c" = { value = 1.5e-5 }
"""


@pytest.fixture
def coupled(tmp_path: Path) -> Path:
    """A campaign of a robot whose wrist axes are coupled, which its model does not know."""
    return write_small_campaign(tmp_path / "coupled", hidden=COUPLED)


def effects_of(folder: Path) -> list[str]:
    return [entry.type for entry in load_campaign(folder).model.effects]


def test_ends_with_what_is_hidden(coupled: Path) -> None:
    told: list[dict[str, Any]] = []
    document = improve_campaign(coupled, told=told.append)
    assert [(step["action"], step["effect"], step["where"]) for step in document["steps"]] == [
        ("start", None, {}),
        ("add", "axis-coupling", {"pairs": [[5, 6]]}),
    ]
    assert told == document["steps"]
    assert effects_of(coupled) == ["joint-compliance", "axis-coupling"]
    assert document["adequate"]
    assert not document["missing"]
    start, end = (step["heldout_rms"]["translation"] for step in document["steps"])
    assert end < 0.5 * start
    assert document["heldout_rms"]["translation"] == end


def test_where_the_answer_is_no_nothing_changes(coupled: Path) -> None:
    asked: list[dict[str, Any]] = []

    def no(proposal: dict[str, Any]) -> bool:
        asked.append(proposal)
        return False

    document = improve_campaign(coupled, ask=no)
    assert [one["effect"] for one in asked] == ["axis-coupling"]
    assert [step["action"] for step in document["steps"]] == ["start"]
    assert (coupled / "model.toml").read_text(encoding="utf-8") == MODEL
    # A dry run says the same, and asks nobody.
    rungs = improve_campaign(coupled, ask=no, dry_run=True)["steps"]
    assert [(step["action"], step["effect"]) for step in rungs] == [("start", None), ("would add", "axis-coupling")]
    assert len(asked) == 1
    assert (coupled / "model.toml").read_text(encoding="utf-8") == MODEL
