"""What the manifest lets a user say of a format is what its reader knows, and only that."""

from __future__ import annotations

import pytest
from pydantic import ValidationError

from stiffcal.campaign.file_formats import (
    CsvOptions,
    Hdf5Options,
    MatOptions,
    ParquetOptions,
    PostgresOptions,
    RosOptions,
    TdmsOptions,
)
from stiffcal.campaign.manifest import Source
from stiffcal.readers import csv, hdf5, mat, postgres, rosbag2, tdms
from stiffcal.reduction.logs import reader_options


def test_manifest_and_readers_know_the_same_options() -> None:
    assert set(CsvOptions.model_fields) == set(csv.layout.KNOWN_OPTIONS)
    assert set(Hdf5Options.model_fields) == set(hdf5.KNOWN_OPTIONS)
    assert not ParquetOptions.model_fields
    assert set(TdmsOptions.model_fields) == set(tdms.KNOWN_OPTIONS)
    assert set(MatOptions.model_fields) == set(mat.KNOWN_OPTIONS)
    assert set(RosOptions.model_fields) == set(rosbag2.KNOWN_OPTIONS)
    # `file` reaches the reader as `from`; a password is no option
    assert set(PostgresOptions.model_fields) == set(postgres.KNOWN_OPTIONS) - {"from"}
    assert "password" not in PostgresOptions.model_fields


@pytest.mark.parametrize("key", ["header", "comment", "units_row"])
def test_other_names_are_refused(key: str) -> None:
    with pytest.raises(ValidationError):
        CsvOptions.model_validate({key: 1})


def test_what_is_said_reaches_the_reader_as_it_is() -> None:
    said = {"delimiter": ";", "decimal": ",", "encoding": "latin-1", "skip_rows": 3, "unit_row": True}
    assert reader_options(Source.model_validate({"csv": said}), "csv") == said
    assert reader_options(Source.model_validate({"hdf5": {"dataset": "log"}}), "hdf5") == {"dataset": "log"}
