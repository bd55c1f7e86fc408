"""Friction campaigns for tests: the rehearsal that `init --kind friction` offers, changed where a test needs it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import tomlkit

from stiffcal.campaign.loading import load_campaign
from stiffcal.propose.templates import write_template
from stiffcal.simulation.settings import load_settings
from stiffcal.simulation.simulate import simulate_campaign

Changes = dict[str, Any]

# kg, m: links of a medium robot, so that there is weight that has to cancel.
LINKS = (
    (250.0, (0.1, 0.0, 0.0)), (180.0, (0.4, 0.0, 0.1)), (150.0, (0.1, 0.3, 0.0)), (60.0, (0.0, 0.0, -0.2)),
    (20.0, (0.0, 0.0, 0.0)), (5.0, (0.0, 0.0, 0.1)),
)  # fmt: skip


def rehearsed(
    folder: Path, simulate: Changes | None = None, joints: Changes | None = None, gear: float | None = None
) -> Path:
    """Write a rehearsed friction campaign and return its folder.

    Parameters
    ----------
    simulate : dotted key to value, set in simulate.toml before the logs are made; joints : likewise in the joints'
        signal of campaign.toml. gear : ratio of every joint.
    """
    plan = folder.parent / f"{folder.name}-plan"
    write_template(plan, "friction")
    set_keys(
        plan / "campaign.toml", {f"sources.controller.joints.{key}": value for key, value in (joints or {}).items()}
    )
    set_keys(plan / "simulate.toml", simulate or {})
    robot: Changes = {}
    for number, (mass, com) in enumerate(LINKS):
        robot[f"joints.{number}.link"] = {"mass_kg": mass, "com_m": list(com)}
        robot |= {f"joints.{number}.gear_ratio": gear} if gear else {}
    set_keys(plan / "robot.toml", robot)
    simulate_campaign(load_campaign(plan, check_files=False), load_settings(plan), folder)
    return folder


def set_keys(file: Path, changes: Changes) -> None:
    """Set dotted keys of a TOML file; None takes a key out; numbers count the tables of an array from 0."""
    document = tomlkit.parse(file.read_text(encoding="utf-8"))
    for dotted, value in changes.items():
        *way, last = dotted.split(".")
        table: Any = document
        for key in way:
            table = table[int(key)] if key.isdigit() else table[key]
        if value is None:
            table.pop(last, None)
        else:
            table[last] = value
    file.write_text(tomlkit.dumps(document), encoding="utf-8")
