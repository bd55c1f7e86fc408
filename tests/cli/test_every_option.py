"""Every option of every command, through `main`; those that all commands take stand before and after its name."""

from __future__ import annotations

import json
import shlex
import shutil
from pathlib import Path
from types import SimpleNamespace

import pytest

from stiffcal.cli.app import main
from stiffcal.cli.command_tree import COMMANDS, command_named
from stiffcal.commands.diagnose import diagnose_campaign
from stiffcal.commands.run import run_campaign
from stiffcal.commands.validate import validate_campaign
from stiffcal.errors import Progress
from stiffcal.fault_codes import FaultCode
from stiffcal.report.content import ReportContent
from stiffcal.stages.run_result import RunResult
from stiffcal.stages.steps import RunContext
from tests.laboratory.small_campaign import write_small_campaign

pytestmark = pytest.mark.usefixtures("few_known_effects")
ROOT = Path(__file__).parents[2]
POSE = "0,-70,20,0,30,0"
PATH = "t,A1,A2,A3,A4,A5,A6\n0,-30,-70,20,15,40,10\n1,-29,-70,20,15,40,10\n2,-28,-70,20,15,40,10\n"
SENSOR = "t,Fx,Fy,Fz,Tx,Ty,Tz\n0,0,0,0,0,0,0\n1,0,0,-100,0,0,0\n2,0,0,-100,0,0,0\n"
FILES = {
    "path.csv": PATH,
    "parts.csv": PATH.replace("t,", "segment,").replace("\n2,", "\n1,").replace("\n0,", "\n1,"),
    "places.csv": "X,Y,Z,roll,pitch,yaw\n1100,100,900,0,90,0\n1110,100,900,0,90,0\n",
    "poses.csv": "A1,A2,A3,A4,A5,A6,Fx,Fy,Fz\n0,-70,20,0,30,0,0,0,-100\n",
    "sensor.csv": SENSOR,
    "small/plan.toml": 'schema = "stiffcal/plan-input/1"\ncandidates = 6\n[load]\nforce_N = 300.0\n',
    "parts_forces.csv": "segment,Fx,Fy,Fz,Tx,Ty,Tz\n1,0,0,-100,0,0,0\n",
    "thresholds.toml": 'schema = "stiffcal/thresholds/1"\n[validate]\nmax_rms_m = 1.0\n',
    "table.csv": "A1,A2,A3,A4,A5,A6,Fx,Fy,Fz,dx,dy,dz\n"
    + "".join(f"{k},-70,20,0,30,{k},0,0,{-100 * k},0,0,{-0.1 * k}\n" for k in range(1, 9)),
}
CALLS: dict[str, list[str]] = {
    "init": [
        "new --kind load",
        "new2 --from table.csv --robot irb4400 --tool 0,0,0.2",
        f"new3 --from table.csv --tool 0,0,0.2 --urdf {ROOT}/tests/laboratory/data/six.urdf",
    ],
    "check": ["small --quick --details", "small --run pose1"],
    "ingest": ["small"],
    "identify": ["small --loss huber --no-update --details", "small --dual-quaternions", "small --coupling"],
    "validate": ["small --details --thresholds thresholds.toml --no-update", "small --model other"],
    "diagnose": ["small --details --jobs 2 --no-update"],
    "improve": ["small --dry-run --likely --no-update --no-report", "small --yes --report"],
    "compare": ["small other --no-update --details"],
    "trend": ["small other --max-change 9 -o trend.svg --no-update --details", "small other --output trend.pdf"],
    "history": ["small --restore 1 --yes"],
    "plot": [
        "small --run pose1 -o plot.png --no-update",
        "small --against torque:2 --output residual.svg",
        "small --of influence -o influence.svg",
        "small --of normal -o normal.svg",
    ],
    "report": ["small -o small.pdf --no-update", "small --output small.pdf --short"],
    "view": [
        "small -o small.html --no-raw --no-update",
        "small --output small.html --open",
        "small --live",
        "small --watch",
    ],
    "run": ["small"],
    "batch": [
        "small --jobs 1 --idle-timeout 99 --no-report --reports pages --junit junit.xml --markdown a.md",
        "small --scheduler nonsense --thresholds thresholds.toml",
    ],
    "export": [
        "small -o states.csv --raw-text --no-update",
        "small --output robot.toml --convention dh --strict",
        f"small -o code.c --filter 20 --tool 1,0,0,0.05 --zeroed-at {POSE} --sensor load_point",
        "small -o code.st --cycle-ms 4 --target target --leave-out joint-compliance",
    ],
    "predict": [
        "small --poses poses.csv -o predicted.csv --no-update --details",
        f"small --pose {POSE} --force 0,0,-100",
        f"small --load-path 0,0,0;0,0,-100 --at {POSE} --points 3 --note words --output predicted.csv",
    ],
    "map": [
        f"small --mass 10 --stiffness z --slices 1 --points 4 --pose {POSE} -o map.svg --table map.csv --no-update",
        "small --load 0,0,-100 --points 4 --plane xz --at 0 --target target --output map.pdf",
    ],
    "compensate": [
        "small --path path.csv --log sensor.csv --filter 0.2 --tool 1,0,0,0.05 --zeroed --frame load_point --no-update",
        "small --path path.csv --log sensor.csv --frame load_point --tool 1,0,0,0.05 --never-zeroed --acts-on robot",
        "small --path path.csv --force 0,0,9 --no-sag --target target --normal 0,0,1 -o out.csv --picture error.svg",
        "small --path parts.csv --segments parts_forces.csv --judge other --position-only --output corrected.csv",
        f"small --path places.csv --force 0,0,-100 --start {POSE} --sag",
    ],
    "plan": [
        "small --for stiffness --criterion worst --runs 3 --campaign planned --program p.src -o runs.csv --no-update",
        "small --runs 3 --force 300 --tell 'backlash j4' 'two-slope j4' --output runs.csv --details",
    ],
    "simulate": [f"twin --from {ROOT}/campaigns/irb4400 --seed 1"],
    "effects": ["backlash -o backlash.svg", "--from small --output creep.svg creep"],
    "add": [
        "small backlash --joints 4 --start width=1e-3",
        "small link-beam --links swing",
        "small axis-coupling --pairs 5-6",
        "small two-slope --all",
        "small bearing-tilt --joints 2 --curved",
    ],
    "remove": [
        "small joint-compliance --joints 6",
        "small link-beam --links swing",
        "small axis-coupling --pairs 5-6",
        "small joint-compliance --all",
    ],
    "trust": ["--list", "small --hash", "--store stores --yes", "small --edit --yes", "--revoke stores"],
    "demo": ["shown"],
    "doctor": [""],
}
"""For each command calls that use all its options; in the present folder are `small`, `other` and `FILES`."""

REFUSED = ("small --coupling", "small --scheduler nonsense --thresholds thresholds.toml", "small --hash")
"""What the option asks for is not to be had here: no link carries rods, there is no cluster, no code."""
BEFORE = {"remove": ["add small link-beam --links swing", "add small axis-coupling --pairs 5-6"]}


@pytest.fixture(scope="module")
def prepared(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two campaigns with every result, the store of the first once more, and files."""
    place = tmp_path_factory.mktemp("options")
    for name, seed in (("small", 1), ("other", 2)):
        folder = write_small_campaign(place / name, seed=seed)
        validate_campaign(folder)
    diagnose_campaign(place / "small")
    shutil.copytree(place / "small" / "store", place / "stores" / "again", symlinks=True)
    for name, text in FILES.items():
        (place / name).write_text(text, encoding="utf-8")
    return place


@pytest.fixture
def place(prepared: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of it as the present folder; what takes long, and is tested elsewhere, is left out."""

    def touch(content: ReportContent, output: Path, progress: Progress, is_short: bool) -> None:
        output.write_bytes(b"pages")

    def show(folder: Path, context: RunContext, notify_step: object) -> RunResult:
        folder.exists() or shutil.copytree(prepared / "small", folder, symlinks=True)
        return run_campaign(folder, context)

    monkeypatch.setattr("stiffcal.report.building.build_report", touch)
    monkeypatch.setattr("stiffcal.commands.demo.run_demo", show)
    monkeypatch.setattr("stiffcal.live.page.live_server", lambda *given: SimpleNamespace(address="here", serve=bool))
    monkeypatch.setattr("webbrowser.open", lambda address: True)
    copy = Path(shutil.copytree(prepared, tmp_path / "here", symlinks=True))
    monkeypatch.chdir(copy)
    return copy


def run(words: list[str]) -> int:
    with pytest.raises(SystemExit) as end:
        main(words)
    assert isinstance(end.value.code, int)
    return end.value.code


def spellings(name: str) -> set[str]:
    """Return every spelling of every option of a command, as its parser knows them."""
    return {word for one in command_named(name).params for word in (*one.opts, *one.secondary_opts) if word[0] == "-"}


def with_every_command(name: str, own: list[str], log: str, number: int) -> list[str]:
    """Return the options that every command takes, and --json and --store where the command has them."""
    overwrite = "--force" if number % 2 and name not in ("plan", "compensate") else "--overwrite"
    words = ["--verbose", "--log-file", log, "--debug", overwrite]
    words += ["--json"] * ("--json" in spellings(name))
    return words + ["--store", "stores/again"] * ("--store" in spellings(name) and name != "trust")


@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_takes_every_option(name: str, place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    used: set[str] = set()
    calls = CALLS[name] if len(CALLS[name]) > 1 else 2 * CALLS[name]
    for call in BEFORE.get(name, ()):
        assert run(shlex.split(call)) == 0
    for number, call in enumerate(calls):
        own, log = shlex.split(call), f"{number}.log"
        common = with_every_command(name, own, log, number)
        capsys.readouterr()
        code = run([*common, name, *own] if number % 2 else [name, *own, *common])
        captured = capsys.readouterr()
        assert code == (2 if call in REFUSED else 0), (call, captured.out, captured.err)
        if "--json" in common:
            document = json.loads(captured.out)
            assert ("schema" in document) is (code == 0)
            assert code == 0 or document["error"]["code"] != FaultCode.COMMAND_LINE
        lines = (place / log).read_text(encoding="utf-8").splitlines()
        assert len(lines) >= 2
        assert all(line in captured.err for line in (lines[0], lines[-1]))  # --verbose gives the same lines
        used |= {word for word in (*own, *common) if word.startswith("-")}
    assert spellings(name) <= used
    assert {file: (place / file).read_text(encoding="utf-8") for file in FILES} == FILES


def test_no_option_of_a_command_is_taken_for_that_of_all(place: Path) -> None:
    """`--log` is compensate's own sensor file, wherever it stands, and no other command's."""
    words = ["compensate", "small", "--path", "path.csv", "--log", "sensor.csv", "--frame", "load_point"]
    assert run(words) == 0
    assert run([*words, "--log-file", "sensor.csv"]) == 2
    assert run(["--log", "sensor.csv", "check", "small"]) == 2
    assert run(["check", "small", "--log", "sensor.csv"]) == 2
    assert (place / "sensor.csv").read_text(encoding="utf-8") == SENSOR


@pytest.mark.parametrize("words", [["--store", "stores/again", "effects"], ["--quick", "check"], ["--json"]])
def test_an_option_before_a_command_that_lacks_it_is_a_mistake(words: list[str]) -> None:
    assert run(words) == 2


def test_what_stands_after_the_command_counts(place: Path) -> None:
    assert run(["--log-file", "first.log", "effects", "--log-file", "second.log"]) == 0
    assert not (place / "first.log").exists()
    assert (place / "second.log").exists()
