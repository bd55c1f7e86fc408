"""link-springs: two rigid halves and three springs at the middle."""

from __future__ import annotations

import numpy as np

from stiffcal.effects.link_beam import LinkBeam
from stiffcal.effects.link_springs import LinkSprings
from stiffcal.model.effect import RX, RY, RZ, TY, TZ, Place, link_node
from tests.laboratory.effect_bench import BEAM_LENGTH, displacement, loads, robot_chain

EFFECT = LinkSprings()
PLACE = Place("links", (), "swing")
NODE = link_node(2)
L = BEAM_LENGTH
STIFFNESS = {"k1": 1.1e7, "k2": 7.0e6, "k3": 7.7e6}


def test_by_plain_geometry() -> None:
    force, moment = np.array([300.0, -200.0, 150.0]), np.array([40.0, -60.0, 90.0])
    arm = np.array([L / 2, 0.0, 0.0])
    turn = (moment + np.cross(arm, force)) / list(STIFFNESS.values())
    entries = {(NODE, k): [float(value)] for k, value in enumerate([*force, *moment])}
    found = displacement(EFFECT, PLACE, STIFFNESS, loads(entries))[NODE, :, 0]
    np.testing.assert_allclose(found, [*np.cross(turn, arm), *turn], rtol=1e-12, atol=1e-18)


def test_pure_moment_as_the_beam_force_three_quarters_of_it() -> None:
    """k = EI/L gives the beam's turn under a moment, and (L/2)² L/EI = 3/4 of L³/3EI under a force at the end."""
    beam = {"EI2": 6e6, "EI3": 6e6, "GJ": 6e6, "EA": 1e30}
    springs = dict.fromkeys(STIFFNESS, 6e6 / L)
    for component in (RX, RY, RZ):
        carried = loads({(NODE, component): [50.0]})
        one, other = (displacement(e, PLACE, v, carried)[NODE, 3:] for e, v in ((LinkBeam(), beam), (EFFECT, springs)))
        np.testing.assert_allclose(other, one, rtol=1e-12)
    for component in (TY, TZ):
        carried = loads({(NODE, component): [50.0]})
        one, other = (
            displacement(e, PLACE, v, carried)[NODE, component] for e, v in ((LinkBeam(), beam), (EFFECT, springs))
        )
        np.testing.assert_allclose(other, 0.75 * one, rtol=1e-12)


def test_excludes_the_beam_and_is_excluded() -> None:
    assert "link-beam" in EFFECT.excludes
    assert "link-springs" in LinkBeam().excludes


def test_driver_is_the_moment_at_the_middle() -> None:
    carried = loads({(NODE, TY): [100.0]})
    np.testing.assert_allclose(EFFECT.covariate(PLACE, robot_chain(), carried).value, [100.0 * L / 2])
