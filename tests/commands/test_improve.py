"""The loop ends with what is hidden in the robot: that effect, at that place, and nothing else."""

from __future__ import annotations

import shlex
import shutil
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.commands.diagnose import diagnose_campaign
from stiffcal.commands.history import read_history
from stiffcal.commands.improve import improve_campaign
from stiffcal.diagnosis.answers.results import DiagnoseResult, ProposedEffect
from stiffcal.model.summary import EffectAt, Where
from stiffcal.results.improve_results import ImproveStep
from stiffcal.results.model_changes import Decision, EffectProposal, next_changes, not_added_in_words, to_add
from tests.cli.test_commands import run as run_command
from tests.laboratory.small_campaign import MODEL, STIFFNESS, write_small_campaign

pytestmark = pytest.mark.usefixtures("few_known_effects")
COUPLED = """
[[effects]]
type = "axis-coupling"
pairs = [[5, 6]]
[effects.parameters]
"axis-coupling.j5-j6.c" = { value = 1.5e-5 }
"""


@pytest.fixture(scope="module")
def diagnosed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign of a robot whose wrist axes are coupled, which its model does not know; not to be changed."""
    folder = write_small_campaign(tmp_path_factory.mktemp("improve") / "coupled", hidden=COUPLED)
    diagnose_campaign(folder)
    return folder


@pytest.fixture
def coupled(diagnosed: Path, tmp_path: Path) -> Path:
    """A copy of it that a test may change; its store holds the first diagnosis."""
    return Path(shutil.copytree(diagnosed, tmp_path / "coupled", symlinks=True))


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


def test_the_answer_names_the_changed_file_and_takes_it_back(coupled: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = (coupled / "model.toml").read_text("utf-8")
    run_command("improve", coupled, "--yes")
    changed = next(line for line in capsys.readouterr().out.splitlines() if str(coupled / "model.toml") in line)
    undo = shlex.split(changed[changed.index("stiffcal ") :])
    assert undo[1:] == ["history", str(coupled), "--restore", "1"]
    run_command(*undo[1:])
    assert (coupled / "model.toml").read_text("utf-8") == before


def test_each_step_shows_what_it_did_to_the_stiffness(coupled: Path) -> None:
    """What a dry run announces is what the step then does, and the values after it are those of the robot."""
    announced = improve_campaign(coupled, dry_run=True)
    assert [step.before_after for step in announced.steps] == [[], []]
    result = improve_campaign(coupled)
    added = {value.name: value for value in result.steps[1].before_after}
    moved = {name for name, value in added.items() if value.outside_interval}
    assert moved == {value.name for value in announced.before_after if value.outside_interval}
    assert moved & {"joint-compliance.j5.c", "joint-compliance.j6.c"}
    assert result.before_after == result.steps[1].before_after
    for name in moved:
        after, truth = added[name].after, STIFFNESS[int(name.split(".")[1][1:]) - 1]
        assert after is not None
        assert after.interval is not None
        assert after.interval[0] is not None
        assert after.interval[0] * 0.99 < truth < (after.interval[1] or truth) * 1.01
    coupling = added["axis-coupling.j5-j6.c"]
    assert coupling.before is None
    assert coupling.after is not None
    assert [step.before_after for step in result.steps[:1]] == [[]]


def test_where_the_answer_is_no_nothing_changes(coupled: Path) -> None:
    asked: list[ProposedEffect | EffectAt] = []

    def no(proposal: EffectProposal) -> Decision:
        asked.append(proposal.effect)
        return "stop"

    result = improve_campaign(coupled, ask=no)
    assert [effect.effect for effect in asked] == ["axis-coupling"]
    assert [step.action for step in result.steps] == ["start"]
    assert (coupled / "model.toml").read_text(encoding="utf-8") == MODEL
    # A dry run says the same, and asks nobody.
    rungs = improve_campaign(coupled, ask=no, dry_run=True).steps
    assert [(step.action, step.effect) for step in rungs] == [("start", None), ("would add", "axis-coupling")]
    assert len(asked) == 1
    assert (coupled / "model.toml").read_text(encoding="utf-8") == MODEL


def test_what_is_skipped_is_not_proposed_again(coupled: Path) -> None:
    asked: list[str] = []

    def skip(proposal: EffectProposal) -> Decision:
        asked.append(proposal.effect.effect)
        return "skip"

    result = improve_campaign(coupled, ask=skip)
    assert asked == ["axis-coupling"]
    assert result.missing
    assert (coupled / "model.toml").read_text(encoding="utf-8") == MODEL


def test_another_effect_can_be_chosen(coupled: Path) -> None:
    other = EffectAt(effect="bearing-tilt", where=Where(joints=[5]))
    decisions: list[Decision] = [other, "stop"]
    result = improve_campaign(coupled, ask=lambda proposal: decisions.pop(0))
    assert [(step.action, step.effect, step.where) for step in result.steps][1] == ("add", other.effect, other.where)
    assert "bearing-tilt" in effects_of(coupled)
    assert [fit.likely for fit in read_history(coupled).fits][-2:] == [None, [other]]


def test_what_a_user_wrote_into_the_model_is_named_and_stays(tmp_path: Path) -> None:
    folder = write_small_campaign(tmp_path / "plain")
    model = folder / "model.toml"
    model.write_text(model.read_text(encoding="utf-8") + '\n[[effects]]\ntype = "bearing-tilt"\njoints = [3]\n')
    assert [one.effect for one in diagnose_campaign(folder).superfluous] == ["bearing-tilt"]
    result = improve_campaign(folder)
    assert [step.action for step in result.steps] == ["start"]
    assert effects_of(folder) == ["joint-compliance", "bearing-tilt"]


def test_what_was_added_and_is_not_needed_is_removed() -> None:
    tilt, beam = (EffectAt(effect=name, where=Where(joints=[3])) for name in ("bearing-tilt", "backlash"))
    diagnosed = cast(DiagnoseResult, SimpleNamespace(missing=[], undecided=[], superfluous=[tilt, beam]))
    assert next_changes(diagnosed, [], [("add", tilt.effect, tilt.where)], likely=False) == [("remove", tilt)]


def test_what_is_not_certain_is_added_when_asked_for() -> None:
    where = Where(joints=[3])
    certain, likely, undecided, with_another = (
        ProposedEffect(effect=name, where=where, alternatives=[], probability=p, member_probability=share, firm=firm)
        for name, p, share, firm in (
            ("backlash", 0.99, 0.99, True), ("two-slope", 0.8, 0.8, False), ("creep", 0.99, 0.4, False),
            ("bearing-tilt", 0.99, 0.52, False),
        )
    )  # fmt: skip
    diagnosed = cast(
        DiagnoseResult,
        SimpleNamespace(
            missing=[certain, likely, undecided, with_another],
            undecided=[EffectAt(effect="bearing-tilt", where=where), EffectAt(effect="link-beam", where=where)],
        ),
    )
    assert to_add(diagnosed, likely=False) == [certain]
    assert to_add(diagnosed, likely=True) == [certain, likely]
    left = not_added_in_words(diagnosed)
    assert "--likely" in left
    assert [left.count(one.effect) for one in (certain, likely, undecided)] == [0, 2, 1]
    for missing, named in ((certain, 0), (likely, 1), (undecided, 1)):
        alone = not_added_in_words(cast(DiagnoseResult, SimpleNamespace(missing=[missing], undecided=[])))
        assert (alone.count(missing.effect), "–" in alone) == (named, False)
