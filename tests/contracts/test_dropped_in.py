"""A log format, an effect, a mistake, a kind of experiment, a section: each is found, and nothing is edited."""

from __future__ import annotations

import csv
import json
import re
import shutil
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import jsonschema
import numpy as np
import pytest
from pydantic import ValidationError
from pypdf import PdfReader

from stiffcal.arrays import Floats
from stiffcal.campaign.found.file_formats import format_names, format_of
from stiffcal.campaign.loading import load_campaign
from stiffcal.campaign.manifest.manifest_type import manifest_type
from stiffcal.campaign.schemas import schema_document
from stiffcal.cli.app import main
from stiffcal.diagnosis.suspects.find import find_suspects
from stiffcal.documents import document_of, result_of
from stiffcal.errors import InputError, no_progress
from stiffcal.ingest.reading.reducing import reduce_campaign
from stiffcal.judgement.mistakes import state_changes
from stiffcal.mistakes.clocks.found import clock_mistake
from stiffcal.mistakes.clocks.mistake import ClockMistake
from stiffcal.mistakes.found import mistakes_of
from stiffcal.mistakes.inputs.mistake import InputMistake
from stiffcal.mistakes.references.kinematics import check_kinematics
from stiffcal.mistakes.rods.mistake import RodMistake
from stiffcal.mistakes.runs.mistake import RunMistake, RunRead
from stiffcal.mistakes.states.exchanges import Exchange
from stiffcal.mistakes.states.mistake import LeftOfStates, StateMistake
from stiffcal.reduction.clocks.course import ClockCourse
from stiffcal.report import building, sections
from stiffcal.report.sections import all_sections
from stiffcal.results.identify_result import IdentifyResult
from stiffcal.schemas.json_schema import schema_of
from tests.fuzz.feeding import feed_one
from tests.fuzz.targets import formats_not_fed
from tests.laboratory.campaign_folders import changed
from tests.laboratory.constant_orientation import write_campaign as write_places
from tests.laboratory.displacement_table import (
    Columns,
    displacement_columns,
    write_displacement_campaign,
    write_table,
)
from tests.laboratory.dropped_in import dropped_in
from tests.laboratory.hidden_campaigns import folder_of, reduced
from tests.laboratory.robots import DEGREES
from tests.laboratory.small_campaign import CAMPAIGN, robot_text, write_small_campaign
from tests.rates.faults import draw_faulty

EFFECT = '\n[[effects]]\ntype = "angle-stiffness"\njoints = [3]\n'
HIDDEN = EFFECT + 'parameters = { "angle-stiffness.j3.c" = { value = 1.5e-6 } }\n'
ABSOLUTE = Path(__file__).parents[2] / "campaigns" / "absolute" / "01"

Command = Callable[..., dict[str, Any]]


@pytest.fixture
def command(capsys: pytest.CaptureFixture[str]) -> Command:
    """Run a command with --json; return its document."""

    def run(*words: str | Path) -> dict[str, Any]:
        with pytest.raises(SystemExit) as end:
            main([*map(str, words), "--json"])
        answer = capsys.readouterr()
        assert end.value.code == 0, answer.out + answer.err
        document: dict[str, Any] = json.loads(answer.out)
        return document

    return run


def refusal(capsys: pytest.CaptureFixture[str], *words: str | Path) -> str:
    """Run a command that refuses what it reads; return its lines."""
    with pytest.raises(SystemExit) as end:
        main([*map(str, words)])
    assert end.value.code == 2
    return capsys.readouterr().err


# ---- a log format ---------------------------------------------------------------------------------------------------


@pytest.fixture
def reader() -> Iterator[None]:
    with dropped_in("readers"):
        yield


def in_json(folder: Path, key: str = "rows") -> Path:
    """Write the small campaign with its table as a JSON document."""
    write_small_campaign(folder, poses=3)
    table = folder / "raw" / "states.csv"
    rows = [
        {name: cell if name == "run" else float(cell) for name, cell in row.items()}
        for row in csv.DictReader(table.read_text(encoding="utf-8").splitlines())
    ]
    (folder / "raw" / "states.jrows").write_text(json.dumps({key: rows}), encoding="utf-8")
    table.unlink()
    (folder / "campaign.toml").write_text(changed(CAMPAIGN, ("states.csv", "states.jrows")), encoding="utf-8")
    return folder


def rewrite(folder: Path, *changes: tuple[str, str]) -> None:
    path = folder / "campaign.toml"
    path.write_text(changed(path.read_text(encoding="utf-8"), *changes), encoding="utf-8")


@pytest.mark.usefixtures("reader")
def test_a_log_of_a_new_format_is_read_by_its_ending_by_its_name_and_with_its_options(
    tmp_path: Path, command: Command
) -> None:
    write_small_campaign(tmp_path / "csv", poses=3)
    parameters = command("identify", tmp_path / "csv")["parameters"]
    assert command("identify", in_json(tmp_path / "ending"))["parameters"] == parameters
    folder = in_json(tmp_path / "name", key="states")
    (folder / "raw" / "states.jrows").rename(folder / "raw" / "states")
    rewrite(folder, ('file = "raw/states.jrows"', 'file = "raw/states"\nformat = "jsonrows"\njsonrows.key = "states"'))
    assert command("identify", folder)["parameters"] == parameters


@pytest.mark.usefixtures("reader")
def test_faults_of_the_manifest_know_a_new_format(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = in_json(tmp_path / "c")
    rewrite(folder, ("[sources.table]\n", '[sources.table]\nformat = "cbor"\njsonrows = { kee = "x" }\ncbor = { }\n'))
    *others, last = (f'"{name}"' for name in format_names())
    names = f"{', '.join(others)} or {last}"
    keys = "format, sampling, file, files, run, time, rows"
    formats = ", ".join(format_names())
    wrong = "campaign.toml: sources.table"
    signals = "joints, wrench, dead_weight, pose, poses, deflection, displacement, lengths, temperature, hold"
    assert refusal(capsys, "check", folder).splitlines() == [
        f'{wrong}.format: "cbor" is not one of the choices; write one of {names} [value-invalid]',
        f'{wrong}.jsonrows.kee: unknown key "kee"; did you mean "key"? The keys here are key [key-unknown]',
        f'{wrong}.cbor: unknown key "cbor"; remove it; the keys here are {keys}, {formats}, {signals} [key-unknown]',
    ]


def test_without_its_file_the_format_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = in_json(tmp_path / "c")
    assert refusal(capsys, "check", folder) == (
        'campaign.toml: sources.table: the ending of "raw/states.jrows" does not determine the format; '
        'add format = "csv", say [format-unknown]\n'
    )


@pytest.mark.usefixtures("reader")
def test_the_json_schema_has_a_new_format() -> None:
    schema = schema_document(manifest_type())
    validator = jsonschema.Draft202012Validator(schema)
    source: dict[str, Any] = {"format": "jsonrows", "jsonrows": {"key": "x"}}
    document = {"schema": "stiffcal/campaign/1", "sources": {"table": source}}
    assert validator.is_valid(document)
    source["jsonrows"]["kee"] = "x"
    assert not validator.is_valid(document)


@pytest.mark.usefixtures("reader")
def test_a_new_format_is_fed_with_spoilt_logs(tmp_path: Path) -> None:
    assert format_of("log.jrows") == "jsonrows"
    assert formats_not_fed() == ()
    outcomes = {feed_one("jsonrows", 20261122, number, tmp_path)[0] for number in range(30)}
    assert outcomes == {"accepted", "refused"}


def test_what_is_dropped_in_leaves_with_its_file() -> None:
    with dropped_in("readers"):
        assert "jsonrows" in format_names()
    assert "jsonrows" not in format_names()
    assert "jsonrows" not in manifest_type().model_json_schema()["$defs"]["Source"]["properties"]


# ---- an effect ------------------------------------------------------------------------------------------------------


@pytest.fixture
def effect() -> Iterator[None]:
    with dropped_in("effects"):
        yield


@pytest.mark.long
@pytest.mark.usefixtures("effect")
def test_a_new_effect_is_listed_fitted_and_proposed(tmp_path: Path, command: Command) -> None:
    assert "angle-stiffness" in {known["name"] for known in command("effects")["effects"]}
    folder = write_small_campaign(tmp_path / "c", hidden=HIDDEN)
    (missing,) = command("diagnose", folder)["missing"]
    assert (missing["effect"], missing["where"]) == ("angle-stiffness", {"joints": [3]})
    command("add", folder, "angle-stiffness", "--joints", "3")
    (fitted,) = (entry for entry in command("identify", folder)["parameters"] if entry["effect"] == "angle-stiffness")
    assert fitted["value"] == pytest.approx(1.5e-6, rel=0.05)


# ---- a mistake ------------------------------------------------------------------------------------------------------


@pytest.fixture
def mistake() -> Iterator[None]:
    with dropped_in("mistakes"):
        yield


def halved(columns: Columns, rows: slice = slice(None)) -> Columns:
    """Return a table in which some rows have half of the angle of A3."""
    angles = np.array(columns["A3"])
    angles[rows] *= 0.5
    return columns | {"A3": angles}


def changes_named(folder: Path) -> list[tuple[str, tuple[str, ...]]]:
    with pytest.raises(InputError) as refused:
        reduce_campaign(load_campaign(folder), no_progress)
    return [(change.kind, change.names) for fault in refused.value.faults for change in fault.changes]


@pytest.mark.usefixtures("mistake")
def test_a_new_mistake_is_named_in_a_table_of_displacements(tmp_path: Path) -> None:
    folder = write_displacement_campaign(tmp_path / "c", halved(displacement_columns(12)))
    assert changes_named(folder) == [("halved-angle", ("A3",))]


@pytest.mark.parametrize("rows", [slice(30, 31), slice(None)])
@pytest.mark.usefixtures("mistake")
def test_a_new_mistake_is_named_in_a_row_and_in_a_table_of_absolute_places(rows: slice, tmp_path: Path) -> None:
    folder = Path(shutil.copytree(ABSOLUTE, tmp_path / "c", ignore=shutil.ignore_patterns("store")))
    file = folder / "raw" / "poses.csv"
    with file.open(encoding="utf-8") as lines:
        head, *read = csv.reader(lines)
    columns = halved({name: np.array([float(row[k]) for row in read]) for k, name in enumerate(head)}, rows)
    write_table(file, columns, decimals=6)
    assert changes_named(folder) == [("halved-angle", ("A3",))]


@pytest.mark.usefixtures("mistake")
def test_a_new_mistake_is_named_in_unloaded_poses() -> None:
    states, chain = reduced("01").states, load_campaign(folder_of("01")).chain
    joints = states.joints * np.where(np.arange(6) == 2, 0.5, 1.0)
    (fault,) = check_kinematics(replace(states, joints=joints), chain, estimated=False, stated=DEGREES)
    assert [(change.kind, change.names) for change in fault.changes] == [("halved-angle", ("A3",))]


@pytest.mark.usefixtures("mistake")
def test_a_new_mistake_is_named_in_a_run() -> None:
    sound = draw_faulty(np.random.default_rng(20261122), "pairs", "")
    factor = np.where(sound.states.run == 4, 0.5, 1.0)
    (suspect,) = find_suspects(
        replace(sound.states, wrench=sound.states.wrench * factor[:, None]), sound.model
    ).suspects
    assert suspect.variant is not None
    assert (suspect.run, suspect.variant.likely) == (4, "two plates, of which one was entered: multiply by 2")


class AsRead:
    """Readings of unit variance whose runs have no constants."""

    n_constants = 0

    def rows(self, stack: Floats) -> Floats:
        return stack.reshape(len(stack), -1)


def two_runs(pulled: Floats, residual: Floats) -> Any:
    """Return what mistakes of states ask for: two runs of two states, whose forces move the target as they are."""
    left = LeftOfStates(
        residual=np.tile(residual, (3, 1)), scale=np.ones((3, 4)), space=AsRead(), run=np.array([0, 0, 1, 1]),
        absolute=np.zeros(4, dtype=np.bool_), wrench=pulled, response=np.repeat(np.eye(6)[:3, :, None], 4, axis=2),
        swept=frozenset(), has_constants=False, step=None, n_runs=2,
    )  # fmt: skip
    return SimpleNamespace(space=SimpleNamespace(data=left), left=left)


@pytest.mark.usefixtures("mistake")
def test_a_new_mistake_of_states_is_weighed_next_to_effects() -> None:
    pulled = np.arange(24.0).reshape(6, 4)
    ground = two_runs(pulled, np.zeros(4))
    found = [change for mistake, change in state_changes(ground) if mistake.name == "backward-pull"]
    assert [change.runs for change in found] == [(0,), (1,)]
    np.testing.assert_array_equal(found[1].rows.reshape(3, 4), -2.0 * pulled[:3] * [0, 0, 1, 1])


def test_a_new_exchange_has_its_share_of_all_that_may_be_exchanged() -> None:
    states = draw_faulty(np.random.default_rng(20261122), "pairs", "").states
    read = RunRead(states, states.members(), 4, load_campaign(folder_of("01")).chain)
    ground = two_runs(np.arange(24.0).reshape(6, 4), np.array([1.0, 1.0, -1.0, -1.0]))

    def shares() -> tuple[set[float], float]:
        pairs = {change.log_share for mistake, change in state_changes(ground) if isinstance(mistake, Exchange)}
        return pairs, replace(read).mix_up_penalty(5)

    (before,), penalty = shares()
    with dropped_in("exchanged_mistakes"):
        (after,), with_it = shares()
    assert before - after == pytest.approx(np.log(4.0 / 3.0))
    assert with_it - penalty == pytest.approx(2.0 * np.log(4.0 / 3.0))


def test_a_new_mistake_of_a_clock_is_named_where_it_explains_the_course() -> None:
    offset = np.array([0.4, 0.4, 1.4, 0.4, 0.4, 0.4])
    course = ClockCourse("tracker", "ft", 20.0 * np.arange(6.0), offset, np.full(6, 0.002))
    assert clock_mistake(course) is None
    with dropped_in("mistakes"):
        found = clock_mistake(course)
    assert found is not None
    assert found[0].name == "hurried-piece"
    assert found[1].moves_s == pytest.approx(1.0)


def test_a_mistake_that_lacks_a_method_is_refused_before_any_data_are_read() -> None:
    with dropped_in("unfinished_mistakes"), pytest.raises(TypeError, match="Unfinished.*texts"):
        mistakes_of(RunMistake)
    assert [base.__abstractmethods__ for base in (RodMistake, RunMistake, ClockMistake)] == [{"ways"}] * 3
    assert StateMistake.__abstractmethods__ == {"ways", "words"}


def test_without_its_file_the_mistake_is_not_known() -> None:
    with dropped_in("mistakes"):
        assert "halved-angle" in {mistake.name for mistake in mistakes_of(InputMistake)}
    assert "halved-angle" not in {mistake.name for mistake in mistakes_of(InputMistake)}


# ---- a kind of experiment -------------------------------------------------------------------------------------------


@pytest.fixture
def kind() -> Iterator[None]:
    with dropped_in("kinds"):
        yield


def with_run(folder: Path, *lines: str) -> Path:
    write_small_campaign(folder, poses=2)
    text = (folder / "campaign.toml").read_text(encoding="utf-8") + "\n".join(['[[runs]]\nid = "pose1"', *lines, ""])
    (folder / "campaign.toml").write_text(text, encoding="utf-8")
    return folder


@pytest.mark.usefixtures("kind")
def test_a_run_may_be_of_a_new_kind_and_have_its_options(tmp_path: Path) -> None:
    folder = with_run(tmp_path / "c", 'experiment = "probing"', 'probing = { plate = "granite" }')
    (run,) = load_campaign(folder).manifest.runs
    assert run.experiment == "probing"
    assert run.options_of("probing") == {"plate": "granite"}


@pytest.mark.usefixtures("kind")
def test_faults_of_the_manifest_know_a_new_kind(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = with_run(tmp_path / "c", 'experiment = "probe"', 'probing = { plato = "granite" }')
    place, names = "campaign.toml: runs[1] (pose1)", '"absolute", "clamped", "free", "friction", "load" or "probing"'
    assert refusal(capsys, "check", folder).splitlines() == [
        f'{place}.experiment: "probe" is not one of the choices; write one of {names} [value-invalid]',
        f'{place}.probing.plato: unknown key "plato"; did you mean "plate"? The keys here are plate [key-unknown]',
    ]


@pytest.mark.usefixtures("kind")
def test_the_json_schema_has_a_new_kind() -> None:
    validator = jsonschema.Draft202012Validator(schema_document(manifest_type()))
    run: dict[str, Any] = {"id": "a", "experiment": "probing", "probing": {"plate": "granite"}}
    document = {"schema": "stiffcal/campaign/1", "runs": [run]}
    assert validator.is_valid(document)
    run["probing"] = {}
    assert not validator.is_valid(document)


@pytest.mark.usefixtures("kind")
def test_the_template_of_a_new_kind_is_written(tmp_path: Path, command: Command) -> None:
    command("init", tmp_path / "c", "--kind", "probing")
    assert (
        (tmp_path / "c" / "campaign.toml").read_text(encoding="utf-8").startswith("# A campaign that touches a plate")
    )


PROBED = """
schema = "stiffcal/campaign/1"
name = "probed"
robot = "robot.toml"

[frames.tip]
parent = "flange"
xyz_m = [0.0, 0.0, 0.1]

[sources.probe]
time = { column = "t", unit = "s" }
[sources.probe.pose]
frame = "base"
body = "tip"
position = ["X", "Y", "Z"]
units = { position = "mm" }
"""
HEIGHTS_MM = (750.0, 750.3, 749.4)


@pytest.fixture
def probed(tmp_path: Path) -> Path:
    """A campaign of the new kind alone: three runs, each stands at one height."""
    folder = tmp_path / "probed"
    (folder / "raw").mkdir(parents=True)
    (folder / "robot.toml").write_text(robot_text(), encoding="utf-8")
    text = PROBED
    for number, height in enumerate(HEIGHTS_MM, start=1):
        text += f'[[runs]]\nid = "touch{number}"\nexperiment = "probing"\nprobing = {{ plate = "granite" }}\n'
        text += f'files = {{ probe = "raw/touch{number}.csv" }}\n'
        rows = [f"{0.1 * k:.1f},100.0,200.0,{height}" for k in range(50)]
        (folder / "raw" / f"touch{number}.csv").write_text("\n".join(["t,X,Y,Z", *rows, ""]), encoding="utf-8")
    (folder / "campaign.toml").write_text(text, encoding="utf-8")
    return folder


@pytest.mark.usefixtures("kind")
def test_logs_of_a_new_kind_are_reduced_by_it(probed: Path, command: Command) -> None:
    assert [run["id"] for run in command("check", probed)["runs"]] == ["touch1", "touch2", "touch3"]
    document = command("ingest", probed)
    assert [run["n_readings"] > 0 for run in document["runs"]] == [True, True, True]
    assert list((probed / "store").rglob("probing.parquet"))


@pytest.mark.usefixtures("kind")
def test_a_new_kind_answers_in_identify_and_validate(probed: Path, command: Command) -> None:
    section = command("identify", probed)["probing"]
    assert section["plate"] == "granite"
    assert section["height"] == pytest.approx(0.7499)
    assert section["heights"] == pytest.approx({"touch1": 0.75, "touch2": 0.7503, "touch3": 0.7494})
    validation = command("validate", probed)
    assert validation["scheme"] == "probing: each run left out"
    assert validation["max"]["translation"] == pytest.approx(0.75e-3)


@pytest.mark.usefixtures("kind")
def test_the_section_of_a_new_kind_is_described_and_read_by_its_type(probed: Path, command: Command) -> None:
    document = command("identify", probed)
    schema = schema_of(IdentifyResult)
    assert schema["properties"]["probing"] == {"$ref": "#/$defs/ProbingSection"}
    assert "probing" not in schema["required"]
    jsonschema.validate(document, schema)
    read = result_of(IdentifyResult, json.dumps(document))
    assert document_of(read) == document
    assert type(read.section("probing")).__name__ == "ProbingSection"
    del document["probing"]["height"]
    with pytest.raises(ValidationError):
        result_of(IdentifyResult, json.dumps(document))


@pytest.mark.usefixtures("kind")
def test_the_terminal_shows_what_a_new_kind_returns(probed: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        main(["identify", str(probed)])
    lines = capsys.readouterr().out.splitlines()
    assert end.value.code == 0
    assert "the granite plate stands at 0.7499 m" in lines
    assert any(line.split() == ["touch2", "750.300"] for line in lines)


@pytest.mark.usefixtures("kind")
def test_the_report_and_plot_draw_what_a_new_kind_returns(
    probed: Path, command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    picture = probed.parent / "plot.svg"
    assert command("plot", probed, "-o", picture)["drawn"] == "heights of the plate"
    assert picture.stat().st_size > 1000
    kept = [module for module in all_sections() if module.__name__.endswith(".experiments")]
    monkeypatch.setattr(building, "all_sections", lambda: kept)  # the others take long to draw
    output = probed.parent / "report.pdf"
    command("report", probed, "-o", output)
    text = re.sub(r"\s+", " ", " ".join(page.extract_text() for page in PdfReader(output).pages))
    assert "Height of a plate of medium six-axis" in text
    assert "Touched plate" in text
    assert "The granite plate stands at 0.7499 m" in text
    assert "touch2 750.300" in text


def test_without_its_folder_the_kind_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = with_run(tmp_path / "c", 'experiment = "probing"', 'probing = { plate = "granite" }')
    lines = refusal(capsys, "check", folder).splitlines()
    assert lines[0].endswith('write one of "absolute", "clamped", "free", "friction" or "load" [value-invalid]')
    assert lines[1].startswith('campaign.toml: runs[1] (pose1).probing: unknown key "probing"')


# ---- a kind of experiment whose runs make load states ---------------------------------------------------------------


# as its folder calls its runs
HANGING = "runs of a rope"


@pytest.fixture
def hanging(tmp_path: Path) -> Iterator[Path]:
    """A small campaign of which the weights of two poses hang on a rope."""
    with dropped_in("load_kinds"):
        folder = write_small_campaign(tmp_path / "c")
        kinds = ("hanging", "hanging", "load", "load")
        runs = "".join(f'[[runs]]\nid = "pose{k}"\nexperiment = "{kind}"\n' for k, kind in enumerate(kinds, start=1))
        (folder / "campaign.toml").write_text(CAMPAIGN + runs, encoding="utf-8")
        yield folder


def test_load_states_of_a_new_kind_are_fitted_with_others_and_judged_in_its_own_way(
    hanging: Path, command: Command
) -> None:
    """Both kinds were measured on one robot with one model: they agree, and each has its folds, words and errors."""
    identified = command("identify", hanging)
    (agreement,) = identified["agreement"]
    assert (agreement["first"], agreement["second"], agreement["agree"]) == ("loads", "hanging", True)
    assert "under another rope" in identified["expected_error"]
    validated = command("validate", hanging)
    assert validated["scheme"] == "leave-one-pose-out; each rope left out in turn"
    assert [part["label"] for part in validated["by_experiment"]] == ["loads", "hanging"]
    assert validated["n_poses"] == 4
    assert command("diagnose", hanging)["missing"] == []


def test_the_terminal_and_the_report_call_a_new_kind_as_it_says(
    hanging: Path, command: Command, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    command("identify", hanging)
    with pytest.raises(SystemExit):
        main(["identify", str(hanging)])
    assert HANGING in capsys.readouterr().out
    kept = [module for module in all_sections() if module.__name__.endswith(".common_parameters")]
    monkeypatch.setattr(building, "all_sections", lambda: kept)  # the others take long to draw
    output = hanging.parent / "report.pdf"
    command("report", hanging, "-o", output)
    text = re.sub(r"\s+", " ", " ".join(page.extract_text() for page in PdfReader(output).pages))
    assert HANGING in text


# ---- kinds whose runs measure what absolute or clamped runs do ------------------------------------------------------


def test_places_of_a_new_kind_are_those_of_absolute_runs(tmp_path: Path, command: Command) -> None:
    folder = write_places(tmp_path / "c", "scara", n=30)
    absolute = command("identify", folder)
    with dropped_in("state_kinds"):
        rewrite(folder, ('experiment = "absolute"', 'experiment = "surveyed"'))
        surveyed = command("identify", folder)
        assert command("check", folder)["runs"][0]["experiment"] == "surveyed"
    assert surveyed["parameters"] == absolute["parameters"]
    assert surveyed["expected_error"] == absolute["expected_error"]


ONE_JOINT_ROBOT = """
schema = "stiffcal/robot/1"
name = "j"
convention = "modified-dh"
gravity_mps2 = [0, 0, 0]

[[joints]]
name = "axis"
"""
ONE_JOINT = """
schema = "stiffcal/campaign/1"
name = "stop"
robot = "robot.toml"

[sources.bench]
time = { column = "t", unit = "s" }
joints = { position = ["q"], torque = ["tau"], units = { position = "deg", torque = "N*m" } }

[[runs]]
id = "a"
experiment = "clamped"
moved_joint = 1
joints_deg = [0.0]
files = { bench = "raw/a.csv" }
"""


@pytest.mark.long
def test_motor_angles_of_a_new_kind_are_those_of_clamped_runs(tmp_path: Path, command: Command) -> None:
    """Three cycles of a spring of 1e5 N·m/rad."""
    folder = tmp_path / "c"
    (folder / "raw").mkdir(parents=True)
    (folder / "campaign.toml").write_text(ONE_JOINT, encoding="utf-8")
    (folder / "robot.toml").write_text(ONE_JOINT_ROBOT, encoding="utf-8")
    time = np.arange(0.0, 60.0, 0.1)
    torque = 100.0 * np.sin(2.0 * np.pi * time / 20.0)
    angle = np.rad2deg(1e-5 * torque + 4e-6 * np.random.default_rng(1).normal(size=time.size))
    rows = [f"{t:.1f},{q:.9f},{tau:.6f}" for t, q, tau in zip(time, angle, torque, strict=True)]
    (folder / "raw" / "a.csv").write_text("\n".join(["t,q,tau", *rows, ""]), encoding="utf-8")
    clamped = command("identify", folder)
    with dropped_in("state_kinds"):
        rewrite(folder, ('experiment = "clamped"', 'experiment = "pressed"'))
        pressed = command("identify", folder)
        validated, diagnosis = command("validate", folder), command("diagnose", folder)
        limits = 'schema = "stiffcal/plan-input/1"\n[load]\nmoment_Nm = 100.0\n'
        (folder / "plan.toml").write_text(limits, encoding="utf-8")
        planned = command("plan", folder, "--runs", "2")
    assert pressed["parameters"] == clamped["parameters"]
    assert "clamped" not in pressed
    assert planned["experiment"] == "clamped"
    assert validated["rms"]["motor_angle"] == pytest.approx(4e-6, rel=0.1)
    assert diagnosis["missing"] == []


# ---- a kind with rows of its own -------------------------------------------------------------------------------------


TURNED = """
schema = "stiffcal/campaign/1"
name = "turned"
robot = "robot.toml"

[sources.drive]
time = { column = "t", unit = "s" }

[sources.drive.joints]
position = ["q"]
velocity = ["w"]
torque = ["tau"]
units = { position = "rad", velocity = "rad/s", torque = "N*m" }
"""


@pytest.mark.long
def test_effects_are_searched_in_rows_of_a_new_kind(
    tmp_path: Path, command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Friction and a ripple of 1 N·m: identify, validate, diagnose and report run, and the ripple is found."""
    folder, rng = tmp_path / "c", np.random.default_rng(1)
    (folder / "raw").mkdir(parents=True)
    (folder / "robot.toml").write_text(ONE_JOINT_ROBOT, encoding="utf-8")
    model = 'schema = "stiffcal/model/1"\n[[effects]]\ntype = "joint-friction"\njoints = [1]\n'
    (folder / "model.toml").write_text(model, encoding="utf-8")
    text = TURNED
    for number, speed in enumerate((0.1, -0.1, 0.2, -0.2, 0.4, -0.4, 0.3, -0.3)):
        angle = np.sign(speed) * np.linspace(-1.5, 1.5, 80)
        torque = 20.0 * np.sign(speed) + 15.0 * speed + np.cos(7.0 * angle) + 0.1 * rng.normal(size=80)
        rows = [
            f"{20 * number + 0.1 * k:.1f},{q},{speed},{tau}"
            for k, (q, tau) in enumerate(zip(angle, torque, strict=True))
        ]
        (folder / "raw" / f"{number}.csv").write_text("\n".join(["t,q,w,tau", *rows, ""]), encoding="utf-8")
        text += f'[[runs]]\nid = "turn{number}"\nexperiment = "turning"\nfiles = {{ drive = "raw/{number}.csv" }}\n'
    (folder / "campaign.toml").write_text(text, encoding="utf-8")
    kept = [module for module in all_sections() if module.__name__.endswith((".experiments", ".diagnosis"))]
    monkeypatch.setattr(building, "all_sections", lambda: kept)  # the others take long to draw
    with dropped_in("row_kinds"):
        assert command("identify", folder)["turning"] == {"turns": 8}
        assert command("validate", folder)["rms"]["torque"] == pytest.approx(0.72, abs=0.05)
        diagnosis = command("diagnose", folder)
        command("report", folder, "-o", folder / "report.pdf")
        command("view", folder, "-o", folder / "view.html")
    (missing,) = diagnosis["missing"]
    assert (missing["effect"], missing["where"]) == ("torque-ripple", {"joints": [1]})
    text = re.sub(r"\s+", " ", " ".join(page.extract_text() for page in PdfReader(folder / "report.pdf").pages))
    assert "The joint was turned 8 times" in text
    assert "torque-ripple" in text


# ---- a section of the report ----------------------------------------------------------------------------------------


def test_a_new_section_stands_where_its_order_puts_it() -> None:
    with dropped_in("sections"):
        names = [module.__name__.rpartition(".")[2] for module in all_sections()]
    assert names.index("campaign") + 1 == names.index("largest_force") == names.index("stiffness") - 1


def test_a_new_section_is_printed(tmp_path: Path, command: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    folder, output = write_small_campaign(tmp_path / "c", poses=2), tmp_path / "report.pdf"
    monkeypatch.setattr(sections, "__path__", [])  # the others take long to draw
    with dropped_in("sections"):
        command("report", folder, "-o", output)
    text = re.sub(r"\s+", " ", " ".join(page.extract_text() for page in PdfReader(output).pages))
    assert re.search(r"The largest force No load exceeds 30\d newtons\.", text)
