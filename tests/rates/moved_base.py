"""`python -m tests.rates.moved_base --seed N --count C`: how often a base that moved is named, and by which rows.

Motions of a stated size in random directions, from a random one of 80 rows on, in the linearised readings of four
robots (`tests/mistakes/test_moved_base.py`) with fresh noise. The size is in standard errors of what the rows
show of the motion: the norm of what the model's parameters leave of it, over the noise. Size 0 is no move at all.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.identification.fitting.fit import Fit
from stiffcal.mistakes.catalogue.places import moved_base as module
from stiffcal.mistakes.places.mistake import MovedRows
from stiffcal.mistakes.places.steps import Steps
from tests.laboratory.absolute_places import SIGMA
from tests.mistakes.test_moved_base import N, fitted, measured, moved_base, steps_about

ROBOTS = (1, 2, 3, 4)
SIZES = (0.0, 5.0, 7.0, 10.0)
MARGIN = 8
"""Rows at either end before which no move is drawn."""


@cache
def _robot(number: int) -> tuple[Fit, Steps]:
    """Return the fit to the rows of a robot that did not move, and what steps make there."""
    states = measured(number)
    fit = fitted(states)
    return fit, steps_about(fit, states)


def drawn(number: int, size: float, rng: np.random.Generator) -> tuple[int, MovedRows | None]:
    """Return the row from which a motion of so many standard errors acts, and what is found."""
    fit, steps = _robot(number)
    row = int(rng.integers(MARGIN, N - MARGIN))
    directions, _ = np.linalg.qr(steps.step(row).reshape(-1, module.NUMBERS))
    motion = rng.standard_normal(module.NUMBERS)
    shape = steps.own.shape[:2]
    left: Floats = (directions @ (size * motion / np.linalg.norm(motion))).reshape(shape) + rng.standard_normal(shape)
    left -= steps.basis @ np.tensordot(steps.basis, left, axes=([0, 1], [0, 1]))
    return row, moved_base(replace(fit, residual=SIGMA * left), measured(number))


def line_of(size: float, draws: Sequence[tuple[int, MovedRows | None]]) -> str:
    """Return the rates of moves of one size in a line."""
    named = [(row, move) for row, move in draws if move is not None]
    text = f"{size:4.0f}  named {len(named) / len(draws):.3f}"
    if not named or size == 0.0:
        return text
    drift = np.mean([move.or_drift for _, move in named])
    held = np.mean([move.between[0] < row <= move.between[1] for row, move in named])
    width = np.mean([move.between[1] - move.between[0] for _, move in named])
    exact = np.mean([move.state == row for row, move in named])
    return (
        f"{text}  of these or drifted {drift:.2f}, row in range {held:.3f}, rows in it {width:.1f}, exact {exact:.2f}"
    )


def main() -> None:
    """Print the rates."""
    parser = argparse.ArgumentParser(prog="python -m tests.rates.moved_base")
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--count", type=int, default=200)
    arguments = parser.parse_args()
    for size in SIZES:
        rng = np.random.default_rng([arguments.seed, int(size)])
        draws = [drawn(ROBOTS[k % len(ROBOTS)], size, rng) for k in range(arguments.count)]
        print(line_of(size, draws), flush=True)


if __name__ == "__main__":
    main()
