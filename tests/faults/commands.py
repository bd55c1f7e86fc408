"""Every command that writes, and the folder each is tried on."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from unittest import mock

from stiffcal.commands.edit_model import edit_model
from stiffcal.commands.identify import identify_campaign
from stiffcal.commands.ingest import ingest_campaign
from stiffcal.commands.validate import validate_campaign
from stiffcal.trust.record import open_record
from tests.laboratory.small_campaign import write_small_campaign

ROOT = Path(__file__).parents[2]
TABLE = "A1,A2,A3,A4,A5,A6,Fx,Fy,Fz,dx,dy,dz\n" + "".join(
    f"{10 * k},{-60 - k},{20 + 3 * k},{30 - 9 * k},{40 + k},{5 * k},{100 + k},{-50 * k},20,0.{k},0.3,-0.2\n"
    for k in range(8)
)
PATH = "A1,A2,A3,A4,A5,A6\n0,-70,20,0,30,0\n5,-70,20,0,30,0\n"
HIDDEN = '\n[[effects]]\ntype = "bearing-tilt"\njoints = [2]\nparameters = { "bearing-tilt.j2.x" = { value = 2e-6 }, "bearing-tilt.j2.y" = { value = 2e-6 } }\n'  # noqa: E501


@dataclass(frozen=True)
class Command:
    """A command under test.

    Attributes
    ----------
    name : in the table. words : its words; ``{}`` is the folder it works in.
    base : the folder it starts from, one of `BASES`. heavy : CI tries it less often.
    own_state : the user's record of trust lies in the folder ``state`` of the base, and meets the faults too.
    """

    name: str
    words: tuple[str, ...]
    base: str
    heavy: bool = False
    own_state: bool = False


COMMANDS = (
    Command("ingest", ("ingest", "{}/c"), "raw"),
    Command("ingest again", ("ingest", "{}/c"), "changed"),
    Command("identify", ("identify", "{}/c"), "ingested"),
    Command("validate", ("validate", "{}/c"), "identified"),
    Command("run from nothing", ("validate", "{}/c"), "raw"),
    Command("diagnose", ("diagnose", "{}/c"), "validated", heavy=True),
    Command("improve", ("improve", "{}/c", "--yes"), "hidden", heavy=True),
    Command("add", ("add", "{}/c", "bearing-tilt", "--joints", "2,3"), "validated"),
    Command("remove", ("remove", "{}/c", "joint-compliance", "--joints", "6"), "validated"),
    Command("history --restore", ("history", "{}/c", "--restore", "1"), "two models"),
    Command("report", ("report", "{}/c", "-o", "{}/c/r.pdf"), "validated", heavy=True),
    Command("view", ("view", "{}/c", "-o", "{}/c/v.html"), "validated", heavy=True),
    Command("plot", ("plot", "{}/c", "-o", "{}/c/p.svg"), "validated"),
    Command("export csv", ("export", "{}/c", "-o", "{}/c/s.csv"), "validated"),
    Command("export parquet", ("export", "{}/c", "-o", "{}/c/s.parquet"), "validated"),
    Command("export json", ("export", "{}/c", "-o", "{}/c/m.json"), "validated"),
    Command("export urdf", ("export", "{}/c", "-o", "{}/c/m.urdf"), "validated"),
    Command("predict", ("predict", "{}/c", "--load-path", "0,0,0;0,0,-100", "--at", "0,-70,20,0,30,0"), "validated"),
    Command("plan", ("plan", "{}/c", "--force", "300", "--runs", "3", "-o", "{}/c/runs.csv"), "validated"),
    Command("map", ("map", "{}/c", "--load", "0,0,-100", "--points", "5", "-o", "{}/c/m.svg", "--table", "{}/c/m.csv"),
            "validated"),
    Command("compensate", ("compensate", "{}/c", "--path", "{}/path.csv", "--force", "0,50,-100", "-o", "{}/c/q.csv"),
            "validated"),
    Command("simulate", ("simulate", "{}/out", "--from", "{}/irb4400"), "simulated", heavy=True),
    Command("trust", ("trust", "{}/c", "--yes"), "code", own_state=True),
    Command("trust --edit", ("trust", "{}/c", "--edit"), "code", own_state=True),
    Command("record of ingest", ("ingest", "{}/c"), "unrecorded", own_state=True),
    Command("identify a stranger's", ("identify", "{}/c"), "stranger", own_state=True),
    Command("init", ("init", "{}/new", "--kind", "load"), "table"),
    Command("init --from", ("init", "{}/new", "--from", "{}/table.csv", "--robot", "irb4400"), "table"),
    Command("effects", ("effects", "backlash", "-o", "{}/e.svg"), "table"),
    Command("batch", ("batch", "{}/cells", "--no-report", "--jobs=2", "--junit", "{}/j.xml", "--markdown", "{}/s.md"),
            "cells", heavy=True),
)  # fmt: skip
BASES = tuple(dict.fromkeys(command.base for command in COMMANDS))


def make_bases(place: Path, wanted: set[str]) -> None:
    """Write the folders that the wanted commands start from, each below `place` under its name."""
    small = write_small_campaign(place / "raw" / "c", poses=2)
    (place / "raw" / "path.csv").write_text(PATH, encoding="utf-8")

    def grow(name: str, before: str, act: Callable[[Path], object]) -> None:
        act(Path(shutil.copytree(place / before, place / name, symlinks=True)) / "c")

    for name, before, act in (
        ("ingested", "raw", ingest_campaign),
        ("identified", "ingested", identify_campaign),
        ("validated", "identified", validate_campaign),
        ("changed", "validated", _shorten),
        ("code", "raw", _with_code),
        ("unrecorded", "raw", _with_record),
        ("stranger", "identified", _with_record),
        ("two models", "validated", _another_model),
    ):
        if name != "two models" or name in wanted:
            grow(name, before, act)
    for name in ("table", "cells", "simulated"):
        (place / name).mkdir()
    (place / "table" / "table.csv").write_text(TABLE, encoding="utf-8")
    for name in ("a", "b"):
        shutil.copytree(small, place / "cells" / "cells" / name)
    shutil.copytree(ROOT / "campaigns" / "irb4400", place / "simulated" / "irb4400")
    if "hidden" in wanted:
        hidden = write_small_campaign(place / "hidden" / "c", poses=4, hidden=HIDDEN)
        validate_campaign(hidden)


def _with_code(folder: Path) -> None:
    (folder / "own.py").write_text("class Own:\n    name = 'own'\n", encoding="utf-8")
    manifest = folder / "campaign.toml"
    manifest.write_text('plugins = ["own.py"]\n' + manifest.read_text(encoding="utf-8"), encoding="utf-8")
    _with_record(folder)


def _with_record(folder: Path) -> None:
    """Write the record of a user who has allowed something before, and knows nothing of this campaign."""
    with mock.patch.dict(os.environ, {"STIFFCAL_STATE": str(folder.parent / "state")}):
        open_record().allow_plugin("0" * 64, "elsewhere")


def _shorten(folder: Path) -> None:
    table = folder / "raw" / "states.csv"
    table.write_text("\n".join(table.read_text(encoding="utf-8").splitlines()[:-2]) + "\n", encoding="utf-8")


def _another_model(folder: Path) -> None:
    edit_model(folder, "remove", "joint-compliance", where={"joints": "6"})
    validate_campaign(folder)
