"""The ladder in characters: bars linear from zero, the noise marked; while it grows, the last number counts down."""

from __future__ import annotations

import re

import pytest

from stiffcal.cli.ladder_bars import COUNT_S, LiveLadder, bar_lines
from stiffcal.measurements.rms import Rms
from stiffcal.model.summary import Where
from stiffcal.presentation.bars import MARK
from stiffcal.results.improve_results import Action, ImproveStep
from stiffcal.show.ladder import ladder

NOISE = Rms(2.5e-5, None)


def step(error: Rms | None, action: Action = "add", effect: str = "backlash") -> ImproveStep:
    """Return a step after which so much error is left."""
    return ImproveStep(
        action=action,
        effect=None if action == "start" else effect,
        where=Where() if action == "start" else Where(joints=[4]),
        heldout_rms=error,
        noise=NOISE,
        zero_model=Rms(1e-3, None),
        scheme="leave-one-pose-out",
    )


STEPS = [step(Rms(1e-4, None), "start"), step(Rms(5e-5, None)), step(Rms(2.5e-5, None), effect="bearing-tilt")]


def bars(lines: list[str]) -> list[str]:
    """Return the bars of all lines but the title and the rule below it."""
    return [re.split(r" {2,}", line)[-1] if re.search(r"[█░│]", line) else "" for line in lines[2:]]


@pytest.mark.parametrize("width", [66, 80, 100])
def test_a_fourfold_fall_is_a_bar_four_times_shorter(width: int) -> None:
    lines = bar_lines(ladder(STEPS, NOISE, "leave-one-pose-out"), width)
    assert all(len(line) <= width for line in lines)
    none, present, first, last, noise = bars(lines)
    assert not none  # ten times the others: on their scale it has no room, and a bar that is cut would not be linear
    assert len(first) == pytest.approx(len(present) / 2, abs=1)
    assert len(last) == pytest.approx(len(present) / 4, abs=1)
    assert {bar.index(MARK) for bar in (present, first, last, noise)} == {len(noise) - 1}


def test_where_bars_have_no_room_there_is_none() -> None:
    lines = bar_lines(ladder(STEPS, NOISE, "leave-one-pose-out"), 40)
    assert not any(bars(lines))
    assert sum("mm" in line for line in lines) == 5


def test_of_several_measures_the_first_that_all_models_have_is_drawn() -> None:
    steps = [step(Rms(None, None, torque=4.0), "start"), step(Rms(None, None, torque=1.0))]
    noise = Rms(None, None, torque=1.0)
    _, present, added, last = bars(bar_lines(ladder(steps, noise, None), 80))
    assert len(present) == pytest.approx(4 * len(added), abs=4)
    assert len(added) == len(last)


def test_without_a_noise_nothing_is_marked_and_what_is_not_done_has_no_bar() -> None:
    lines = bar_lines(ladder([STEPS[0], step(None, "would add")], None, None), 80)
    assert MARK not in "".join(lines)
    assert [bool(bar) for bar in bars(lines)] == [False, True, False, False]


def test_the_number_counts_down_to_that_of_the_step() -> None:
    now = [0.0]
    live = LiveLadder(clock=lambda: now[0])
    assert live.lines(80) == []
    shown = []
    for one in STEPS[:2]:
        live.reached(one)
    for share in (0.0, 0.5, 1.0, 2.0):
        now[0] = share * COUNT_S
        shown.append(next(line for line in live.lines(80) if line.startswith("add")))
    numbers = [float(re.findall(r"([0-9.]+) mm", line)[0]) for line in shown]
    assert numbers == pytest.approx([0.1, 0.075, 0.05, 0.05])
    assert [len(line) for line in shown] == sorted((len(line) for line in shown), reverse=True)
