"""Documents and tables of a stranger's store that have another shape than stiffcal writes: one line, no traceback."""

from __future__ import annotations

import shutil
from contextlib import suppress
from functools import partial
from pathlib import Path

import pyarrow as pa
import pytest

from stiffcal.cli.app import main
from stiffcal.commands.history import read_history
from stiffcal.commands.validate import validate_campaign
from stiffcal.errors import InputError
from stiffcal.stages.stored import stored_document
from stiffcal.store import Store
from stiffcal.trust.record import open_record
from tests.laboratory.delivered_store import forge, forge_table, without_logs

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
    assert "store: states: damaged (column reference holds double, not bool)" in capsys.readouterr().err
