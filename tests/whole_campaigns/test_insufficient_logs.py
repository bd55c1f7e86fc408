"""Clamped and friction logs that cannot determine what the model asks for: one line each, and no value is guessed."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from stiffcal.cli.app import main
from stiffcal.commands.diagnose import diagnose_campaign
from stiffcal.commands.identify import identify_campaign
from stiffcal.commands.validate import validate_campaign
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.ingest.checks.loaded import check_campaign
from stiffcal.kinds.friction.fitting.identifiability import MotionLack, motion_lack
from tests.laboratory.friction_campaigns import rehearsed

JOINTS = Path(__file__).parents[2] / "campaigns" / "joints"


def copied(name: str, folder: Path) -> Path:
    return Path(shutil.copytree(JOINTS / name, folder / name, ignore=shutil.ignore_patterns("store")))


def cut_to_one_way(log: Path) -> None:
    """Keep the first whole way from the smallest torque to the largest."""
    table = pd.read_csv(log)
    torque = table["torque"].to_numpy()
    low = int(np.argmin(torque[:600]))
    high = low + int(np.argmax(torque[low : low + 401]))
    table.loc[low:high].to_csv(log, index=False)


def value_and_std(folder: Path, name: str) -> tuple[float, float]:
    parameter = {p.name: p for p in identify_campaign(folder).parameters}[name]
    assert parameter.value is not None
    assert parameter.std is not None
    return parameter.value, parameter.std


def test_a_clamped_run_without_reversal_is_left_out_everywhere(tmp_path: Path) -> None:
    folder = copied("02", tmp_path)
    whole = identify_campaign(folder)
    cut_to_one_way(folder / "raw" / "p1.csv.gz")
    checked = check_campaign(folder)
    assert not checked.ready
    assert [line for line in checked.missing if line.startswith("run p1: driven in one direction only")]
    assert len(checked.missing) == 1
    identified = identify_campaign(folder)
    assert identified.n_runs == whole.n_runs - 1
    assert identified.n_states < whole.n_states


def test_without_any_reversal_nothing_is_identified(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = copied("02", tmp_path)
    for log in (folder / "raw").glob("*.csv.gz"):
        cut_to_one_way(log)
    checked = check_campaign(folder)
    assert len(checked.missing) == 6
    with pytest.raises(SystemExit) as end:
        main(["identify", str(folder), "--json"])
    assert end.value.code == 2
    error = json.loads(capsys.readouterr().out)["error"]
    assert error["code"] == FaultCode.STATES_MISSING


def test_one_speed_determines_neither_coulomb_nor_viscous(tmp_path: Path) -> None:
    folder = rehearsed(tmp_path / "cell", {"friction.speeds_rad_s": [0.6]})
    checked = check_campaign(folder)
    assert [line.split(":")[0] for line in checked.missing] == ["joint A1", "joint A2"]
    assert all(MotionLack.ONE_SPEED.sentence in line for line in checked.missing)
    identified = identify_campaign(folder)
    assert {parameter.value for parameter in identified.parameters} == {None}
    assert not any(parameter.identifiable for parameter in identified.parameters)
    groups = {tuple(group.parameters) for group in identified.not_identifiable}
    assert ("joint-friction.j1.coulomb", "joint-friction.j1.viscous") in groups
    # their sum at that speed is known all the same: the noise of the current times its torque constant is left
    assert identified.rms.torque == pytest.approx(identified.noise and identified.noise.torque, rel=0.1)


def test_two_speeds_determine_both(tmp_path: Path) -> None:
    folder = rehearsed(tmp_path / "cell", {"friction.speeds_rad_s": [0.3, 0.6]})
    assert check_campaign(folder).ready
    for name, true in (("j1.coulomb", 60.0), ("j1.viscous", 90.0), ("j2.coulomb", 80.0), ("j2.viscous", 120.0)):
        value, std = value_and_std(folder, f"joint-friction.{name}")
        assert abs(value - true) < 3.5 * std


def test_one_direction_leaves_coulomb_open(tmp_path: Path) -> None:
    """A joint without stops that turns on and on: its constant torque is friction, weight or the sensor's zero."""
    folder = rehearsed(tmp_path / "cell", {"friction.speeds_rad_s": [0.15, 0.3, 0.6], "friction.longest_s": 1.5})
    for number in (1, 2):
        log = folder / "raw" / f"joint{number}.csv"
        table = pd.read_csv(log)
        forward = np.gradient(table[f"A{number}"], table["t"]) > 0.3
        table = table[forward]
        steps = np.diff(table[f"A{number}"], prepend=table[f"A{number}"].iloc[0]).clip(min=0.0)
        table.assign(**{f"A{number}": steps.cumsum(), "t": 0.01 * np.arange(len(table))}).to_csv(log, index=False)
    missing = check_campaign(folder).missing
    assert [line.split(":")[0] for line in missing] == ["joint A1", "joint A2"]
    assert all(MotionLack.ONE_DIRECTION.sentence in line for line in missing)
    identified = identify_campaign(folder)
    coulomb = [p for p in identified.parameters if p.name.endswith("coulomb")]
    assert [parameter.value for parameter in coulomb] == [None, None]
    error = validate_campaign(folder).rms.torque
    assert error is not None
    assert np.isfinite(error)


def test_motion_that_lacks_nothing() -> None:
    assert motion_lack(np.array([0.1, -0.1, 0.11, -0.11])) is None
    assert motion_lack(np.array([0.100, -0.101])) is MotionLack.ONE_SPEED


def test_too_few_positions_and_no_temperature_are_given_as_needs(tmp_path: Path) -> None:
    clamped = copied("04", tmp_path)
    manifest = clamped / "campaign.toml"
    head, *runs = manifest.read_text(encoding="utf-8").split("[[runs]]")
    manifest.write_text("[[runs]]".join([head, *runs[:2]]), encoding="utf-8")
    needs = {entry.effect: entry.needs for entry in diagnose_campaign(clamped).not_tried}
    assert "four poses" in needs["periodic-stiffness"]
    friction = copied("08", tmp_path)
    manifest = friction / "campaign.toml"
    manifest.write_text(re.sub(r"temperature = .*\n", "", manifest.read_text(encoding="utf-8")), encoding="utf-8")
    diagnosed = diagnose_campaign(friction)
    needs = {entry.effect: entry.needs for entry in diagnosed.not_tried}
    assert "temperature" in needs["friction-temperature"]
    assert "friction-temperature" not in [entry.effect for entry in diagnosed.missing]


def test_readings_at_the_end_of_the_range_make_no_states(tmp_path: Path) -> None:
    """A force sensor that is cut off would make the joint seem softer there."""
    folder = copied("01", tmp_path)
    compliance, std = value_and_std(folder, "joint-compliance.j1.c")
    for log in (folder / "raw").glob("*.csv.gz"):
        table = pd.read_csv(log)
        limit = 0.7 * float(table.torque.abs().max())
        table.assign(torque=table.torque.clip(-limit, limit)).to_csv(log, index=False)
    cut, cut_std = value_and_std(folder, "joint-compliance.j1.c")
    assert cut == pytest.approx(compliance, abs=4.0 * (std + cut_std))


def test_a_fault_of_a_joint_that_is_not_moved_is_a_fault_of_the_user(tmp_path: Path) -> None:
    folder = copied("02", tmp_path)
    text = (folder / "campaign.toml").read_text(encoding="utf-8").replace("moved_joint = 1", "moved_joint = 2", 1)
    (folder / "campaign.toml").write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match="moved_joint"):
        check_campaign(folder)
