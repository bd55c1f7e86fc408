"""All that may be wrong with a run: its states once for every mistake that is taken back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import log

import numpy as np

from stiffcal.arrays import Floats, Integers
from stiffcal.measurements.load_states import LoadStates, RunInfo
from stiffcal.mistakes.found import mistakes_of
from stiffcal.mistakes.runs.mistake import RunMistake, RunRead, Variant


def variants_of(read: RunRead) -> list[Variant]:
    """Return the possible faults of a run, the likelier ones first."""
    of_one, of_two = list[Variant](), list[Variant]()
    for mistake in mistakes_of(RunMistake):
        found = [replace(variant, kind=mistake.kind) for variant in mistake.ways(read)]
        if mistake.of_two_runs:
            of_two += found
        else:
            of_one += found
    return [*(replace(one, penalty=one.penalty + 2.0 * log(len(of_one))) for one in of_one), *of_two]


def trial_states(states: LoadStates, own: Integers, variants: Sequence[Variant]) -> LoadStates:
    """Return a run's states once for every variant, each a run of its own.

    Parameters
    ----------
    states : of the whole campaign. own : (k,) the run's states. variants : V of them.
    """
    picked = states.select(np.tile(own, len(variants)))
    arrays: dict[str, Floats] = {}
    for name in ("joints", "wrench", "position", "rotation", "deflection"):
        as_read = getattr(states, name)[own]
        arrays[name] = np.concatenate(
            [as_read if getattr(variant, name) is None else getattr(variant, name) for variant in variants]
        )
    return replace(
        picked,
        runs=tuple(RunInfo(f"variant {number + 1}") for number in range(len(variants))),
        run=np.repeat(np.arange(len(variants)), len(own)),
        joints=arrays["joints"],
        wrench=arrays["wrench"],
        position=arrays["position"],
        rotation=arrays["rotation"],
        deflection=arrays["deflection"],
    )
