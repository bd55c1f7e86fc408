"""A small campaign in which everything that can have a name has an unusual one."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path

from stiffcal.escapes import csv_cell, json_text
from tests.laboratory.small_campaign import write_small_campaign

COLUMNS = ("A1", "A2", "A3", "A4", "A5", "A6", "Fx", "Fy", "Fz", "X", "Y", "Z", "rx", "ry", "rz")


def quoted(name: str) -> str:
    """Return a name as TOML."""
    return json_text.escaped(name)


def write_named_campaign(
    folder: Path,
    *,
    runs: Sequence[str] = ("pose1", "pose2"),
    joints: Sequence[str] = ("A1", "A2", "A3", "A4", "A5", "A6"),
    named: Mapping[str, str] | None = None,
) -> Path:
    """Write the small campaign with other names; return the folder.

    Parameters
    ----------
    folder : where to. runs : the names of its runs, two to four.
    joints : the six joints' names, in robot.toml and as columns.
    named : other names by the usual one: "robot", "campaign", "source", "target", "load_point", "run" (the column),
        "link_A1", a column.
    """
    named = dict(named or {})
    write_small_campaign(folder, poses=len(runs))
    manifest, robot = folder / "campaign.toml", folder / "robot.toml"
    columns = [*joints, *(named.get(column, column) for column in COLUMNS[6:])]
    text = manifest.read_text(encoding="utf-8")
    text = text.replace('"A1..A6"', f"[{', '.join(map(quoted, joints))}]")
    for column in COLUMNS[6:]:
        text = text.replace(f'"{column}"', quoted(named.get(column, column)))
    text = text.replace('"small"', quoted(named.get("campaign", "small")))
    text = text.replace("sources.table", f"sources.{quoted(named.get('source', 'table'))}")
    for frame in ("target", "load_point"):
        own = quoted(named.get(frame, frame))
        text = text.replace(f"[frames.{frame}]", f"[frames.{own}]").replace(f'"{frame}"', own)
    text = text.replace('column = "run"', f"column = {quoted(named.get('run', 'run'))}")
    manifest.write_text(text, encoding="utf-8")
    text = robot.read_text(encoding="utf-8").replace('"medium six-axis"', quoted(named.get("robot", "medium six-axis")))
    for number, joint in enumerate(joints, start=1):
        text = text.replace(f'name = "A{number}"', f"name = {quoted(joint)}")
        text = text.replace(f'"link_A{number}"', quoted(named.get(f"link_A{number}", f"link_A{number}")))
    robot.write_text(text, encoding="utf-8")
    table = folder / "raw" / "states.csv"
    with table.open(newline="", encoding="utf-8") as file:
        _, *rows = csv.reader(file)
    with table.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow([csv_cell.escaped(name) for name in (named.get("run", "run"), *columns)])
        for run, *cells in rows:
            writer.writerow([csv_cell.escaped(runs[int(run.removeprefix("pose")) - 1]), *cells])
    return folder
