"""Names stand in messages: a name as long as a file is refused where it is read."""

from __future__ import annotations

from pathlib import Path

import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.campaign.toml.name_checks import LONGEST_NAME, name_faults
from stiffcal.commands.ingest import ingest_campaign
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from tests.laboratory.small_campaign import write_small_campaign

LONG = "n" * 200_000
PLACES = [
    ("robot.toml", 'name = "A1"'),
    ("robot.toml", 'name = "medium six-axis"'),
    ("campaign.toml", 'name = "small"'),
    ("campaign.toml", "sources.table"),
    ("campaign.toml", '"Fx"'),
    ("model.toml", '"joint-compliance"'),
]


@pytest.mark.parametrize(("file", "text"), PLACES)
def test_a_name_in_a_file_of_the_campaign_is_refused(tmp_path: Path, file: str, text: str) -> None:
    folder = write_small_campaign(tmp_path / "small", poses=1)
    path = folder / file
    old = text.strip('"').split('"')[-1].split(".")[-1]
    path.write_text(path.read_text().replace(text, text.replace(old, LONG)))
    with pytest.raises(InputError) as refused:
        load_campaign(folder)
    assert refused.value.code == FaultCode.NAME_INVALID
    assert len(str(refused.value)) < LONGEST_NAME


def test_the_name_of_a_run_in_a_log_is_refused(tmp_path: Path) -> None:
    folder = write_small_campaign(tmp_path / "small", poses=1)
    log = folder / "raw" / "states.csv"
    log.write_text(log.read_text().replace("pose1", LONG))
    with pytest.raises(InputError) as refused:
        ingest_campaign(folder)
    assert refused.value.code == FaultCode.NAME_INVALID


def test_conditions_queries_and_reasons_may_be_long() -> None:
    assert not list(name_faults({"rows": LONG, "file": LONG, "files": {"ft": LONG}, "why": LONG}, "campaign.toml"))
    assert list(name_faults({"column": "n" * (LONGEST_NAME + 1)}, "campaign.toml"))
    assert not list(name_faults({"column": "n" * LONGEST_NAME}, "campaign.toml"))
