"""The comparison of two revisions' answers finds what differs, and nothing else."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from stiffcal.campaign.loading import load_campaign
from tests.answers.compare import ROUNDED, differences, resolved, value_differences
from tests.answers.record import REPOSITORY
from tests.answers.shifts import compare_campaign, recorded
from tests.answers.variants import VARIANTS


def recording(place: Path, **files: str) -> Path:
    for name, text in files.items():
        path = place / "answers" / name.replace("__", "/").replace("_json", ".json").replace("_txt", ".txt")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, "utf-8")
    return place


def test_numbers_count_as_equal_to_1e_9_of_their_size() -> None:
    assert not list(value_differences({"rms": 1.0e-5}, {"rms": 1.0e-5 * (1 + 5e-10)}))
    assert list(value_differences({"rms": 1.0e-5}, {"rms": 1.0e-5 * (1 + 5e-9)}))
    assert not list(value_differences({"torque": float("nan")}, {"torque": float("nan")}))
    assert list(value_differences({"passed": True}, {"passed": 1.5}))


def test_times_paths_and_keys_of_the_moment_are_no_difference(tmp_path: Path) -> None:
    old = recording(tmp_path / "a", a_json=json.dumps({"time": "x", "rms": 1}), b_txt="fit of 2026-11-22T08:00:00Z")
    new = recording(tmp_path / "b", a_json=json.dumps({"time": "y", "rms": 1}), b_txt="fit of 2026-11-23T09:30:00Z")
    assert differences(old, new) == []


def test_a_changed_word_a_missing_file_and_a_longer_list_are_named(tmp_path: Path) -> None:
    old = recording(tmp_path / "a", a_txt="ready", b_json='{"runs": [1]}', c_txt="")
    new = recording(tmp_path / "b", a_txt="not ready", b_json='{"runs": [1, 2]}')
    assert differences(old, new) == [
        "a.txt: -ready",
        "a.txt: +not ready",
        "b.json: runs: [1] → [1, 2]",
        "c.txt: only before",
    ]


def test_schemas_with_the_same_structure_under_other_names_are_equal() -> None:
    old = {"$defs": {"Part": {"type": "number"}}, "properties": {"x": {"$ref": "#/$defs/Part"}}}
    new = {"$defs": {"Length": {"type": "number", "title": "Length"}}, "properties": {"x": {"$ref": "#/$defs/Length"}}}
    other = {"$defs": {"Length": {"type": "string"}}, "properties": {"x": {"$ref": "#/$defs/Length"}}}
    assert resolved(old, old) == resolved(new, new)
    assert list(value_differences(resolved(old, old), resolved(other, other)))


def test_the_order_of_choices_and_of_required_keys_is_no_difference() -> None:
    old = {"properties": {"format": {"enum": ["csv", "mat", "hdf5"]}}, "required": ["b", "a"]}
    new = {"properties": {"format": {"enum": ["csv", "hdf5", "mat"]}}, "required": ["a", "b"]}
    other = {"properties": {"format": {"enum": ["csv", "hdf5"]}}, "required": ["a", "b"]}
    assert resolved(old, old) == resolved(new, new)
    assert list(value_differences(resolved(new, new), resolved(other, other)))


def campaign(place: Path, value: float, missing: list[str]) -> Path:
    folder = place / "answers" / "campaigns" / "a" / "01"
    folder.mkdir(parents=True)
    identified = {"parameters": [{"name": "c", "value": value, "std": 0.1}], "rms": {"translation": value}}
    found = {"missing": [{"effect": name, "where": {"joints": [1]}, "size_m": value} for name in missing]}
    for command, document in (("check", {"ready": True}), ("identify", identified), ("diagnose", found)):
        (folder / f"{command}.json").write_text(json.dumps(document))
        (folder / f"{command}.end.txt").write_text("exit code 0\n")
    return place


def test_shifts_count_in_uncertainties_and_verdicts_by_what_they_name(tmp_path: Path) -> None:
    old = campaign(tmp_path / "a", 2.0, ["backlash"])
    near = campaign(tmp_path / "b", 2.0009, ["backlash"])
    far = campaign(tmp_path / "c", 2.002, ["backlash"])
    other = campaign(tmp_path / "d", 2.0, ["seat-shift"])
    results = []
    for new in (near, far, other):
        ((name, pair),) = recorded(old, new).items()
        results.append(compare_campaign(name, *pair))
    assert [result.holds for result in results] == [True, False, False]
    assert results[0].shifts["identify parameters.c.value"] == pytest.approx(0.009)
    assert results[1].errors["identify rms translation"] == pytest.approx(0.001)
    assert results[2].name == "a/01"
    assert len(results[2].verdicts) == 1


def test_arrays_of_a_page_may_differ_by_the_step_they_are_rounded_to() -> None:
    old = {ROUNDED: 0.1, "values": [1.0, 2.0, math.nan]}
    assert not list(value_differences({"x": old}, {"x": {ROUNDED: 0.1, "values": [1.1, 2.0, math.nan]}}))
    assert list(value_differences({"x": old}, {"x": {ROUNDED: 0.1, "values": [1.2, 2.0, math.nan]}}))
    assert list(value_differences({"x": old}, {"x": {ROUNDED: 0.1, "values": [1.0, 2.0, 3.0]}}))
    assert list(value_differences({"x": old}, {"x": {ROUNDED: 0.1, "values": [1.0, 2.0]}}))


def test_every_variant_is_a_campaign_that_checks(tmp_path: Path) -> None:
    for name, write in VARIANTS.items():
        write(REPOSITORY / "campaigns", tmp_path / name)
        load_campaign(tmp_path / name, check_files=False)
    entries = load_campaign(tmp_path / "variants/reversed-absolute", check_files=False).model.effects
    bundled = load_campaign(REPOSITORY / "campaigns/absolute/02", check_files=False).model.effects
    assert [entry.type for entry in entries] == [entry.type for entry in reversed(bundled)]
