"""What hangs on the numbers of the judgement: each is changed, and the largest change of a probability is reported.

Those of the computation are doubled, grids made twice as fine over the same range: what moves a probability by more
than 0.01 is no setting, but a rule. Priors and what is ours are doubled and halved.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import stiffcal.judgement
from stiffcal.arrays import Floats
from stiffcal.campaign.loading import load_campaign
from stiffcal.errors import no_progress
from stiffcal.ingest.reading.reducing import reduce_campaign
from stiffcal.judgement import numbers
from stiffcal.judgement.judge import Judged
from stiffcal.judgement.priors import MemberKind
from stiffcal.judgement.states import judge_states
from stiffcal.measurements.load_states import LoadStates
from stiffcal.mistakes.states import exchanges
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.catalogue.campaign_effects import placed_robot
from stiffcal.model.catalogue.catalogue import built_in_effects
from tests.calibration.field_mix import draw_campaign


def _finer(grid: Floats) -> Floats:
    """Return a geometric grid with a point between each two."""
    return np.exp(np.interp(np.arange(2 * len(grid) - 1) / 2.0, np.arange(len(grid)), np.log(grid)))


_SPREAD = np.linspace(-3.6, 3.6, 41)
COMPUTED: Mapping[str, Mapping[str, Any]] = {
    "WITHIN": {"WITHIN": 18.0},
    "CLOSE": {"CLOSE": 24},
    "MOST_EXPANDED": {"MOST_EXPANDED": 28},
    "OUT_OF_REACH": {"OUT_OF_REACH": 80.0},
    "SHAPE_STAYS": {"SHAPE_STAYS": 0.15},
    "SHAPE_ROUNDS": {"SHAPE_ROUNDS": 10},
    "HOPELESS": {"HOPELESS": 8.0},
    "SWEEPS": {"SWEEPS": 6},
    "RIVALS_WITHIN": {"RIVALS_WITHIN": 50.0},
    "MOST_REFITS": {"MOST_REFITS": 16},
    "WAVES": {"WAVES": 40},
    "MOST_OF_RUN": {"MOST_OF_RUN": 84},
    "TAILS_WITHIN": {"TAILS_WITHIN": 8.0},
    "BINS": {"BINS": 640},
    "SCALE_PASSES": {"SCALE_PASSES": 24},
    "RUNS_KEPT": {"RUNS_KEPT": 16},
    "EXCHANGES_KEPT": {"EXCHANGES_KEPT": 6},
    "ROWS_KEPT": {"ROWS_KEPT": 24},
    "SIZES": {"SIZES": np.exp(np.log(5.0) * _SPREAD), "SIZE_WEIGHTS": np.exp(-0.5 * _SPREAD**2)},
    "UNLISTED_SIZES": {"UNLISTED_SIZES": _finer(numbers.UNLISTED_SIZES)},
    "RUN_SIZES": {"RUN_SIZES": _finer(numbers.RUN_SIZES)},
    "TOOL_SIZES": {"TOOL_SIZES": _finer(numbers.TOOL_SIZES)},
    "OF_CELL": {"OF_CELL": 8},
    "DISCREPANCIES": {"DISCREPANCIES": _finer(numbers.DISCREPANCIES)},
    "LINGERS": {"LINGERS": _finer(numbers.LINGERS)},
}  # fmt: skip
"""Numbers of the computation: by name the values with which each is doubled."""
OURS = (
    "STILL", "INSTEAD", "RUNS_KEPT", "FAR", "SHOWS_ITS_NOISE", "KNOWN_IN_PLACES", "BEYOND_USUAL", "LEVER_OF_NODE",
    "STEPS", "WARMING", "THRESHOLDS", "WIDTH_OF_STEP",
)  # fmt: skip
"""Numbers that are neither a prior of the published table nor a limit of the answer; by them it is asked ×2 and ÷2 …"""
PRIORS = (
    "SPRING", "EXPECTED_EFFECTS", "UNLISTED", "SETUP_MISTAKE", "CONTRADICTED", "DOUBTED_RUN", "DOUBTED_ROW",
    "LEVER_OF_TOOL", "STATED_NOISE_DOF", "NORMAL", "ALONE", "BEND", "LINGERING",
    "ALIKE_IN_SWEEPS",
)  # fmt: skip
"""… and of these."""


def changes(name: str) -> dict[str, Mapping[str, Any]]:
    """Return what a number is changed to, or each of several, by what is printed: probabilities stay below one."""
    value = getattr(numbers, name)
    if isinstance(value, tuple):
        return {
            f"{name} x 2": {name: tuple(2 * one for one in value)},
            f"{name} / 2": {name: tuple(one / 2 for one in value)},
        }
    more = 0.5 * (1.0 + value) if value == 0.5 else 2 * value
    return {f"{name} x 2": {name: more}, f"{name} / 2": {name: type(value)(value / 2)}}


@contextmanager
def _changed(values: Mapping[str, Any]) -> Iterator[None]:
    """Change numbers wherever they were imported to."""
    modules = [
        importlib.import_module(f"stiffcal.judgement.{one.name}")
        for one in pkgutil.iter_modules(stiffcal.judgement.__path__)
    ]
    modules.append(exchanges)
    before = {name: getattr(numbers if hasattr(numbers, name) else exchanges, name) for name in values}
    places = [(module, name) for module in modules for name in values if getattr(module, name, None) is before[name]]
    for module, name in places:
        setattr(module, name, values[name])
    try:
        yield
    finally:
        for module, name in places:
            setattr(module, name, before[name])


def probabilities(judged: Judged) -> dict[str, float]:
    """Return the probability of each effect and of each run that is off, and that of unlisted laws together."""
    found: dict[str, float] = {}
    for key, p in judged.weighed.probabilities().items():
        names = {judged.members[i].name for i in key if judged.members[i].kind is not MemberKind.UNLISTED}
        if any(judged.members[i].kind is MemberKind.UNLISTED for i in key):
            names.add("an unlisted law")
        for name in names:
            found[name] = found.get(name, 0.0) + p
    return found | {f"run {off.run}, state {off.state}": p for off, p in judged.aside.items()}


@dataclass(frozen=True)
class Asked:
    """A campaign that is judged with each number changed."""

    name: str
    states: LoadStates
    model: CompliantRobot


def of_field_mix(seed: int, first: int, count: int) -> list[Asked]:
    """Return campaigns of the field mix."""
    drawn = (draw_campaign(seed, number) for number in range(first, first + count))
    return [Asked(f"campaign {one.number}", one.states, one.model) for one in drawn]


def of_practice(folders: Sequence[Path]) -> list[Asked]:
    """Return campaigns of folders, read as ingest does."""
    found = []
    for folder in folders:
        campaign = load_campaign(folder)
        found.append(Asked(folder.name, reduce_campaign(campaign, no_progress).states, placed_robot(campaign)))
    return found


def table(campaigns: Sequence[Asked], changed: Mapping[str, Mapping[str, Any]]) -> str:
    """Return of each number the largest change of a probability in some campaigns, with what it was of.

    Parameters
    ----------
    changed : by what is printed the numbers and their other values.
    """
    lines = [f"{'changed':<26}{'most':>8}   of"]
    plain = [probabilities(judge_states(one.states, one.model, built_in_effects())) for one in campaigns]
    for name, values in changed.items():
        worst = (0.0, "")
        with _changed(values):
            for one, before in zip(campaigns, plain, strict=True):
                after = probabilities(judge_states(one.states, one.model, built_in_effects()))
                change = {k: after.get(k, 0.0) - before.get(k, 0.0) for k in before.keys() | after.keys()}
                largest = max(change, key=lambda k: (abs(change[k]), k), default="")
                if largest and abs(change[largest]) > abs(worst[0]):
                    worst = (change[largest], f"{largest} in {one.name}, {before.get(largest, 0.0):.3f} before")
        lines.append(f"{name:<26}{worst[0]:>+8.3f}   {worst[1]}")
    return "\n".join(lines)
