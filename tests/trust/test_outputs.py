"""Files that a command writes where its user wants them: what stiffcal did not write is not overwritten."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import pytest

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.trust import output_kinds, outputs
from stiffcal.trust.output_kinds import CAMPAIGN_FILE, EXPORT, MODEL, OutputKind
from stiffcal.trust.outputs import (
    check_output,
    was_written,
    write_copy,
    write_output,
)


@pytest.fixture(autouse=True)
def own_state(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A state folder, and no memory of this process: what counts is what the next command finds."""
    monkeypatch.setenv("STIFFCAL_STATE", str(tmp_path / "state"))
    monkeypatch.setattr(outputs, "_of_this_process", _Forgetful())
    return tmp_path / "state"


class _Forgetful(set[str]):
    def add(self, note: str) -> None:
        pass


@pytest.fixture
def goal(tmp_path: Path) -> Path:
    (tmp_path / "place").mkdir()
    return tmp_path / "place" / "states.csv"


def refused(goal: Path, content: str = "new") -> bool:
    """Return whether a file is refused as somebody else's, and then as it was."""
    before = goal.read_bytes()
    with suppress(InputError):
        write_output(goal, content, EXPORT)
        assert goal.read_text() == content
        return False
    with pytest.raises(InputError, match=FaultCode.FILE_EXISTS.value):
        write_output(goal, content, EXPORT)
    assert goal.read_bytes() == before
    assert [path.name for path in goal.parent.iterdir()] == [goal.name]
    return True


def test_own_content_is_replaced_and_any_other_is_not(goal: Path) -> None:
    write_output(goal, "first", EXPORT)
    assert not refused(goal, "second")
    goal.write_text(goal.read_text() + "by hand")
    assert refused(goal)
    write_output(goal, "third", EXPORT, overwrite=True)
    assert not refused(goal, "fourth")


def test_what_holds_nothing_is_replaced(goal: Path) -> None:
    goal.touch()
    assert not refused(goal)


def test_own_content_may_have_been_moved(goal: Path) -> None:
    write_output(goal, "first", EXPORT)
    moved = goal.parent.rename(goal.parent.with_name("elsewhere")) / goal.name
    assert not refused(moved)


def test_a_copy_is_own_in_its_place_alone(goal: Path, tmp_path: Path) -> None:
    source = tmp_path / "mine.csv"
    source.write_text("mine")
    write_copy(source, goal, CAMPAIGN_FILE)
    write_copy(source, goal, CAMPAIGN_FILE)  # what is the same already is not lost
    source.write_text("mine, later")
    write_copy(source, goal, CAMPAIGN_FILE)
    with pytest.raises(InputError):
        write_output(source, "theirs", EXPORT)
    assert source.read_text() == "mine, later"
    assert refused(goal)


def test_what_was_written_as_another_kind_is_not_replaced(goal: Path) -> None:
    for kind in (MODEL, OutputKind("another table", EXPORT.endings)):
        write_output(goal, "first", kind, overwrite=True)
        assert refused(goal)
        write_output(goal, "second", kind)


def test_no_two_kinds_have_one_name() -> None:
    kinds = [kind for kind in vars(output_kinds).values() if isinstance(kind, OutputKind)]
    assert len({kind.name for kind in kinds}) == len(kinds) > 15


def test_a_foreign_file_is_not_replaced_by_a_copy(goal: Path, tmp_path: Path) -> None:
    source = tmp_path / "mine.csv"
    source.write_text("mine")
    goal.write_text("theirs")
    with pytest.raises(InputError):
        write_copy(source, goal, CAMPAIGN_FILE)
    assert goal.read_text() == "theirs"


def test_a_link_does_not_lead_to_a_foreign_file(goal: Path, tmp_path: Path) -> None:
    target = tmp_path / "diary.txt"
    target.write_text("mine")
    goal.symlink_to(target)
    assert refused(goal)
    write_output(goal, "new", EXPORT, overwrite=True)
    assert target.read_text() == "mine"
    assert not goal.is_symlink()


def test_a_state_folder_that_others_may_write_to_is_not_believed(goal: Path, own_state: Path) -> None:
    write_output(goal, "first", EXPORT)
    assert was_written(goal, EXPORT)
    (own_state / outputs.OUTPUTS).chmod(0o777)
    assert not was_written(goal, EXPORT)
    (own_state / outputs.OUTPUTS).chmod(0o700)
    assert was_written(goal, EXPORT)


def test_the_oldest_notes_are_forgotten(goal: Path, own_state: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(outputs, "MOST_OUTPUTS", 4)
    for number in range(11):
        write_output(goal, str(number), EXPORT)
        assert len(list((own_state / outputs.OUTPUTS).iterdir())) <= 4
    assert was_written(goal, EXPORT)


@pytest.mark.parametrize("name", ["states.xlsx", "states", "states.csv.gz", "no/states.csv"])
def test_a_name_that_does_not_fit_is_refused_before_the_work(name: str, tmp_path: Path) -> None:
    with pytest.raises(InputError):
        check_output(tmp_path / name, OutputKind("table", (".csv", ".parquet")))
    check_output(tmp_path / "STATES.CSV", OutputKind("table", (".csv",)))
