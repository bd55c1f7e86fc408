"""Clamped runs of several joints: which states and which effects belong to which search."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stiffcal.diagnosis.drive_parts import drive_parts
from stiffcal.measurements.load_states import LoadStates, RunInfo
from stiffcal.model.catalogue import find_effects
from stiffcal.model.composite import CompliantRobot, PlacedEffect
from stiffcal.model.effect import Place
from tests.laboratory.clamped_bench import clamped_bench
from tests.laboratory.robots import six_axes

POSES = np.array([[0.1, -1.0, 0.8, 0.2, 0.7, 0.1], [-0.4, -0.8, 1.1, -0.3, 0.9, 0.4]])


def bench(*moved: int) -> LoadStates:
    return clamped_bench(six_axes(), POSES, moved, 1e-9 * np.eye(6))


def model() -> CompliantRobot:
    effects = find_effects()
    springs = [PlacedEffect(effects["joint-compliance"], Place("joints", (k,))) for k in range(1, 7)]
    plate = PlacedEffect(effects["fixture-compliance"], Place("setup"))
    return CompliantRobot(six_axes(), (*springs, plate))


def test_each_drive_has_its_states_and_its_effects() -> None:
    states = bench(2, 5)
    parts = drive_parts(states, model(), {"joint-compliance.j5.c": 3e-6})
    assert [part.joint for part in parts] == [2, 5]
    for part in parts:
        runs = {states.runs[number].name for number in states.run[part.chosen]}
        # of each pose the first run drives joint 2, the second joint 5
        assert runs == {info.name for info in states.runs[0 if part.joint == 2 else 1 :: 2]}
        assert [placed.place.label for placed in part.robot.placed] == [f"j{part.joint}", "setup"]
        assert len(part.robot.background) == 5
    assert not np.any(parts[0].chosen & parts[1].chosen)
    # the others give with their identified values, one's own start where the model file has them
    of_joint_5 = {placed.place.label: placed.values for placed in parts[0].robot.background}
    assert of_joint_5["j5"] == {"c": 3e-6}
    assert parts[1].robot.placed[0].values == {}


def test_one_joint_or_other_runs_are_searched_as_they_are() -> None:
    assert drive_parts(bench(3), model(), {}) == []
    states = bench(2, 5)
    with_loads = replace(states, runs=(RunInfo(states.runs[0].name, "load"), *states.runs[1:]))
    assert drive_parts(with_loads, model(), {}) == []
