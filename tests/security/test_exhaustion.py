"""A few kilobytes of settings do not make stiffcal work for hours or fill the memory.

Each of these folders kept the command busy for more than two minutes, or until the memory was full.
"""

from __future__ import annotations

import os
import shutil
import time
import tomllib
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from stiffcal.campaign.loading import load_campaign, load_manifest
from stiffcal.campaign.signals.row_filter import parse_rows
from stiffcal.campaign.toml.typed import WrongValueError, expand_columns
from stiffcal.commands.plan import plan_campaign
from stiffcal.compensation.load_table import read_load_table
from stiffcal.errors import InputError
from stiffcal.ingest.proposals import propose_sources
from stiffcal.model.assembled.assembly import compliant_robot
from stiffcal.model.catalogue.catalogue import built_in_effects
from stiffcal.processes import ChildEndedError, ChildProcess
from stiffcal.propose.table_sniffing import sniff_table
from stiffcal.simulation.extent import check_extent
from stiffcal.simulation.settings import parse_settings
from tests.laboratory import children

CAMPAIGNS = Path(__file__).parents[2] / "campaigns"
SECONDS = 10.0
"""Of processor time; loading such a campaign without what is added takes 0.1."""


@pytest.fixture
def campaign(tmp_path: Path) -> Path:
    folder = tmp_path / "campaign"
    shutil.copytree(CAMPAIGNS / "hidden" / "01", folder)
    return folder


def add(folder: Path, file: str, text: str) -> None:
    with (folder / file).open("a", encoding="utf-8") as stream:
        stream.write("\n" + text)


def refused(folder: Path) -> str:
    """Load a campaign that is refused; return the first line."""
    began = time.process_time()
    with pytest.raises(InputError) as caught:
        load_campaign(folder)
    assert time.process_time() - began < SECONDS
    return str(caught.value).splitlines()[0]


def test_a_hundred_thousand_columns_of_one_signal(campaign: Path) -> None:
    columns = ", ".join(f'"c{number}"' for number in range(100_000))
    add(campaign, "campaign.toml", f'[sources.x]\nfile = "raw/states.csv"\ntemperature = {{ columns = [{columns}] }}')
    assert "sources.x.temperature.columns: more than 1000 entries" in refused(campaign)


def test_a_long_chain_of_frames_is_checked_in_a_moment(campaign: Path) -> None:
    parents = ["base", *(f"f{number}" for number in range(900))]
    add(campaign, "campaign.toml", "".join(f'[frames.f{n}]\nparent = "{p}"\n' for n, p in enumerate(parents[:-1])))
    began = time.process_time()
    load_campaign(campaign)
    assert time.process_time() - began < SECONDS


def test_frames_that_go_round_in_a_circle_are_named_once(campaign: Path) -> None:
    add(campaign, "campaign.toml", '[frames.x]\nparent = "y"\n[frames.y]\nparent = "z"\n[frames.z]\nparent = "y"\n')
    with pytest.raises(InputError) as caught:
        load_campaign(campaign)
    assert [fault.reason for fault in caught.value.faults] == ["the parents form a loop: y → z → y"]


def test_excludes_that_name_rows_by_the_million(campaign: Path) -> None:
    entry = '[[exclude]]\nsource = "table"\nrows = ["1-900000"]\nwhy = "x"\n'
    add(campaign, "campaign.toml", 500 * entry)
    assert "more than 1000000 rows are left out" in refused(campaign)


def test_five_thousand_runs_that_name_the_same_log(campaign: Path) -> None:
    source = '[sources.x]\nsampling = "states"\ntemperature = { columns = ["T"] }\n'
    runs = "".join(f'[[runs]]\nid = "r{n}"\nfiles = {{ x = "raw/states.csv" }}\n' for n in range(5_000))
    add(campaign, "campaign.toml", source + runs)
    assert refused(campaign).startswith("campaign.toml: ")


def test_an_effect_that_stands_in_the_model_a_thousand_times(campaign: Path) -> None:
    entry = '[[effects]]\ntype = "joint-compliance"\njoints = [1, 1, 1, 1, 1, 1]\n'
    (campaign / "model.toml").write_text('schema = "stiffcal/model/1"\n' + 999 * entry)
    loaded = load_campaign(campaign)
    with pytest.raises(InputError) as caught:
        compliant_robot(loaded.chain, loaded.model, built_in_effects())
    assert [fault.reason for fault in caught.value.faults] == ["is given twice at j1"]


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ("[[joints]]", f"[[joints]]\ngear_orders = [{'1, ' * 900}1]", "found 901 entries, more than 100"),
        ('name = "', f'logged = {{ {", ".join(f"J{n} = 1" for n in range(2000))} }}\nname = "', "more than 1000"),
    ],
)
def test_lists_of_a_robot_that_no_robot_needs(campaign: Path, old: str, new: str, reason: str) -> None:
    path = campaign / "robot.toml"
    head, mark, rest = path.read_text().partition("[[joints]]")
    path.write_text(head + (mark + rest).replace(old, new, 1))
    assert reason in refused(campaign)


def test_a_robot_of_a_thousand_joints(campaign: Path) -> None:
    path = campaign / "robot.toml"
    joint = '[[joints]]\nname = "x{}"\na_m = 0.1\nalpha_deg = 0.0\nd_m = 0.1\ntheta_deg = 0.0\n\n'
    head, mark, rest = path.read_text().partition("[[joints]]")
    path.write_text(head + "".join(joint.format(number) for number in range(900)) + mark + rest)
    assert "more than 100" in refused(campaign)


@pytest.mark.parametrize(
    ("table", "change", "limit"),
    [
        ("sensors", {"force": {"rate_hz": 1e12}}, "STIFFCAL_MAX_SAMPLES"),
        ("loads", {"cycles": 1_000_000}, "STIFFCAL_MAX_BALANCES"),
        ("loads", {"waves": 100_000_000, "waviness": 1e-10}, "STIFFCAL_MAX_BALANCES"),
        ("loads", {"hold_s": 1e9}, "STIFFCAL_MAX_SAMPLES"),
    ],
)
def test_a_simulation_that_would_not_end(table: str, change: dict[str, Any], limit: str) -> None:
    folder = CAMPAIGNS / "irb4400"
    document = tomllib.loads((folder / "simulate.toml").read_text("utf-8"))
    settings = parse_settings({**document, table: {**document[table], **change}})
    with pytest.raises(InputError, match=limit):
        check_extent(settings, load_manifest(folder))


@pytest.mark.parametrize("kind", ["load", "clamped"])
def test_a_plan_that_chooses_from_too_much(kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """20 000 candidates with 20 directions of 1000 steps took 18 GiB; here the limit is lower instead."""
    monkeypatch.setenv("STIFFCAL_MAX_PLANNED", "2000")
    for name in ("campaign.toml", "robot.toml", "model.toml"):
        shutil.copy(CAMPAIGNS / "irb4400" / name, tmp_path / name)
    head = f'schema = "stiffcal/plan-input/1"\ncandidates = 20\nexperiment = "{kind}"\n'
    steps = "[load]\nforce_N = 100\ncycles = 20\nsteps = [0.5, 1.0]\n"
    (tmp_path / "plan.toml").write_text(head + steps + "[noise]\nmotor_angle_rad = 1e-5\nforce_N = 1\nmoment_Nm = 1\n")
    with pytest.raises(InputError, match=r"^plan.toml: candidates: more than 2000 load states.*fewer candidates"):
        plan_campaign(tmp_path)


def columns_of(text: str) -> object:
    return expand_columns(text)


@pytest.mark.parametrize(
    ("read", "text"),
    [
        (parse_rows, "a" + 100_000 * " " + "b"),
        (columns_of, 20_000 * "1" + ".." + 20_000 * "1" + "x"),
        (columns_of, "A1..A" + 5000 * "9"),
    ],
)
def test_texts_of_a_manifest_that_nearly_match(read: Callable[[str], object], text: str) -> None:
    began = time.process_time()
    with pytest.raises(WrongValueError, match="is not a"):
        read(text)
    assert time.process_time() - began < SECONDS


@pytest.mark.parametrize("name", ["a" + 50_000 * " " + "b", 40_000 * "[ ", 40_000 * "( "])
def test_a_long_name_of_a_column(tmp_path: Path, name: str) -> None:
    path = tmp_path / "table.csv"
    path.write_text(f"{name},A1,Fx\n" + 20 * "1,2,3\n")
    began = time.process_time()
    assert [column.header for column in sniff_table(path).columns[1:]] == ["A1", "Fx"]
    read_load_table(path, ("A1",), joints_needed=True)
    assert time.process_time() - began < SECONDS


@pytest.mark.parametrize("words", [3000 * "sampl", 1900 * "frequenc", "sample time" + 16_000 * " "])
def test_first_lines_of_a_log_that_nearly_state_a_rate(campaign: Path, words: str) -> None:
    (campaign / "raw" / "unnamed.csv").write_text(f"{words}\nFx,Fy,Fz\n" + 30 * "1,2,3\n")
    began = time.process_time()
    (proposal,) = propose_sources(load_campaign(campaign))
    assert any(line.startswith("wrench = ") for line in proposal.lines)
    assert time.process_time() - began < SECONDS


@pytest.mark.skipif(os.name == "nt", reason="signals end a process otherwise there")
def test_a_process_that_has_written_without_end_is_reported_by_its_last_words() -> None:
    """All that was written was read into memory: here 64 MB, of which the end is shown."""
    tracemalloc.start()
    child = ChildProcess(children.write_much_and_end)
    try:
        with pytest.raises(ChildEndedError, match="^its process was ended by signal 9: no memory is left$"):
            child.receive(SECONDS * 60)
        assert tracemalloc.get_traced_memory()[1] < 1 << 21
    finally:
        tracemalloc.stop()
        child.stop()
