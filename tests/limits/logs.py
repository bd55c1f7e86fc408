"""The logs with which numbers are varied: bundled campaigns, rehearsed ones, and tables with a mistake in them."""

from __future__ import annotations

import csv
import gzip
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path

from stiffcal.commands.simulate import simulate_campaign
from stiffcal.propose.templates import write_template
from tests.laboratory.changed_tables import PLACE, Table, all_of, scaled

CAMPAIGNS = Path(__file__).parents[2] / "campaigns"
RUNS = 3
"""Of each campaign that lists its runs the first ones are kept: the logs of the others are like them."""

SOURCE_OF_TORQUE = """[sources.torque]
time = { column = "t", unit = "s" }
joints = { torque = ["torque"], units = { torque = "N*m" } }
"""

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


def with_torque_of_another_clock(folder: Path) -> None:
    """Copy the strokes of a joint with its torque in a log of its own, whose clock is 0.2 s ahead."""
    bundled("joints/06")(folder)
    whole = folder / "raw" / "log.csv.gz"
    with gzip.open(whole, "rt", encoding="utf-8") as lines:
        rows = list(csv.DictReader(lines))
    whole.unlink()
    logs = {
        "drive": ["t,angle,speed,T", *(f"{row['t']},{row['angle']},{row['speed']},{row['T']}" for row in rows)],
        "torque": ["t,torque", *(f"{float(row['t']) + 0.2:.6f},{row['torque']}" for row in rows)],
    }
    for name, log in logs.items():
        (folder / "raw" / f"{name}.csv").write_text("\n".join(log) + "\n", encoding="utf-8")
    manifest = folder / "campaign.toml"
    text = manifest.read_text(encoding="utf-8").replace(', torque = ["torque"]', "").replace(', torque = "N*m"', "")
    text = text.replace('"raw/log.csv.gz"', '"raw/drive.csv", torque = "raw/torque.csv"')
    manifest.write_text(text.replace("[[runs]]", f"{SOURCE_OF_TORQUE}\n[[runs]]"), encoding="utf-8")


SOUND: Mapping[str, Prepare] = {
    name: bundled(name) for name in ("demo", "hidden/02", "ipa-ur10", "joints/01", "joints/06")
}
"""Sampled logs, a table of displacements, measured places, a clamped robot, friction: all numbers are varied."""
FURTHER: Mapping[str, Prepare] = {
    "kr240": bundled("kr240"),
    "irb4400": bundled("irb4400"),
    "max100": bundled("max100", 4),
    "init --kind clamped": rehearsed("clamped"),
    "joints/06, torque by another clock": with_torque_of_another_clock,
    "absolute/01, A4 with the other sign": table_with(scaled("A4", -1.0), "absolute/01"),
    "absolute/01, a row of places in m": table_with(
        all_of(*(scaled(axis, 1e-3, slice(9, 10)) for axis in PLACE)), "absolute/01"
    ),
}
"""With these the numbers that no log before them asks for."""
LOGS: Mapping[str, Prepare] = {**SOUND, **FURTHER}
