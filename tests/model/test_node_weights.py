"""What weight makes every node carry is minus the slope of the potential energy along that node's displacement."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.campaign.loading import load_campaign
from stiffcal.errors import no_progress
from stiffcal.ingest.reading.reducing import reduce_campaign
from stiffcal.mechanics.chain import Chain
from stiffcal.model.balance.deformed_chain import deformed_chain, node_wrenches
from stiffcal.model.effect import Inputs

FOLDER = Path(__file__).resolve().parents[2] / "campaigns" / "absolute" / "05"
STEP = 1e-6


def potential(chain: Chain, angles: Floats, small: Floats) -> Floats:
    """Return (n,) J: the weights of all links at their centres."""
    bodies = deformed_chain(chain, angles, small).bodies
    energy = np.zeros(angles.shape[1])
    for k in range(chain.n_joints):
        energy -= float(chain.link_mass[k]) * (chain.gravity @ bodies[k + 1].point(chain.link_com[k]))
    return energy


@pytest.mark.parametrize("component", range(6))
def test_weight_works_along_the_displacement_of_every_node(component: int) -> None:
    """Virtual work (Lanczos, The Variational Principles of Mechanics, chapter III): links' ends carry no own weight."""
    campaign = load_campaign(FOLDER)
    chain, setup = campaign.chain, reduce_campaign(campaign, no_progress).states.setup
    angles = np.random.default_rng(4).uniform(-1.0, 1.0, (chain.n_joints, 5))
    none = np.zeros((2 * chain.n_joints + 2, 6, 5))
    inputs = Inputs(angles, np.zeros((6, 5)), setup)
    carried = node_wrenches(chain, deformed_chain(chain, angles, none), inputs)
    nodes = [2 * k - 1 for k in range(1, chain.n_joints + 1)] + [2 * beam.joint for beam in chain.beams.values()]
    assert len(nodes) > chain.n_joints
    for node in nodes:
        moved = none.copy()
        moved[node, component] = STEP
        slope = (potential(chain, angles, moved) - potential(chain, angles, -moved)) / (2.0 * STEP)
        assert carried[node, component] == pytest.approx(-slope, abs=1e-6)
