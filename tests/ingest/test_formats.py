"""The same measurements give the same stiffness, whatever format they were logged in."""

from __future__ import annotations

from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import pytest

from stiffcal.campaign.loading import load_manifest
from stiffcal.campaign.manifest.queries import queries_of
from stiffcal.commands.ingest import ingest_campaign, is_stale
from stiffcal.errors import InputError
from stiffcal.extras import install_command
from stiffcal.ingest.checks.loaded import check_campaign
from stiffcal.stages.fit import fit_now
from stiffcal.stages.steps import RunContext, up_to_date_states
from tests.laboratory.campaign_in_formats import FORMATS, write_campaign
from tests.laboratory.database import VARIABLE, VARIABLES, Database, trusting
from tests.laboratory.log_reading import parse_here
from tests.laboratory.small_campaign import STIFFNESS


def stiffness_of(folder: Path) -> dict[str, float]:
    means = RunContext()
    fit = fit_now(up_to_date_states(folder, means), "linear", means)
    assert fit is not None
    return {parameter.name: 1.0 / (parameter.value or float("nan")) for parameter in fit.parameters}


@pytest.fixture(scope="module")
def by_csv(tmp_path_factory: pytest.TempPathFactory) -> dict[str, float]:
    found = stiffness_of(write_campaign(tmp_path_factory.mktemp("formats") / "csv", "csv"))
    assert len(found) == 6
    for known, value in zip(STIFFNESS, found.values(), strict=True):
        assert value == pytest.approx(known, rel=0.05)
    return found


def trusted(folder: Path) -> AbstractContextManager[None]:
    """Have the queries of a campaign trusted."""
    return trusting(*(text for _, text in queries_of(load_manifest(folder))))


@pytest.mark.parametrize("log_format", [name for name in FORMATS if name != "csv"])
def test_every_format_gives_the_same_stiffness(
    tmp_path: Path, by_csv: dict[str, float], log_format: str, request: pytest.FixtureRequest
) -> None:
    server: Database | None = request.getfixturevalue("database") if log_format == "postgres" else None
    folder = write_campaign(tmp_path / "campaign", log_format, server)
    with trusted(folder):
        stiffness = stiffness_of(folder)
    assert stiffness == pytest.approx(by_csv, rel=1e-9)


def test_changed_rows_of_a_database_are_found(tmp_path: Path, database: Database) -> None:
    folder = write_campaign(tmp_path / "campaign", "postgres", database)
    with trusted(folder):
        assert ingest_campaign(folder).unchanged is False
        assert ingest_campaign(folder).unchanged is True
        assert is_stale(folder) == ""
        database.run('update ft set "Fx" = "Fx" + 1 where run = \'pose1\'')
        assert is_stale(folder) == "changed: ft: select * from ft where run = 'pose1' order by t"
    store = b"".join(path.read_bytes() for path in (folder / "store").rglob("*.json"))
    assert VARIABLE.encode() in store  # the settings name the variable
    assert b"postgresql://" not in store


def test_changed_parts_of_a_bag_are_found(tmp_path: Path) -> None:
    folder = write_campaign(tmp_path / "campaign", "rosbag2")
    ingest_campaign(folder)
    assert is_stale(folder) == ""
    (folder / "raw" / "pose2" / "more.txt").write_text("a note", encoding="utf-8")
    assert is_stale(folder) == "changed: raw/pose2"


@pytest.mark.parametrize(
    ("log_format", "library", "extra"),
    [("tdms", "nptdms", "tdms"), ("mcap", "rosbags.rosbag2", "ros"), ("rosbag1", "rosbags.rosbag1", "ros"),
     ("rosbag2", "rosbags.rosbag2", "ros"), ("postgres", "adbc_driver_postgresql", "postgres")],
)  # fmt: skip
def test_a_missing_library_is_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, log_format: str, library: str, extra: str
) -> None:
    import sys

    from stiffcal.readers import WantedColumns, find_reader

    parse_here(monkeypatch, 100)
    monkeypatch.setitem(sys.modules, library, None)
    monkeypatch.setenv(VARIABLE, "postgresql://localhost/none")
    monkeypatch.setenv(VARIABLES, VARIABLE)
    path = tmp_path / "log"
    path.write_bytes(b"something")
    options: dict[str, Any] = {"uri_env": VARIABLE, "from": "ft"} if log_format == "postgres" else {}
    with pytest.raises(InputError) as caught:
        find_reader(path, log_format).read_header(path, options, "raw/log", WantedColumns(("t",)))
    assert str(caught.value).endswith(f"is not installed; {install_command(extra)} [library-missing]")


def test_check_names_a_missing_library_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    folder = write_campaign(tmp_path / "campaign", "tdms")
    parse_here(monkeypatch, 100)
    monkeypatch.setitem(sys.modules, "nptdms", None)
    with pytest.raises(InputError) as caught:
        check_campaign(folder)
    assert [fault.mend for fault in caught.value.faults] == [install_command("tdms")]
