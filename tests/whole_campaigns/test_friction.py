"""Friction campaigns through the command line: rehearsed, identified, judged; and every way they go wrong, said."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pandas as pd
import pytest

from stiffcal.cli.app import main
from stiffcal.commands.history import read_history
from stiffcal.presentation.values import Table
from stiffcal.report.building import lay_out
from stiffcal.report.gathering.content import report_content
from stiffcal.stages.fit import up_to_date_fit
from stiffcal.stages.steps import RunContext, up_to_date_states
from stiffcal.stages.validation import up_to_date_validation
from tests.laboratory.friction_campaigns import rehearsed, set_keys
from tests.laboratory.friction_law import friction_torque
from tests.whole_campaigns.conftest import Command

SCHEMAS = Path(__file__).resolve().parents[2] / "schemas"
TRUE = {
    1: {"coulomb": 60.0, "viscous": 90.0},
    2: {"coulomb": 80.0, "viscous": 120.0},
}
FEW = [0.03, 0.15, 0.6, 1.2]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The rehearsal as `init --kind friction` offers it, weights added; not to be changed."""
    return rehearsed(tmp_path_factory.mktemp("friction") / "cell")


@pytest.fixture
def cell(made: Path, tmp_path: Path) -> Path:
    """A copy that a test may change."""
    return Path(shutil.copytree(made, tmp_path / "cell", ignore=shutil.ignore_patterns("store")))


def small(folder: Path, **how: Any) -> Path:
    """Write a rehearsal of few speeds."""
    simulate = {"friction.speeds_rad_s": FEW, "friction.longest_s": 1.5, **how.pop("simulate", {})}
    return rehearsed(folder, simulate=simulate, **how)


def value(document: dict[str, Any], name: str) -> dict[str, Any]:
    return next(p for p in document["parameters"] if p["name"] == f"joint-friction.{name}")


def refused(words: list[str], capsys: pytest.CaptureFixture[str]) -> dict[str, str]:
    """Run a command that must end with code 2; return its one fault."""
    with pytest.raises(SystemExit) as end:
        main([*words, "--json"])
    reported = capsys.readouterr()
    assert end.value.code == 2, reported.out + reported.err
    assert "Traceback" not in reported.err
    fault: dict[str, str] = json.loads(reported.out)["error"]
    return fault


def test_friction_is_found_again(made: Path, command: Command) -> None:
    document = command("identify", made)
    for joint, true in TRUE.items():
        for symbol in ("coulomb", "viscous"):
            found = value(document, f"j{joint}.{symbol}")
            assert abs(found["value"] - true[symbol]) < 3.0 * found["std"] + 0.002 * true[symbol], found["name"]
            assert found["std"] < 0.02 * true[symbol]
    one, _ = document["friction"]["joints"]
    speed = np.array(one["curve"]["velocity"])
    wanted = friction_torque(speed, TRUE[1])
    assert np.all(np.abs(np.array(one["curve"]["torque"]) - wanted) < 4.0 * np.array(one["curve"]["std"]) + 0.2)
    assert document["not_identifiable"] == []
    assert document["noise_source"] == "neighbours"
    assert document["n_states"] == 0


def test_held_out_speeds_and_verdict(made: Path, command: Command) -> None:
    document = command("validate", made)
    assert "each speed left out" in document["scheme"]
    assert document["rms"]["torque"] < 1.3 * document["noise"]["torque"]
    assert document["relative"]["torque"] < 0.02
    assert {one["label"] for one in document["by_joint"]} == {"A1", "A2"}
    diagnosed = command("diagnose", made)
    assert diagnosed["missing"] == []
    assert diagnosed["adequate"]


@pytest.mark.parametrize("name", ["check", "ingest", "identify", "validate", "diagnose", "history"])
def test_answers_hold_to_their_schemas(made: Path, command: Command, name: str) -> None:
    schema = json.loads((SCHEMAS / f"{name}.document.schema.json").read_text(encoding="utf-8"))
    jsonschema.validate(command(name, made), schema)


def test_check_is_ready(made: Path, command: Command) -> None:
    document = command("check", made)
    assert document["ready"]
    assert [(run["experiment"], run["n_readings"] > 50) for run in document["runs"]] == [("friction", True)] * 2


def test_the_store_holds_passes_and_fit(made: Path, command: Command) -> None:
    command("identify", made)
    passes = pd.read_parquet(made / "store" / "current" / "friction.parquet")
    assert set(passes["joint"]) == {"A1", "A2"}
    assert (passes["set_aside"] == "").mean() > 0.95
    fit = pd.read_parquet(made / "store" / "current" / "friction_fit.parquet")
    left = fit["friction_measured_Nm"] - fit["friction_Nm"] - fit["residual_Nm"]
    assert np.abs(left).max() < 1e-9
    # weight of joint 2: a kilonewton metre that the friction does not see
    assert fit.loc[fit["joint"] == "A2", "beside_Nm"].abs().min() > 500.0


def test_pages_on_friction(made: Path) -> None:
    means = RunContext()
    data = up_to_date_states(made, means)
    identified = up_to_date_fit(data, means)
    content = report_content(
        data, identified, up_to_date_validation(data, identified, means), read_history(made, means)
    )
    (page,) = content.pages
    (table,) = (block for block in page.blocks if isinstance(block, Table))
    assert [row[0] for row in table.rows] == [("A1",), ("A2",)]
    sections = {one.title: one for one in lay_out(content)}
    assert "Friction of the drives" in sections
    assert "Stiffness" not in sections
    reported = " ".join(str(block) for block in sections["Summary"].blocks)
    assert "2 drives" in reported
    assert "each speed left out in turn" in reported


def test_pictures(made: Path, command: Command, tmp_path: Path) -> None:
    assert command("plot", made, "-o", tmp_path / "all.png")["drawn"] == "friction over speed of A1, A2"
    assert command("plot", made, "--against", "velocity:2", "-o", tmp_path / "two.png")["drawn"].endswith("of A2")
    assert (tmp_path / "two.png").stat().st_size > 5000
    assert "load states" in command("plot", made, "--against", "torque:2", codes=(2,))["error"]["reason"]
    assert "A5" in command("plot", made, "--against", "velocity:5", codes=(2,))["error"]["reason"]


def test_friction_alone_predicts_no_deflection(made: Path, command: Command) -> None:
    words = ("--load-path", "0,0,0;0,0,-100", "--at", "0,-70,20,0,30,0")
    fault = command("predict", made, *words, codes=(2,))["error"]
    assert "contains no compliance" in fault["reason"]


def test_export_compare_and_another_model(made: Path, command: Command, tmp_path: Path) -> None:
    assert "readings" in command("export", made, "-o", tmp_path / "x.csv")["holds"]
    command("export", made, "-o", tmp_path / "x.json")
    assert json.loads((tmp_path / "x.json").read_text())["parameters"]
    assert command("compare", made, made)["changed"] == []


def test_a_value_that_is_held(cell: Path, command: Command) -> None:
    (cell / "model.toml").write_text(
        (cell / "model.toml").read_text()
        + '[effects.parameters]\n"joint-friction.j2.viscous" = { value = 110.0, fixed = true }\n'
    )
    document = command("identify", cell)
    held = value(document, "j2.viscous")
    assert (held["value"], held["fixed"], held["std"]) == (110.0, True, None)


def test_current_without_a_torque_constant(cell: Path, capsys: pytest.CaptureFixture[str]) -> None:
    set_keys(cell / "campaign.toml", {"sources.controller.joints.torque_constant": None})
    fault = refused(["identify", str(cell)], capsys)
    assert "torque_constant" in fault["place"]
    assert "no torque constant is given" in fault["reason"]
    assert "N·m per ampere" in fault["mend"]


def test_a_joint_that_never_moved(cell: Path, capsys: pytest.CaptureFixture[str]) -> None:
    set_keys(cell / "campaign.toml", {"runs.0.moved_joint": 4})
    fault = refused(["ingest", str(cell)], capsys)
    assert fault["reason"] == "joint A4 never moved in this run"
    assert "A1" in fault["mend"]


def test_a_joint_of_the_model_that_no_run_moves(cell: Path, command: Command) -> None:
    model = cell / "model.toml"
    model.write_text(model.read_text().replace("[1, 2]", "[1, 2, 5]"))
    document = command("identify", cell)
    assert value(document, "j5.coulomb")["value"] is None
    assert any("A5 never moved" in gap["reason"] for gap in document["not_identifiable"])
    checked = command("check", cell, codes=(1,))
    assert checked["missing"] == ["joint A5: no run measures its friction: move it in both directions"]


def test_one_direction_only(tmp_path: Path, command: Command) -> None:
    folder = small(tmp_path / "one-way", simulate={"runs.1.friction": {"both_ways": False}})
    document = command("identify", folder)
    assert value(document, "j1.coulomb")["value"] == pytest.approx(60.0, rel=0.1)
    assert value(document, "j2.coulomb")["value"] is None
    (gap,) = [gap for gap in document["not_identifiable"] if "joint-friction.j2.coulomb" in gap["parameters"]]
    assert "one direction only" in gap["reason"]


def test_friction_in_a_model_that_lacks_it(cell: Path, capsys: pytest.CaptureFixture[str]) -> None:
    effect = '[[effects]]\ntype = "joint-compliance"\njoints = [1]\n'
    (cell / "model.toml").write_text(f'schema = "stiffcal/model/1"\n{effect}')
    fault = refused(["identify", str(cell)], capsys)
    assert "the model no friction" in fault["reason"]
    assert "joint-friction --all" in fault["mend"]


def test_without_a_model_file_every_drive_has_friction(cell: Path, command: Command) -> None:
    (cell / "model.toml").unlink()
    document = command("identify", cell)
    assert document["model"]["effects"] == [{"type": "joint-friction", "joints": [1, 2, 3, 4, 5, 6]}]
    assert value(document, "j2.viscous")["value"] == pytest.approx(120.0, rel=0.01)


def test_motor_side_logs_with_velocity(tmp_path: Path, command: Command, capsys: pytest.CaptureFixture[str]) -> None:
    """Angles, velocities in rpm and currents of the motors; then the wrong unit is named."""
    joints = {"motor": True, "torque_constant": 1.2, "velocity": "V1..V6"}
    joints |= {"units": {"position": "rad", "current": "A", "velocity": "rpm"}}
    white = {"sensors.controller.white": {"angle_rad": 1e-4}}
    folder = small(tmp_path / "motor", joints=joints, simulate=white, gear=100.0)
    document = command("identify", folder)
    assert value(document, "j2.coulomb")["value"] == pytest.approx(80.0, rel=0.02)
    assert value(document, "j2.viscous")["value"] == pytest.approx(120.0, rel=0.02)
    set_keys(folder / "campaign.toml", {"sources.controller.joints.units.velocity": "rad/s"})
    fault = refused(["ingest", str(folder)], capsys)
    assert "9.55 times that of its angles" in fault["reason"]


def test_a_stated_speed_that_is_not_reached(tmp_path: Path, command: Command) -> None:
    """004, section 5.2: programmed velocities would make false points; strokes too short for one are dropped."""
    first, second = {"speeds_rad_s": [0.3, 0.9, 1.5, 6.0]}, {"speeds_rad_s": [0.3, 0.9, 1.5], "reachable_rad_s": 1.2}
    folder = small(tmp_path / "slow", simulate={"runs.0.friction": first, "runs.1.friction": second})
    reported = command("ingest", folder)
    assert any("no phase of constant velocity" in words for words in reported["warnings"])
    passes = pd.read_parquet(folder / "store" / "current" / "friction.parquet")
    reached = passes["velocity_radps"].abs().groupby(passes["joint"]).max()
    assert reached["A1"] == pytest.approx(1.5, rel=0.01)
    assert reached["A2"] == pytest.approx(1.2, rel=0.01)
    document = command("identify", folder)
    assert value(document, "j2.viscous")["value"] == pytest.approx(120.0, rel=0.03)
