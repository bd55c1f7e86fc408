"""What the manifest lets a user write for a format is what its reader declares, and only that."""

from __future__ import annotations

import pytest
from pydantic import ValidationError

from stiffcal.campaign.found.file_formats import log_formats
from stiffcal.campaign.manifest.manifest_type import source_type
from stiffcal.readers import NoOptions
from stiffcal.reduction.logs.log_rows import reader_options


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("c3d", {"data"}),
        ("jsonl", set()),
        ("npz", {"array", "columns"}),
        ("ods", {"sheet", "skip_rows", "unit_row", "decimal"}),
        ("rsi", set()),
        ("xlsx", {"sheet", "skip_rows", "unit_row", "decimal"}),
        ("csv", {"delimiter", "decimal", "encoding", "skip_rows", "unit_row", "section"}),
        ("hdf5", {"group", "dataset"}),
        ("mat", {"variable", "columns"}),
        ("mcap", {"topic", "child_frame", "types"}),
        ("parquet", set()),
        ("postgres", {"uri_env", "host", "port", "database", "user", "order_by"}),
        ("rosbag1", {"topic", "child_frame"}),
        ("rosbag2", {"topic", "child_frame", "types"}),
        ("tdms", {"group"}),
    ],
)
def test_the_manifest_has_the_options_of_the_interface(name: str, options: set[str]) -> None:
    """Interface, section 2; no password is among them."""
    (declared,) = (found.options for found in log_formats() if found.name == name)
    assert set(declared.model_fields) == options
    assert name in source_type().model_fields


@pytest.mark.parametrize("key", ["header", "comment", "units_row"])
def test_other_names_are_refused(key: str) -> None:
    with pytest.raises(ValidationError):
        source_type().model_validate({"csv": {key: 1}})


def test_options_reach_the_reader_as_they_are_written() -> None:
    written = {"delimiter": ";", "decimal": ",", "encoding": "latin-1", "skip_rows": 3, "unit_row": True}
    source = source_type().model_validate({"csv": written, "mat": {"columns": ["t", "Fx"]}})
    assert reader_options(source, "csv") == written
    assert reader_options(source, "mat") == {"columns": ["t", "Fx"]}
    assert reader_options(source, "hdf5") == {}


def test_a_format_without_options_refuses_them() -> None:
    assert not NoOptions.model_fields
    with pytest.raises(ValidationError):
        source_type().model_validate({"parquet": {"nothing": 1}})
