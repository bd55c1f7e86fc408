"""A unit that a log states and the manifest contradicts is one warning, with its columns."""

from __future__ import annotations

from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as parquet
import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.errors import no_progress
from stiffcal.ingest.reading.reducing import reduce_campaign
from tests.laboratory.displacement_table import DISPLACEMENTS, FORCES, MANIFEST, displacement_columns, write_table

TABLE = "raw/table.csv"


def warnings_of(
    folder: Path, headers: list[str], manifest: str = MANIFEST, units: str = "", file: str = TABLE
) -> list[str]:
    """Return the warnings on units of a table with these headers and a row of units under them."""
    (folder / "raw").mkdir(parents=True)
    for name, new in zip((*FORCES, *DISPLACEMENTS), headers[6:], strict=True):
        manifest = manifest.replace(f'"{name}"', f'"{new}"')
    (folder / "campaign.toml").write_text(manifest.replace(TABLE, file))
    from tests.laboratory.small_campaign import robot_text

    (folder / "robot.toml").write_text(robot_text())
    columns = displacement_columns()
    if file.endswith(".parquet"):
        fields = [
            pa.field(name, pa.float64(), metadata={"unit": unit} if unit else None)
            for name, unit in zip(headers, units.split(","), strict=True)
        ]
        table = pa.Table.from_arrays([pa.array(values) for values in columns.values()], schema=pa.schema(fields))
        parquet.write_table(table, folder / file)
    else:
        path = write_table(folder / file, columns, headers=headers)
        lines = path.read_text().splitlines()
        text = "\n".join([lines[0], *([units] if units else []), *lines[1:]]) + "\n"
        path.write_text(text.replace(",", "\t") if file.endswith(".txt") else text)
    result = reduce_campaign(load_campaign(folder), no_progress).result
    return [warning for warning in result.warnings if "the log states" in warning]


def headers(force: str, displacement: str) -> list[str]:
    return (
        [f"A{k}" for k in range(1, 7)]
        + [force.format(name) for name in FORCES]
        + [displacement.format(n) for n in DISPLACEMENTS]
    )


@pytest.mark.parametrize(
    ("force", "displacement", "stated"),
    [
        ("{} [kN]", "{}", "kN"),
        ("{} (lbf)", "{}", "lbf"),
        ("{}_kN", "{}", "kN"),
        ("{}/kN", "{}", "kN"),
        ("{} in daN", "{}", "daN"),
        ("{}", "{} [µm]", "µm"),
        ("{}", "{}_um", "um"),
        ("{}", "{}_m", "m"),
        ("{}", "{} [N]", "N"),
        ("{} [N]", "{} [mm]", ""),
        ("{} (N)", "{}_mm", ""),
        ("{}_load", "{}_mean", ""),
    ],
)
def test_units_in_names(force: str, displacement: str, stated: str, tmp_path: Path) -> None:
    found = warnings_of(tmp_path / "cell", headers(force, displacement))
    assert len(found) == bool(stated)
    for warning in found:
        assert warning.startswith(f"{TABLE}: ")
        assert all(
            name.format(axis) in warning
            for name, axes in ((force, FORCES), (displacement, DISPLACEMENTS))
            for axis in axes
            if name != "{}"
        )
        assert f"states {stated}," in warning


@pytest.mark.parametrize("file", [TABLE, "raw/table.txt", "raw/table.parquet"])
def test_units_next_to_names(file: str, tmp_path: Path) -> None:
    """Of a row under the names, or of a column's metadata."""
    names = headers("{}", "{}")
    (force, displacement) = warnings_of(
        tmp_path / "wrong", names, units=",".join(["deg"] * 6 + ["kN"] * 3 + ["µm"] * 3), file=file
    )
    assert file in force
    assert "Fx, Fy and Fz" in force
    assert "dx, dy and dz" in displacement
    assert warnings_of(tmp_path / "right", names, units=",".join(["deg"] * 6 + ["N"] * 3 + ["mm"] * 3), file=file) == []


def test_angles(tmp_path: Path) -> None:
    names = headers("{}", "{}")
    (warning,) = warnings_of(tmp_path / "cell", names, units=",".join(["rad"] * 6 + ["N"] * 3 + ["mm"] * 3))
    assert "A1" in warning


def test_units_written_in_other_letters_are_the_same(tmp_path: Path) -> None:
    names = headers("{}", "{}")
    assert warnings_of(tmp_path / "cell", names, units=",".join(["°"] * 6 + ["N"] * 3 + ["mm"] * 3)) == []
