"""`init --kind clamped|friction --from`: what is proposed from a stranger's logs, and what is refused."""

from __future__ import annotations

import gzip
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.commands.identify import identify_campaign
from stiffcal.commands.init import init_campaign
from stiffcal.errors import InputError
from stiffcal.propose.drive_columns import drive_columns
from stiffcal.propose.from_logs import draft_from_logs, propose_from_logs
from stiffcal.propose.table_sniffing import SniffedColumn

COMPLIANCE = 4.0e-6  # rad/(N·m)
COULOMB, VISCOUS = 30.0, 50.0  # N·m, N·m·s/rad


def write(folder: Path, name: str, header: str, rows: np.ndarray, before: str = "") -> Path:
    path = folder / name
    lines = [before + header, *(",".join(f"{value:.7g}" for value in row) for row in rows)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def clamped_log(folder: Path, name: str, seed: int) -> Path:
    """A printer of benches writes it: milliseconds, degrees, the torque in kN·m, a temperature, and a word."""
    chance = np.random.default_rng(seed)
    time = np.arange(0.0, 30.0, 0.02)
    torque = 200.0 * np.sin(2.0 * np.pi * time / 10.0)
    angle = 40.0 * seed + np.degrees(COMPLIANCE * torque) + np.degrees(1e-6) * chance.standard_normal(time.size)
    rows = np.stack([1e3 * time, angle, 1e-3 * torque + 1e-4 * chance.standard_normal(time.size), 22.0 + 0.0 * time], 1)
    return write(folder, name, "Zeit [ms],Winkel [deg],Drehmoment [kNm],Temp [°C]", rows, "Pruefstand 3,,,\n")


def friction_log(folder: Path) -> Path:
    """Strokes of axis 2 of three, angles and currents of all."""
    chance = np.random.default_rng(5)
    steps = [(sign * speed, 1.0 / speed) for speed in (0.2, 0.3, 0.5, 0.8) for _ in range(3) for sign in (1.0, -1.0)]
    velocity = np.concatenate([np.full(int(last / 0.01), speed) for speed, last in steps])
    angle = np.cumsum(velocity) * 0.01
    rows = np.zeros((velocity.size, 7))
    rows[:, 0] = 0.01 * np.arange(velocity.size)
    rows[:, 2] = angle
    torque = COULOMB * np.sign(velocity) + VISCOUS * velocity + 0.3 * chance.standard_normal(velocity.size)
    rows[:, 5] = torque / 2.0
    return write(folder, "strokes.csv", "time_s,A1,A2,A3,I1_A,I2_A,I3_A", rows)


def values_of(folder: Path) -> dict[str, Any]:
    return {parameter.name: parameter for parameter in identify_campaign(folder).parameters}


def test_logs_of_a_bench_make_a_campaign_that_is_identified(tmp_path: Path) -> None:
    logs = [clamped_log(tmp_path, f"pos {k}.csv", k) for k in (1, 2, 3)]
    proposal = propose_from_logs(tmp_path / "bench", "clamped", logs)
    manifest = tomllib.loads(proposal.manifest)
    source = manifest["sources"]["log"]
    assert source["time"] == {"column": "Zeit [ms]", "unit": "ms"}
    assert source["joints"]["position"] == ["Winkel [deg]"]
    assert source["joints"]["torque"] == ["Drehmoment [kNm]"]
    assert source["joints"]["units"] == {"position": "deg", "torque": "kN*m"}
    assert source["temperature"] == {"columns": ["Temp [°C]"], "units": {"temperature": "degC"}}
    assert [(run["id"], run["experiment"], run["moved_joint"]) for run in manifest["runs"]] == [
        (f"pos-{k}", "clamped", 1) for k in (1, 2, 3)
    ]
    assert [effect.type for effect in load_campaign(tmp_path / "bench").model.effects] == ["joint-compliance"]
    compliance = values_of(tmp_path / "bench")["joint-compliance.j1.c"]
    # 1 µrad of angle and 0.1 N·m of torque in 1500 samples a run: 0.2 % is ten of their standard errors
    assert compliance.value == pytest.approx(COMPLIANCE, rel=2e-3)


def test_one_axis_of_three_in_free_motion(tmp_path: Path) -> None:
    proposal = propose_from_logs(tmp_path / "cell", "friction", [friction_log(tmp_path)])
    manifest = tomllib.loads(proposal.manifest)
    joints = manifest["sources"]["log"]["joints"]
    assert (joints["position"], joints["current"]) == (["A1", "A2", "A3"], ["I1_A", "I2_A", "I3_A"])
    assert joints["torque_constant"] == []
    assert manifest["runs"] == [
        {"id": "strokes", "experiment": "friction", "moved_joint": 2, "files": {"log": "raw/strokes.csv"}}
    ]
    model = tomllib.loads(proposal.model)
    assert model["effects"] == [{"type": "joint-friction", "joints": [2]}]
    with pytest.raises(InputError, match="torque_constant"):
        load_campaign(tmp_path / "cell")
    written = tmp_path / "cell" / "campaign.toml"
    written.write_text(written.read_text(encoding="utf-8").replace("torque_constant = []", "torque_constant = 2.0"))
    with pytest.raises(InputError, match=r"gravity_mps2 = \[0, 0, 0\]"):
        values_of(tmp_path / "cell")
    robot = tmp_path / "cell" / "robot.toml"
    robot.write_text("gravity_mps2 = [0, 0, 0]\n" + robot.read_text(encoding="utf-8"), encoding="utf-8")
    values = values_of(tmp_path / "cell")
    assert values["joint-friction.j2.coulomb"].value == pytest.approx(COULOMB, rel=0.02)
    assert values["joint-friction.j2.viscous"].value == pytest.approx(VISCOUS, rel=0.02)


def test_logs_of_two_devices_belong_together_by_name(tmp_path: Path) -> None:
    rows = np.array([[0.0, 1.0, 2.0, 3.0, 0.1, 0.2, 0.3], [0.1, 1.1, 2.0, 3.0, 0.1, 0.2, 0.4]])
    logs = []
    for run in ("a", "b"):
        logs.append(write(tmp_path, f"{run}_ft.csv", "Time,Fx,Fy,Fz,Tx,Ty,Tz", rows))
        logs.append(write(tmp_path, f"{run}_kuka.csv", "t_ms,M1,M2,M3", rows[:, :4]))
    manifest = tomllib.loads(draft_from_logs("clamped", logs).manifest)
    assert manifest["sources"]["ft"]["wrench"]["columns"] == "Fx..Tz" or manifest["sources"]["ft"]["wrench"][
        "columns"
    ] == ["Fx", "Fy", "Fz", "Tx", "Ty", "Tz"]
    assert manifest["sources"]["kuka"]["joints"]["motor"] is True
    assert [run["files"] for run in manifest["runs"]] == [
        {"ft": f"raw/{run}_ft.csv", "kuka": f"raw/{run}_kuka.csv"} for run in ("a", "b")
    ]
    with pytest.raises(InputError, match='run "b" has no log of kuka; add --from b_kuka.csv'):
        draft_from_logs("clamped", logs[:3])
    renamed = logs[1].rename(tmp_path / "kuka.csv")
    with pytest.raises(InputError, match="kuka.csv: header: its columns differ from those of a_ft.csv"):
        draft_from_logs("clamped", [logs[0], renamed])


@pytest.mark.parametrize(("header", "unit"), [("ms", "ms"), ("us", "us"), ("Millisekunden", "ms"), ("Seconds", "s")])
def test_a_column_that_is_called_by_a_unit_of_time_is_the_time(tmp_path: Path, header: str, unit: str) -> None:
    rows = np.column_stack([4.0 * np.arange(6), np.arange(6.0) / 7, np.arange(6.0) / 3])
    log = write(tmp_path, "log.csv", f"{header},angle [deg],torque [N*m]", rows)
    manifest = tomllib.loads(draft_from_logs("clamped", [log]).manifest)
    assert manifest["sources"]["log"]["time"] == {"column": header, "unit": unit}


def test_a_compressed_log_is_read(tmp_path: Path) -> None:
    plain = clamped_log(tmp_path, "p1.csv", 1)
    packed = tmp_path / "p2.csv.gz"
    packed.write_bytes(gzip.compress(plain.read_bytes()))
    manifest = tomllib.loads(draft_from_logs("clamped", [plain, packed]).manifest)
    assert [run["id"] for run in manifest["runs"]] == ["p1", "p2"]
    packed.write_bytes(packed.read_bytes()[:200])
    with pytest.raises(InputError, match="compressed file is damaged or incomplete"):
        draft_from_logs("clamped", [plain, packed])


@pytest.mark.parametrize(
    ("names", "signals"),
    [
        # UR, ROS and KUKA as their tools write them; commanded values are not measured ones
        ("timestamp actual_q_0 actual_q_1 actual_qd_0 actual_qd_1 actual_current_0 actual_current_1 target_q_0",
         {"position": "actual_q_0", "velocity": "actual_qd_0", "current": "actual_current_0"}),
        ("t joint_1_position joint_2_position joint_1_effort joint_2_effort",
         {"position": "joint_1_position", "torque": "joint_1_effort"}),
        ("Zeit AxisAct1 AxisAct2 Torque1 Torque2 Temp1 Temp2", {"position": "AxisAct1", "torque": "Torque1"}),
        ("TIME POSITION TORQUE CONTROL_TORQUE Q_CURRENT FAULT",
         {"position": "POSITION", "torque": "TORQUE", "current": "Q_CURRENT"}),
        ("t A1 A2 V1 V2 T1 T2", {"position": "A1", "velocity": "V1", "torque": "T1"}),
        ("t MotorPos MotorSpeed Iq T", {"position": "MotorPos", "velocity": "MotorSpeed", "current": "Iq"}),
    ],
)  # fmt: skip
def test_names_of_other_makers(names: str, signals: dict[str, str]) -> None:
    found = drive_columns(SniffedColumn(name, name, None, (0.0, 1.0)) for name in names.split())
    assert {signal: columns[0].header for signal, columns in found.signals.items()} == signals
    assert found.time is not None
    assert found.motor == names.startswith("t Motor")


@pytest.mark.parametrize(
    ("kind", "header", "words"),
    [
        ("clamped", "t,angle,note", "no columns of torque or current, or of forces"),
        ("clamped", "t,torque,speed", "no joint angles are recognised; name them angle"),
        ("friction", "t,angle,speed", "no columns of torque or current are recognised"),
        ("friction", "t,angle [deg],torque [bar]", "no columns of torque or current are recognised"),
    ],
)
def test_logs_that_cannot_serve(tmp_path: Path, kind: str, header: str, words: str) -> None:
    path = write(tmp_path, "log.csv", header, np.ones((4, 3)))
    with pytest.raises(InputError, match=words):
        propose_from_logs(tmp_path / "cell", kind, [path])
    assert not (tmp_path / "cell").exists()


def test_options_that_do_not_go_together(tmp_path: Path) -> None:
    log = clamped_log(tmp_path, "p1.csv", 1)
    with pytest.raises(InputError, match="no campaign of kind ids can be proposed"):
        init_campaign(tmp_path / "cell", kind="ids", tables=[log])
    with pytest.raises(InputError, match="a clamped run has no tool point"):
        init_campaign(tmp_path / "cell", kind="clamped", tables=[log], tool=(0.0, 0.0, 0.1))
    with pytest.raises(InputError, match="1 joint column.* but the robot has 6 joints"):
        init_campaign(tmp_path / "cell", kind="clamped", tables=[log], robot="kr125")
    assert not (tmp_path / "cell").exists()
