"""link-beam: the cantilever's closed forms, and a beam integrated numerically."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stiffcal.effects.link_beam import LinkBeam
from stiffcal.model.assembled.composite import PlacedEffect
from stiffcal.model.effect import RX, RY, RZ, TX, TY, TZ, Place, link_node
from tests.laboratory.effect_bench import BEAM_LENGTH, displacement, loads, robot_chain

EFFECT = LinkBeam()
PLACE = Place("links", (), "swing")
NODE = link_node(2)
L = BEAM_LENGTH
RIGIDITY = {"EI2": 8e6, "EI3": 5e6, "GJ": 4e6, "EA": 2e9}


def tip(component: int, load: float = 1000.0) -> np.ndarray:
    return displacement(EFFECT, PLACE, RIGIDITY, loads({(NODE, component): [load]}))[NODE, :, 0]


@pytest.mark.parametrize(
    ("component", "expected"),
    [
        (TX, {TX: 1000 * L / 2e9}),
        (TY, {TY: 1000 * L**3 / (3 * 5e6), RZ: 1000 * L**2 / (2 * 5e6)}),
        (TZ, {TZ: 1000 * L**3 / (3 * 8e6), RY: -1000 * L**2 / (2 * 8e6)}),
        (RX, {RX: 1000 * L / 4e6}),
        (RY, {RY: 1000 * L / 8e6, TZ: -1000 * L**2 / (2 * 8e6)}),
        (RZ, {RZ: 1000 * L / 5e6, TY: 1000 * L**2 / (2 * 5e6)}),
    ],
)
def test_closed_forms(component: int, expected: dict[int, float]) -> None:
    wanted = np.zeros(6)
    for place, value in expected.items():
        wanted[place] = value
    np.testing.assert_allclose(tip(component), wanted, rtol=1e-12)


def test_against_many_small_hinges() -> None:
    """A chain of short rigid pieces with springs EI/ΔL between them bends like the beam, signs by plain geometry."""
    force, moment = np.array([300.0, -200.0, 150.0]), np.array([40.0, -60.0, 90.0])
    n = 4000
    middle = (np.arange(n) + 0.5) * L / n
    arm = np.zeros((n, 3))
    arm[:, 0] = L - middle
    inner = moment + np.cross(arm, force)
    turn = inner / np.array([RIGIDITY["GJ"], RIGIDITY["EI2"], RIGIDITY["EI3"]]) * L / n
    shift = np.cross(turn, arm).sum(axis=0)
    shift[0] += force[0] * L / RIGIDITY["EA"]
    entries = {(NODE, k): [float(value)] for k, value in enumerate([*force, *moment])}
    found = displacement(EFFECT, PLACE, RIGIDITY, loads(entries))[NODE, :, 0]
    np.testing.assert_allclose(found, [*shift, *turn.sum(axis=0)], rtol=1e-6)


def test_unvalued_rigidities_count_as_rigid() -> None:
    assert PlacedEffect(EFFECT, PLACE, {}).amplitude("EI2") == 0.0
    assert PlacedEffect(EFFECT, PLACE, {"EI2": 4.0}).amplitude("EI2") == 0.25


def test_places_are_the_robots_beams() -> None:
    assert EFFECT.places(robot_chain()) == [PLACE]
    assert EFFECT.places(replace(robot_chain(), beams={})) == []


def test_driver_is_the_bending_moment_at_the_clamp() -> None:
    carried = loads({(NODE, TZ): [100.0], (NODE, RY): [10.0]})
    np.testing.assert_allclose(EFFECT.covariate(PLACE, robot_chain(), carried).value, [abs(10.0 - 100.0 * L)])
