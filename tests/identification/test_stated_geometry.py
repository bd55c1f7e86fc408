"""Zeros, lengths and twists in a convention: those of the true robot, to within their stated uncertainties."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.campaign.robot.geometry import chain_of, planned_rows
from stiffcal.commands.identify import identify_campaign
from stiffcal.effects.joint_offset import JointOffset
from stiffcal.effects.link_geometry import LinkGeometry
from stiffcal.identification.answers import stated_geometry
from stiffcal.identification.answers.geometry_results import GeometryFound, NoOffsets, OffsetsAlone, StatedNumber
from stiffcal.identification.answers.stated_geometry import HeldEnds, best_offsets, geometry_found
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.identify import identify_parameters
from stiffcal.identification.readings.observations import observe
from stiffcal.mechanics.joint_rows import rows_as_planned, rows_of_chain
from stiffcal.model.assembled.composite import CompliantRobot
from tests.laboratory.absolute_and_loads import write_campaign
from tests.laboratory.absolute_places import absolute_states, on_all_joints
from tests.laboratory.robots import six_axes
from tests.laboratory.track_and_arm import TRACK, robot_of

N_SEEDS = 5


def numbers(found: GeometryFound) -> dict[tuple[str, int], StatedNumber]:
    """Return every number of the rows by symbol and joint."""
    result = {("theta", zero.joint): zero.theta for zero in found.zeros}
    for link in found.links:
        result |= {("d", link.joint): link.d}
        if link.a is not None and link.alpha is not None:
            result |= {("a", link.joint): link.a, ("alpha", link.joint): link.alpha}
    return result | {("beta", entry.joint): entry.beta for entry in found.beta}


@pytest.fixture(scope="module")
def deviations(tmp_path_factory: pytest.TempPathFactory) -> list[float]:
    """Deviations of all numbers of all seeds from the true robot's, in standard uncertainties."""
    away = []
    for seed in range(N_SEEDS):
        folder = Path(tmp_path_factory.mktemp("stated")) / f"arm-{seed}"
        truth = write_campaign(folder, seed)
        campaign = load_campaign(folder)
        planned = planned_rows(campaign.robot, campaign.chain)
        true = rows_of_chain(truth.chain, planned).rows
        found = identify_campaign(folder).geometry
        assert isinstance(found, GeometryFound)
        assert found.convention == campaign.robot.convention
        stated = numbers(found)
        # the tracker and the target are found by the same places; of parallel axes 2 and 3 one d is a choice
        open_ones = {key for key, number in stated.items() if number.std is None}
        assert open_ones == {("theta", 1), ("d", 1), ("theta", 6), ("d", 6), ("d", 2)}
        assert stated["theta", 1].cannot_be_separated_from == ["frame.tracker"]
        assert stated["theta", 6].cannot_be_separated_from == ["frame.target"]
        assert stated["d", 2].cannot_be_separated_from == ["d of joint 3"]
        assert all(stated[key].change == 0.0 for key in open_ones)
        for key, number in stated.items():
            if number.std is not None:
                away.append((number.value - float(getattr(true, key[0])[key[1] - 1])) / number.std)
        # zeros as the controller takes them
        logged = np.array([zero.logged for zero in found.zeros])
        changes = np.array([zero.theta.change for zero in found.zeros])
        assert campaign.chain.coupling @ logged == pytest.approx(changes, abs=1e-12)
        alone = found.offsets_alone
        assert alone is not None
        assert alone.zeros[0] == alone.zeros[5] == 0.0
        assert 5e-5 < alone.mean <= alone.rms <= alone.max < 5e-3
    return away


@pytest.mark.practice
def test_stated_uncertainties_cover_the_truth(deviations: list[float]) -> None:
    """The mean square of 5 × 20 normal deviations lies between 0.6 and 1.5; those of one campaign hang together."""
    assert len(deviations) >= 5 * 18
    assert 0.6 < np.mean(np.square(deviations)) < 1.5
    assert np.abs(deviations).max() < 4.5


def test_of_few_places_no_number_is_claimed() -> None:
    """Five poses determine some combination, and no zero or length by itself."""
    chain = six_axes()
    states = absolute_states(chain, 5, 1)
    model = CompliantRobot(chain, tuple(on_all_joints(LinkGeometry(), 6)))
    fit = identify_parameters(states, model)
    found = geometry_found(fit, rows_as_planned(chain, "modified-dh"))
    assert found is not None
    assert all(number.std is None or number.std < 1.0 for number in numbers(found).values())
    none_known = geometry_found(replace(fit, free_names=(), covariance=np.zeros((0, 0))), rows_as_planned(chain, "dh"))
    assert none_known is not None
    assert all(number.std is None or number.std == 0.0 for number in numbers(none_known).values())


def test_the_zero_of_an_axis_parallel_to_a_track_is_the_frames() -> None:
    """A vertical slide under an upright arm: in all poses, a turn about joint 2 is one of the base."""
    rows = ((0.0, 0.0, 0.1, 0.0, *TRACK[0][4:]), (0.0, 0.0, 0.6, 0.0, *TRACK[1][4:]), *TRACK[2:6])
    chain = chain_of(robot_of(rows), Path())
    errors = np.random.default_rng(1).normal(0.0, 3e-4, (6, 4))
    names = ("x", "y", "rx", "ry")
    values = [dict(zip(names, row, strict=True)) for row in errors.tolist()]
    data = observe(absolute_states(chain, 40, 1), chain)
    held = HeldEnds(("frame.tracker",), ("frame.target1",))

    def found(limits: np.ndarray) -> list[float] | NoOffsets:
        of_limits = replace(chain, limits=limits)
        robot = CompliantRobot(of_limits, tuple(on_all_joints(LinkGeometry(), 6, values)))
        alone = best_offsets(cast("Fit", SimpleNamespace(robot=robot, data=data)), held)
        return alone if isinstance(alone, NoOffsets) else alone.zeros

    zeros = found(chain.limits)
    assert not isinstance(zeros, NoOffsets)
    assert zeros[0] == zeros[1] == zeros[5] == 0.0
    # tilts and shifts of 0.3 mrad and 0.3 mm at arms of 0.15 m and more
    assert 1e-4 < np.abs(zeros[2:5]).max() < 0.02
    narrow = chain.limits.copy()
    narrow[2] = 0.0, 0.5 * abs(zeros[2])
    assert found(narrow) is NoOffsets.BEYOND_RANGE


def test_offsets_alone_are_iterated_to_their_end(monkeypatch: pytest.MonkeyPatch) -> None:
    """Zeros that are wrong by up to a radian are found to rounding, and not called found before."""
    chain = six_axes()
    zeros = np.array([0.0, 1.0, -0.8, 1.0, -1.0, 0.0])
    parts = on_all_joints(JointOffset(), 6, [{"zero": zero} for zero in zeros.tolist()])
    data = observe(absolute_states(chain, 40, 1), chain)
    fit = cast("Fit", SimpleNamespace(robot=CompliantRobot(chain, tuple(parts)), data=data))
    held = HeldEnds(("frame.tracker",), ("frame.target1",))
    alone = best_offsets(fit, held)
    assert isinstance(alone, OffsetsAlone)
    assert alone.zeros == pytest.approx(zeros.tolist(), abs=1e-8)
    assert alone.max < 1e-8
    monkeypatch.setattr(stated_geometry, "MOST_STEPS", 3)
    assert best_offsets(fit, held) is NoOffsets.NOT_CONVERGED
