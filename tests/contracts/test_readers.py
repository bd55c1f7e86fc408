"""What every log format promises, plugins included: found by walking, never by name."""

from __future__ import annotations

import random
from pathlib import Path

import numpy as np
import pytest

from stiffcal.campaign.found.file_formats import format_names, format_of, log_formats
from stiffcal.campaign.manifest.source import Source
from stiffcal.campaign.toml.typed import TomlTable
from stiffcal.errors import InputError
from stiffcal.readers import DatabaseReader, Options, Reader, WantedColumns, find_reader
from tests.fuzz.mutations import spoilt_bytes
from tests.fuzz.targets import check_fault

INPUTS = [
    (reader.name, number)
    for reader in log_formats()
    if isinstance(reader, Reader)
    for number in range(len(reader.fuzz_inputs))
]


@pytest.fixture(params=format_names())
def reader(request: pytest.FixtureRequest) -> Reader:
    """Every log format in turn."""
    return find_reader(Path("no-matter"), request.param)


def test_it_is_named_as_its_module(reader: Reader) -> None:
    assert type(reader).__module__.removeprefix("stiffcal.readers.").split(".")[0] == reader.name


def test_its_table_of_options_takes_no_key_of_a_source(reader: Reader) -> None:
    assert issubclass(type(reader).options, TomlTable)
    assert reader.name not in Source.model_fields


def test_it_has_endings_and_fuzz_inputs_or_is_no_file(reader: Reader) -> None:
    if reader.in_files:
        assert reader.endings
        assert reader.fuzz_inputs
    else:
        assert isinstance(reader, DatabaseReader)
    assert all(ending.startswith(".") and ending == ending.lower() for ending in reader.endings)


def test_each_ending_stands_for_one_format() -> None:
    endings = [ending for known in log_formats() for ending in known.endings]
    assert len(endings) == len(set(endings))


def test_its_endings_are_recognised_by_manifest_and_reader(reader: Reader) -> None:
    for ending in reader.endings:
        assert format_of(f"raw/log{ending.upper()}") == reader.name
        assert find_reader(Path(f"log{ending}")).name == reader.name
        for packed in reader.packed_endings:
            assert format_of(f"raw/log{ending}{packed}") == reader.name


@pytest.mark.parametrize(("name", "number"), INPUTS)
def test_its_fuzz_input_is_a_whole_log(name: str, number: int, tmp_path: Path) -> None:
    reader = find_reader(tmp_path, name)
    declared = reader.fuzz_inputs[number]
    path = tmp_path / f"log{declared.ending}"
    declared.write(path)
    assert reader.recognises(path)
    options = type(reader).options.model_validate(dict(declared.options)).model_dump(exclude_unset=True)
    wanted = WantedColumns(declared.numbers, declared.texts)
    batches = list(reader.read_batches(path, options, wanted, "log"))
    assert sum(map(len, batches)) > 1
    for column in declared.numbers:
        assert np.isfinite(np.concatenate([batch.numbers[column] for batch in batches])).all()
    for column in declared.texts:
        assert all(batch.texts[column] for batch in batches)


@pytest.mark.parametrize(("name", "number"), INPUTS)
def test_a_spoilt_log_is_read_or_refused_in_clear_lines(name: str, number: int, tmp_path: Path) -> None:
    reader = find_reader(tmp_path, name)
    declared = reader.fuzz_inputs[number]
    path = tmp_path / f"log{declared.ending}"
    declared.write(path)
    whole, chance = path.read_bytes(), random.Random(20261122)
    for _ in range(20):
        path.write_bytes(spoilt_bytes(chance, whole))
        assert _unclear(reader, path, WantedColumns(declared.numbers, declared.texts), declared.options) == ""


def _unclear(reader: Reader, path: Path, wanted: WantedColumns, options: Options) -> str:
    """Return what is not clear about how a log is refused, "" where it is read or all is clear."""
    try:
        list(reader.read_batches(path, options, wanted, "log"))
    except InputError as error:
        return check_fault(error)
    return ""
