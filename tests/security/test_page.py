"""The page "Campaign folders you do not trust" names what there is."""

from __future__ import annotations

from pathlib import Path

from docs.page_blocks import blocks_of
from stiffcal.cli.app import COMMANDS
from stiffcal.limits import ALL, shown_amount

PAGE = (Path(__file__).parents[2] / "docs" / "folders-from-others.md").read_text("utf-8")


def test_every_limit_stands_there_with_its_default() -> None:
    rows = [line.split(" | ")[:2] for line in PAGE.splitlines() if line.startswith("| `STIFFCAL_MAX_")]
    wanted = [[f"| `{limit.variable}`", shown_amount(limit.default, limit.in_bytes)] for limit in ALL]
    assert sorted(rows) == sorted(wanted)


def test_every_command_that_it_names_exists() -> None:
    text = "".join(block.text for block in blocks_of("folders-from-others.md") if block.language == "sh")
    named = {line.split()[1] for line in text.splitlines() if line.startswith("stiffcal ")}
    assert named
    assert named <= set(COMMANDS)
