"""A correcting controller: how much it takes back, how late, and that its commands are no motor pushed off."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pandas as pd
import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.commands.identify import identify_campaign
from stiffcal.documents import document_of
from stiffcal.errors import InputError, no_progress
from stiffcal.ingest.reading.reducing import reduce_campaign
from stiffcal.mechanics.low_pass import LowPass
from stiffcal.model.catalogue.catalogue import find_effects
from stiffcal.model.effect import EffectAtRest
from stiffcal.reduction.states.commanded import without_commands
from stiffcal.simulation.simulate import simulate_campaign
from tests.laboratory.simulation_folders import FRAMES, LOGS, MODEL, SETTINGS, TABLE, write_folder

TWICE = """
[[runs]]
id = "off"
{off}
[[runs]]
id = "on"
compensation = "on"
{on}
"""
POSE = "joints_deg = [-45.8, 4.6, 38.8, -0.1, 51.8, -73.0]"
POSES = f'[[runs]]\nid = "off"\n{POSE}\n[[runs]]\nid = "on"\n{POSE}\n'
SAME = "level_scatter = 0.0\ndirection_scatter_rad = 0.0\n"
TILT = """
[[effects]]
type = "bearing-tilt"
joints = [2]
[effects.parameters]
"bearing-tilt.j2.x" = { value = 6e-7 }
"bearing-tilt.j2.y" = { value = 6e-7 }
"""


def simulated(folder: Path, controller: str = "", model: str = MODEL, seed: int = 1) -> Path:
    source = folder / "source"
    settings = SETTINGS + SAME + POSES + controller
    campaign, loaded = write_folder(source, FRAMES + TABLE + TWICE.format(off="", on=""), settings, model)
    simulate_campaign(campaign, loaded, folder / "out", seed)
    return folder / "out"


def deflections(folder: Path) -> dict[str, np.ndarray]:
    """Return each run's (n, 3) displacement of the target since its first state, m, in the tracker's axes."""
    table = pd.read_csv(folder / "raw" / "states.csv")
    return {
        str(name): 1e-3 * (rows[["X", "Y", "Z"]].to_numpy() - rows[["X", "Y", "Z"]].to_numpy()[0])
        for name, rows in table.groupby("run")
    }


def test_the_right_model_takes_nearly_all_back(tmp_path: Path) -> None:
    seen = deflections(simulated(tmp_path))
    off, on = (np.linalg.norm(seen[name], axis=1) for name in ("off", "on"))
    assert off.max() > 1e-3
    assert on.max() < 0.02 * off.max()


def test_drives_alone_take_60_per_cent_of_what_drives_and_bearings_give(tmp_path: Path) -> None:
    seen = deflections(simulated(tmp_path, model=MODEL + TILT))
    off, on = (np.sqrt(np.mean(np.sum(seen[name] ** 2, axis=1))) for name in ("off", "on"))
    assert 0.02 * off < on < 0.40 * off
    whole = '[controller]\neffects = ["joint-compliance", "bearing-tilt"]\n'
    better = deflections(simulated(tmp_path / "whole", whole, MODEL + TILT))
    assert np.sqrt(np.mean(np.sum(better["on"] ** 2, axis=1))) < 0.02 * off


def test_a_controller_that_takes_the_robot_for_softer_overshoots(tmp_path: Path) -> None:
    names = "\n".join(f'"joint-compliance.j{k}.c" = {2 * c}' for k, c in enumerate((1.4e-6, 2.0e-6, 2.3e-6), start=1))
    seen = deflections(simulated(tmp_path, f"[controller.parameters]\n{names}\n"))
    loaded = np.linalg.norm(seen["off"], axis=1) > 5e-4
    assert np.all(np.sum(seen["on"][loaded] * seen["off"][loaded], axis=1) < 0.0)


def test_commands_are_no_motors_pushed_off(tmp_path: Path) -> None:
    folder = simulated(tmp_path)
    campaign = load_campaign(folder)
    states = reduce_campaign(campaign, no_progress).states
    assert [run.compensated for run in states.runs] == [False, True]
    effect = find_effects()["servo-deflection"]
    assert isinstance(effect, EffectAtRest)
    assert effect.lacking(campaign.chain, states) is None  # the log moves by the corrections
    plain = without_commands(states, campaign.chain)
    assert effect.lacking(campaign.chain, plain) is not None
    off, on = (plain.position[plain.run == k, 0] for k in (0, 1))
    # the load finds the corrected robot a milliradian from where it was: a thousandth of the deflection
    assert np.allclose(on - on[0], off - off[0], atol=5e-6)
    assert np.abs(states.position[states.run == 1, 0] - on).max() > 1e-3
    turned = plain.rotation[plain.run == 1, 0] @ np.swapaxes(plain.rotation[plain.run == 0, 0], 1, 2)
    assert np.allclose(turned, np.eye(3), atol=1e-5)


def test_a_compensated_run_shows_the_same_stiffness(tmp_path: Path) -> None:
    folder = simulated(tmp_path)
    document = document_of(identify_campaign(folder))
    assert document["n_runs"] == 2
    assert document["rms"]["translation"] < 5e-6  # of more than a millimetre
    found = {one["name"]: one["value"] for one in document["parameters"]}
    for name, true in (("joint-compliance.j1.c", 1.366456e-6), ("joint-compliance.j3.c", 2.333123e-6)):
        assert found[name] == pytest.approx(true, rel=5e-3)


def test_without_a_log_of_the_commands_such_a_run_is_set_aside(tmp_path: Path) -> None:
    campaign = load_campaign(simulated(tmp_path))
    states = reduce_campaign(campaign, no_progress).states
    joints = states.joints.copy()
    joints[states.run == 1] = joints[states.run == 1][0]
    plain = without_commands(replace(states, joints=joints), campaign.chain)
    assert set(plain.set_aside[plain.run == 1]) == {
        "the controller was correcting, and no joint log contains the correction"
    }
    assert set(plain.set_aside[plain.run == 0]) == {""}


def test_a_step_is_taken_back_after_filter_and_delay(tmp_path: Path) -> None:
    """A dead weight that drops (002, Fig. 7): the robot gives at once and is back after delay and filter lag."""
    step = "ramp_s = 0.001\nsettle_s = 0.0\nramp_scatter = 0.0\nboth_ways = false\nfirst_hold_s = 1.0\nhold_s = 1.0\n"
    settings = SETTINGS.replace("levels = [0.5, 1.0]", "levels = [1.0]\ndirections = [[0, 0, -1]]") + SAME + step
    sensors = "".join(f"[sensors.{name}]\nrate_hz = 1000.0\n" for name in ("ft", "tracker", "controller"))
    controller = "[controller]\ndelay_s = 0.05\nfilter_hz = 20.0\n"
    files = 'files = {{ ft = "raw/{0}_ft.csv", tracker = "raw/{0}_tracker.h5", controller = "raw/{0}_joints.parquet" }}'
    manifest = FRAMES + LOGS + TWICE.format(off=files.format("off"), on=files.format("on"))
    campaign, loaded = write_folder(tmp_path / "source", manifest, settings + POSES + sensors + controller)
    simulate_campaign(campaign, loaded, tmp_path / "out", 1)
    with h5py.File(tmp_path / "out" / "raw" / "on_tracker.h5") as file:
        group = file["at960"]
        time, place = np.array(group["t"]), np.stack([np.array(group[axis]) for axis in "XYZ"], axis=1)
    moved = np.linalg.norm(place - place[0], axis=1)
    gave = int(np.argmax(moved > 0.5 * moved.max()))
    whole = float(moved[gave + 5])
    # taken back by half after the delay, the filter's half-rise and up to one cycle
    rise = LowPass(20.0, 250.0, 1).run(np.concatenate([[[0.0]], np.ones((60, 1))]))[:, 0]
    half = 0.004 * float(np.interp(0.5, rise, np.arange(61.0)))
    back = time[gave + int(np.argmax(moved[gave + 5 :] < 0.5 * whole)) + 5] - time[gave]
    assert back == pytest.approx(0.05 + half, abs=0.006)
    held = (time > time[gave] + 0.3) & (time < time[gave] + 0.9)
    assert moved[held].max() < 0.03 * whole
    # and after the load has gone the correction stays for as long
    assert np.abs(moved[held | (time > time[gave] + 1.02)]).max() > 0.8 * whole


@pytest.mark.parametrize(
    ("controller", "message"),
    [
        ('effects = ["backlash"]', "the model file contains no backlash"),
        ('parameters = { "joint-compliance.j9.c" = 1.0 }', "no joint-compliance.j9.c"),
        ("filter_hz = 500.0", "is not below half"),
        ("cycle_s = 0.0", "cycle_s"),
    ],
)
def test_faulty_controllers(tmp_path: Path, controller: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        simulated(tmp_path, f"[controller]\n{controller}\n")
