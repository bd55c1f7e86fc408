"""`check` sees logs that nothing names, says whose export they are and proposes lines that the manifest takes."""

from __future__ import annotations

import shutil
import tomllib
from pathlib import Path

import h5py
import numpy as np
import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.campaign.manifest.manifest_type import source_type
from stiffcal.ingest.proposals import propose_sources
from stiffcal.readers import find_reader
from stiffcal.reduction.logs.log_rows import reader_options, wanted_columns
from tests.laboratory.small_campaign import CAMPAIGN, write_small_campaign

PROPERTIES = (
    *(("Name", "A{k}"), ("SymbolComment", ""), ("SampleTime[ms]", "2"), ("SymbolName", "MAIN.A{k}")),
    ("Unit", "deg (Degree)"),
)
SCOPE = "\n".join(
    (
        *("Name\tYT Scope", "Starttime of export\t134082189300000000\tSamstag, 21. November 2026", "", ""),
        *("\t".join(f"{word}\t{value.format(k=k)}" for k in range(1, 7)) for word, value in PROPERTIES),
        *("", "\t".join("0\t10,5" for _ in range(6)), "\t".join("2\t10,25" for _ in range(6)), ""),
    )
)
EXPORTS = {
    "ATI force-torque sensor, in quotation marks": (
        "raw/netft_java.csv",
        (
            '"Start Time:","Nov 21, 2026 8:15:30 AM"\n"RDT Sample Rate:","1000"\n"Counts per Unit Force:","1000000"\n\n'
            '"Status (hex)","RDT Sequence","F/T Sequence","Fx","Fy","Fz","Tx","Ty","Tz","Time"\n'
            '"0x00000000","1","7","0.5","1.5","-2.5","0.1","0.2","0.3","Nov 21, 2026 8:15:30 AM"\n'
            '"0x00000000","2","14","0.5","1.5","-2.5","0.1","0.2","0.3","Nov 21, 2026 8:15:30 AM"\n'
        ),
        {"wrench", "rate 1000"},
    ),
    "Beckhoff TwinCAT Scope, a time column per channel": ("raw/all.csv", SCOPE, {"joints", "column time A1"}),
    "Beckhoff TwinCAT Scope, one time column": (
        "raw/shared.csv",
        (
            "Name,Scope\n\nName,A1,A2,A3,A4,A5,A6\nSampleTime[ms],2,2,2,2,2,2\n\n"
            "0,10.5,20,30,40,50,60\n2,10.5,20,30,40,50,60\n"
        ),
        {"joints", "column time"},
    ),
    "Leica tracker, with dates": (
        "raw/pilot.txt",
        (
            "Leica AT960; Tracker Pilot\nTimestamp;X [mm];Y [mm];Z [mm]\n2026-11-21T08:15:30.000Z;1200,5;300,25;900,0\n"
            "2026-11-21T08:15:30.010Z;1200,5;300,25;900,0\n"
        ),
        {"pose", "column Timestamp"},
    ),
    "Leica tracker, with names of points": (
        "raw/sa.txt",
        "// SpatialAnalyzer, AT901\nCollection,Group,Point,X,Y,Z,Note\nA,Main,p1,1.5,2,3,x\nA,Main,p2,1.5,2,3,x\n",
        {"pose", "no time"},
    ),
    "Nikon tracker, an LED": (
        "raw/k610.txt",
        "Nikon Metrology K610\nZeit [s];LED1 X [mm];LED1 Y [mm];LED1 Z [mm]\n0,00;1,5;2,5;3,5\n0,01;1,5;2,5;3,5\n",
        {"pose", "column Zeit [s]"},
    ),
    "FARO tracker": (
        "raw/vantage.csv",
        "FARO Vantage E6, CAM2 Measure\nTime (s),X (mm),Y (mm),Z (mm)\n0.00,1.5,2.5,3.5\n0.01,1.5,2.5,3.5\n",
        {"pose", "column Time (s)"},
    ),
    "API tracker": (
        "raw/radian.txt",
        "API Radian Pro\nTime [s]\tX [mm]\tY [mm]\tZ [mm]\n0.00\t1.5\t2.5\t3.5\n0.01\t1.5\t2.5\t3.5\n",
        {"pose", "column Time [s]"},
    ),
    "KUKA controller trace, by variables": (
        "raw/trace.csv",
        (
            "KUKA Trace\nZeit [s];" + ";".join(f"$AXIS_ACT.A{k}" for k in range(1, 7)) + "\n"
            "0,000;10,5;-90,0;95,0;0,0;12,0;100,0\n0,012;10,5;-90,0;95,0;0,0;12,0;100,0\n"
        ),
        {"joints", "column Zeit [s]"},
    ),
    "ATI force-torque sensor": (
        "raw/netft.csv",
        (
            "Start Time:,11/21/2026 08:15\nRDT Sample Rate:,7000\nForce Units:,N\nCounts per Unit Force:,1000000\n"
            "RDT Sequence,F/T Sequence,Fx,Fy,Fz,Tx,Ty,Tz\n1,10,0.5,1.5,-2.5,0.01,0.02,0.03\n"
            "2,11,0.5,1.5,-2.5,0.01,0.02,0.03\n"
        ),
        {"wrench", "rate 7000"},
    ),
    "Beckhoff TwinCAT Scope": (
        "raw/scope.csv",
        (
            "Name;Scope Project\nStarttime of export;132\nSampleTime[ms];2\n"
            "Time [ms];A1 [deg];A2 [deg];A3 [deg];A4 [deg];A5 [deg];A6 [deg]\n"
            "0,0;10,5;20,25;30,0;40,0;50,0;60,0\n2,0;10,5;20,25;30,0;40,0;50,0;60,0\n"
        ),
        {"joints", "column Time [ms]"},
    ),
    "Leica tracker": (
        "raw/at960.txt",
        (
            "Leica AT960 - Tracker Pilot\nTime [s]\tX [mm]\tY [mm]\tZ [mm]\tq0\tqx\tqy\tqz\n"
            "0.0\t1200.5\t300.25\t900.0\t1.0\t0.0\t0.0\t0.0\n0.1\t1200.5\t300.25\t900.0\t1.0\t0.0\t0.0\t0.0\n"
        ),
        {"pose", "column Time [s]"},
    ),
    "Nikon tracker": (
        "raw/k600.txt",
        "Nikon Metrology K-Series\nSampling frequency: 100 Hz\nX;Y;Z\n1200,5;300,25;900,0\n1200,6;300,25;900,0\n",
        {"pose", "rate 100"},
    ),
    "KUKA controller trace": (
        "raw/KRC4_trace.csv",
        "Zeit,A1,A2,A3,A4,A5,A6\n0.000,10.0,-90.0,95.0,0.0,12.0,100.0\n0.012,10.0,-90.0,95.0,0.0,12.0,100.0\n",
        {"joints", "column Zeit"},
    ),
}


@pytest.fixture(scope="module")
def empty(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_small_campaign(tmp_path_factory.mktemp("proposals") / "small", poses=1)


def _pasted(folder: Path, lines: list[str], name: str, file: str) -> Path:
    """Return a campaign next to `folder` whose manifest has the proposed lines and a run."""
    pasted = folder.parent / "pasted"
    shutil.copytree(folder, pasted, dirs_exist_ok=True)
    run = f'[[runs]]\nid = "r"\nfiles = {{ {name} = "{file}" }}\n'
    run += "" if any(line.startswith("joints") for line in lines) else "joints_deg = [0, 0, 0, 0, 0, 0]\n"
    text = CAMPAIGN[: CAMPAIGN.index("[sources.table]")] + "\n".join([*lines, run])
    (pasted / "campaign.toml").write_text(text, encoding="utf-8")
    return pasted


@pytest.mark.parametrize("device", EXPORTS)
def test_the_usual_exports_are_recognised_and_readable(empty: Path, device: str) -> None:
    file, text, expected = EXPORTS[device]
    path = empty / file
    path.write_text(text, encoding="utf-8")
    try:
        (proposal,) = propose_sources(load_campaign(empty))
        assert proposal.device == device.split(",")[0]
        assert proposal.files == [file]
        said = tomllib.loads("\n".join(proposal.lines))
        ((name, table),) = said["sources"].items()
        if "no time" in expected:  # nothing in the log states a rate: it is left to be written
            assert table["time"] == {}
            table["time"] = {"rate_hz": 1.0}
        lines = [line.replace("time = {}", "time = { rate_hz = 1.0 }") for line in proposal.lines]
        load_campaign(_pasted(empty, lines, name, file))  # every frame it names is there
        assert f'# in its run: files = {{ {name} = "{file}" }}' in proposal.lines
        source = source_type().model_validate(table)
        assert set(source.signals()) == {word for word in expected if " " not in word}
        assert source.time is not None
        reported = f"rate {source.time.rate_hz:g}" if source.time.rate_hz else f"column {source.time.column}"
        assert reported in expected or "no time" in expected
        # what is proposed is what the reader takes
        wanted = wanted_columns(source, None)
        (batch,) = find_reader(path).read_batches(path, reader_options(source, "csv"), wanted)
        assert len(batch) == 2
    finally:
        path.unlink()


def test_other_formats_and_many_files_are_one_proposal(empty: Path) -> None:
    paths = [empty / "raw" / f"run{k}.h5" for k in range(5)]
    for path in paths:
        with h5py.File(path, "w") as file:
            for name in ("t", "Fx", "Fy", "Fz"):
                file[name] = np.arange(3.0)
    (empty / "raw" / "notes.csv").write_text("nothing, of, use\n", encoding="utf-8")
    try:
        notes, proposal = sorted(propose_sources(load_campaign(empty)), key=lambda entry: len(entry.files))
        assert (notes.files, notes.understood) == (["raw/notes.csv"], False)  # each file that nothing reads is named
        assert len(proposal.files) == 5
        assert proposal.device == ""
        assert proposal.lines[:2] == ["[sources.ft]", 'format = "hdf5"']
        assert proposal.lines[-1] == "# … and 2 more files of this kind"
    finally:
        for path in [*paths, empty / "raw" / "notes.csv"]:
            path.unlink()


def test_forces_are_proposed_in_the_axes_of_the_campaign_s_sensor(tmp_path: Path) -> None:
    folder = write_small_campaign(tmp_path / "small", poses=1)
    (folder / "raw" / "force.csv").write_text("t [s],Fx [N],Fy [N],Fz [N]\n0.0,1.5,2.0,3.0\n0.1,1.5,2.0,3.1\n")
    axes = []
    for frame in ("", '[frames.ft_sensor]\nparent = "flange"\nxyz_m = [0, 0, 0.1]\n'):
        (folder / "campaign.toml").write_text(CAMPAIGN + frame, encoding="utf-8")
        (proposal,) = propose_sources(load_campaign(folder))
        (source,) = tomllib.loads("\n".join(proposal.lines))["sources"].values()
        axes.append(source["wrench"]["axes"])
    assert axes == ["base", "ft_sensor"]


def test_what_is_named_is_not_proposed(empty: Path) -> None:
    assert propose_sources(load_campaign(empty)) == []


def test_an_export_that_cannot_be_read_says_what_helps(empty: Path) -> None:
    path = empty / "raw" / "each.csv"
    head = "Name\tScope\nStarttime of export\t1\n\nName\tF\tName\tF\nSampleTime[ms]\t1\tSampleTime[ms]\t1\n"
    path.write_text(head + "0\t1.5\t0\t2.5\n1\t1.5\t1\t2.5\n", encoding="utf-8")
    try:
        (proposal,) = propose_sources(load_campaign(empty))
        assert proposal.device == "Beckhoff TwinCAT Scope"
        (line,) = proposal.lines
        assert line.startswith("# two columns have the name")
    finally:
        path.unlink()
