"""The real command killed at random moments: the store holds the last campaign's states or the new one's, whole.

Three kills here; ``STIFFCAL_KILLS=100`` makes it a hundred.
"""

from __future__ import annotations

import hashlib
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from stiffcal.commands.ingest import stored_states
from stiffcal.measurements.tables import states_from_table
from stiffcal.store import Store
from tests.laboratory.small_campaign import robot_text

KILLS = int(os.environ.get("STIFFCAL_KILLS", "3"))
KELVIN = {"one": 293.15, "two": 303.15}
FLANGE_M = (0.95619221, -0.52516348, 2.31314544)  # of the robot in the run's pose
N_HOLDS, ROWS_PER_HOLD = 20, 400

CAMPAIGN = """
schema = "stiffcal/campaign/1"
robot = "robot.toml"

[frames.target]
parent = "flange"

[sources.log]
time = { column = "t", unit = "s" }
wrench = { columns = ["Fx", "Fy", "Fz"], units = { force = "N" }, axes = "base", point = "target" }
pose = { frame = "base", body = "target", position = ["X", "Y", "Z"], units = { position = "m" } }
temperature = { columns = ["T1"], units = { temperature = "degC" } }

[[runs]]
id = "a"
joints_deg = [-30.0, -70.0, 20.0, 15.0, 40.0, 10.0]
files = { log = "raw/log.csv" }
"""

pytestmark = pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="SIGKILL is of POSIX")


def write_campaign(folder: Path) -> None:
    """Write a campaign of one log, and two versions of it that differ in the temperature of every reading."""
    (folder / "raw").mkdir(parents=True)
    (folder / "campaign.toml").write_text(CAMPAIGN, encoding="utf-8")
    (folder / "robot.toml").write_text(robot_text(), encoding="utf-8")
    generator = np.random.default_rng(4)
    n = N_HOLDS * ROWS_PER_HOLD
    load = np.repeat(100.0 * np.arange(N_HOLDS), ROWS_PER_HOLD)[:, None] * np.array([0.6, 0.0, 0.8])
    place = np.array(FLANGE_M) + 1e-6 * load
    rows = np.concatenate(
        [
            np.arange(n)[:, None] / 100.0,
            load + generator.normal(size=(n, 3)),
            place + 1e-5 * generator.normal(size=(n, 3)),
        ],
        axis=1,
    )
    for version, kelvin in KELVIN.items():
        table = np.concatenate([rows, np.full((n, 1), kelvin - 273.15)], axis=1)
        np.savetxt(
            folder / f"{version}.csv", table, fmt="%.7g", delimiter=",", header="t,Fx,Fy,Fz,X,Y,Z,T1", comments=""
        )


def ingest(folder: Path) -> subprocess.Popen[bytes]:
    """Start the command."""
    command = [sys.executable, "-m", "stiffcal", "ingest", str(folder), "--json"]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL)


def ingest_to_the_end(folder: Path) -> float:
    """Run the command; return how long it took, s."""
    began = time.monotonic()
    assert ingest(folder).wait(120) == 0
    return time.monotonic() - began


def digest(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()


def put(folder: Path, version: str) -> None:
    """Make the log that version, as a measuring program would: whole at once."""
    shutil.copy(folder / f"{version}.csv", folder / "raw" / "log.new")
    (folder / "raw" / "log.new").replace(folder / "raw" / "log.csv")


def version_of(folder: Path, digests: dict[str, str]) -> str:
    """Return of which version everything in the store is."""
    with Store(folder / "store", display_name="store").snapshot() as snapshot:
        states = states_from_table(snapshot.read_table("states"))
        recorded = snapshot.read_table("recordings/a/log").column("temperature1_K").to_numpy()
        document = snapshot.read_document("ingest")
        (source,) = snapshot.read_document("provenance")["sources"]
    assert recorded.size == N_HOLDS * ROWS_PER_HOLD
    assert len(states) == document["n_states"] == N_HOLDS
    kelvin = np.concatenate([recorded, states.temperature.ravel()])
    versions = [version for version, value in KELVIN.items() if np.allclose(kelvin, value)]
    assert len(versions) == 1, f"a mix: {np.unique(kelvin.round(2))} K"
    assert source["sha256"] == digests[versions[0]]
    return versions[0]


def generations(folder: Path) -> set[str]:
    return {entry.name for entry in (folder / "store" / "generations").iterdir()}


def other(version: str) -> str:
    return "two" if version == "one" else "one"


@pytest.mark.long
def test_the_command_killed_at_random_moments(tmp_path: Path) -> None:
    folder = tmp_path / "campaign"
    write_campaign(folder)
    digests = {version: digest(folder / f"{version}.csv") for version in KELVIN}
    usual = 0.0
    for held in ("one", "two"):
        put(folder, held)
        usual = max(ingest_to_the_end(folder), usual)
        assert version_of(folder, digests) == held
    chance = random.Random(5)
    # One moment in each of as many equal parts of the time (a little more than the command takes), in a random order.
    moments = [(number + chance.random()) / KILLS for number in range(KILLS)]
    chance.shuffle(moments)
    outcomes: Counter[str] = Counter()
    for moment in moments:
        put(folder, other(held))
        before = generations(folder)
        process = ingest(folder)
        began = time.monotonic()
        try:
            finished = process.wait(1.2 * moment * usual) == 0
            # The machine has become faster: the next moments are fractions of this.
            usual = time.monotonic() - began
        except subprocess.TimeoutExpired:
            process.kill()
            finished = process.wait(60) == 0
        found = version_of(folder, digests)
        assert not finished or found == other(held)
        begun = bool(generations(folder) - before)
        outcomes["finished" if finished else "new" if found != held else "old, half-written" if begun else "old"] += 1
        # and so does every command that reads load states
        put(folder, found)
        assert len(stored_states(folder, update=False)) == N_HOLDS
        held = found
    print(f"{KILLS} kills within {1.2 * usual:.2f} s: {dict(outcomes)}")
    assert outcomes["old"] + outcomes["old, half-written"] + outcomes["new"] > KILLS // 4
    put(folder, other(held))
    ingest_to_the_end(folder)
    assert version_of(folder, digests) == other(held)
    assert len(generations(folder)) == 1
