"""The tool with and without a link's own part (000, Fig. 7), by the model and by the compliance that rods gave."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.commands.predict import predict_campaign
from stiffcal.compensation.link_parts import link_parts
from stiffcal.compensation.prediction import at_load_point
from stiffcal.compensation.requested_loads import LoadPathRequest
from stiffcal.model.balance.equilibrium import solve_balance
from tests.compensation.test_targets import six
from tests.laboratory.robots import SIX_STIFFNESS
from tests.laboratory.rod_states import bending_swing, six_axes_with_beams, with_effect
from tests.laboratory.simulated_states import joint_springs

MAX100 = Path(__file__).parents[2] / "campaigns" / "max100"
RIGIDITY = {"EI2": 4e6, "EI3": 6e6, "GJ": 3e6, "EA": 1.5e9}


def cantilever(length: float) -> Floats:
    """Return the closed form of a cantilever's end: displacement per wrench there, beam axes."""
    compliance = np.diag(
        [
            length / RIGIDITY["EA"],
            length**3 / (3.0 * RIGIDITY["EI3"]),
            length**3 / (3.0 * RIGIDITY["EI2"]),
            length / RIGIDITY["GJ"],
            length / RIGIDITY["EI2"],
            length / RIGIDITY["EI3"],
        ]
    )
    compliance[1, 5] = compliance[5, 1] = length**2 / (2.0 * RIGIDITY["EI3"])
    compliance[2, 4] = compliance[4, 2] = -(length**2) / (2.0 * RIGIDITY["EI2"])
    return compliance


def test_the_link_by_its_6x6_is_the_link_by_its_law() -> None:
    chain = six_axes_with_beams()
    robot = with_effect(joint_springs(chain, SIX_STIFFNESS), bending_swing(**RIGIDITY))
    _, setup, joints, wrench = six(6)
    setup, angles = at_load_point(setup), chain.model_angles(joints)
    known = cantilever(chain.beams["swing"].length)
    (part,) = link_parts(robot, angles, wrench, setup, None, {"swing": known})
    assert part.end is not None
    assert part.at_target is not None
    assert part.end_by_compliance is not None
    assert part.at_target_by_compliance is not None
    assert np.allclose(part.end_by_compliance, part.end, rtol=1e-9, atol=1e-15)
    # the rest of the robot stands otherwise where the swing is rigid: a share of its turns under load and weight, mrad
    size = np.linalg.norm(part.at_target[:, :3], axis=1)
    assert np.all(np.linalg.norm((part.at_target_by_compliance - part.at_target)[:, :3], axis=1) < 1.5e-2 * size)
    # with and without it are what the robot with and without a swing that gives does
    whole = solve_balance(robot, angles, wrench, setup).displacement[:, 0]
    rigid = solve_balance(joint_springs(chain, SIX_STIFFNESS), angles, wrench, setup).displacement[:, 0]
    assert np.allclose(whole - part.at_target, rigid, rtol=1e-12, atol=1e-12)

    blind = known.copy()
    blind[3], blind[:, 3] = np.nan, np.nan
    (twist_of_the_fit,) = link_parts(robot, angles, wrench, setup, None, {"swing": blind})
    assert twist_of_the_fit.end_by_compliance is not None
    assert np.allclose(twist_of_the_fit.end_by_compliance, part.end, rtol=1e-9, atol=1e-15)
    jointed = replace(robot, placed=robot.placed[:-1])
    (alone,) = link_parts(jointed, angles, wrench, setup, None, {"swing": blind})
    assert alone.end is None
    assert alone.end_by_compliance is not None
    assert np.all(alone.end_by_compliance[:, 3] == 0.0)
    assert link_parts(jointed, angles, wrench, setup, None, {}) == ()


def test_predict_shows_the_tool_with_and_without_the_swing(tmp_path: Path) -> None:
    folder = tmp_path / "max100"
    shutil.copytree(MAX100, folder)
    wish = LoadPathRequest("0,0,0;0,-1500,0", "-21,33,40,22,-73,-96", points=1)
    output = tmp_path / "predicted.csv"
    state = predict_campaign(folder, load_path=wish, output=output).states[1]
    (swing,) = state.links
    assert swing.link == "swing"
    # 000's pose 1 presses across the swing: a good tenth of what the tool does
    assert swing.at_target is not None
    share = np.dot(swing.at_target[:3], state.deflection[:3]) / np.dot(state.deflection[:3], state.deflection[:3])
    assert 0.10 < share < 0.20
    assert swing.at_target_by_compliance is None
    assert "dy of swing [mm]" in output.read_text().splitlines()[0]
