"""One logged campaign, written in every format that is read: the same numbers, three devices, a log per run."""

from __future__ import annotations

import csv
import gzip
import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from stiffcal.mechanics.rotations import rotation_from_vector
from stiffcal.quaternions import quaternion_from_rotation
from stiffcal.readers.ods import write_ods
from tests.laboratory.bags import joint_state, pose, wrench, write_bag
from tests.laboratory.database import VARIABLE, Database
from tests.laboratory.small_campaign import CAMPAIGN, write_small_campaign
from tests.laboratory.workbooks import write_xlsx

Columns = dict[str, NDArray[np.float64]]
START_NS = 1_795_248_930_000_000_000
STEP_NS = 10_000_000
HELD = 6  # samples of one load state
DEVICES = {"controller": "/joint_states", "ft": "/ft", "tracker": "/tool"}
FORMATS = (
    *("csv", "csv.gz", "csv.bz2", "csv.xz", "csv.zst", "hdf5", "parquet"),
    *("xlsx", "ods", "npz", "jsonl", "rsi"),
    *("tdms", "mat", "mat73", "mcap", "rosbag1", "rosbag2", "postgres"),
)
# each reading an attribute of an element of one letter
RSI = {
    name: f"R.{name}"
    for name in ("t", *(f"A{k}" for k in range(1, 7)), *("Fx", "Fy", "Fz"), *"XYZ", *(f"q{c}" for c in "wxyz"))
}
BAGS = {"mcap": ".mcap", "rosbag1": ".bag", "rosbag2": ""}
FIELDS = {
    "t": "header.stamp",
    **{f"A{k}": f"position.A{k}" for k in range(1, 7)},
    **{f"F{axis}": f"wrench.force.{axis}" for axis in "xyz"},
    **{axis.upper(): f"pose.position.{axis}" for axis in "xyz"},
    **{f"q{axis}": f"pose.orientation.{axis}" for axis in "wxyz"},
}


def write_campaign(folder: Path, log_format: str, database: Database | None = None) -> Path:
    """Write the campaign with all its logs in `log_format`, one of `FORMATS`."""
    write_small_campaign(folder, poses=3)
    table = list(csv.DictReader((folder / "raw" / "states.csv").read_text(encoding="utf-8").splitlines()))
    (folder / "raw" / "states.csv").unlink()
    runs = list(dict.fromkeys(row["run"] for row in table))
    entries = []
    for run in runs:
        states = {
            name: np.array([float(row[name]) for row in table if row["run"] == run])
            for name in table[0]
            if name != "run"
        }
        files = _write_run(folder, run, _logs(states), log_format, database)
        _write_holds(folder / "raw" / f"{run}_states.csv", len(states["Fx"]))
        named = ", ".join(f"{device} = {file!r}" for device, file in files.items())
        clocks = "clock_ahead_s = { ft = 0.0, tracker = 0.0 }"
        entries.append(f'[[runs]]\nid = "{run}"\nfiles = {{ {named} }}\n{clocks}\nstates = "raw/{run}_states.csv"\n')
    text = CAMPAIGN[: CAMPAIGN.index("[sources.table]")] + _sources(log_format) + "\n".join(entries)
    (folder / "campaign.toml").write_text(text, encoding="utf-8")
    return folder


def _logs(states: Columns) -> dict[str, Columns]:
    """Return the logs of each device: every load state held for some samples."""
    held = {name: np.repeat(values, HELD) for name, values in states.items()}
    t = (START_NS + STEP_NS * np.arange(len(held["Fx"]))) * 1e-9
    turned = quaternion_from_rotation(rotation_from_vector(np.stack([held.pop(f"r{axis}") for axis in "xyz"], axis=-1)))
    quaternion = {f"q{axis}": turned[:, k] for k, axis in enumerate("wxyz")}
    return {
        "controller": {"t": t, **{f"A{k}": np.radians(held[f"A{k}"]) for k in range(1, 7)}},
        "ft": {"t": t, **{name: held[name] for name in ("Fx", "Fy", "Fz")}},
        "tracker": {"t": t, **{name: 1e-3 * held[name] for name in "XYZ"}, **quaternion},
    }


def _write_holds(path: Path, count: int) -> None:
    starts = (START_NS + STEP_NS * HELD * np.arange(count)) * 1e-9
    lines = [f"{start - 0.002!r},{start + 1e-9 * STEP_NS * (HELD - 1) + 0.002!r}" for start in starts.tolist()]
    path.write_text("\n".join(["start,end", *lines]) + "\n", encoding="utf-8")


def _sources(log_format: str) -> str:
    ros = log_format in BAGS
    name = FIELDS.__getitem__ if ros else RSI.__getitem__ if log_format == "rsi" else str
    said = log_format.split(".")[0].replace("mat73", "mat")

    def source(device: str, *signals: str) -> str:
        options = f'{said} = {{ topic = "{DEVICES[device]}" }}\n' if ros else ""
        options += f'postgres = {{ uri_env = "{VARIABLE}" }}\n' if said == "postgres" else ""
        time = f'time = {{ column = "{name("t")}", unit = "s" }}'
        return (
            f'[sources.{device}]\nformat = "{said}"\nsampling = "time"\n{options}{time}\n' + "\n".join(signals) + "\n\n"
        )

    def listed(*columns: str) -> str:
        return str([name(column) for column in columns]).replace("'", '"')

    joints = f"joints = {{ position = {listed(*(f'A{k}' for k in range(1, 7)))} }}"
    force = f'wrench = {{ columns = {listed("Fx", "Fy", "Fz")}, axes = "base", point = "load_point", tared = "no" }}'
    place = f"position = {listed('X', 'Y', 'Z')}, quaternion_wxyz = {listed('qw', 'qx', 'qy', 'qz')}"
    moved = f'pose = {{ frame = "base", body = "target", {place}, units = {{ position = "m" }} }}'
    return source("controller", joints) + source("ft", force) + source("tracker", moved)


def _write_run(
    folder: Path, run: str, logs: dict[str, Columns], log_format: str, database: Database | None
) -> dict[str, str]:
    if log_format in BAGS:
        file = f"raw/{run}{BAGS[log_format]}"
        write_bag(folder / file, _messages(logs))
        return dict.fromkeys(DEVICES, file)
    if log_format == "postgres":
        assert database is not None
        return {device: _fill(database, run, device, columns) for device, columns in logs.items()}
    ending = {"hdf5": "h5", "mat73": "mat", "rsi": "xml"}.get(log_format, log_format)
    files = {device: f"raw/{run}_{device}.{ending}" for device in logs}
    for device, columns in logs.items():
        WRITERS[log_format](folder / files[device], columns)
    return files


def _text(columns: Columns) -> bytes:
    rows = zip(*(values.tolist() for values in columns.values()), strict=True)
    return "\n".join([",".join(columns), *(",".join(map(repr, row)) for row in rows), ""]).encode()


def _write_csv(path: Path, columns: Columns) -> None:
    import bz2
    import lzma

    pack: dict[str, Callable[[bytes], Any]] = {
        ".gz": gzip.compress,
        ".bz2": bz2.compress,
        ".xz": lzma.compress,
        ".zst": lambda text: pa.compress(text, codec="zstd", asbytes=True),
    }
    path.write_bytes(pack.get(path.suffix, bytes)(_text(columns)))


def _write_hdf5(path: Path, columns: Columns) -> None:
    import h5py

    with h5py.File(path, "w") as file:
        for name, values in columns.items():
            file[name] = values


def _write_parquet(path: Path, columns: Columns) -> None:
    import pyarrow.parquet as parquet

    parquet.write_table(pa.table({name: pa.array(values.tolist()) for name, values in columns.items()}), path)


def _write_tdms(path: Path, columns: Columns) -> None:
    from nptdms import ChannelObject, TdmsWriter

    with TdmsWriter(path) as writer:
        writer.write_segment([ChannelObject("log", name, values) for name, values in columns.items()])


def _write_mat(path: Path, columns: Columns) -> None:
    from scipy.io import savemat

    savemat(path, {"log": columns}, oned_as="column")


def _write_mat73(path: Path, columns: Columns) -> None:
    import h5py

    with h5py.File(path, "w") as file:
        file.create_group("log").attrs["MATLAB_class"] = np.bytes_("struct")
        for name, values in columns.items():
            file["log"].create_dataset(name, data=values[None, :]).attrs["MATLAB_class"] = np.bytes_("double")


def _write_xlsx(path: Path, columns: Columns) -> None:
    write_xlsx(path, {"log": [list(columns), *zip(*(values.tolist() for values in columns.values()), strict=True)]})


def _write_ods(path: Path, columns: Columns) -> None:
    rows: list[list[str | float]] = [list(columns)]
    write_ods(path, [*rows, *map(list, zip(*(values.tolist() for values in columns.values()), strict=True))])


def _write_npz(path: Path, columns: Columns) -> None:
    with path.open("wb") as file:
        np.savez(file, **columns)  # type: ignore[arg-type]


def _rows(columns: Columns) -> Iterator[dict[str, float]]:
    for row in zip(*(values.tolist() for values in columns.values()), strict=True):
        yield dict(zip(columns, row, strict=True))


def _write_jsonl(path: Path, columns: Columns) -> None:
    path.write_text("".join(json.dumps(row) + "\n" for row in _rows(columns)), encoding="utf-8")


def _write_rsi(path: Path, columns: Columns) -> None:
    lines = (" ".join(f'{name}="{value!r}"' for name, value in row.items()) for row in _rows(columns))
    path.write_text("".join(f'<Rob TYPE="KUKA"><R {line}/></Rob>\n' for line in lines), encoding="utf-8")


WRITERS: dict[str, Callable[[Path, Columns], None]] = {
    **dict.fromkeys(("csv", "csv.gz", "csv.bz2", "csv.xz", "csv.zst"), _write_csv),
    "xlsx": _write_xlsx,
    "ods": _write_ods,
    "npz": _write_npz,
    "jsonl": _write_jsonl,
    "rsi": _write_rsi,
    "hdf5": _write_hdf5,
    "parquet": _write_parquet,
    "tdms": _write_tdms,
    "mat": _write_mat,
    "mat73": _write_mat73,
}


def _messages(logs: dict[str, Columns]) -> dict[str, list[tuple[int, Any]]]:
    joints, force, place = logs["controller"], logs["ft"], logs["tracker"]
    moments = [START_NS + STEP_NS * k for k in range(len(force["t"]))]
    names = [f"A{k}" for k in range(1, 7)]
    angles = np.stack([joints[name] for name in names], axis=-1)
    loads = np.stack([*(force[name] for name in ("Fx", "Fy", "Fz")), *(np.zeros(len(moments)),) * 3], axis=-1)
    at = np.stack([place[name] for name in "XYZ"], axis=-1)
    turned = np.stack([place[f"q{axis}"] for axis in "wxyz"], axis=-1)
    return {
        "/joint_states": [(moment, joint_state(moment, names, angles[k])) for k, moment in enumerate(moments)],
        "/ft": [(moment, wrench(moment, loads[k])) for k, moment in enumerate(moments)],
        "/tool": [(moment, pose(moment, at[k], turned[k])) for k, moment in enumerate(moments)],
    }


def _fill(database: Database, run: str, device: str, columns: Columns) -> str:
    """Put a log into the device's table, partitioned by run as a lab's would be; return the query of this run."""
    fields = ", ".join(f'"{name}" double precision' for name in columns)
    rows = ", ".join(
        f"('{run}', {', '.join(map(repr, row))})"
        for row in zip(*(values.tolist() for values in columns.values()), strict=True)
    )
    database.run(
        f"create table if not exists {device} (run text, {fields}) partition by list (run);\n"
        f"drop table if exists {device}_{run};\n"
        f"create table {device}_{run} partition of {device} for values in ('{run}');\n"
        f"insert into {device} values {rows};\n"
    )
    return f"select * from {device} where run = '{run}' order by t"
