"""Real measurements of a FANUC R-2000iC: the published stiffness, and figures from an independent plain fit.

Repository longton2001-pixel/breakthrough-surge-suppression-in-high-speed-robotic-drilling, ``data/stiffness_data``
(MIT): cable-loaded, 43 poses, one load each, forces and displacements in base axes. Read here with numpy alone; the
folder `shared/data/fanuc-r2000ic` next to the project, skipped where it is missing.

Conventions that give the figures: first order without weights of links; c times the torque of the force alone; rms is
the root mean square *length* of the 3-vector residual; no offset (the displacement is given as taken); every reading
counts alike; standard errors from the residuals with 3 n - 6 degrees of freedom; the percentage is that of the
compliance. Leave-one-out fits 42 poses and predicts the 43rd.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from stiffcal.arrays import Floats
from stiffcal.campaign.robot.geometry import chain_of
from stiffcal.campaign.robot.robot_file import RobotFile
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.fitting.identify import Settings, fit_rms, identify_parameters
from stiffcal.measurements.load_states import Attachment, LoadStates, MeasurementSetup, RunInfo
from stiffcal.mechanics.chain import Chain
from stiffcal.model.assembled.composite import CompliantRobot, PlacedEffect
from stiffcal.model.catalogue.catalogue import find_effects
from stiffcal.model.effect import Place
from stiffcal.validation.validate import validate_fit

FOLDER = Path(__file__).resolve().parents[3] / "shared" / "data" / "fanuc-r2000ic"
ROWS = (
    # alpha deg, a m, theta deg, d m: modified DH
    (0.0, 0.0, 0.0, 0.670),
    (-90.0, 0.312, -90.0, 0.0),
    (0.0, 1.075, 0.0, 0.0),
    (-90.0, 0.225, 0.0, 1.280),
    (90.0, 0.0, 0.0, 0.0),
    (-90.0, 0.0, 0.0, 0.215),
)
TOOL_POINT = (0.0069, 0.2453, 0.3193)
PUBLISHED = (8.6158e5, 2.8560e6, 1.8483e6, 2.7935e5, 4.1867e5, 2.7772e5)
LEFT_OUT = (1, 2, 11, 12, 13)


@cache
def robot() -> Chain:
    joints: list[dict[str, object]] = [
        {"name": f"J{k + 1}", "alpha_deg": alpha, "a_m": a, "theta_deg": theta, "d_m": d}
        for k, (alpha, a, theta, d) in enumerate(ROWS)
    ]
    joints[2] |= {"direction": -1, "logged": {"J2": 1, "J3": 1}}
    for k in (3, 4, 5):
        joints[k] |= {"direction": -1}
    document = {"schema": "stiffcal/robot/1", "convention": "modified-dh", "joints": joints}
    return chain_of(RobotFile.model_validate(document), Path())


def table(name: str) -> Floats:
    if not FOLDER.is_dir():
        pytest.skip(f"the FANUC measurements are not on this machine ({FOLDER})")
    return np.loadtxt(FOLDER / name, delimiter=",", skiprows=1)


@cache
def measurements(without: tuple[int, ...] = ()) -> LoadStates:
    """Return the 43 poses, each a run of one state; rows counted from 1 may be left out."""
    joints, force, moved = table("joint_angles.csv"), table("forces.csv"), table("deltaX.csv")
    n = len(joints)
    point = np.eye(4)
    point[:3, 3] = TOOL_POINT
    on_flange = Attachment(7, point)
    deflection = np.full((n, 1, 6), np.nan)
    deflection[:, 0, :3] = moved
    aside = np.array(["left out by the authors" if row in without else "" for row in range(1, n + 1)], dtype=np.str_)
    return LoadStates(
        runs=tuple(RunInfo(f"row{row}") for row in range(1, n + 1)),
        run=np.arange(n),
        time=np.full(n, np.nan),
        hold=np.full(n, np.nan),
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
        set_aside=aside,
        setup=MeasurementSetup(
            Attachment(0, np.eye(4)), on_flange, (on_flange,), ("tool",), False
        ),
    )  # fmt: skip


@cache
def identified(without: tuple[int, ...] = (), deformed: bool = False) -> Fit:
    effect = find_effects()["joint-compliance"]
    placed = tuple(PlacedEffect(effect, Place("joints", (k,))) for k in range(1, 7))
    model = CompliantRobot(robot(), placed, deformed)
    return identify_parameters(measurements(without), model, Settings(equal_weights=True))


def stiffness_and_error(fit: Fit) -> tuple[Floats, Floats]:
    """Return stiffness, N·m/rad, and its relative standard uncertainty."""
    stiffness, relative = [], []
    for k in range(1, 7):
        parameter = fit.parameter(f"joint-compliance.j{k}.c")
        assert parameter.value is not None
        assert parameter.std is not None
        stiffness.append(1.0 / parameter.value)
        relative.append(parameter.std / parameter.value)
    return np.array(stiffness), np.array(relative)


def test_all_poses() -> None:
    fit = identified()
    stiffness, relative = stiffness_and_error(fit)
    assert fit_rms(fit)["translation"] == pytest.approx(0.372e-3, abs=0.5e-6)
    assert [f"{k / 1e6:#.3g}" for k in stiffness] == ["0.861", "2.72", "1.96", "0.271", "0.425", "0.206"]
    np.testing.assert_allclose(100 * relative, [4, 16, 12, 14, 17, 48], atol=0.5)
    assert fit.scaled
    assert fit.dof == 3 * 43 - 6
    assert [k for k in range(1, 7) if fit.parameter(f"joint-compliance.j{k}.c").poorly_known] == [6]


def test_held_out_poses_and_no_model() -> None:
    found = validate_fit(measurements(), identified())
    assert found.heldout.scheme == "leave-one-pose-out"
    assert found.rms.translation == pytest.approx(0.405e-3, abs=0.5e-6)
    assert found.zero_model.translation == pytest.approx(1.725e-3, abs=0.5e-6)


def test_published_values_without_the_authors_five_rows() -> None:
    stiffness, _ = stiffness_and_error(identified(LEFT_OUT))
    for found, printed in zip(stiffness, PUBLISHED, strict=True):
        assert f"{found:.4e}" == f"{printed:.4e}"


def test_balanced_robot_differs_by_less_than_the_uncertainty() -> None:
    """Without link masses only the load deforms the robot: a few tenths of a percent, far below the error bars."""
    linear, relative = stiffness_and_error(identified())
    balanced, _ = stiffness_and_error(identified(deformed=True))
    change = balanced / linear - 1.0
    assert np.all(np.abs(change) < 0.3 * relative)
    assert np.abs(change).max() > 1e-4
