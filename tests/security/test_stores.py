"""A campaign folder that brings a store with it: a stranger's results are computed again, or shown and not counted."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as parquet
import pytest

from stiffcal.batch import task as batch_task
from stiffcal.batch.results import BatchTask, CampaignOutcome
from stiffcal.batch.task import run_task
from stiffcal.cli.app import main
from stiffcal.documents import document_of
from stiffcal.errors import InputError
from stiffcal.store import Store
from stiffcal.trust import foreign_content
from stiffcal.trust.record import open_record
from stiffcal.workflow.compare import compare_campaigns
from stiffcal.workflow.history import read_history, restore_model
from stiffcal.workflow.identify import identify_campaign
from stiffcal.workflow.steps import RunContext, up_to_date_states
from stiffcal.workflow.stored import stored_document
from stiffcal.workflow.validate import validate_campaign
from tests.laboratory.small_campaign import write_small_campaign

STRICT = "\n[thresholds]\nmax_rms_m = 1e-9\n"
NOT_YOURS = "ingest first: the store was not written by you: computed again"


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign that somebody else has identified and validated, with a threshold that it does not hold."""
    root = tmp_path_factory.mktemp("stranger")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("STIFFCAL_STATE", str(root / "state"))
        folder = write_small_campaign(root / "small", poses=2)
        with (folder / "campaign.toml").open("a", encoding="utf-8") as file:
            file.write(STRICT)
        assert validate_campaign(folder).passed is False
    return folder


@pytest.fixture
def delivered(made: Path, tmp_path: Path, state: Path) -> Path:
    """The stranger's folder on this user's machine, where nothing is recorded of it."""
    shutil.copytree(made, tmp_path / "small", symlinks=True)
    return tmp_path / "small"


def forge(folder: Path, name: str, change: Callable[[dict[str, Any]], None]) -> None:
    """Rewrite a document of the store together with its entry in the index, as somebody might who knows the format."""
    current = (folder / "store" / "current").resolve()
    document = json.loads((current / f"{name}.json").read_text("utf-8"))
    change(document)
    content = json.dumps(document).encode()
    (current / f"{name}.json").write_bytes(content)
    index = json.loads((current / "generation.json").read_text("utf-8"))
    index["documents"][name] |= {"bytes": len(content), "sha256": hashlib.sha256(content).hexdigest()}
    (current / "generation.json").write_text(json.dumps(index), "utf-8")


def hold(document: dict[str, Any]) -> None:
    """Make a validation say that all is well."""
    document.update(passed=True, failed=[], rms={"translation": 1e-12, "rotation": 1e-12})
    for check in document["checks"]:
        check.update(held=True, value=1e-12)


def batch(folder: Path) -> CampaignOutcome:
    return run_task(BatchTask(folder=str(folder), campaign="small", report=False))


def without_logs(folder: Path) -> Path:
    shutil.rmtree(folder / "raw")
    return folder


def test_forged_results_do_not_make_batch_say_held(delivered: Path) -> None:
    forge(delivered, "validate", hold)
    forge(delivered, "identify", lambda document: document.update(rms={"translation": 1e-12, "rotation": 1e-12}))
    outcome = batch(delivered)
    assert outcome.state == "not held"
    assert outcome.origin == "own"
    assert outcome.steps["ingest"].why == "the store was not written by you: computed again"
    assert outcome.rms is not None
    assert (outcome.rms.translation or 0.0) > 1e-6


def test_results_of_one_own_are_not_computed_again(delivered: Path) -> None:
    said: list[str] = []
    first = validate_campaign(delivered, RunContext(notify=said.append))
    assert said == [NOT_YOURS, "identify first: nothing is fitted yet"]
    said.clear()
    assert validate_campaign(delivered, RunContext(notify=said.append)) == first
    assert identify_campaign(delivered).origin == first.origin == "own"
    assert said == []


@pytest.mark.parametrize("how", ["copied", "moved", "links followed"])
def test_an_own_store_stays_own_wherever_it_lies(delivered: Path, tmp_path: Path, how: str) -> None:
    validate_campaign(delivered)
    goal = tmp_path / "elsewhere"
    if how == "moved":
        delivered.rename(goal)
    else:
        shutil.copytree(delivered, goal, symlinks=how == "copied")
    said: list[str] = []
    assert validate_campaign(goal, RunContext(notify=said.append)).origin == "own"
    assert said == []


def test_a_document_changed_in_an_own_store_is_computed_again(delivered: Path) -> None:
    true = validate_campaign(delivered)
    forge(delivered, "validate", hold)  # with its index: the generation is nobody's now
    assert batch(delivered).state == "not held"
    current = delivered / "store" / "current"
    document = json.loads((current / "validate.json").read_text("utf-8"))
    hold(document)
    (current / "validate.json").write_text(json.dumps(document), "utf-8")  # without it
    said: list[str] = []
    again = validate_campaign(delivered, RunContext(notify=said.append))
    assert document_of(again.rms) == pytest.approx(document_of(true.rms))
    assert again.passed is False
    assert any("validate: damaged" in line and "computed again" in line for line in said)


@pytest.mark.skipif(os.name == "nt", reason="Windows keeps no time of change of an inode: there all is hashed")
def test_a_log_rewritten_with_its_size_and_time_kept_is_noticed(tmp_path: Path, state: Path) -> None:
    folder = write_small_campaign(tmp_path / "mine", poses=2)
    log = folder / "raw" / "states.csv"
    os.utime(log, ns=(log.stat().st_atime_ns, log.stat().st_mtime_ns - 10**12))
    before = identify_campaign(folder)
    found, text = log.stat(), log.read_text()
    last = text.rstrip()[-1]
    log.write_text(text.rstrip()[:-1] + ("1" if last != "1" else "2") + "\n")
    os.utime(log, ns=(found.st_atime_ns, found.st_mtime_ns))
    assert (log.stat().st_size, log.stat().st_mtime_ns) == (found.st_size, found.st_mtime_ns)
    said: list[str] = []
    after = identify_campaign(folder, RunContext(notify=said.append))
    assert said[0] == "ingest first: changed: raw/states.csv"
    assert after.key != before.key


def test_logs_are_not_hashed_again_where_the_file_system_says_they_are_unchanged(
    delivered: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from stiffcal.store import provenance

    monkeypatch.setattr(provenance, "RACY_NS", -(10**18))  # as if the logs had been written long ago
    identify_campaign(delivered)
    hashed: list[str] = []
    true_hash = provenance._hash_file

    def hash_file(folder: Path, file: str, *rest: Any) -> Any:
        hashed.append(file)
        return true_hash(folder, file, *rest)

    monkeypatch.setattr(provenance, "_hash_file", hash_file)
    identify_campaign(delivered)
    validate_campaign(delivered)
    assert hashed == [] or os.name == "nt"
    batch(delivered)
    assert hashed == ["raw/states.csv"]  # a batch looks at all that counts


def test_without_the_logs_a_strangers_results_are_shown_and_marked(
    delivered: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    without_logs(delivered)
    said: list[str] = []
    fit = identify_campaign(delivered, RunContext(notify=said.append))
    assert fit.origin == "foreign"
    assert said[0] == "the logs are missing (raw/states.csv): results that were not computed by you are shown"
    assert validate_campaign(delivered).origin == "foreign"
    with pytest.raises(SystemExit) as ended:
        main(["identify", str(delivered)])
    assert ended.value.code == 0
    assert capsys.readouterr().out.startswith("not computed by you")


@pytest.mark.parametrize("thresholds", [STRICT, "\n[thresholds]\nmax_rms_m = 1.0\n", ""])
def test_without_the_logs_no_threshold_is_held(made: Path, tmp_path: Path, state: Path, thresholds: str) -> None:
    shutil.copytree(made, tmp_path / "small", symlinks=True)
    folder = without_logs(tmp_path / "small")
    manifest = folder / "campaign.toml"
    manifest.write_text(manifest.read_text().replace(STRICT, thresholds))
    forge(folder, "validate", hold)
    document = validate_campaign(folder)
    assert document.passed is False
    assert not any(check.held for check in document.checks)
    assert "not computed by you" in document.failed[0]
    assert batch(folder).state == "not held"
    with pytest.raises(SystemExit) as ended:
        main(["validate", str(folder), "--json"])
    assert ended.value.code == 1


def test_a_fit_of_a_strangers_states_stays_a_strangers(delivered: Path, made: Path) -> None:
    without_logs(delivered)
    (delivered / "model.toml").write_text(
        'schema = "stiffcal/model/1"\n[[effects]]\ntype = "joint-compliance"\njoints = [2, 3]\n'
    )
    assert identify_campaign(delivered).origin == "foreign"
    assert validate_campaign(delivered).passed is False
    assert Store(delivered / "store").origin_of("identify", "states") == "foreign"
    # When the logs come, all is computed from them.
    shutil.copytree(made / "raw", delivered / "raw")
    said: list[str] = []
    assert identify_campaign(delivered, RunContext(notify=said.append)).origin == "own"
    assert said[0] == NOT_YOURS


def test_the_baseline_of_a_stranger_is_computed_again_or_refused(delivered: Path, made: Path, tmp_path: Path) -> None:
    folder = write_small_campaign(tmp_path / "mine", poses=2)
    shutil.copytree(delivered, folder / "before", symlinks=True)
    with (folder / "campaign.toml").open("a", encoding="utf-8") as file:
        file.write('\n[thresholds]\nbaseline = "before"\nmax_drift = 0.5\n')

    def stiffer(document: dict[str, Any]) -> None:
        for parameter in document["parameters"]:
            parameter.update(value=1e-12, stiffness=1e12)

    forge(folder / "before", "identify", stiffer)
    assert validate_campaign(folder).passed is True  # of the same robot, once it is computed again
    shutil.copytree(made, folder / "again", symlinks=True)
    shutil.rmtree(folder / "before")
    (folder / "again").rename(folder / "before")
    without_logs(folder / "before")
    with pytest.raises(InputError, match=r"thresholds\.baseline: before: the results were not computed by you"):
        validate_campaign(folder)


def test_a_model_of_a_stranger_is_judged_only_after_it_is_computed_again(delivered: Path, tmp_path: Path) -> None:
    folder = write_small_campaign(tmp_path / "mine", poses=2)
    with pytest.raises(InputError, match="its store was not written by you; run stiffcal identify"):
        validate_campaign(folder, model=delivered)
    without_logs(delivered)
    document = validate_campaign(folder, model=delivered)
    assert (document.origin, document.passed) == ("foreign", False)


@pytest.mark.parametrize("swapped", [False, True])
def test_a_comparison_with_a_stranger_s_campaign_is_marked_whichever_comes_first(
    delivered: Path, tmp_path: Path, swapped: bool
) -> None:
    mine, strange = write_small_campaign(tmp_path / "mine", poses=2), without_logs(delivered)
    foreign_content.use_own_results()
    before, after = (mine, strange) if swapped else (strange, mine)
    assert compare_campaigns(before, after).origin == "foreign"
    assert foreign_content.fault_of_foreign_content(KeyError("x")) is not None
    foreign_content.use_own_results()


def test_history_of_a_stranger_is_kept_entry_by_entry_and_marked(delivered: Path) -> None:
    forge(delivered, "history", lambda document: document["fits"][0].update(origin="own", loss="huber"))
    assert [fit["origin"] for fit in document_of(read_history(delivered))["fits"]] == ["foreign"]
    validate_campaign(delivered)
    fits = document_of(read_history(delivered))["fits"]
    assert [(fit["id"], fit["origin"], fit["loss"]) for fit in fits] == [
        ("1", "foreign", "huber"),
        ("2", "own", "linear"),
    ]
    (delivered / "model.toml").write_text(
        'schema = "stiffcal/model/1"\n[[effects]]\ntype = "joint-compliance"\njoints = [2, 3]\n'
    )
    identify_campaign(delivered)
    assert [fit["origin"] for fit in document_of(read_history(delivered))["fits"]] == ["foreign", "own", "own"]


@pytest.mark.parametrize(
    "entry",
    [{}, {"id": "9" * 5000}, {"id": 7}, {"id": "../1"}, {"model": 3}, {"model": {"balance": "x", "effects": None}},
     {"fit_rms": None}, {"time": None}, {"model_text": []}, {"heldout_rms": {"translation": "1"}}],
)  # fmt: skip
def test_an_entry_of_the_wrong_shape_harms_nothing(delivered: Path, entry: dict[str, Any]) -> None:
    def add(document: dict[str, Any]) -> None:
        document["fits"].append(document["fits"][0] | {"id": "2"} | entry if entry else "no entry")

    forge(delivered, "history", add)
    assert [fit["id"] for fit in document_of(read_history(delivered))["fits"]] == ["1"]
    assert identify_campaign(delivered).fit_id.isdigit()


def test_restoring_a_strangers_model_shows_it_and_asks(
    delivered: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    (delivered / "model.toml").unlink()
    text = 'schema = "stiffcal/model/1"\n# \u202e\n[[effects]]\ntype = "joint-compliance"\njoints = [2]\n'
    forge(delivered, "history", lambda document: document["fits"][0].update(model_text=text))
    with pytest.raises(InputError, match="history: fit 1: this fit was not made by you"):
        restore_model(delivered, RunContext(), "1")
    for words, code in (([], 2), (["--json"], 2), (["--yes"], 0)):
        with pytest.raises(SystemExit) as ended:
            main(["history", str(delivered), "--restore", "1", *words])
        error = capsys.readouterr().err
        assert ended.value.code == code
        assert "joints = [2]" in error
        assert "\u202e" not in error
        assert (delivered / "model.toml").exists() == (code == 0)
    assert (delivered / "model.toml").read_text("utf-8") == text


def test_restoring_what_is_no_model_is_one_line(delivered: Path) -> None:
    (delivered / "model.toml").unlink()
    forge(delivered, "history", lambda document: document["fits"][0].update(model_text="[[effects]]\ntype = 7\n"))
    with pytest.raises(InputError, match=r"model\.toml"):
        restore_model(delivered, RunContext(), "1", lambda entry: True)
    assert not (delivered / "model.toml").exists()


def test_a_store_of_version_0_1_is_computed_again_and_its_history_kept(delivered: Path) -> None:
    index = delivered / "store" / "current" / "generation.json"
    document = json.loads(index.read_text("utf-8"))
    document["schema"] = "stiffcal/store/1"
    for kind in ("tables", "documents"):
        for entry in document[kind].values():
            del entry["sha256"]
    index.write_text(json.dumps(document), "utf-8")
    said: list[str] = []
    assert identify_campaign(delivered, RunContext(notify=said.append)).origin == "own"
    assert said[0] == NOT_YOURS
    assert [fit["origin"] for fit in document_of(read_history(delivered))["fits"]] == ["foreign", "own"]


def test_in_a_trusted_place_what_others_wrote_counts(delivered: Path, state: Path) -> None:
    open_record().allow_place(str(delivered.parent))
    said: list[str] = []
    document = validate_campaign(delivered, RunContext(notify=said.append))
    assert said == []
    assert document.origin == "trusted place"
    assert document.passed is False
    assert "not computed by you" not in document.failed[0]
    open_record().revoke(str(delivered.parent))
    assert validate_campaign(delivered, RunContext(notify=said.append)).origin == "own"
    assert said[0] == NOT_YOURS


def test_store_option_is_no_proof_of_origin(delivered: Path) -> None:
    said: list[str] = []
    means = RunContext(store=str(delivered / "store"), notify=said.append)
    assert identify_campaign(delivered, means).origin == "own"
    assert said[0] == NOT_YOURS


def test_where_nothing_can_be_remembered_each_step_is_computed_once(
    delivered: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    inside = delivered / "state"  # a record in the campaign folder is not believed
    monkeypatch.setenv("STIFFCAL_STATE", str(inside))
    said: list[str] = []
    document = validate_campaign(delivered, RunContext(notify=said.append))
    assert document.origin == "own"
    assert len(said) == 2
    assert not inside.exists()
    lines = [line for line in capsys.readouterr().err.splitlines() if "nothing is remembered" in line]
    assert len(lines) == 1


def test_no_update_refuses_a_strangers_store(delivered: Path) -> None:
    with pytest.raises(InputError, match="the store was not written by you"):
        identify_campaign(delivered, RunContext(update=False))


WRONG: tuple[object, ...] = ([], "x", -1)


@pytest.mark.parametrize("name", ["identify", "validate", "ingest", "provenance", "history"])
def test_every_key_of_a_strangers_document_may_be_something_else(delivered: Path, tmp_path: Path, name: str) -> None:
    without_logs(delivered)
    store = delivered / "store"
    shutil.copytree(store, tmp_path / "pristine", symlinks=True)
    for key in Store(store).read_document(name):
        for value in WRONG:
            shutil.rmtree(store)
            shutil.copytree(tmp_path / "pristine", store, symlinks=True)
            forge(delivered, name, partial(dict.update, **{key: value}))
            with suppress(InputError):  # one line
                if name in ("identify", "validate"):
                    stored_document(Store(store), name)
                if name == "history":
                    read_history(delivered)
                else:
                    assert not validate_campaign(delivered).passed


def forge_table(folder: Path, name: str, table: Any) -> None:
    """Put another table in the place of one of the store, together with its entry in the index."""
    current = (folder / "store" / "current").resolve()
    parquet.write_table(table, current / f"{name}.parquet")
    content = (current / f"{name}.parquet").read_bytes()
    index = json.loads((current / "generation.json").read_text("utf-8"))
    index["tables"][name] |= {"bytes": len(content), "sha256": hashlib.sha256(content).hexdigest()}
    (current / "generation.json").write_text(json.dumps(index), "utf-8")


@pytest.mark.parametrize("words", [("export", "-o", "x.csv"), ("plot", "-o", "x.png"), ("identify",)])
@pytest.mark.parametrize("name", ["states", "fit", "unseen"])
@pytest.mark.parametrize("how", ["other columns", "other rows", "other types"])
def test_a_strangers_table_of_another_shape_is_one_line(
    delivered: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...],
    name: str, how: str,
) -> None:  # fmt: skip
    monkeypatch.chdir(delivered)
    without_logs(delivered)
    table = Store(delivered / "store").read_table(name)
    others = {
        "other columns": pa.table({"x": [1.0]}).replace_schema_metadata(table.schema.metadata),
        "other rows": table.slice(0, 3),
        "other types": pa.table({column: ["x"] * 3 for column in table.column_names}).replace_schema_metadata(
            table.schema.metadata
        ),
    }
    forge_table(delivered, name, others[how])
    command, *rest = words
    with pytest.raises(SystemExit) as ended:
        main([command, str(delivered), *rest])
    said = capsys.readouterr().err
    assert ended.value.code in (0, 2)
    assert "Traceback" not in said
    assert "internal fault" not in said


def test_a_delivered_report_does_not_pass_for_the_one_of_this_batch(
    delivered: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def write(folder: Path, means: RunContext, output: Path) -> None:
        output.write_bytes(b"by the user")

    monkeypatch.setattr(batch_task, "report_campaign", write)
    forged = b"all thresholds hold"
    (without_logs(delivered) / "report.pdf").write_bytes(forged)
    key = batch_task._report_key(up_to_date_states(delivered, RunContext()))
    made = {"schema": "stiffcal/report-made/1", "key": key, "sha256": hashlib.sha256(forged).hexdigest()}
    current = (delivered / "store" / "current").resolve()
    index = json.loads((current / "generation.json").read_text("utf-8"))
    index["documents"]["report"] = {"bytes": 0, "sha256": ""}
    (current / "generation.json").write_text(json.dumps(index), "utf-8")
    (current / "report.json").write_text("{}", "utf-8")
    forge(delivered, "report", lambda document: document.update(made))
    assert run_task(BatchTask(folder=str(delivered), campaign="small")).error is None
    assert (delivered / "report.pdf").read_bytes() == b"by the user"


def test_a_table_of_another_shape_in_a_trusted_place_is_one_line(
    delivered: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    without_logs(delivered)
    table = Store(delivered / "store").read_table("states")
    place = table.column_names.index("reference")
    forge_table(delivered, "states", table.set_column(place, "reference", table["Fx_N"]))
    open_record().allow_place(str(delivered / "store"))
    with pytest.raises(SystemExit) as ended:
        main(["identify", str(delivered)])
    assert ended.value.code == 2
    assert "of another shape than stiffcal writes" in capsys.readouterr().err


@pytest.mark.parametrize("option", ["--store", "--revoke"])
@pytest.mark.parametrize("name", ["", " "])
def test_an_empty_name_is_not_the_current_folder(
    option: str, name: str, state: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """`trust --store "$CACHE"` where CACHE is not set trusted whatever lies in the current folder."""
    with pytest.raises(SystemExit) as end:
        main(["trust", option, name, "--yes"])
    assert end.value.code == 2
    words = f'command line: {option}: is empty; name it in full, the current folder as "."'
    assert capsys.readouterr().err == f"{words} [option-invalid]\n"
    assert not open_record().entries()
