"""What README and documentation show of `init` and of thresholds is what the program does."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

from docs.page_blocks import page_text
from stiffcal.campaign.manifest.thresholds import Thresholds, load_thresholds
from stiffcal.cli.app import main
from stiffcal.commands.init import init_campaign

README = (Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")
HEADER = "A1,A2,A3,A4,A5,A6,Fx,Fy,Fz,dx,dy,dz"


def test_shortest_manifest_is_what_init_proposes(tmp_path: Path) -> None:
    shown = re.findall(r"```toml\n(.*?)```", README, flags=re.DOTALL)[0]
    lines = [line for line in shown.splitlines() if line.strip()]
    assert len(lines) <= 15
    joints = [f"{10 * k},{-60 - k},{20 + 3 * k},{30 - 9 * k},{40 + k},{5 * k}" for k in range(8)]
    rows = [f"{pose},{100 + k},{-50 * k},20,{0.1 * k + 0.5:.1f},0.3,-0.2" for k, pose in enumerate(joints)]
    table = tmp_path / "table.csv"
    table.write_text("\n".join([HEADER, *rows]) + "\n", encoding="utf-8")
    init_campaign(tmp_path / "my-robot", tables=[table], robot="irb4400", tool=(0.0, 0.0, 0.2))
    proposed = tomllib.loads((tmp_path / "my-robot" / "campaign.toml").read_text(encoding="utf-8"))
    expected = tomllib.loads(shown)
    assert proposed == expected


def test_thresholds_shown_are_understood(tmp_path: Path) -> None:
    page = page_text("how-to/many-campaigns.md")
    (shown,) = re.findall(r"```toml check\n(schema = \"stiffcal/thresholds.*?)```", page, flags=re.DOTALL)
    file = tmp_path / "thresholds.toml"
    file.write_text(shown, encoding="utf-8")
    limits = load_thresholds(file).limits_for("cell-2", "cell-2", Thresholds())
    assert limits.baseline == str(tmp_path / "cell-2-2025")
    assert set(limits.written()) == set(Thresholds.model_fields) - {"max_rms_rad"}
    load_thresholds(Path(__file__).parents[2] / "campaigns" / "thresholds.toml")


def test_init_of_each_kind_is_understood_by_check(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for kind in ("load", "clamped", "ids", "friction"):
        folder = tmp_path / kind
        with pytest.raises(SystemExit) as end:
            main(["init", str(folder), "--kind", kind])
        assert end.value.code == 0
        with pytest.raises(SystemExit) as end:
            main(["check", str(folder)])
        reported = capsys.readouterr()
        assert end.value.code == 1, reported.err
        assert "not there yet" in reported.out


def test_init_options_that_do_not_go_together(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for words in (["--tool", "0,0,0.1"], ["--from", "x.csv", "--kind", "ids"]):
        with pytest.raises(SystemExit) as end:
            main(["init", str(tmp_path / "new"), *words])
        assert end.value.code == 2
        assert len(capsys.readouterr().err.splitlines()) == 1
    assert not (tmp_path / "new").exists()


def test_init_from_several_tables(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """As published measurements come: angles, forces and displacements in a file each."""
    (tmp_path / "angles.csv").write_text("A1,A2,A3,A4,A5,A6\n10,20,30,40,50,60\n20,10,35,0,50,0\n", encoding="utf-8")
    (tmp_path / "forces.csv").write_text("Fx,Fy,Fz\n0,0,-100\n50,0,-300\n", encoding="utf-8")
    (tmp_path / "moved.csv").write_text("dx,dy,dz\n0.1,0,-0.2\n0.2,0.1,-0.6\n", encoding="utf-8")
    words = [word for name in ("angles", "forces", "moved") for word in ("--from", str(tmp_path / f"{name}.csv"))]
    folder = tmp_path / "my-robot"
    with pytest.raises(SystemExit) as end:
        main(["init", str(folder), *words, "--robot", "irb4400"])
    assert end.value.code == 0, capsys.readouterr().err
    source = tomllib.loads((folder / "campaign.toml").read_text(encoding="utf-8"))["sources"]["table"]
    assert source["files"] == {"joints": "raw/angles.csv", "wrench": "raw/forces.csv", "deflection": "raw/moved.csv"}
