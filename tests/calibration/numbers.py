"""What hangs on the numbers of the computation: each is doubled, and the largest change of a probability is reported.

Grids are twice as fine over the same range. What a number moves by more than 0.01 is no setting, but a rule.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import numpy as np

import stiffcal.judgement
from stiffcal.arrays import Floats
from stiffcal.judgement.judge import Judged
from stiffcal.judgement.priors import MemberKind
from stiffcal.judgement.states import judge_states
from stiffcal.model.catalogue import built_in_effects
from tests.calibration.field_mix import draw_campaign


def _finer(grid: Floats) -> Floats:
    """Return a geometric grid with a point between each two."""
    return np.exp(np.interp(np.arange(2 * len(grid) - 1) / 2.0, np.arange(len(grid)), np.log(grid)))


_SPREAD = np.linspace(-3.6, 3.6, 17)
DOUBLED: Mapping[str, Mapping[str, Any]] = {
    "sets.WITHIN": {"WITHIN": 18.0},
    "sets.CLOSE": {"CLOSE": 24},
    "sets.MOST_EXPANDED": {"MOST_EXPANDED": 28},
    "sets.OUT_OF_REACH": {"OUT_OF_REACH": 80.0},
    "shapes.STAYS": {"STAYS": 0.15},
    "shapes.ROUNDS": {"ROUNDS": 10},
    "shapes.HOPELESS": {"HOPELESS": 8.0},
    "evidence.SWEEPS": {"SWEEPS": 6},
    "rivals.NEAR": {"NEAR": 50.0},
    "rivals.MOST_REFITS": {"MOST_REFITS": 16},
    "discrepancy.WAVES": {"WAVES": 40},
    "discrepancy.MOST_OF_RUN": {"MOST_OF_RUN": 84},
    "tails.NEAR": {"NEAR": 8.0},
    "tails.BINS": {"BINS": 640},
    "tails.PASSES": {"PASSES": 24},
    "exchanged.KEPT": {"KEPT": 6},
    "rows_off.KEPT": {"KEPT": 24},
    "priors.SIZES": {"SIZES": np.exp(np.log(5.0) * _SPREAD), "SIZE_WEIGHTS": np.exp(-0.5 * _SPREAD**2)},
    "priors.UNLISTED_SIZES": {"UNLISTED_SIZES": _finer(np.geomspace(0.05, 50.0, 7))},
    "priors.RUN_SIZES": {"RUN_SIZES": _finer(np.geomspace(2.0, 5000.0, 7))},
    "priors.DISCREPANCIES": {"DISCREPANCIES": _finer(np.array([0.05, 0.14, 0.4, 1.1, 3.2, 9.0]))},
}  # fmt: skip
"""By name the values with which it is doubled."""


@contextmanager
def _changed(values: Mapping[str, Any], home: str) -> Iterator[None]:
    """Change constants wherever they were imported to."""
    modules = [
        importlib.import_module(f"stiffcal.judgement.{one.name}")
        for one in pkgutil.iter_modules(stiffcal.judgement.__path__)
    ]
    source = importlib.import_module(f"stiffcal.judgement.{home}")
    before = {name: getattr(source, name) for name in values}
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


def table(seed: int, first: int, count: int) -> str:
    """Return of each number the largest change of a probability in each of some campaigns, with what it was of."""
    lines = [f"{'doubled':<26}{'most':>8}   of"]
    campaigns = [draw_campaign(seed, number) for number in range(first, first + count)]
    plain = [probabilities(judge_states(one.states, one.model, built_in_effects())) for one in campaigns]
    for name, values in DOUBLED.items():
        worst = (0.0, "")
        with _changed(values, name.split(".", maxsplit=1)[0]):
            for one, before in zip(campaigns, plain, strict=True):
                after = probabilities(judge_states(one.states, one.model, built_in_effects()))
                change = {k: after.get(k, 0.0) - before.get(k, 0.0) for k in before.keys() | after.keys()}
                largest = max(change, key=lambda k: (abs(change[k]), k), default="")
                if largest and abs(change[largest]) > abs(worst[0]):
                    place = f"{largest} in campaign {one.number}, {before.get(largest, 0.0):.3f} before"
                    worst = (change[largest], place)
        lines.append(f"{name:<26}{worst[0]:>+8.3f}   {worst[1]}")
    return "\n".join(lines)
