"""A part of ``python -m tests.next_steps``: the states that are followed in seconds."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.next_steps.states import ALL, QUICK, State
from tests.next_steps.walking import Walker, next_words, refused_commands


@pytest.fixture(scope="module")
def walker(tmp_path_factory: pytest.TempPathFactory) -> Walker:
    return Walker(tmp_path_factory.mktemp("copies"))


@pytest.mark.parametrize("state", QUICK, ids=lambda state: state.name)
def test_every_proposed_step_runs_and_none_comes_again(state: State, walker: Walker, tmp_path: Path) -> None:
    folder = tmp_path / "campaign"
    state.make(folder)
    start = walker.begin(folder)
    assert [fault for words in state.entries for fault in walker.follow(start, words)] == []


def test_fifty_states_are_known() -> None:
    assert len({state.name for state in ALL}) == len(ALL) >= 50


def test_a_loop_and_a_step_that_fails_are_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "campaign"
    folder.mkdir()
    (tmp_path / "copies").mkdir()
    answers = {("a",): (0, "next: stiffcal b"), ("b",): (1, "next: stiffcal a"), ("c",): (0, "next: stiffcal d")}
    monkeypatch.setattr(
        "tests.next_steps.walking.run", lambda folder, words: (*answers.get(tuple(words), (2, "no")), "")
    )
    walker = Walker(tmp_path / "copies")
    start = walker.begin(folder)
    assert [fault.split(":")[0] for fault in walker.follow(start, ("a",))] == ["comes back to"]
    assert [fault.split(":")[0] for fault in walker.follow(start, ("c",))] == ["exit code 2"]
    assert next_words("next: stiffcal plan 'my robot' --force 3\n", "") == ("plan", "my robot", "--force", "3")


def test_a_printed_command_that_is_refused_is_found() -> None:
    taken = "once it is there: stiffcal compare . LATER_DIR\nmodel: none; stiffcal add . backlash --all [no-effect]"
    assert list(refused_commands(taken + "\nthe runs are gone; stiffcal check names each")) == []
    for line in (
        "once it is there: stiffcal compare LATER_DIR",
        "m.toml: none; stiffcal add backlash --all [no-effect]",
    ):
        assert len(list(refused_commands(line))) == 1
