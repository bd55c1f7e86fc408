"""No command writes to a file that holds something it did not write, wherever the user or the command puts it."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import pytest

from stiffcal.fault_codes import FaultCode
from stiffcal.trust.output_kinds import CAMPAIGN_FILE, LOG
from stiffcal.trust.outputs import note_written
from tests.cli.test_every_option import CALLS, place, prepared, run

__all__ = ["place", "prepared"]

MINE = b"t,Fx\n0,1\n"
POSE = "0,-70,20,0,30,0"
# Words, and the file that they write; a name that an option states fits its command.
WRITES = [
    ("report small", "small/report.pdf"),
    ("report small -o a.pdf", "a.pdf"),
    ("view small", "small/view.html"),
    ("view small -o a.html", "a.html"),
    ("run small", "small/report.pdf"),
    ("run small", "small/view.html"),
    ("plot small", "small/plot.svg"),
    ("plot small -o a.png", "a.png"),
    ("trend small other -o a.svg", "a.svg"),
    ("export small", "small/states.csv"),
    *(
        (f"export small -o a.{ending}", f"a.{ending}")
        for ending in ("parquet", "json", "urdf", "toml", "xml", "c", "st")
    ),
    ("export small -o a.c", "a.h"),
    ("predict small --poses poses.csv -o a.csv", "a.csv"),
    ("predict small --poses poses.csv -o poses.csv", "poses.csv"),
    ("map small --load 0,0,-100 --points 3", "small/map.svg"),
    ("map small --load 0,0,-100 --points 3 -o a.svg --table a.csv", "a.csv"),
    ("map small --load 0,0,-100 --points 3 -o a.svg --table a.csv", "a.svg"),
    ("compensate small --path path.csv --force 0,0,9 -o a.csv", "a.csv"),
    ("compensate small --path path.csv --force 0,0,9 -o path.csv", "path.csv"),
    ("compensate small --path path.csv --force 0,0,9 --picture a.svg", "a.svg"),
    ("plan small --runs 3 -o a.csv", "a.csv"),
    ("plan small --runs 3 -o a.pdf", "a.pdf"),
    ("plan small --runs 3 --program a.src", "a.src"),
    ("batch small --no-report --junit a.xml", "a.xml"),
    ("batch small --no-report --markdown a.md", "a.md"),
    ("effects backlash -o a.svg", "a.svg"),
    ("effects --log-file a.csv", "a.csv"),
    ("check small --log-file small/raw/states.csv", "small/raw/states.csv"),
    ("init new", "new/campaign.toml"),
    ("init new", "new/robot.toml"),
    ("init new --from table.csv --robot irb4400 --tool 0,0,0.2", "new/raw/table.csv"),
    (f"simulate {CALLS['simulate'][0]}", "twin/truth.json"),
    (f"simulate {CALLS['simulate'][0]}", "twin/README.md"),
    ("history small --restore 1", "small/model.toml"),
]
"""`simulate` writes no README.md: a folder that holds anything is no place for a campaign."""


@pytest.mark.parametrize(("words", "file"), WRITES, ids=[f"{words}: {file}" for words, file in WRITES])
def test_what_somebody_else_wrote_or_a_command_as_something_else_is_left_alone(
    words: str, file: str, place: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = (place / file).read_bytes() if (place / file).exists() else b""
    mine = before if file in ("poses.csv", "path.csv", "small/raw/states.csv") else MINE
    if file == "small/model.toml":
        mine = before + b"# another drive\n"
    (place / file).parent.mkdir(parents=True, exist_ok=True)
    (place / file).write_bytes(mine)
    for kind in (LOG, CAMPAIGN_FILE):
        note_written(place / file, kind)
    folders = {path: sorted(path.iterdir()) for path in (place, place / "small", (place / file).parent)}
    assert run([*shlex.split(words), "--json"]) == 2
    document = json.loads(capsys.readouterr().out)
    assert document["error"]["code"] == "file-exists"
    assert (place / file).read_bytes() == mine
    assert {path: sorted(path.iterdir()) for path in folders} == folders


OWN = {
    "plot small": "small/plot.svg",
    "export small": "small/states.csv",
    "effects backlash -o a.svg": "a.svg",
    "report small": "small/report.pdf",
}


@pytest.mark.parametrize("words", OWN)
def test_what_a_command_wrote_itself_is_written_anew(words: str, place: Path) -> None:
    for _ in range(2):
        assert run(shlex.split(words)) == 0
    file = place / OWN[words]
    file.write_bytes(file.read_bytes() + b"\n")
    assert run(shlex.split(words)) == 2
    assert run([*shlex.split(words), "--force"]) == 0
    assert run(shlex.split(words)) == 0


OTHER_ENDINGS = [
    "report small -o a.xlsx",
    "report small -o a",
    "view small -o a.pdf",
    "plot small -o a.csv",
    "trend small other -o a.csv",
    "export small -o a.txt",
    "predict small --poses poses.csv -o a.txt",
    "map small --load 0,0,-100 --points 3 -o a.csv",
    "map small --load 0,0,-100 --points 3 --table a.svg",
    "compensate small --path path.csv --force 0,0,9 -o a.txt",
    "compensate small --path path.csv --force 0,0,9 --picture a.csv",
    "plan small --runs 3 -o a.svg",
    "plan small --runs 3 --program a.csv",
    "effects backlash -o a.csv",
]


@pytest.mark.parametrize("words", OTHER_ENDINGS)
def test_a_name_says_what_the_file_is(words: str, place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = sorted(place.iterdir())
    assert run([*shlex.split(words), "--json"]) == 2
    assert json.loads(capsys.readouterr().out)["error"]["code"] == FaultCode.FORMAT_UNKNOWN
    assert sorted(place.iterdir()) == before


@pytest.mark.parametrize(("words", "file"), [("plot", "plot.svg"), ("export", "states.csv"), ("report", "report.pdf")])
def test_what_is_not_told_where_goes_to_the_campaign_folder(words: str, file: str, place: Path) -> None:
    before = sorted(place.iterdir())
    assert run([words, "small"]) == 0
    assert (place / "small" / file).is_file()
    assert sorted(place.iterdir()) == before
    assert run([words, "small", "-o", file]) == 0  # as the shell has it
    assert (place / file).is_file()
