"""`predict`: against the linear form of the papers, against its own derivatives, and the tables it reads."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiffcal.commands.history import read_history
from stiffcal.commands.predict import predict_campaign
from stiffcal.compensation.load_table import read_load_table
from stiffcal.compensation.requested_loads import LoadPathRequest, OneLoad
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.mechanics.kinematics import jacobians
from stiffcal.report.gathering.content import report_content
from stiffcal.stages.steps import RunContext, open_store, stored_fit, up_to_date_states
from stiffcal.stages.validation import up_to_date_validation
from tests.laboratory.small_campaign import POSES_DEG, STIFFNESS

POSE = ",".join(f"{angle:g}" for angle in POSES_DEG[0])
NAMES = ("A1", "A2", "A3", "A4", "A5", "A6")


def poses_file(folder: Path, rows: list[str], header: str = "A1,A2,A3,A4,A5,A6,Fx,Fy,Fz,Tx,Ty,Tz") -> Path:
    file = folder / "poses.csv"
    file.write_text("\n".join([header, *rows]) + "\n", encoding="utf-8")
    return file


def test_cartesian_compliance_is_the_papers_at_small_load(campaign: Path) -> None:
    """Wang, Zhang and Fuhlbrigge 2009, eq. 7: C = J K⁻¹ Jᵀ without load."""
    (state,) = predict_campaign(campaign, poses=poses_file(campaign, [POSE + ",0,0,0,0,0,0"])).states
    data = up_to_date_states(campaign, RunContext())
    chain = data.campaign.chain
    jacobian = jacobians(chain, chain.model_angles(np.radians([POSES_DEG[0]])), data.states.setup.targets[0])[0]
    expected = jacobian @ np.diag(1.0 / np.array(STIFFNESS)) @ jacobian.T
    found = np.array(state.cartesian_compliance)
    # the fit is off the truth by its uncertainty, and the robot sags by some tenths of a millimetre
    size = np.sqrt(np.diag(expected))
    assert np.all(np.abs(found - expected) < 0.03 * np.outer(size, size))
    assert np.allclose(np.array(state.cartesian_stiffness) @ found, np.eye(6), atol=1e-6)
    assert np.allclose(state.deflection, 0.0, atol=1e-11)


def test_deflection_follows_the_compliance(campaign: Path) -> None:
    rows = [POSE + f",{100 + step},0,-200,0,0,0" for step in (0, 1)]
    first, second = predict_campaign(campaign, poses=poses_file(campaign, rows)).states
    difference = np.array(second.deflection) - np.array(first.deflection)
    data = up_to_date_states(campaign, RunContext())
    lever = np.array(data.states.setup.targets[0].transform[:3, 3] - data.states.setup.wrench_point.transform[:3, 3])
    assert np.linalg.norm(lever) > 0.05  # so that load point and target differ indeed
    # a force at the load point is one at the target and a moment: the compliance knows both
    compliance = np.array(first.cartesian_compliance)
    from stiffcal.mechanics.kinematics import attached_poses

    chain = data.campaign.chain
    angles = chain.model_angles(np.radians([POSES_DEG[0]]))
    point, _ = attached_poses(chain, angles, data.states.setup.wrench_point)
    target, _ = attached_poses(chain, angles, data.states.setup.targets[0])
    moment = np.cross((point - target)[0], [1.0, 0.0, 0.0])
    assert np.allclose(difference, compliance @ [1.0, 0.0, 0.0, *moment], rtol=0.01, atol=2e-8)


def test_uncertainty_is_that_of_the_parameters(campaign: Path) -> None:
    (state,) = predict_campaign(campaign, poses=poses_file(campaign, [POSE + ",0,0,-300,0,0,0"])).states
    covariance = np.array(state.covariance)
    assert np.allclose(covariance, covariance.T)
    assert np.linalg.eigvalsh(covariance).min() > -1e-20
    # three parameters of one per cent make some micrometres of a millimetre
    assert 1e-7 < np.sqrt(covariance[2, 2]) < 2e-5
    # twice the load, twice the uncertainty
    (more,) = predict_campaign(campaign, poses=poses_file(campaign, [POSE + ",0,0,-600,0,0,0"])).states
    assert np.sqrt(np.array(more.covariance)[2, 2] / covariance[2, 2]) == pytest.approx(2.0, rel=0.02)


def test_load_path_passes_its_corners_and_reaches_the_report(campaign: Path) -> None:
    wish = LoadPathRequest("-100,200,-300;0,0,0;100,-200,100", POSE, points=4, note="the pose of the test")
    result = predict_campaign(campaign, load_path=wish)
    path = result.load_path
    assert path is not None
    assert path.corners == (0, 4, 8)
    assert path.force[8].tolist() == [100.0, -200.0, 100.0]
    assert np.allclose(path.deflection[4], 0.0, atol=1e-11)
    predict_campaign(campaign, load_path=wish)
    stored = open_store(campaign, RunContext()).read_document("load_paths")["paths"]
    assert len(stored) == 1
    data = up_to_date_states(campaign, RunContext())
    store = data.store
    fit = stored_fit(store)
    assert fit is not None
    content = report_content(
        data, fit, up_to_date_validation(data, fit, RunContext()), read_history(campaign, RunContext())
    )
    assert content.load_paths[0].pose.endswith("the pose of the test")


def test_a_load_path_may_be_a_file(campaign: Path) -> None:
    file = poses_file(campaign, ["0,0,0", "0,0,-100"], header="Fx,Fy,Fz")
    states = predict_campaign(campaign, load_path=LoadPathRequest(str(file), POSE, points=2)).states
    assert [state.wrench[2] for state in states] == [0.0, -50.0, -100.0]


def test_values_of_the_model_file_serve_where_nothing_was_measured(campaign: Path, tmp_path: Path) -> None:
    (campaign / "raw" / "states.csv").unlink()
    wish = LoadPathRequest("0,0,0;0,0,-100", POSE, points=1)
    elsewhere = RunContext(store=str(tmp_path / "elsewhere"))
    with pytest.raises(
        InputError, match=r"the campaign contains no measurements, and joint-compliance.j1.c has no value"
    ):
        predict_campaign(campaign, elsewhere, load_path=wish)
    values = "\n".join(f'"joint-compliance.j{k + 1}.c" = {{ value = {1 / c} }}' for k, c in enumerate(STIFFNESS))
    model = campaign / "model.toml"
    model.write_text(model.read_text() + "[effects.parameters]\n" + values + "\n")
    result = predict_campaign(campaign, elsewhere, load_path=wish)
    assert result.values_from == "model.toml"
    assert np.all(np.array(result.states[1].covariance) == 0.0)
    assert result.warnings


def test_output_is_a_table_with_units(campaign: Path) -> None:
    output = campaign / "predicted.csv"
    predict_campaign(campaign, poses=poses_file(campaign, [POSE + ",0,0,-300,0,0,0"]), output=output)
    header = output.read_text().splitlines()[0]
    assert '"A1 [deg]"' in header or "A1 [deg]" in header
    assert "dz [mm]" in header
    # what it wrote can be read again as poses and loads
    table = read_load_table(output, NAMES, joints_needed=True)
    assert table.wrench[0, 2] == -300.0
    assert np.allclose(np.degrees(table.joints[0]), POSES_DEG[0])


@pytest.mark.parametrize(
    ("wish", "message"),
    [
        (LoadPathRequest("1,2;3,4", POSE), "is not a list of loads"),
        (LoadPathRequest("1,2,3", POSE), "not a load path"),
        (LoadPathRequest("1,2,3;4,5,x", POSE), "contains something that is not a number"),
        (LoadPathRequest("1,2,3;4,5,6"), "no pose given"),
        (LoadPathRequest("1,2,3;4,5,6", "1,2,3"), "3 angles, the robot has 6 joints"),
    ],
)
def test_faulty_load_paths(campaign: Path, wish: LoadPathRequest, message: str) -> None:
    with pytest.raises(InputError, match=message):
        predict_campaign(campaign, load_path=wish)


@pytest.mark.parametrize(
    ("poses", "path", "place", "code"),
    [
        (OneLoad(POSE), True, "--pose", FaultCode.OPTION_CONFLICT),
        (Path("poses.csv"), True, "--poses", FaultCode.OPTION_CONFLICT),
        (None, False, "--poses", FaultCode.OPTION_MISSING),
        (OneLoad(POSE, ""), False, "--force", FaultCode.OPTION_INVALID),
    ],
)
def test_faults_of_what_is_requested_name_its_option(
    campaign: Path, poses: Path | OneLoad | None, path: bool, place: str, code: FaultCode
) -> None:
    wish = LoadPathRequest("0,0,0;0,0,-100", POSE) if path else None
    with pytest.raises(InputError) as refused:
        predict_campaign(campaign, poses=poses, load_path=wish)
    assert (refused.value.place, refused.value.code) == (place, code)


def test_units_in_brackets_and_decimal_commas(tmp_path: Path) -> None:
    header = "A1 [rad];A2;A3;A4;A5;A6;Fz [kN];comment"
    file = poses_file(tmp_path, ["0,5;90;0;0;0;0;-1,5;hello"], header)
    table = read_load_table(file, NAMES, joints_needed=True)
    assert table.joints[0, :2].tolist() == [0.5, np.pi / 2]
    assert table.wrench[0].tolist() == [0.0, 0.0, -1500.0, 0.0, 0.0, 0.0]


@pytest.mark.parametrize(
    ("header", "row", "message"),
    [
        ("A1,A2,A3,A4,A5,Fx", "0,0,0,0,0,0", "line 1: no column A6"),
        ("A1,A2,A3,A4,A5,A6 [xyz],Fx", "0,0,0,0,0,0,0", "column A6"),
        ("A1,A2,A3,A4,A5,A6,Fx", "0,0,0,0,0,0", "line 2: 6 cells, the header has 7"),
        ("A1,A2,A3,A4,A5,A6,Fx", "0,0,0,0,0,0,nan", "line 2, column Fx: 'nan' is not a finite number"),
        ("A1,A2,A3,A4,A5,A6,Rx", "0,0,0,0,0,0,100", "column Rx may be a moment or a rotation"),
    ],
)
def test_faulty_tables_name_line_and_column(tmp_path: Path, header: str, row: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        read_load_table(poses_file(tmp_path, [row], header), NAMES, joints_needed=True)


def test_moments_by_another_name_count(campaign: Path) -> None:
    rows = [POSE + ",0,0,-300,0,50,0"]
    first = predict_campaign(campaign, poses=poses_file(campaign, rows))
    other = predict_campaign(campaign, poses=poses_file(campaign, rows, "A1,A2,A3,A4,A5,A6,Fx,Fy,Fz,Mx,My,Mz"))
    assert np.array_equal(first.states[0].deflection, other.states[0].deflection)
    assert other.states[0].wrench[4] == 50.0


def test_poses_and_loads_in_other_units_are_doubted(campaign: Path) -> None:
    """One line each, and none where the units are stated."""
    radians = ",".join(f"{np.radians(angle):.4f}" for angle in POSES_DEG[0])
    header = "A1,A2,A3,A4,A5,A6,Fz"
    sound = predict_campaign(campaign, poses=poses_file(campaign, [POSE + ",-300"], header)).warnings
    for row, names, count in (
        (f"{radians},-300", header, 1),
        (f"{POSE},-0.3", header, 1),
        (f"{radians},-0.3", header, 2),
        (f"{radians},-0.3", "A1 [rad],A2 [rad],A3 [rad],A4 [rad],A5 [rad],A6 [rad],Fz [kN]", 0),
        (f"{POSE},-0.3", header.replace("Fz", "Fz [N]"), 0),
    ):
        warnings = predict_campaign(campaign, poses=poses_file(campaign, [row], names)).warnings
        assert len(warnings) == len(sound) + count, warnings
    warnings = predict_campaign(campaign, load_path=LoadPathRequest("0,0,0;0,0,-0.3", radians, points=2)).warnings
    assert len(warnings) == len(sound) + 2


@pytest.mark.parametrize(
    ("wish", "poses", "code"),
    [
        (LoadPathRequest("0,0,0;0,0,-100", POSE, points=10**9), False, FaultCode.SIZE_EXCEEDED),
        (LoadPathRequest("0,0,0;0,0,-100", f"1e9,{POSE.partition(',')[2]}"), False, FaultCode.OPTION_INVALID),
        (LoadPathRequest("0,0,0;0,0,-100", POSE), True, FaultCode.OPTION_CONFLICT),
    ],
)
def test_options_that_nobody_means(wish: LoadPathRequest, poses: bool, code: FaultCode, campaign: Path) -> None:
    table = poses_file(campaign, [f"{POSE},0"], f"{','.join(NAMES)},Fx") if poses else None
    with pytest.raises(InputError) as refused:
        predict_campaign(campaign, poses=table, load_path=wish)
    assert [fault.code for fault in refused.value.faults] == [code]
