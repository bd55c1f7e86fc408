"""Names that are used and hold what nobody can see are refused in one line; what is only shown or not used is not."""

from __future__ import annotations

import gzip
import json
import unicodedata
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest

from stiffcal.campaign.loading import load_campaign, load_robot
from stiffcal.campaign.robot.urdf.chain import read_urdf
from stiffcal.campaign.toml.toml_reading import read_toml
from stiffcal.cli.app import main
from stiffcal.errors import InputError
from stiffcal.escapes import escape_invisible
from stiffcal.reduction.states.raw_states import RawStates
from stiffcal.reduction.states.tabled_states import tabled_states
from tests.laboratory import hostile_names
from tests.laboratory.campaign_folders import MANIFEST, ROBOT, write_campaign
from tests.laboratory.named_campaign import quoted, write_named_campaign

IN_TOML = {
    kind: name for kind, name in hostile_names.REFUSED.items() if not any(0xD800 <= ord(c) < 0xE000 for c in name)
}
"""TOML has no lone surrogates."""

NAMED: dict[str, Callable[[str], str]] = {
    "name": lambda name: MANIFEST.replace("robot =", f"name = {name}\nrobot ="),
    "sources.": lambda name: MANIFEST.replace("[sources.table]", f"[sources.{name}]"),
    "sources.table.file": lambda name: MANIFEST.replace('"raw/table.csv"', name),
    "sources.table.wrench.columns[1]": lambda name: MANIFEST.replace('"Fx"', name),
    "frames.": lambda name: MANIFEST.replace("[frames.tool]", f"[frames.{name}]").replace('"tool"', name),
    "sources.table.deflection.body": lambda name: MANIFEST.replace('body = "tool"', f"body = {name}"),
    "runs[1]": lambda name: MANIFEST + f"[[runs]]\nid = {name}\n",
    "ids.": lambda name: MANIFEST + f"[ids.{name}]\nlink = 'swing'\nstart_m = [0, 0, 0]\nend_m = [1, 0, 0]\n",
}
"""Where a name stands in the manifest, and the manifest with another one there."""


def states_of(folder: Path) -> RawStates:
    """Return the rows of a campaign's table of states."""
    campaign = load_campaign(folder)
    found = tabled_states(folder, campaign.manifest, campaign.chain)
    assert found is not None
    return found


def the_fault_of(call: Callable[[], object]) -> str:
    """Return the line about a name, else the first one, of what a call refuses."""
    with pytest.raises(InputError) as refused:
        call()
    lines = str(refused.value).splitlines()
    assert all(line == escape_invisible(line) for line in lines)
    return next((line for line in lines if "contains U+" in line), lines[0])


@pytest.mark.parametrize("place", sorted(NAMED))
@pytest.mark.parametrize("kind", sorted(IN_TOML))
def test_a_name_in_the_manifest(tmp_path: Path, place: str, kind: str) -> None:
    name = IN_TOML[kind]
    manifest = NAMED[place](quoted(name))
    line = the_fault_of(lambda: load_campaign(write_campaign(tmp_path / "c", manifest)))
    assert line.startswith(f"campaign.toml: {place}")
    assert "contains U+" in line


def test_the_character_and_what_to_do_are_named(tmp_path: Path) -> None:
    manifest = MANIFEST + '[[runs]]\nid = "gpj\\u202eexe"\n'
    line = the_fault_of(lambda: load_campaign(write_campaign(tmp_path / "c", manifest)))
    assert line == (
        r'campaign.toml: runs[1] (gpj\u202eexe).id: the name "gpj\u202eexe" contains U+202E, '
        "which changes the writing direction; remove it, in the logs too [name-invalid]"
    )


def test_letters_of_windows_read_as_latin_1(tmp_path: Path) -> None:
    line = the_fault_of(lambda: load_campaign(write_campaign(tmp_path / "c", MANIFEST.replace('"Fx"', '"F\x80"'))))
    assert 'encoding = "cp1252"' in line


def test_a_robot_and_its_joints_and_links(tmp_path: Path) -> None:
    changes = {
        '"A1"': '"A\\u009b1"',
        "convention": 'name = "x\\u2028"\nconvention',
        '"A2"': '"A2"\nlink = { name = "\\u001b[0m" }',
    }
    for number, (old, new) in enumerate(changes.items()):
        robot = write_campaign(tmp_path / str(number), robot=ROBOT.replace(old, new, 1)) / "robot.toml"
        assert "contains U+" in the_fault_of(partial(load_robot, robot))


def test_a_urdf(tmp_path: Path) -> None:
    text = """<robot name="r"><link name="base"/><link name="l{}"/><joint name="j{}" type="revolute">
    <parent link="base"/><child link="l{}"/><axis xyz="0 0 1"/></joint><link name="unused{}"/></robot>"""
    file = tmp_path / "r.urdf"
    for link, joint, tip in (("&#x202e;", "", "l\u202e"), ("", "&#x202e;", "l")):
        file.write_text(text.format(link, joint, link, ""), encoding="utf-8")
        assert "contains U+202E" in the_fault_of(partial(read_urdf, file, "r.urdf", "base", tip))
    file.write_text(text.format("", "", "", "&#x202e;"), encoding="utf-8")
    assert read_urdf(file, "r.urdf", "base", "l").path[0].name == "j"


def test_free_text_and_queries_may_hold_anything(tmp_path: Path) -> None:
    free = 'a = [{ why = "slipped\\n\\u202e\\u001b[31m" }]\nfile = """select *\n\tfrom ft"""\n'
    (tmp_path / "c.toml").write_text(free + 'csv = { delimiter = "\t" }\n', encoding="utf-8")
    assert read_toml(tmp_path / "c.toml", "c.toml")["csv"] == {"delimiter": "\t"}


def test_empty_names(tmp_path: Path) -> None:
    manifests = [MANIFEST.replace("[sources.table]", '[sources.""]'), MANIFEST + '[[runs]]\nid = " "\n']
    for number, manifest in enumerate(manifests):
        folder = write_campaign(tmp_path / str(number), manifest)
        assert "the name is empty" in the_fault_of(partial(load_campaign, folder))


def test_many_odd_names_are_few_lines(tmp_path: Path) -> None:
    (tmp_path / "c.toml").write_text("".join(f'"a\\u001b{k}" = 1\n' for k in range(900)), encoding="utf-8")
    with pytest.raises(InputError) as refused:
        read_toml(tmp_path / "c.toml", "c.toml")
    assert len(refused.value.faults) == 20


@pytest.mark.parametrize("odd", ["pose\x1b[31m", "pose\u202e", "po\x85se", "po\u2028se", "\u2066pose"])
def test_a_run_named_in_a_log(tmp_path: Path, odd: str) -> None:
    folder = write_named_campaign(tmp_path / "c", runs=("pose1", odd))
    line = the_fault_of(lambda: states_of(folder))
    assert line.startswith("raw/states.csv: data row 26, column run: ")


def test_odd_columns_that_are_not_used_are_ignored(tmp_path: Path) -> None:
    folder = write_named_campaign(tmp_path / "c", runs=("pose1", "pose2"))
    table = folder / "raw" / "states.csv"
    first, *rows = table.read_text(encoding="utf-8").splitlines()
    odd = "a\x1b[31m\u202e\x85\u2028\x80"
    table.write_text("\n".join([f"{first},{odd}", *(f"{row},1" for row in rows)]) + "\n", encoding="utf-8")
    assert len(states_of(folder).run) == 50


def test_a_column_of_windows_that_latin_1_spoils(tmp_path: Path) -> None:
    folder = write_named_campaign(tmp_path / "c", runs=("pose1", "pose2"), named={"Fx": "F€"})
    table, manifest = folder / "raw" / "states.csv", folder / "campaign.toml"
    table.write_bytes(table.read_text(encoding="utf-8").encode("cp1252"))
    text = manifest.read_text(encoding="utf-8")
    manifest.write_text(text.replace("sampling =", 'csv = { encoding = "latin-1" }\nsampling =', 1), encoding="utf-8")
    line = the_fault_of(lambda: states_of(folder))
    assert 'set csv = { encoding = "cp1252" }' in line
    manifest.write_text(text.replace("sampling =", 'csv = { encoding = "cp1252" }\nsampling =', 1), encoding="utf-8")
    assert len(states_of(folder).run) == 50


@pytest.mark.parametrize(("in_manifest", "in_file"), [("NFC", "NFD"), ("NFD", "NFC")])
def test_letters_composed_in_another_way_name_the_same_column(tmp_path: Path, in_manifest: str, in_file: str) -> None:
    folder = write_named_campaign(tmp_path / "c", runs=("pose1", "pose2"), named={"Fx": "Kräfte", "run": "Läufe"})
    table, manifest = folder / "raw" / "states.csv", folder / "campaign.toml"
    for file, form in ((manifest, in_manifest), (table, in_file)):
        file.write_text(unicodedata.normalize(form, file.read_text(encoding="utf-8")), encoding="utf-8")  # type: ignore[arg-type]
    states = states_of(folder)
    assert set(states.run) == {"pose1", "pose2"}


def test_a_file_composed_in_another_way_is_named(tmp_path: Path) -> None:
    folder = write_campaign(tmp_path / "c", MANIFEST.replace("raw/table.csv", "raw/Kräfte.csv"))
    (folder / "raw" / "Kra\u0308fte.csv").write_text("A1\n", encoding="utf-8")
    assert "NFD" in the_fault_of(lambda: load_campaign(folder))


def test_init_reads_past_odd_columns(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table = tmp_path / "table.csv"
    header = "A1,A2,A3,A4,A5,A6,Fx,Fy,Fz,dx,dy,dz,odd\u2028\x85\x1b"
    table.write_text(f"{header}\n" + "10,20,30,40,50,60,0,0,100,0.1,0,-0.2,7\n" * 3, encoding="utf-8")
    with pytest.raises(SystemExit) as done:
        main(["init", str(tmp_path / "c"), "--from", str(table), "--tool", "0,0,0.1", "--json"])
    assert done.value.code == 0
    document = json.loads(capsys.readouterr().out)
    assert "odd" in str(document)
    load_campaign(tmp_path / "c")


def test_a_packed_log_has_the_same_rules(tmp_path: Path) -> None:
    folder = write_named_campaign(tmp_path / "c", runs=("pose1", "po\x85se2"))
    table = folder / "raw" / "states.csv"
    (folder / "raw" / "states.csv.gz").write_bytes(gzip.compress(table.read_bytes()))
    table.unlink()
    manifest = folder / "campaign.toml"
    manifest.write_text(manifest.read_text(encoding="utf-8").replace("states.csv", "states.csv.gz"), encoding="utf-8")
    assert "contains U+0085" in the_fault_of(lambda: states_of(folder))
