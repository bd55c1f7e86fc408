"""Whether `trend` names what has changed: ``python -P -m tests.rates.trends [SERIES] [FIRST_SEED] [FIRST LAST]``.

Every series is of one robot with a campaign a month, four before a change and three after it. In every month each
stiffness varies by 1 %, hook and target sit 0.1 mm elsewhere than stated along each axis, and the tracker is turned by
0.3 mrad. Counted are alarms, and of these what is named: the cause that is there ("right"), nothing for certain
("open": undecided or unexplained), or another cause firmly. FIRST and LAST choose scenarios.
"""

from __future__ import annotations

import sys
import tempfile
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.commands.trend import trend_campaigns
from stiffcal.errors import InputError
from tests.laboratory.small_campaign import CAMPAIGN, STIFFNESS, write_small_campaign

BEFORE, AFTER = 4, 3
JOINTS = len(STIFFNESS)
SETTINGS = "\n[trend]\ndate = 2026-{:02d}-01\nbetween_campaigns = 0.015\n"
TILT = """
[[effects]]
type = "bearing-tilt"
joints = [{joint}]
parameters = {{ "bearing-tilt.j{joint}.x" = {{ value = {size} }}, "bearing-tilt.j{joint}.y" = {{ value = {size} }} }}
"""
PLAY = """
[[effects]]
type = "backlash"
joints = [{joint}]
parameters = {{ "backlash.j{joint}.width" = {{ value = {size} }}, "backlash.j{joint}.band" = {{ value = 2.0 }} }}
"""


@dataclass(frozen=True)
class Change:
    """What is other after the change."""

    right: frozenset[str]
    """Verdicts that are right."""
    joints: tuple[int, ...] = ()
    """From 1; those that wear, if any."""
    stiffness: Floats = field(default_factory=lambda: np.ones(JOINTS))
    """Factors."""
    hidden: str = ""
    """Effects that no model holds."""
    hook: Floats = field(default_factory=lambda: np.zeros(3))
    """m, where the load acts, beyond what is stated."""
    target: Floats = field(default_factory=lambda: np.zeros(3))
    """m, likewise."""
    tracker: Floats = field(default_factory=lambda: np.zeros(3))
    """rad, how the tracker is turned."""
    tool_kg: float = 0.0
    """Mass of a tool that is not stated."""


def _scaled(*joints: int, by: float) -> Floats:
    factors = np.ones(JOINTS)
    factors[[joint - 1 for joint in joints]] = by
    return factors


def _direction(rng: np.random.Generator) -> Floats:
    vector = rng.normal(size=3)
    return np.asarray(vector / np.linalg.norm(vector))


def _one(rng: np.random.Generator) -> int:
    return int(rng.integers(1, JOINTS + 1))


def _worn(rng: np.random.Generator) -> Change:
    joint = _one(rng)
    return Change(frozenset({"wear"}), (joint,), _scaled(joint, by=0.9))


def _two_worn(rng: np.random.Generator) -> Change:
    one, other = (int(joint) + 1 for joint in rng.choice(JOINTS, 2, replace=False))
    return Change(frozenset({"wear"}), (one, other), _scaled(one, other, by=0.88))


def _repaired(rng: np.random.Generator) -> Change:
    return Change(frozenset({"stiffened"}), stiffness=_scaled(_one(rng), by=1.12))


def _hidden(template: str, sizes: tuple[float, float], last: int) -> Callable[[np.random.Generator], Change]:
    def change(rng: np.random.Generator) -> Change:
        joint = int(rng.integers(1, last + 1))
        text = template.format(joint=joint, size=f"{rng.uniform(*sizes):.3e}")
        # the joint that it is at is right too
        return Change(frozenset({"unexplained", "wear"}), (joint,), hidden=text)

    return change


SET_UP = frozenset({"set-up"})
CHANGES: dict[str, Callable[[np.random.Generator], Change]] = {
    "nothing": lambda rng: Change(frozenset()),
    "a joint loses 10 %": _worn,
    "two joints lose 12 %": _two_worn,
    "a joint is repaired, 12 % stiffer": _repaired,
    "a bearing gives way": _hidden(TILT, (4e-7, 1.5e-6), 3),
    "a drive has play": _hidden(PLAY, (1e-4, 4e-4), 6),
    "hook 15 mm elsewhere": lambda rng: Change(SET_UP, hook=0.015 * _direction(rng)),
    "target 10 mm elsewhere": lambda rng: Change(SET_UP, target=0.010 * _direction(rng)),
    "tracker turned by 20 mrad": lambda rng: Change(SET_UP, tracker=0.02 * _direction(rng)),
    "a tool of 30 kg": lambda rng: Change(SET_UP, tool_kg=30.0),
    "all warm, 6 % softer": lambda rng: Change(SET_UP, stiffness=np.full(JOINTS, 0.94)),
}  # fmt: skip


def _manifest(change: Change, rng: np.random.Generator, changed: bool) -> str:
    hook = np.array([0.02, 0.0, 0.18]) + 1e-4 * rng.normal(size=3) + changed * change.hook
    target = np.array([0.06, -0.04, 0.1]) + 1e-4 * rng.normal(size=3) + changed * change.target
    text = CAMPAIGN.replace("[0.02, 0.0, 0.18]", str(hook.tolist()))
    text = text.replace("[0.06, -0.04, 0.1]", str(target.tolist()))
    return text + (
        f"[tool]\nmass_kg = {change.tool_kg}\ncom_m = [0.0, 0.0, 0.1]\n" if changed and change.tool_kg else ""
    )


def verdict_of(change: Change, folder: Path, rng: np.random.Generator) -> str:
    """Return what is named of one series: "no alarm", "right", "open", or the wrong cause."""
    folders = []
    for month in range(BEFORE + AFTER):
        changed = month >= BEFORE
        factors = np.exp(0.01 * rng.normal(size=JOINTS)) * (change.stiffness if changed else 1.0)
        one = write_small_campaign(
            folder / f"month{month + 1}", seed=int(rng.integers(1 << 30)), hidden=change.hidden if changed else "",
            stiffness=(np.array(STIFFNESS) * factors).tolist(), set_up=_manifest(change, rng, changed),
            tracker_turn=(3e-4 * rng.normal(size=3) + changed * change.tracker).tolist(),
        )  # fmt: skip
        (one / "campaign.toml").write_text(CAMPAIGN + SETTINGS.format(month + 1), encoding="utf-8")
        folders.append(one)
    try:
        result = trend_campaigns(folders)
    except InputError as refused:
        return f"refused: {refused.faults[0].code.value}"
    if not result.alarms:
        return "no alarm"
    if result.cause is None:
        return "open"
    verdict = result.cause.verdict
    named = set(result.cause.causes[0].joints)
    if verdict in change.right and (verdict != "wear" or named == set(change.joints)):
        return "right"
    if verdict in ("undecided", "unexplained"):
        return "open"
    return f"{verdict}, joints {sorted(named)}" if named else f"{verdict}, {result.cause.causes[0].effect}"


def main(series: int, first_seed: int, first: int = 0, last: int = len(CHANGES)) -> None:
    """Print the table."""
    for number, (name, draw) in list(enumerate(CHANGES.items()))[first:last]:
        counts: Counter[str] = Counter()
        for seed in range(first_seed, first_seed + series):
            rng = np.random.default_rng([seed, number])
            with tempfile.TemporaryDirectory() as folder:
                counts[verdict_of(draw(rng), Path(folder), rng)] += 1
        print(f"{name}: {', '.join(f'{count} {verdict}' for verdict, count in counts.most_common())}", flush=True)


if __name__ == "__main__":
    given = [int(word) for word in sys.argv[1:]]
    main(*(given + [10, 1][len(given) :]))
