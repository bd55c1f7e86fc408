"""How fast a large CSV log comes into the store, against pyarrow alone on the same file in the same run.

A campaign with one run is made in a temporary folder: a force log at 5 kHz of the size wanted (time and six wrench
columns), a tracker and a controller log next to it. Peer: ``pyarrow.csv.open_csv`` streamed into a ``ParquetWriter``,
single-threaded like ours, with pyarrow's own settings; and once more with the encoding of our store, to see how much of
the ratio is the encoding. Ours: ``ingest`` as the command runs it, from the manifest to the committed store, hashing
and flushing to the disk included; and reader and store without the reduction between them. Each runs in a process of
its own, in turns; the best of the turns counts.

    python -m tests.benchmarks.ingest_speed [--gigabytes 1] [--turns 3]

Limits: ingest at no less than 60 % of the peer's speed; peak memory at twice the size within 10 %.
"""

from __future__ import annotations

import argparse
import json
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

COLUMNS = ("Time", "Fx", "Fy", "Fz", "Tx", "Ty", "Tz")
LEAST_RATIO = 0.60
MOST_MEMORY_GROWTH = 1.10
RATE_HZ = 5000
TRACKER_HZ = 10
TURN_S = 5.0
RAMP_S = 1.0
N_LOADS = 16
JOINTS_DEG = (10.0, 20.0, -15.0, 30.0, 60.0, -20.0)
COMPLIANCE = 1.2e-6  # m/N at the target, alike in all directions
CAMPAIGN = """schema = "stiffcal/campaign/1"
robot = "robot.toml"
[frames.tracker]
parent = "base"
xyz_m = [0.0, 0.0, 0.0]
[frames.ft_sensor]
parent = "flange"
xyz_m = [0.0, 0.0, 0.06]
[frames.target]
parent = "flange"
xyz_m = [0.0, 0.0, 0.10]
[sources.ft]
time = { column = "Time", unit = "s" }
sampling = "time"
[sources.ft.wrench]
columns = ["Fx", "Fy", "Fz", "Tx", "Ty", "Tz"]
units = { force = "N", moment = "N*m" }
frame = "ft_sensor"
acts_on = "robot"
[sources.tracker]
time = { column = "t", unit = "s" }
sampling = "time"
[sources.tracker.pose]
frame = "tracker"
body = "target"
position = ["X", "Y", "Z"]
units = { position = "mm" }
[sources.controller]
time = { column = "t", unit = "s" }
sampling = "time"
[sources.controller.joints]
position = "A1..A6"
units = { position = "deg" }
[[runs]]
id = "long"
experiment = "load"
clock_ahead_s = { tracker = 0.0, controller = 0.0 }
files = { ft = "ft.csv", tracker = "tracker.csv", controller = "controller.csv" }
"""


def make_campaign(folder: Path, size: int, rate_hz: int) -> Path:
    """Write a campaign whose force log has about `size` bytes, at so many rows in a second; return that log."""
    from stiffcal.campaign.loading import load_campaign
    from stiffcal.mechanics.kinematics import body_poses
    from stiffcal.propose.templates import bundled_robot

    folder.mkdir()
    (folder / "campaign.toml").write_text(CAMPAIGN, "utf-8")
    (folder / "robot.toml").write_text(bundled_robot("irb4400"), "utf-8")
    chance = np.random.default_rng(7)
    loads = chance.normal(size=(N_LOADS, 6)) * [200, 200, 200, 30, 30, 30]
    loads[[0, -1]] = 0  # the first turn goes from the last load to the first: unloaded
    rows = write_forces(folder / "ft.csv", loads, size, rate_hz, chance)
    chain = load_campaign(folder, check_files=False).chain
    logged = np.deg2rad([JOINTS_DEG])
    position, rotation = (values[0, -1] for values in body_poses(chain, chain.model_angles(logged)))
    time_s = np.arange(0, rows / rate_hz, 1 / TRACKER_HZ)
    force = load_at(time_s, loads)[:, :3] @ rotation.T
    seen = position + rotation @ [0, 0, 0.1] + COMPLIANCE * force + 1e-5 * chance.normal(size=(len(time_s), 3))
    tracker, controller = folder / "tracker.csv", folder / "controller.csv"
    np.savetxt(tracker, np.column_stack([time_s, seen * 1e3]), "%.5f", ",", header="t,X,Y,Z", comments="")
    joints = np.column_stack([time_s, np.tile(JOINTS_DEG, (len(time_s), 1))])
    np.savetxt(controller, joints, "%.5f", ",", header="t,A1,A2,A3,A4,A5,A6", comments="")
    return folder / "ft.csv"


def load_at(time_s: NDArray[np.float64], loads: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the load at each time: in turns of `TURN_S` it goes straight from one to the next and is held."""
    turn = (time_s / TURN_S).astype(int)
    share = np.minimum((time_s - turn * TURN_S) / RAMP_S, 1.0)[:, None]
    before, now = loads[(turn - 1) % N_LOADS], loads[turn % N_LOADS]
    return np.asarray(before + share * (now - before), dtype=np.float64)


def write_forces(path: Path, loads: NDArray[np.float64], size: int, rate_hz: int, chance: np.random.Generator) -> int:
    """Write the loads in turn, with sensor noise, four decimals; return the number of rows."""
    # The text of one turn is used again and again: writing numbers as text is slow, and no reader knows the difference.
    per_turn = int(TURN_S * rate_hz)
    turns = []
    for turn in range(N_LOADS):
        readings = load_at((np.arange(per_turn) + 0.5) / rate_hz + turn * TURN_S, loads)
        readings += chance.normal(size=(per_turn, 6)) * [0.5, 0.5, 0.5, 0.05, 0.05, 0.05]
        turns.append(["," + ",".join([f"{value:.4f}" for value in line]) + "\n" for line in readings.tolist()])
    row = 0
    with path.open("wb") as file:
        file.write((",".join(COLUMNS) + "\n").encode())
        while file.tell() < size:
            texts = turns[row // per_turn % N_LOADS]
            file.write("".join([f"{(row + k) / rate_hz:.4f}{text}" for k, text in enumerate(texts)]).encode())
            row += len(texts)
    return row


def run_peer(log: Path, folder: Path, own_encoding: bool) -> None:
    """Stream the log into Parquet with pyarrow alone."""
    import pyarrow as pa
    import pyarrow.csv as arrow_csv
    import pyarrow.parquet as parquet

    stream = arrow_csv.open_csv(
        log,
        read_options=arrow_csv.ReadOptions(use_threads=False),
        convert_options=arrow_csv.ConvertOptions(column_types=dict.fromkeys(COLUMNS, pa.float64())),
    )
    encoding = {"compression": "lz4", "use_dictionary": False, "use_byte_stream_split": True} if own_encoding else {}
    with parquet.ParquetWriter(folder / "peer.parquet", stream.schema, **encoding) as writer:
        for batch in stream:
            writer.write_batch(batch)


def run_reader_and_store(log: Path, folder: Path) -> None:
    """Stream the log into a store with reader, checks, hashing and provenance."""
    from stiffcal.documents import document_of
    from stiffcal.readers import WantedColumns, find_reader
    from stiffcal.store import Provenance, Store, hash_sources

    with Store(folder / "store").begin("benchmark") as writing, hash_sources(log.parent, [log.name]) as hashes:
        table = writing.stream("recordings/ft", COLUMNS)
        for batch in find_reader(log).read_batches(log, {}, WantedColumns(COLUMNS)):
            table.append({name: values * 1.0 for name, values in batch.numbers.items()})
        table.close()
        writing.write_document("provenance", document_of(Provenance.now("benchmark", hashes.result(), {})))
        writing.commit()


def run_ingest(log: Path, folder: Path) -> None:
    """Ingest the campaign that the log belongs to."""
    from stiffcal.commands.ingest import ingest_campaign

    result = ingest_campaign(log.parent, folder / "store")
    assert sum(run.n_states for run in result.runs) >= N_LOADS


RUNS = {
    "pyarrow": lambda log, folder: run_peer(log, folder, own_encoding=False),
    "pyarrow, our encoding": lambda log, folder: run_peer(log, folder, own_encoding=True),
    "reader and store": run_reader_and_store,
    "ingest": run_ingest,
}


def measured(name: str, log: Path) -> dict[str, float]:
    """Run one of `RUNS` in a process of its own; seconds and peak memory in MB."""
    command = [sys.executable, __file__, "--run", name, "--log", str(log)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return dict(json.loads(done.stdout.splitlines()[-1]))


def run_once(name: str, log: Path) -> None:
    """Run and print what it took, imports aside: they are measured by another benchmark."""
    import pyarrow.csv
    import pyarrow.parquet

    pyarrow.set_cpu_count(1)
    with tempfile.TemporaryDirectory(dir=log.parent.parent) as folder:
        began, processor = time.perf_counter(), time.process_time()
        RUNS[name](log, Path(folder))
        took = {"seconds": time.perf_counter() - began, "processor": time.process_time() - processor}
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (1024 if sys.platform != "darwin" else 1024**2)
    print(json.dumps({**took, "memory": peak}))


def main(gigabytes: float = 1.0, turns: int = 3, rate_hz: int = RATE_HZ) -> bool:
    """Make the campaigns, measure in turns, print; return whether the limits are met."""
    folder = Path(tempfile.mkdtemp(prefix="ingest-speed-"))
    try:
        return report(folder, int(gigabytes * 1e9), turns, rate_hz)
    finally:
        shutil.rmtree(folder)


def report(folder: Path, size: int, turns: int, rate_hz: int) -> bool:
    """Make the campaigns, measure in turns, print; return whether the limits are met."""
    log, double = (
        make_campaign(folder / name, bytes_of_log, rate_hz)
        for name, bytes_of_log in (("single", size), ("double", 2 * size))
    )
    print(f"a log of {log.stat().st_size / 1e9:.2f} GB, and one of twice the size; best of {turns} turns", flush=True)
    taken: dict[str, list[dict[str, float]]] = {name: [] for name in RUNS}
    for _ in range(turns):
        for name, results in taken.items():
            results.append(measured(name, log))
    best = {name: min(results, key=lambda result: result["seconds"]) for name, results in taken.items()}
    for name, result in best.items():
        line = f"{name:22s} {result['seconds']:7.2f} s, processor {result['processor']:7.2f} s"
        print(f"{line}, {size / 1e6 / result['seconds']:5.0f} MB/s, peak {result['memory']:5.0f} MB", flush=True)
    for name in ("reader and store", "ingest"):
        for peer in ("pyarrow", "pyarrow, our encoding"):
            print(f"speed of {name} over {peer}: {best[peer]['seconds'] / best[name]['seconds']:.2f}")
    ratio = best["pyarrow"]["seconds"] / best["ingest"]["seconds"]
    growth = measured("ingest", double)["memory"] / max(result["memory"] for result in taken["ingest"])
    good = ratio >= LEAST_RATIO and growth <= MOST_MEMORY_GROWTH
    print(f"ingest over pyarrow: {ratio:.2f} (at least {LEAST_RATIO})")
    print(f"peak memory of ingest at twice the size: {growth:.3f} times (at most {MOST_MEMORY_GROWTH})")
    print("met" if good else "NOT MET")
    return good


def run(arguments: Sequence[str] | None = None) -> int:
    """Run the comparison, or one of `RUNS` in a process that is measured."""
    options = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    options.add_argument("--gigabytes", type=float, default=1.0)
    options.add_argument("--turns", type=int, default=3)
    options.add_argument("--run", help=argparse.SUPPRESS)
    options.add_argument("--log", type=Path, help=argparse.SUPPRESS)
    chosen = options.parse_args(arguments)
    if chosen.run:
        run_once(chosen.run, chosen.log)
        return 0
    return 0 if main(chosen.gigabytes, chosen.turns) else 1


if __name__ == "__main__":
    sys.exit(run())
