"""What the README shows is what the program does."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

from stiffcal.cli.app import COMMANDS, main
from stiffcal.workflow.effects import describe_effects
from stiffcal.workflow.init import init_campaign

README = (Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")
HEADER = "A1,A2,A3,A4,A5,A6,Fx,Fy,Fz,dx,dy,dz"


def rows_of(title: str) -> list[list[str]]:
    section = README.split(f"\n## {title}\n")[1].split("\n## ")[0]
    lines = re.findall(r"^\|(.*)\|$", section, flags=re.MULTILINE)
    return [[cell.strip() for cell in re.split(r"(?<!\\)\|", line)] for line in lines]


def test_every_effect_is_listed_as_the_catalogue_has_it() -> None:
    listed = {row[0].strip("`"): (row[1], row[2]) for row in rows_of("Effects")[2:]}
    found = {one["name"]: (one["place"], one["summary"]) for one in describe_effects()["effects"]}
    assert listed == found


def test_every_command_is_listed() -> None:
    first_cells = " ".join(row[0] for row in rows_of("Commands"))
    for name in COMMANDS:
        assert re.search(rf"`{name}\b", first_cells), name


def test_shortest_manifest_is_what_init_proposes(tmp_path: Path) -> None:
    (shown,) = re.findall(r"```toml\n(.*?)```", README, flags=re.DOTALL)
    lines = [line for line in shown.splitlines() if line.strip()]
    assert len(lines) <= 15
    joints = [f"{10 * k},{-60 - k},{20 + 3 * k},{30 - 9 * k},{40 + k},{5 * k}" for k in range(8)]
    rows = [f"{pose},{100 + k},{-50 * k},20,{0.1 * k + 0.5:.1f},0.3,-0.2" for k, pose in enumerate(joints)]
    table = tmp_path / "table.csv"
    table.write_text("\n".join([HEADER, *rows]) + "\n", encoding="utf-8")
    init_campaign(tmp_path / "my-robot", table=table, robot="irb4400")
    proposed = tomllib.loads((tmp_path / "my-robot" / "campaign.toml").read_text(encoding="utf-8"))
    expected = tomllib.loads(shown)
    # where the tool is only its owner knows
    expected["frames"]["tool"]["xyz_m"] = proposed["frames"]["tool"]["xyz_m"]
    assert proposed == expected


def test_init_of_each_kind_is_understood_by_check(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for kind in ("load", "clamped", "ids", "friction"):
        folder = tmp_path / kind
        with pytest.raises(SystemExit) as end:
            main(["init", str(folder), "--kind", kind])
        assert end.value.code == 0
        with pytest.raises(SystemExit) as end:
            main(["check", str(folder)])
        told = capsys.readouterr()
        assert end.value.code == 1, told.err
        assert "not there yet" in told.out


def test_init_options_that_do_not_go_together(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for words in (["--robot", "irb4400"], ["--from", "x.csv", "--kind", "load"]):
        with pytest.raises(SystemExit) as end:
            main(["init", str(tmp_path / "new"), *words])
        assert end.value.code == 2
        assert len(capsys.readouterr().err.splitlines()) == 1
    assert not (tmp_path / "new").exists()
