"""The comparison of two revisions' answers finds what differs, and nothing else."""

from __future__ import annotations

import json
from pathlib import Path

from tests.answers.compare import differences, resolved, value_differences


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
