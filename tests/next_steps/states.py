"""States of a campaign, from the empty folder to the finished one, each made in a moment or from a bundled campaign."""

from __future__ import annotations

import csv
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from stiffcal.commands.init import init_campaign
from stiffcal.propose.templates import template_kinds
from tests.laboratory.small_campaign import write_small_campaign
from tests.next_steps.walking import Words, run

CAMPAIGNS = Path(__file__).parents[2] / "campaigns"
SIGMA = "sigma = { position = 0.01, rotation = 2e-5 }\n"
BACKLASH = """
[[effects]]
type = "backlash"
joints = [2]
[effects.parameters]
"backlash.j2.width" = { value = 1e-3 }
"backlash.j2.band" = { value = 5.0 }
"""
PLAN = 'schema = "stiffcal/plan-input/1"\ncandidates = 30\nruns = 3\n'
THRESHOLD = "\n[thresholds]\nmax_rms_m = 1e-9\n"
ENTRIES: tuple[Words, ...] = (
    ("check",), ("run",), ("ingest",), ("identify",), ("validate",), ("diagnose",), ("improve", "--dry-run"),
    ("report",), ("history",), ("plan", "--force", "200"), ("plot", "-o", "plot.svg"), ("export", "-o", "states.csv"),
    ("add", ".", "bearing-tilt", "--joints", "2"), ("remove", ".", "joint-compliance", "--joints", "6"), ("trust",),
    ("effects",), ("map", "--load", "0,0,-100", "--points", "5"),
    ("predict", "--load-path", "0,0,-100", "--at", "0,0,0,0,0,0"),
)  # fmt: skip
"""What a user may type in any state."""


@dataclass(frozen=True)
class State:
    """A state of a campaign."""

    name: str
    make: Callable[[Path], object]
    """Writes the campaign folder, which does not exist yet."""
    entries: tuple[Words, ...] = ENTRIES
    """Commands from which the `next:` lines are followed."""


def small(
    changes: tuple[tuple[str, str], ...] = (), commands: tuple[Words, ...] = (), hidden: str = "", poses: int = 4,
    plan: str = PLAN, more: str = "", rows: Callable[[dict[str, str]], bool] | None = None,
) -> Callable[[Path], object]:  # fmt: skip
    """Return what makes the small campaign, changed, after commands.

    Parameters
    ----------
    changes : pieces of campaign.toml and what takes their place. commands : run in it. more : at its end.
    hidden, poses : as of `write_small_campaign`. rows : which of the measured ones are there.
    """

    def make(folder: Path) -> None:
        write_small_campaign(folder, hidden=hidden, poses=poses)
        manifest = folder / "campaign.toml"
        text = manifest.read_text(encoding="utf-8")
        for piece, other in changes:
            assert piece in text
            text = text.replace(piece, other)
        manifest.write_text(text + more, encoding="utf-8")
        (folder / "plan.toml").write_text(plan, encoding="utf-8")
        if rows is not None:
            keep_rows(folder / "raw" / "states.csv", rows)
        for words in commands:
            run(folder, words)

    return make


def keep_rows(file: Path, wanted: Callable[[dict[str, str]], bool]) -> None:
    """Leave out the rows of a table that are not wanted."""
    with file.open(encoding="utf-8", newline="") as stream:
        reader = csv.DictReader(stream)
        rows, names = [row for row in reader if wanted(row)], list(reader.fieldnames or ())
    with file.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.DictWriter(stream, names)
        writer.writeheader()
        writer.writerows(rows)


def template(kind: str) -> Callable[[Path], object]:
    """Return what makes the commented folder of a kind."""
    return lambda folder: init_campaign(folder, kind=kind)


def bundled(name: str) -> Callable[[Path], object]:
    """Return what copies a bundled campaign with its logs."""
    return lambda folder: shutil.copytree(CAMPAIGNS / name, folder, ignore=shutil.ignore_patterns("store", "*.pdf"))


def simulated(name: str, *commands: Words) -> Callable[[Path], object]:
    """Return what simulates a bundled campaign."""

    def make(folder: Path) -> None:
        folder.parent.mkdir(parents=True, exist_ok=True)
        code, _, error = run(folder.parent, ("simulate", folder.name, "--from", str(CAMPAIGNS / name)))
        assert code == 0, error
        for words in commands:
            run(folder, words)

    return make


def simulated_with_few_loads(name: str) -> Callable[[Path], object]:
    """Return what simulates a bundled campaign with one level of load in place of four."""

    def make(folder: Path) -> None:
        source = folder.parent / "from"
        shutil.copytree(CAMPAIGNS / name, source)
        settings = source / "simulate.toml"
        text, levels = settings.read_text(encoding="utf-8"), "levels = [0.25, 0.5, 0.75, 1.0]"
        assert levels in text
        settings.write_text(text.replace(levels, "levels = [1.0]"), encoding="utf-8")
        simulated(str(source))(folder)

    return make


def empty(folder: Path) -> None:
    """Make an empty folder."""
    folder.mkdir(parents=True)


def stale(folder: Path) -> None:
    """Make a finished campaign in whose log one number changes afterwards."""
    small(commands=(("run",),))(folder)
    log = folder / "raw" / "states.csv"
    log.write_text(log.read_text(encoding="utf-8").replace("150", "151", 1), encoding="utf-8")


def without_logs(folder: Path) -> None:
    """Make a finished campaign whose logs are gone."""
    small(commands=(("run",),))(folder)
    shutil.rmtree(folder / "raw")


def along_one_axis(row: dict[str, str]) -> bool:
    """Return whether a row is unloaded, or loaded along z."""
    return abs(float(row["Fx"])) < 1.0 and (float(row["Fz"]) > 1.0 or float(row["Fy"]) == 0.0)


_UNITS = 'units = { position = "mm", rotation = "rad" }\n'
_STATED = ((_UNITS, _UNITS + SIGMA),)
_NOISE = "[noise]\ntranslation_m = 1e-5\nrotation_rad = 2e-5\n"
_BACKLASH_J4 = ("add", ".", "backlash", "--joints", "4")
_TILT = ("add", ".", "bearing-tilt", "--joints", "2")
_PLANNED = (("check",), ("plan", "--force", "200"))

QUICK: tuple[State, ...] = (
    State("empty folder", empty, (("check",), ("run",), ("history",), ("effects",))),
    *(State(f"template {kind}", template(kind)) for kind in template_kinds()),
    State("measured", small(), (("history",),)),
)
"""States that are made and followed in seconds."""

SMALL: tuple[State, ...] = (
    State("nothing installed yet", empty, (("doctor",),)),
    State("measured, any command", small()),
    State("one axis loaded, any command", small(rows=along_one_axis)),
    State("one axis loaded, noise not known", small(rows=along_one_axis), (("check",),)),
    State("one axis loaded, noise stated", small(_STATED, rows=along_one_axis), (("check",),)),
    State("one axis loaded, noise stated, planned", small(_STATED, rows=along_one_axis), _PLANNED),
    State("noise stated", small(_STATED)),
    State("one pose", small(poses=1)),
    State("two poses", small(poses=2)),
    State("ingested", small(commands=(("ingest",),))),
    State("fitted", small(commands=(("identify",),))),
    State("validated", small(commands=(("validate",),))),
    State("diagnosed", small(commands=(("diagnose",),))),
    State("finished", small(commands=(("run",),))),
    State("an effect missing", small(hidden=BACKLASH)),
    State("an effect missing, diagnosed", small(hidden=BACKLASH, commands=(("diagnose",),))),
    State("an effect missing, improved", small(hidden=BACKLASH, commands=(("improve",),))),
    State("an effect missing, noise stated", small(_STATED, hidden=BACKLASH)),
    State("threshold not met", small(more=THRESHOLD)),
    State("threshold not met, finished", small(more=THRESHOLD, commands=(("run",),))),
    State("log changed since", stale),
    State("logs gone since", without_logs),
    State("an effect added", small(commands=(_BACKLASH_J4,))),
    State("an effect added, fitted", small(commands=(_BACKLASH_J4, ("identify",)))),
    State("all effects removed", small(commands=(("remove", ".", "joint-compliance", "--all"),))),
    State("restored", small(commands=(("run",), _TILT, ("identify",), ("history", "--restore", "1")))),
    State(
        "dead weights planned",
        small(rows=along_one_axis, plan=PLAN + "[load]\ndead_weights_kg = [10, 20]\n" + _NOISE),
    ),
    State("steps planned", small(plan=PLAN + "[load]\nforce_N = 150\n")),
    State("plan made", small(commands=(("plan", "--force", "200", "--campaign", "planned"),))),
    State("no load at all", small(rows=lambda row: row["Fx"] == row["Fy"] == row["Fz"] == "0")),
    State("seldom repeated", small(rows=lambda row: float(row["Fx"]) != 150.0)),
)  # fmt: skip
"""States of the small campaign."""

BUNDLED: tuple[State, ...] = (
    *(State(f"absolute {number}", bundled(f"absolute/{number}")) for number in ("01", "03", "07")),
    State("absolute and loads", bundled("absolute-and-loads")),
    *(State(f"joint bench {number}", bundled(f"joints/{number}")) for number in ("01", "05", "09")),
    *(State(f"hidden {number}", bundled(f"hidden/{number}")) for number in ("01", "04", "08", "12")),
    *(State(name, simulated(name)) for name in ("demo", "mixed", "max100", "kr240")),
    # of all its loads a single diagnosis takes minutes of a processor, and the ways lead through a dozen
    State("rods on links", simulated_with_few_loads("kr125-bodies")),
)
"""Bundled campaigns; seconds to minutes each."""

ALL = (*QUICK, *SMALL, *BUNDLED)
