"""Whole simulated campaigns: exact against the balance, the same bytes from a seed, readable by the readers."""

from __future__ import annotations

import hashlib
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stiffcal.campaign.frames.frames import measurement_setup, resolve_frames
from stiffcal.campaign.loading import load_campaign
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.files import temporary_name
from stiffcal.measurements.load_states import Attachment
from stiffcal.mechanics.rotations import rotation_from_rpy, rpy_from_rotation, vector_from_rotation
from stiffcal.model.balance.equilibrium import solve_balance
from stiffcal.quaternions import rotation_from_quaternion
from stiffcal.reduction.logs.log_rows import LogRows, read_rows
from stiffcal.simulation.played.true_motion import PlannedRun, ToolWeight, solve_true_runs
from stiffcal.simulation.scene import draw_acts, robot_with_values, tool_weight, true_frames
from stiffcal.simulation.simulate import simulate_campaign
from stiffcal.trust.record import open_record
from tests.laboratory.simulation_folders import FRAMES, LOGS, MODEL, POSES, RUNS, SETTINGS, TABLE, write_folder

RATES = """
[sensors.ft]
rate_hz = 20.0
preamble = ["Messprotokoll Kraft", "Gerät 2"]
[sensors.tracker]
rate_hz = 10.0
[sensors.controller]
rate_hz = 5.0
"""


def rows_of(folder: Path, source: str, run: str | None = None) -> LogRows:
    manifest = load_campaign(folder).manifest
    entry = next((one for one in manifest.runs if one.id == run), None)
    parts = list(read_rows(folder, source, manifest.sources[source], manifest.files_of(source, entry)))
    signals = {name: np.concatenate([part.signals[name] for part in parts], axis=1) for name in parts[0].signals}
    return LogRows(
        np.concatenate([part.number for part in parts]),
        np.concatenate([part.time for part in parts]),
        [name for part in parts for name in part.run],
        signals,
    )


def digests(folder: Path) -> dict[str, str]:
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def test_a_table_without_noise_is_the_balance(tmp_path: Path) -> None:
    """The table's wrench, put into solve_balance as an analyst would, gives the table's poses."""
    campaign, settings = write_folder(tmp_path / "source", FRAMES + TABLE, SETTINGS + POSES)
    written = simulate_campaign(campaign, settings, tmp_path / "out")
    rows = rows_of(tmp_path / "out", "table")
    frames = resolve_frames(campaign.manifest, campaign.chain)
    setup = measurement_setup(campaign.manifest, campaign.chain, frames)
    angles = campaign.chain.model_angles(rows.signals["joints"].T)
    balance = solve_balance(robot_with_values(campaign), angles, rows.signals["wrench"].T, setup)
    tracker = frames["tracker"].transform
    seen = (balance.target_position[:, 0] - tracker[:3, 3]) @ tracker[:3, :3]
    np.testing.assert_allclose(rows.signals["position.target"].T, seen, atol=2e-8)  # written to 10 nm
    rotation = rotation_from_quaternion(rows.signals["quaternion.target"].T)
    turned = vector_from_rotation(rotation @ np.swapaxes(tracker[:3, :3].T @ balance.target_rotation[:, 0], 1, 2))
    assert np.abs(turned).max() < 1e-8
    assert written["states"] == len(rows) == 50
    assert np.abs(balance.displacement[:, 0, :3]).max() > 5e-4


def test_ramps_are_exact_within_a_tenth_of_a_micrometre(tmp_path: Path) -> None:
    """Places between the balances that are solved, against balances solved right there."""
    campaign, settings = write_folder(tmp_path, FRAMES + TABLE, SETTINGS + POSES)
    frames = true_frames(campaign, settings)
    planned = draw_acts(campaign, settings, frames, 3)[0]
    robot, tool = robot_with_values(campaign), tool_weight(campaign.manifest)
    played = solve_true_runs(robot, [planned], frames, tool)[0]
    path = np.linspace(0.0, 2.0 * len(planned.program) - 1.0, 307, dtype=np.float64)
    setup = measurement_setup(campaign.manifest, campaign.chain, frames)
    base = Attachment(0, np.eye(4))
    setup = replace(setup, wrench_axes=base, wrench_point=frames["load_point"], moments_measured=True)
    joints = np.repeat(campaign.chain.model_angles(planned.joints[None, :]), path.size, axis=0)
    balance = solve_balance(robot, joints, planned.program.wrench_at(path), setup)
    assert np.abs(played.position_at("target", path) - balance.target_position[:, 0]).max() < 1e-7
    turn = vector_from_rotation(played.rotation_at("target", path) @ np.swapaxes(balance.target_rotation[:, 0], 1, 2))
    assert np.abs(turn).max() < 1e-7


def test_logs_of_three_formats_hold_the_same_moment(tmp_path: Path) -> None:
    """Without noise: each log, on its own clock, shows the load and the place of the true states."""
    campaign, settings = write_folder(tmp_path / "source", FRAMES + LOGS + RUNS, SETTINGS + RATES + POSES)
    truth = simulate_campaign(campaign, settings, tmp_path / "out")["truth"]
    frames = true_frames(campaign, settings)
    robot, tool = robot_with_values(campaign), tool_weight(campaign.manifest)
    acts = draw_acts(campaign, settings, frames, settings.seed)
    for run, planned, played in zip(truth["runs"], acts, solve_true_runs(robot, acts, frames, tool), strict=True):
        holds = np.array(run["holds"])
        force, tracker, joints = (
            rows_of(tmp_path / "out", name, planned.name) for name in ("ft", "tracker", "controller")
        )
        for rows, source in ((force, "ft"), (tracker, "tracker"), (joints, "controller")):
            assert rows.time[0] == 0.0
            assert rows.time[-1] + run["clock_ahead_s"]["ft"] > holds[-1, 0], source
        middle = holds.mean(axis=1)
        path = np.arange(0.5, 2.0 * len(planned.program), 2.0, dtype=np.float64)
        load = np.stack([np.interp(middle, force.time, channel) for channel in force.signals["wrench"][:3]])
        size = np.sqrt(np.sum(planned.program.wrench[:, :3] ** 2, axis=1))
        np.testing.assert_allclose(np.sqrt(np.sum(load**2, axis=0)), size, atol=1e-3)
        seen = middle + run["clock_ahead_s"]["tracker"]
        position = np.stack(
            [np.interp(seen, tracker.time, channel) for channel in tracker.signals["position.target"]], axis=1
        )
        place = frames["tracker"].transform
        there = (played.position_at("target", path) - place[:3, 3]) @ place[:3, :3]
        np.testing.assert_allclose(position, there, atol=2e-8)
        np.testing.assert_allclose(joints.signals["joints"].T, np.tile(planned.joints, (len(joints), 1)), atol=1e-12)


def test_the_same_seed_gives_the_same_bytes(tmp_path: Path) -> None:
    noisy = RATES.replace("rate_hz = 20.0", "rate_hz = 20.0\nwhite = { force_N = 1.0 }\nbumps = { per_run = 1 }")
    campaign, settings = write_folder(tmp_path / "source", FRAMES + LOGS + RUNS, SETTINGS + noisy + POSES)
    for name, seed in (("one", None), ("two", 3), ("three", 4)):
        simulate_campaign(campaign, settings, tmp_path / name, seed=seed)
    one, two, three = (digests(tmp_path / name) for name in ("one", "two", "three"))
    assert one == two
    same = {name for name, digest in one.items() if three[name] == digest}
    assert same == {"campaign.toml", "robot.toml", "model.toml"}


@pytest.mark.parametrize("name", ["model.toml", "campaign.toml", "robot.toml", "raw/a_ft.csv"])
def test_what_was_changed_since_is_not_overwritten(tmp_path: Path, name: str) -> None:
    campaign, settings = write_folder(tmp_path / "source", FRAMES + LOGS + RUNS, SETTINGS + RATES + POSES)
    out = tmp_path / "out"
    simulate_campaign(campaign, settings, out, seed=3)
    simulate_campaign(campaign, settings, out, seed=4)  # untouched: simulated anew
    other = MODEL + "\n# another model\n"
    simulate_campaign(*write_folder(tmp_path / "other", FRAMES + LOGS + RUNS, SETTINGS + RATES + POSES, other), out)
    (out / name).write_bytes((out / name).read_bytes() + b"\n# mine\n")
    before = digests(out)
    with pytest.raises(InputError, match=f"{name}: .*{FaultCode.FILE_EXISTS.value}"):
        simulate_campaign(campaign, settings, out, seed=5)
    assert digests(out) == before
    simulate_campaign(campaign, settings, tmp_path / "elsewhere", seed=5)
    (out / name).unlink()
    simulate_campaign(campaign, settings, out, seed=5)


def test_noise_comes_out_as_it_was_asked_for(tmp_path: Path) -> None:
    noise = """
[sensors.table]
white = { translation_m = 2.4e-5, force_N = 1.2 }
between_holds = { translation_m = 1.6e-5, rotation_rad = 3e-5, moment_Nm = 0.2 }
readings_per_hold = 6
"""
    many = SETTINGS.replace("[loads]", "[loads]\ncycles = 20")
    outs = {}
    for name, sensors in (("exact", ""), ("noisy", noise)):
        campaign, settings = write_folder(tmp_path / f"{name}-source", FRAMES + TABLE, many + sensors + POSES)
        simulate_campaign(campaign, settings, tmp_path / name)
        outs[name] = rows_of(tmp_path / name, "table").signals
    force = outs["noisy"]["wrench"] - outs["exact"]["wrench"]
    assert np.std(force[:3]) == pytest.approx(1.2 / np.sqrt(6), rel=0.05)
    assert np.std(force[3:]) == pytest.approx(0.2, rel=0.05)
    position = outs["noisy"]["position.target"] - outs["exact"]["position.target"]
    assert np.std(position) == pytest.approx(np.hypot(1.6e-5, 2.4e-5 / np.sqrt(6)), rel=0.05)
    rotations = [rotation_from_quaternion(outs[name]["quaternion.target"].T) for name in ("noisy", "exact")]
    turn = vector_from_rotation(rotations[0] @ np.swapaxes(rotations[1], 1, 2))
    assert np.std(turn) == pytest.approx(3e-5, rel=0.05)


def test_the_robot_stands_off_its_kinematics_and_deflects_the_same(tmp_path: Path) -> None:
    outs = {}
    for name, robot in (("here", ""), ("there", "[robot]\nposition_error_m = 3e-4\n")):
        campaign, settings = write_folder(tmp_path / f"{name}-source", FRAMES + TABLE, SETTINGS + robot + POSES)
        simulate_campaign(campaign, settings, tmp_path / name)
        outs[name] = rows_of(tmp_path / name, "table").signals["position.target"]
    moved = outs["there"] - outs["here"]
    assert 1e-5 < np.abs(moved[:, 0]).max() < 2e-3
    np.testing.assert_allclose(moved[:, :25], np.repeat(moved[:, :1], 25, axis=1), atol=3e-8)
    assert np.abs(moved[:, 30] - moved[:, 0]).max() > 1e-5


def test_a_deflection_table_has_no_unloaded_rows(tmp_path: Path) -> None:
    table = """
[sources.table]
file = "raw/table.csv"
run = { each = "row" }
joints = { position = "A1..A6", units = { position = "deg" } }
wrench = { columns = ["Fx", "Fy", "Fz"], axes = "base", point = "load_point" }
deflection = { translation = ["dx", "dy", "dz"], units = { translation = "mm" }, body = "target", axes = "base" }
"""
    campaign, settings = write_folder(tmp_path / "source", FRAMES + table, SETTINGS + POSES)
    simulate_campaign(campaign, settings, tmp_path / "out")
    rows = rows_of(tmp_path / "out", "table")
    assert len(rows) == 2 * 3 * 2 * 3
    work = np.sum(rows.signals["wrench"][:3] * rows.signals["translation"], axis=0)
    assert (work > 0).mean() > 0.9
    frames = resolve_frames(campaign.manifest, campaign.chain)
    setup = measurement_setup(campaign.manifest, campaign.chain, frames)
    angles = campaign.chain.model_angles(rows.signals["joints"].T)
    balance = solve_balance(robot_with_values(campaign), angles, rows.signals["wrench"].T, setup)
    np.testing.assert_allclose(rows.signals["translation"].T, balance.displacement[:, 0, :3], atol=2e-8)


def test_the_model_comes_out_without_values_and_the_truth_with(tmp_path: Path) -> None:
    campaign, settings = write_folder(tmp_path / "source", FRAMES + TABLE, SETTINGS + POSES)
    written = simulate_campaign(campaign, settings, tmp_path / "out")
    out = load_campaign(tmp_path / "out")
    assert out.model.effects[0].joints == (1, 2, 3, 4, 5, 6)
    assert out.model.parameter_settings() == {}
    truth = json.loads((tmp_path / "out" / "truth.json").read_text())
    assert truth == written["truth"]
    assert truth["joint_stiffness"]["joint-compliance.j6.c"] == pytest.approx(16.55e3)


def test_a_hidden_effect_acts_and_is_in_the_truth_alone(tmp_path: Path) -> None:
    campaign, settings = write_folder(tmp_path / "source", FRAMES + TABLE, SETTINGS + POSES)
    play = '[[effects]]\ntype = "backlash"\njoints = [2]\n[effects.parameters]\n'
    values = '"backlash.j2.width" = { value = 1e-4 }\n"backlash.j2.band" = { value = 20.0 }\n'
    (tmp_path / "source" / "model.toml").write_text(f"{MODEL}\n{play}{values}", encoding="utf-8")
    campaign = load_campaign(tmp_path / "source", check_files=False)
    hidden = settings.model_copy(update={"robot": settings.robot.model_copy(update={"hidden": ["backlash"]})})
    truth = simulate_campaign(campaign, hidden, tmp_path / "out")["truth"]
    assert truth["parameters"]["backlash.j2.width"] == 1e-4
    assert [effect.type for effect in load_campaign(tmp_path / "out").model.effects] == ["joint-compliance"]
    wrong = settings.model_copy(update={"robot": settings.robot.model_copy(update={"hidden": ["creep"]})})
    with pytest.raises(InputError, match=r"robot\.hidden: the model file contains no creep"):
        simulate_campaign(campaign, wrong, tmp_path / "other")


def test_a_folder_may_be_simulated_into_itself_and_again(tmp_path: Path) -> None:
    campaign, settings = write_folder(tmp_path, FRAMES + TABLE, SETTINGS + POSES)
    for _ in range(2):
        simulate_campaign(campaign, settings, tmp_path)
    assert (tmp_path / "model.toml").read_text(encoding="utf-8") == MODEL
    assert len(rows_of(tmp_path, "table")) == 50


def test_runs_of_one_batch_are_those_of_single_runs(tmp_path: Path) -> None:
    campaign, settings = write_folder(tmp_path, FRAMES + TABLE, SETTINGS + POSES)
    frames = true_frames(campaign, settings)
    acts: list[PlannedRun] = draw_acts(campaign, settings, frames, 3)
    robot, tool = robot_with_values(campaign), ToolWeight(5.0, np.zeros(3))
    together = solve_true_runs(robot, acts, frames, tool)
    alone = [solve_true_runs(robot, [planned], frames, tool)[0] for planned in acts]
    for one, other in zip(together, alone, strict=True):
        assert one.planned.name == other.planned.name
        np.testing.assert_allclose(one.position["target"], other.position["target"], atol=1e-11)


PLUGIN = '''
"""Two effects that the catalogue does not have, in the shape of a user's own file."""

import numpy as np

from stiffcal.effects_api import RZ, Instrument, Law, ParameterSpec, Term, joint_node


class Wandering(Instrument):
    """The target wanders along x at a constant rate."""

    name = "wandering"
    place_kind = "setup"
    summary = "drift"
    parameters = (ParameterSpec("x", "m/s", "rate", -1.0, 1.0, 1e-8, "made up"),)

    def observation_columns(self, place, observed, shape):
        column = np.zeros_like(observed.displacement)
        column[:, 0] = observed.order.since_reference
        return {"x": column}


class Yielding(Law):
    """Joint 1 goes on turning while the load is held."""

    name = "yielding"
    place_kind = "joints"
    summary = "creep"
    has_memory = True
    parameters = (ParameterSpec("c", "rad/(N·m·s)", "rate", 0.0, 1.0, 1e-9, "made up"),)

    def terms(self, place, chain, loads, shape):
        node = joint_node(place.joints[0])
        hold = np.zeros(loads.wrench.shape[2]) if loads.order is None else loads.order.hold
        return (Term(node, RZ, "c", hold * loads.wrench[node, RZ]),)
'''

WITH_PLUGIN = (
    MODEL
    + """
[[effects]]
type = "wandering"
parameters = { "wandering.setup.x" = { value = 1e-6 } }
[[effects]]
type = "yielding"
joints = [1]
parameters = { "yielding.j1.c" = { value = 1e-7 } }
"""
)


def test_drift_and_creep_follow_time_and_hold(tmp_path: Path) -> None:
    """A user's own effects: one seen on top of the displacement, one with the time held as its driver."""
    (tmp_path / "own.py").write_text(PLUGIN, encoding="utf-8")
    open_record().allow_folder(tmp_path)
    manifest = FRAMES.replace('robot = "robot.toml"', 'robot = "robot.toml"\nplugins = ["own.py"]') + TABLE
    many = SETTINGS.replace("[loads]", "[loads]\nhold_points = 5")
    campaign, settings = write_folder(tmp_path, manifest, many + POSES, WITH_PLUGIN)
    frames = true_frames(campaign, settings)
    acts = draw_acts(campaign, settings, frames, 3)
    robot, tool = robot_with_values(campaign), tool_weight(campaign.manifest)
    without = robot.with_values({"wandering.setup.x": 0.0, "yielding.j1.c": 0.0})
    program = acts[1].program
    for name, kept in (("wandering.setup.x", "yielding.j1.c"), ("yielding.j1.c", "wandering.setup.x")):
        played = solve_true_runs(robot.with_values({kept: 0.0}), acts, frames, tool)[1]
        still = solve_true_runs(without, acts, frames, tool)[1]
        time = program.start[:, None] + np.array([0.1, 0.5, 1.0]) * (program.end - program.start)[:, None]
        path = program.path(time.ravel())
        extra = (played.position_at("target", path) - still.position_at("target", path)).reshape(*time.shape, 3)
        if name == "wandering.setup.x":
            since = time - 0.5 * (program.start[0] + program.end[0])
            np.testing.assert_allclose(extra[..., 0], 1e-6 * since, atol=1e-12)
        else:
            loaded = np.sqrt(np.sum(extra[:, -1] ** 2, axis=1)) > 5e-6
            assert loaded.sum() > 4
            grown = np.sum(extra[loaded, 1] * extra[loaded, 2], axis=1) / np.sum(extra[loaded, 2] ** 2, axis=1)
            assert grown == pytest.approx(np.full(loaded.sum(), 0.5), abs=0.02)


def test_rpy_is_the_inverse_of_its_rotation() -> None:
    rpy = np.random.default_rng(1).uniform(-1.5, 1.5, (200, 3))
    np.testing.assert_allclose(rpy_from_rotation(rotation_from_rpy(rpy)), rpy, atol=1e-12)


@pytest.mark.parametrize(
    ("part", "old", "new", "message"),
    [
        ("model", '"joint-compliance.j6.c" = { value = 6.042296073e-5 }\n', "", "parameters.joint-compliance.j6.c"),
        ("manifest", "xyz_m = [3.4, -1.1, 0.35]", "xyz_m = [3.4, -1.1, 0.35]\nestimate = true", "frames.tracker"),
        ("settings", "max_force_N = 400.0", "max_force_N = 4e7", "loads: "),
        ("settings", "max_force_N = 400.0", 'point = "hook"', 'no frame "hook"'),
        ("settings", 'id = "b"', 'id = "c"', 'the run "b" of campaign.toml is not here'),
        ("settings", "12.0, -14.0, 24.0", "12.0, -14.0, 124.0", "A3 = 124°"),
        ("settings", "12.0, -14.0, 24.0,", "12.0, -14.0,", "5 joint angles for a robot of 6"),
        ("settings", "rate_hz = 5.0", "", "sensors.controller.rate_hz"),
        ("settings", "[sensors.ft]", "[sensors.fts]", "sensors.fts"),
        ("settings", '"Gerät 2"', '"Gerät 2", ""', "3 lines of preamble, where campaign.toml skips 2"),
        ("manifest", 'id = "a"', 'id = "a"\nexperiment = "friction"', "which joint is driven"),
    ],
)  # fmt: skip
def test_faults_are_named(tmp_path: Path, part: str, old: str, new: str, message: str) -> None:
    texts = {"manifest": FRAMES + LOGS + RUNS, "settings": SETTINGS + RATES + POSES, "model": MODEL}
    assert old in texts[part]
    texts[part] = texts[part].replace(old, new, 1)
    campaign, settings = write_folder(tmp_path / "source", texts["manifest"], texts["settings"], texts["model"])
    with pytest.raises(InputError) as caught:
        simulate_campaign(campaign, settings, tmp_path / "out")
    assert message in str(caught.value)
    assert not (tmp_path / "out" / "truth.json").exists()


def test_a_folder_with_something_in_it_is_left_alone(tmp_path: Path) -> None:
    campaign, settings = write_folder(tmp_path / "source", FRAMES + TABLE, SETTINGS + POSES)
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "thesis.txt").write_text("mine", encoding="utf-8")
    with pytest.raises(InputError, match="not empty"):
        simulate_campaign(campaign, settings, tmp_path / "out")
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["thesis.txt"]


def test_a_folder_in_which_a_process_was_killed_before_its_first_file_is_used(tmp_path: Path) -> None:
    campaign, settings = write_folder(tmp_path / "source", FRAMES + TABLE, SETTINGS + POSES)
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / temporary_name(".json")).write_text("{", encoding="utf-8")
    simulate_campaign(campaign, settings, tmp_path / "out")
    assert (tmp_path / "out" / "truth.json").exists()
