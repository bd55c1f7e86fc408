"""J. Wang, H. Zhang, T. Fuhlbrigge: Improving machining accuracy with robot deformation compensation.

IEEE/RSJ International Conference on Intelligent Robots and Systems (IROS), St. Louis, 2009. The paper's equations are
written out here once more, with pinocchio's Jacobians, and held against ours under ``balance = "first-order"``; of the
printed numbers those are checked that follow from printed numbers: section II.C's stiffness and Fig. 2's loads, the
poses in the captions of Figs. 6 and 7, section I's millimetre at 500 N. The paper prints no kinematics: where a robot
is needed it is `campaigns/irb4400/robot.toml`, whose README says what of it is public and what assumed. Measured curves
(Figs. 4, 6, 7, 9) cannot be checked without their data.
"""

from __future__ import annotations

import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.campaign.robot.geometry import chain_of
from stiffcal.campaign.robot.robot_file import RobotFile
from stiffcal.estimation.unknowns import free_columns
from stiffcal.identification.derivatives.observation import evaluate, observe
from stiffcal.identification.fitting.identify import Settings, identify_parameters
from stiffcal.measurements.load_states import Attachment, LoadStates, MeasurementSetup, RunInfo
from stiffcal.mechanics.chain import Chain
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.balance.equilibrium import solve_balance
from stiffcal.model.catalogue.catalogue import find_effects
from stiffcal.model.effect import Place
from tests.laboratory.pinocchio_robot import pinocchio_model, place_and_jacobian
from tests.laboratory.robots import shifted, six_axes, six_axis_joints

SECTION_II_C = np.array([386.83, 614.62, 372.29, 112.56, 97.79, 24.77]) * 1e3
SECTION_III_C = np.array([731.82, 488.31, 428.61, 59.52, 56.87, 16.55]) * 1e3
FIG_2_LOADS = np.array([[-100.0, 200.0, -300.0], [0.0, 0.0, 0.0], [100.0, -200.0, 100.0]])
CAPTIONS_DEG = {
    "Fig. 6": (-45.8058, 4.61262, 38.8404, -0.105546, 51.8232, -72.9578),
    "Fig. 7": (-40.1679, 0.9757, 31.8607, 3.2696, 56.7923, -30.5593),
}
# T_f and T_m: parallel, with different origins (section III.B, Fig. 3)
FORCE_POINT, MEASURED_POINT = Attachment(7, shifted(0.13, 0.05, 0.24)), Attachment(7, shifted(-0.06, -0.11, 0.17))


def model(chain: Chain, stiffness: Floats | None) -> CompliantRobot:
    effect = find_effects()["joint-compliance"]
    values = [{}] * 6 if stiffness is None else [{"c": float(1.0 / k)} for k in stiffness]
    placed = tuple(PlacedEffect(effect, Place("joints", (k + 1,)), values[k]) for k in range(6))
    return CompliantRobot(chain, placed, deformed=False)


def forces_at_a_point(force_point: Attachment, measured: Attachment) -> MeasurementSetup:
    base = Attachment(0, np.eye(4))
    return MeasurementSetup(base, force_point, (measured,), ("T_m",), False)


def experiment(n: int) -> tuple[Chain, LoadStates, Floats]:
    """Return robot, n readings (each a deflection already taken) with errors, and A_i of eq. 12 (n, 3, 6)."""
    rng = np.random.default_rng(31)
    chain = replace(six_axes(), link_mass=np.zeros(6))
    joints, force = six_axis_joints(rng, n), rng.normal(size=(n, 3)) * 200.0
    engine = pinocchio_model(chain)
    a = np.empty((n, 3, 6))
    for i, q in enumerate(chain.model_angles(joints)):
        _, _, at_force = place_and_jacobian(engine, chain, q, FORCE_POINT)
        _, _, at_measured = place_and_jacobian(engine, chain, q, MEASURED_POINT)
        torque = at_force[:3].T @ force[i]  # eq. 6, no torque at the force point
        a[i] = at_measured[:3] @ np.diag(torque)  # eq. 12
    deflection = np.full((n, 1, 6), np.nan)
    deflection[:, 0, :3] = a @ (1.0 / SECTION_III_C) + 2e-5 * rng.normal(size=(n, 3))
    unknown = np.full(n, np.nan)
    states = LoadStates(
        runs=tuple(RunInfo(f"{i}") for i in range(n)),
        run=np.arange(n),
        time=unknown,
        hold=unknown,
        joints=joints,
        wrench=np.concatenate([force, np.zeros((n, 3))], axis=1),
        position=np.full((n, 1, 3), np.nan),
        rotation=np.full((n, 1, 3, 3), np.nan),
        deflection=deflection,
        reference=np.zeros(n, dtype=np.bool_),
        temperature=np.zeros((n, 0)),
        row=np.arange(1, n + 1),
        n_readings=np.ones(n, dtype=np.int64),
        wrench_scatter=np.full((n, 6), np.nan),
        position_scatter=np.full((n, 1, 3), np.nan),
        set_aside=np.full(n, "", dtype=np.str_),
        setup=forces_at_a_point(FORCE_POINT, MEASURED_POINT),
    )
    return chain, states, a


def test_equations_8_and_9_force_frame_and_measurement_frame_apart() -> None:
    chain, states, a = experiment(30)
    balance = solve_balance(model(chain, SECTION_III_C), chain.model_angles(states.joints), states.wrench, states.setup)
    np.testing.assert_allclose(balance.displacement[:, 0, :3], a @ (1.0 / SECTION_III_C), rtol=0, atol=1e-15)


def test_equation_12_is_the_observation_matrix() -> None:
    chain, states, a = experiment(30)
    robot = model(chain, None)
    blocks = evaluate(replace(robot, deformed=False), observe(states, chain), free_columns(robot))
    found = np.concatenate([block.columns for block in blocks], axis=2)
    np.testing.assert_allclose(np.moveaxis(found, (0, 1, 2), (2, 1, 0)), a, rtol=1e-9, atol=1e-12)


def test_equations_10_and_11_solution_and_fitting_error() -> None:
    chain, states, a = experiment(30)
    stacked, b = a.reshape(-1, 6), states.deflection[:, 0, :3].ravel()
    solution = np.linalg.solve(stacked.T @ stacked, stacked.T @ b)  # eq. 10
    error = b @ b - (stacked.T @ b) @ np.linalg.solve(stacked.T @ stacked, stacked.T @ b)  # eq. 11
    fit = identify_parameters(states, model(chain, None), Settings(equal_weights=True))
    found = np.array([fit.parameter(f"joint-compliance.j{k}.c").value for k in range(1, 7)], dtype=np.float64)
    np.testing.assert_allclose(found, solution, rtol=1e-8)
    assert float(np.sum(fit.residual**2)) == pytest.approx(error, rel=1e-6)


def test_equations_2_and_4_cartesian_stiffness() -> None:
    """K_t = J⁻ᵀ K_θ J⁻¹: the deflections under six unit wrenches at the tool tip are its inverse's columns."""
    chain = replace(six_axes(), link_mass=np.zeros(6))
    setup = replace(forces_at_a_point(FORCE_POINT, FORCE_POINT), moments_measured=True)
    angles = chain.model_angles(np.radians([[20.0, -80.0, 25.0, 30.0, -50.0, 60.0]]))
    _, _, jacobian = place_and_jacobian(pinocchio_model(chain), chain, angles[0], FORCE_POINT)
    inverse = np.linalg.inv(jacobian)
    stiffness = inverse.T @ np.diag(SECTION_III_C) @ inverse
    moved = solve_balance(model(chain, SECTION_III_C), np.repeat(angles, 6, axis=0), np.eye(6), setup).displacement
    np.testing.assert_allclose(stiffness @ moved[:, 0].T, np.eye(6), atol=1e-8)


@pytest.fixture
def irb4400() -> Chain:
    folder = Path(__file__).resolve().parents[2] / "campaigns" / "irb4400"
    document: dict[str, Any] = tomllib.loads((folder / "robot.toml").read_text("utf-8"))
    return chain_of(RobotFile.model_validate(document), folder)


def deflections(chain: Chain, stiffness: Floats, pose_deg: tuple[float, ...], forces: Floats) -> Floats:
    """Return (n, 3) m, base axes, of the force point."""
    angles = np.repeat(chain.model_angles(np.radians([pose_deg])), len(forces), axis=0)
    wrench = np.concatenate([forces, np.zeros((len(forces), 3))], axis=1)
    setup = forces_at_a_point(FORCE_POINT, FORCE_POINT)
    return solve_balance(model(chain, stiffness), angles, wrench, setup).displacement[:, 0, :3]


@pytest.mark.parametrize("pose", CAPTIONS_DEG.values(), ids=CAPTIONS_DEG.keys())
def test_figure_2_piecewise_linear_in_z(irb4400: Chain, pose: tuple[float, ...]) -> None:
    """Its caption: other stiffness on either leg of the path, because F_x and F_y move the tip in z."""
    under_load = deflections(irb4400, SECTION_II_C, pose, FIG_2_LOADS)
    first, second = FIG_2_LOADS[0, 2] / under_load[0, 2], FIG_2_LOADS[2, 2] / under_load[2, 2]
    assert np.all(under_load[1] == 0.0)
    assert first / second > 1.5
    halfway = deflections(irb4400, SECTION_II_C, pose, FIG_2_LOADS / 2)
    np.testing.assert_allclose(halfway, under_load / 2, atol=1e-12)  # each leg is straight
    alone = deflections(irb4400, SECTION_II_C, pose, FIG_2_LOADS * [0.0, 0.0, 1.0])
    assert abs(alone[2, 2] / under_load[2, 2]) < 0.5  # "the contribution of Fx and Fy … is significant"


@pytest.mark.parametrize("pose", CAPTIONS_DEG.values(), ids=CAPTIONS_DEG.keys())
def test_section_1_500_newtons_make_a_millimetre(irb4400: Chain, pose: tuple[float, ...]) -> None:
    """With III.C's stiffness the caption's poses give by that order of magnitude: a factor of √10 either way."""
    moved = np.linalg.norm(deflections(irb4400, SECTION_III_C, pose, 500.0 * np.eye(3)), axis=1)
    assert np.all(np.abs(np.log10(moved / 1e-3)) < 0.5)
