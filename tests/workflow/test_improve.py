"""The loop ends with what is hidden in the robot: that effect, at that place, and nothing else."""

from __future__ import annotations

from pathlib import Path

import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.diagnosis.results import ProposedEffect
from stiffcal.model.summary import Where
from stiffcal.workflow.improve import improve_campaign
from stiffcal.workflow.improve_results import ImproveStep
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
    steps: list[ImproveStep] = []
    result = improve_campaign(coupled, notify_step=steps.append)
    assert [(step.action, step.effect, step.where) for step in result.steps] == [
        ("start", None, Where()),
        ("add", "axis-coupling", Where(pairs=[[5, 6]])),
    ]
    assert steps == result.steps
    assert effects_of(coupled) == ["joint-compliance", "axis-coupling"]
    assert result.adequate
    assert not result.missing
    errors = [step.heldout_rms.translation for step in result.steps if step.heldout_rms is not None]
    assert errors[0] is not None
    assert errors[1] is not None
    assert errors[1] < 0.5 * errors[0]
    assert result.heldout_rms.translation == errors[1]


def test_where_the_answer_is_no_nothing_changes(coupled: Path) -> None:
    asked: list[ProposedEffect] = []

    def no(effect: ProposedEffect) -> bool:
        asked.append(effect)
        return False

    result = improve_campaign(coupled, ask=no)
    assert [effect.effect for effect in asked] == ["axis-coupling"]
    assert [step.action for step in result.steps] == ["start"]
    assert (coupled / "model.toml").read_text(encoding="utf-8") == MODEL
    # A dry run says the same, and asks nobody.
    rungs = improve_campaign(coupled, ask=no, dry_run=True).steps
    assert [(step.action, step.effect) for step in rungs] == [("start", None), ("would add", "axis-coupling")]
    assert len(asked) == 1
    assert (coupled / "model.toml").read_text(encoding="utf-8") == MODEL
