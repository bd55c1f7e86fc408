"""A command that is repeated after a fault answers as if the fault had not been; each fit is once in the history."""

from __future__ import annotations

import errno
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from stiffcal.commands.edit_model import edit_model
from stiffcal.commands.export import export_campaign
from stiffcal.commands.history import read_history, restore_model
from stiffcal.commands.identify import identify_campaign
from stiffcal.commands.ingest import ingest_campaign
from stiffcal.commands.plot import plot_campaign
from stiffcal.commands.report import report_campaign
from stiffcal.commands.validate import validate_campaign
from stiffcal.commands.view import view_campaign
from stiffcal.documents import document_of
from stiffcal.errors import InputError
from stiffcal.ingest import freshness
from stiffcal.python.opening import open_campaign
from stiffcal.stages.fit import fit_now
from stiffcal.stages.steps import RunContext
from stiffcal.store import Store
from stiffcal.trust import record
from stiffcal.trust.record import open_record
from tests.laboratory.small_campaign import write_small_campaign


def damage(folder: Path, name: str) -> None:
    """Replace a document of the store by something else."""
    file = folder / "store" / "current" / f"{name}.json"
    file.unlink()
    file.write_text("damaged")


def ids(folder: Path) -> list[str]:
    return [fit["id"] for fit in document_of(read_history(folder))["fits"]]


def forget_this_process() -> None:
    """Read the record of trust as another process would."""
    record._of_this_process.clear()
    record._cached.clear()
    record._writable_at_first.clear()


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_small_campaign(tmp_path_factory.mktemp("repeated") / "small", poses=2)


@pytest.fixture
def validated(made: Path, tmp_path: Path, state: Path) -> Path:
    """A campaign of this user, with one fit."""
    folder = tmp_path / "mine"
    shutil.copytree(made, folder, symlinks=True)
    validate_campaign(folder)
    return folder


SHOWN: dict[str, Callable[[Path], object]] = {
    "view": view_campaign,
    "report": report_campaign,
    "plot": plot_campaign,
    "export": lambda folder: export_campaign(folder, output=folder / "states.csv"),
    "residuals": lambda folder: open_campaign(folder).residuals(),
}


@pytest.mark.parametrize("show", SHOWN.values(), ids=SHOWN.keys())
def test_a_changed_model_is_fitted_once(
    show: Callable[[Path], object], validated: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fits: list[Path] = []

    def counted(data: Any, loss: str, context: RunContext) -> Any:
        fits.append(data.campaign.folder)
        return fit_now(data, loss, context)

    for module in ("stages.fit", "stages.validation", "commands.identify", "stages.other_model"):
        monkeypatch.setattr(f"stiffcal.{module}.fit_now", counted)
    edit_model(validated, "remove", "joint-compliance", where={"joints": "6"})
    show(validated)
    assert len(fits) == 1


@pytest.mark.parametrize("name", ["provenance", "ingest"])
def test_states_damaged_after_they_were_compared_are_made_again(
    validated: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    before = document_of(read_history(validated))["fits"]
    true = freshness.freshness_of

    def damaged_afterwards(*given: Any) -> freshness.Freshness:
        found = true(*given)
        damage(validated, name)
        return found

    monkeypatch.setattr(freshness, "freshness_of", damaged_afterwards)
    said: list[str] = []
    export_campaign(validated, RunContext(notify=said.append), tmp_path / "states.parquet")
    assert said == [f"running ingest: the store is damaged: {name}"]
    assert name in Store(validated / "store").documents
    assert document_of(read_history(validated))["fits"] == before


@pytest.mark.parametrize("name", ["provenance", "states"])
@pytest.mark.parametrize("use", [ingest_campaign, identify_campaign])
def test_a_store_without_a_part_that_all_have_is_made_again(validated: Path, name: str, use: Any) -> None:
    store = Store(validated / "store")
    with store.begin() as writing:
        writing.keep(*({*store.tables, *store.documents} - {name}))
        writing.commit()
    use(validated)
    assert name in (*store.tables, *store.documents)
    assert ids(validated) == ["1"]


def test_a_damaged_fit_is_made_again_as_the_same_entry(validated: Path) -> None:
    before = document_of(read_history(validated))["fits"]
    damage(validated, "identify")
    assert identify_campaign(validated).fit_id == "1"
    assert document_of(read_history(validated))["fits"] == before
    assert before[0]["heldout_rms"] is not None


def test_the_model_of_an_earlier_fit_is_that_fit_again(validated: Path) -> None:
    edit_model(validated, "remove", "joint-compliance", where={"joints": "6"})
    assert identify_campaign(validated).fit_id == "2"
    restore_model(validated, RunContext(), "1")
    assert "not_fitted_yet" in document_of(read_history(validated))
    assert identify_campaign(validated).fit_id == "1"
    assert "not_fitted_yet" not in document_of(read_history(validated))
    assert ids(validated) == ["1", "2"]


def test_where_nothing_is_remembered_the_history_does_not_grow_with_each_command(
    validated: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("STIFFCAL_STATE", str(validated / "state"))  # not believed: it lies in the campaign folder
    for _ in range(3):
        forget_this_process()
        identify_campaign(validated)
    # The first is of somebody else, as far as anybody can know.
    assert ids(validated) == ["1", "2"]


def refuse_record(*given: Any) -> None:
    raise OSError(errno.EFBIG, "File too large")


def test_what_the_record_cannot_take_is_known_to_the_next_command(
    validated: Path, monkeypatch: pytest.MonkeyPatch, state: Path
) -> None:
    edit_model(validated, "remove", "joint-compliance", where={"joints": "6"})
    with monkeypatch.context() as patch:
        patch.setattr(record, "_replace", refuse_record)
        identify_campaign(validated)
    forget_this_process()
    said: list[str] = []
    assert identify_campaign(validated, RunContext(notify=said.append)).fit_id == "2"
    assert said == ["nothing has changed since fit 2"]
    assert [fit["origin"] for fit in document_of(read_history(validated))["fits"]] == ["own", "own"]
    assert (state / "pending").exists()
    open_record().allow_plugin("0" * 64, "elsewhere")  # the record takes it now
    assert not (state / "pending").exists()
    forget_this_process()
    assert Store(validated / "store").origin_of("identify") == "own"


def test_what_cannot_be_remembered_at_all_is_not_committed(validated: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    edit_model(validated, "remove", "joint-compliance", where={"joints": "6"})
    generation = Store(validated / "store").generation
    with monkeypatch.context() as patch:
        patch.setattr(record, "_replace", refuse_record)
        patch.setattr(record, "add_pending", lambda *given: False)
        with pytest.raises(InputError, match=r"File too large.*; what was stored before is unchanged"):
            identify_campaign(validated)
    forget_this_process()
    store = Store(validated / "store")
    assert store.generation == generation
    assert store.origin_of("identify") == "own"
    assert identify_campaign(validated).fit_id == "2"


def test_leftovers_of_a_killed_command_go_with_the_next_one(validated: Path) -> None:
    for use in (ingest_campaign, identify_campaign):
        (validated / "store" / "generations" / "20200101T000000-aaaaaa").mkdir()
        use(validated)
        assert len(list((validated / "store" / "generations").iterdir())) == 1


def test_showing_the_results_of_a_stranger_removes_nothing(validated: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("STIFFCAL_STATE", str(validated.parent / "another user"))
    shutil.rmtree(validated / "raw")
    left = validated / "store" / "generations" / "20200101T000000-aaaaaa"
    left.mkdir()
    assert identify_campaign(validated).origin == "foreign"
    assert left.exists()
