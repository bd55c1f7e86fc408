"""The logs with which numbers are varied: bundled campaigns, rehearsed ones, and tables with a mistake in them."""

from __future__ import annotations

import csv
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from stiffcal.commands.simulate import simulate_campaign
from stiffcal.propose.templates import write_template
from tests.laboratory.changed_tables import PLACE, Table, all_of, columns, exchanged, scaled

CAMPAIGNS = Path(__file__).parents[2] / "campaigns"
RUNS = 3
"""Of each campaign that lists its runs the first ones are kept: the logs of the others are like them."""

Prepare = Callable[[Path], None]


def bundled(name: str, runs: int = RUNS) -> Prepare:
    """Copy a bundled campaign, or simulate its logs; of the runs that it lists the first ones are kept."""

    def prepare(folder: Path) -> None:
        if (CAMPAIGNS / name / "simulate.toml").exists():
            simulate_campaign(CAMPAIGNS / name, folder)
        else:
            shutil.copytree(CAMPAIGNS / name, folder, ignore=shutil.ignore_patterns("store"))
        manifest = folder / "campaign.toml"
        head, *listed = manifest.read_text(encoding="utf-8").split("[[runs]]")
        manifest.write_text("[[runs]]".join([head, *listed[:runs]]), encoding="utf-8")

    return prepare


def rehearsed(kind: str) -> Prepare:
    """Simulate what `init --kind` writes."""

    def prepare(folder: Path) -> None:
        write_template(folder.parent / "template", kind)
        simulate_campaign(folder.parent / "template", folder)

    return prepare


def table_with(change: Callable[[Table], None], name: str) -> Prepare:
    """Copy a bundled campaign of absolute places with its table changed."""

    def prepare(folder: Path) -> None:
        bundled(name)(folder)
        file = folder / "raw" / "poses.csv"
        with file.open(encoding="utf-8") as lines:
            head, *rows = csv.reader(lines)
        table = {column: [float(row[k]) for row in rows] for k, column in enumerate(head)}
        change(table)
        text = [head, *([f"{value:.9g}" for value in row] for row in zip(*table.values(), strict=True))]
        file.write_text("\n".join(",".join(row) for row in text) + "\n", encoding="utf-8")

    return prepare


def moved(column: str, by: float) -> Callable[[Table], None]:
    """Return a change that adds to a column."""

    def change(table: Table) -> None:
        table[column] = [value + by for value in table[column]]

    return change


def further(table: Table) -> None:
    """Write each place one row further down."""
    for axis in PLACE:
        table[axis] = np.roll(table[axis], 1).tolist()


SOUND: Mapping[str, Prepare] = {
    name: bundled(name) for name in ("demo", "hidden/02", "ipa-ur10", "joints/01", "joints/06")
}
"""Sampled logs, a table of displacements, measured places, a clamped robot, friction: all numbers are varied."""
FURTHER: Mapping[str, Prepare] = {
    "kr240": bundled("kr240"),
    "irb4400": bundled("irb4400"),
    "max100": bundled("max100", 99),
    "init --kind clamped": rehearsed("clamped"),
    "absolute/01, A4 with the other sign": table_with(scaled("A4", -1.0), "absolute/01"),
    "absolute/01, A3 by 90° off": table_with(moved("A3", 90.0), "absolute/01"),
    "absolute/01, A2 and A3 exchanged": table_with(columns("A2", "A3"), "absolute/01"),
    "absolute/01, places in m": table_with(all_of(*(scaled(axis, 1e-3) for axis in PLACE)), "absolute/01"),
    "absolute/01, places a row further": table_with(further, "absolute/01"),
    "absolute/01, a row of places in m": table_with(
        all_of(*(scaled(axis, 1e-3, slice(9, 10)) for axis in PLACE)), "absolute/01"
    ),
    "absolute/03, targets of a row exchanged": table_with(lambda table: exchanged(table, slice(9, 10)), "absolute/03"),
}
"""With these the numbers that no log before them asks for."""
LOGS: Mapping[str, Prepare] = {**SOUND, **FURTHER}
