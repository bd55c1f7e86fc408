"""The project's own promises: the lock follows pyproject, nothing names a registry, start-up stays light."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path
from typing import Any

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from packaging.version import Version

from stiffcal.extras import EXTRAS
from tests.conftest import LONG, NO_KERNEL, NUMERICAL
from tests.laboratory.small_campaign import write_small_campaign

ROOT = Path(__file__).parents[1]
# Folders of tests that are no room's: what they hold, and whether modules that are no tests may stand in them.
ACROSS_ROOMS = {
    "answers": "records what commands answer",
    "benchmarks": "compares with peers and limits",
    "calibration": "judges campaigns in the proportions of laboratories, and compares judges",
    "docs": "builds the documentation, executes its blocks",
    "contracts": "tests over everything that is found",
    "faults": "kills commands, fills disks",
    "fuzz": "spoils inputs",
    "independent": "tests against engines from outside",
    "laboratory": "builds robots, states and campaigns for all tests",
    "limits": "varies the numbers that decide in the reduction",
    "long_campaigns": "measures campaigns of thousands of runs",
    "next_steps": "follows what answers propose as the next step, until it ends",
    "python": "`import stiffcal` as scripts, notebooks and plugins use it",
    "rates": "counts how often the right effect is named",
    "security": "tests of folders from strangers",
    "whole_campaigns": "tests of campaigns through the command line",
}
WITHOUT_MODULES = {"contracts", "independent", "security", "whole_campaigns"}
# What `stiffcal --help` may load: numpy and pyarrow are loaded inside functions there. Elsewhere a module may load what
# it works with, but for libraries that most commands can do without (TID253 in pyproject.toml).
LIGHT_FILES = ("__init__.py", "__main__.py", "errors.py", "quantities.py", "uncertainty.py", "cli/*.py")
HEAVY = ("numpy", "scipy", "pandas", "pyarrow", "matplotlib", "h5py")
LIGHT_CALLS: tuple[list[str], ...] = (
    [],
    ["--help"],
    ["--version"],
    ["check", "--help"],
    ["no-such-command"],
    ["check", "--no-such-option"],
)


def project() -> dict[str, Any]:
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def locked(file: str) -> dict[str, list[tuple[Requirement, int]]]:
    """Return name to (requirement, number of hashes), one entry per marker."""
    text = (ROOT / "requirements" / file).read_text(encoding="utf-8")
    found: dict[str, list[tuple[Requirement, int]]] = {}
    for block in re.split(r"\n(?=\S)", text.strip()):
        requirement = Requirement(block.split(" \\\n")[0])
        found.setdefault(canonicalize_name(requirement.name), []).append((requirement, block.count("--hash=sha256:")))
    return found


def asked(*groups: str) -> list[Requirement]:
    document = project()
    lines = list(document["project"]["dependencies"])
    for group in groups:
        lines += document["dependency-groups"][group]
    return [Requirement(line) for line in lines]


@pytest.mark.parametrize(("file", "groups"), [("run.txt", ("build",)), ("test.txt", ("build", "test"))])
def test_lock_holds_what_pyproject_asks_for(file: str, groups: tuple[str, ...]) -> None:
    lock = locked(file)
    for wish in asked(*groups):
        name = canonicalize_name(wish.name)
        assert name in lock, f"{wish} is not in requirements/{file}: run `make lock`"
        for requirement, _ in lock[name]:
            (pin,) = requirement.specifier
            assert pin.operator == "=="
            assert Version(pin.version) in wish.specifier, f"requirements/{file} pins {requirement}: run `make lock`"


def test_lines_that_install_a_library_ask_for_what_the_extra_asks_for() -> None:
    assert {name: [line] for name, line in EXTRAS.items()} == project()["project"]["optional-dependencies"]


def test_only_typst_is_capped() -> None:
    document = project()["project"]
    lines = [
        *document["dependencies"],
        *(line for extra in document["optional-dependencies"].values() for line in extra),
    ]
    assert [Requirement(line).name for line in lines if "<" in line] == ["typst"]


def test_every_pin_has_hashes() -> None:
    for file in ("run.txt", "test.txt"):
        for entries in locked(file).values():
            assert all(hashes > 0 for _, hashes in entries)


def test_run_and_test_pin_the_same_versions() -> None:
    test = locked("test.txt")
    for name, entries in locked("run.txt").items():
        here = {(str(requirement.specifier), str(requirement.marker)) for requirement, _ in entries}
        there = {(str(requirement.specifier), str(requirement.marker)) for requirement, _ in test[name]}
        assert {pin for pin, _ in here} == {pin for pin, _ in there}, name


def test_pinocchio_is_not_asked_for_on_windows() -> None:
    (entry,) = locked("test.txt")["pin"]
    assert entry[0].marker is not None
    assert not entry[0].marker.evaluate({"sys_platform": "win32"})
    assert entry[0].marker.evaluate({"sys_platform": "linux"})


def test_build_back_end_stands_in_the_lock() -> None:
    (requirement,) = [Requirement(line) for line in project()["build-system"]["requires"]]
    assert canonicalize_name(requirement.name) in locked("run.txt")


def test_no_committed_file_names_a_registry_or_this_machine() -> None:
    listing = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True)
    if listing.returncode:
        pytest.skip("not a git checkout")
    forbidden = re.compile(r"--(extra-)?index-url|--find-links|https?://[^\s\"']*/simple\b|py" + r"pi\.org")
    for name in filter(None, listing.stdout.split("\0")):
        file = ROOT / name
        if not file.is_file() or file.stat().st_size > 2_000_000 or file.suffix in {".parquet", ".h5", ".hdf5", ".pdf"}:
            continue
        if file == Path(__file__):
            continue
        match = forbidden.search(file.read_text(encoding="utf-8", errors="replace"))
        assert match is None, f"{name}: {match and match.group()}"


def test_no_pattern_has_a_possessive_group() -> None:
    """Python before 3.11.5 ends one too early where its content can be matched in several ways."""
    group = re.compile(r"\)(?:[*+?]|\{[^{}]*\})\+|\(\?>")
    assert group.search(r"(?:[^']|'(?!''))*+")
    assert [path for path in (ROOT / "stiffcal").rglob("*.py") if group.search(path.read_text("utf-8"))] == []


def test_top_level_holds_only_what_was_agreed() -> None:
    listing = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True)
    if listing.returncode:
        pytest.skip("not a git checkout")
    top = {name.split("/")[0] for name in listing.stdout.splitlines()}
    agreed = {"README.md", "CHANGELOG.md", "CONTRIBUTING.md", "LICENSE", "Makefile", "pyproject.toml", "requirements"}
    assert {name for name in top if not name.startswith(".")} <= agreed | {
        "stiffcal",
        "campaigns",
        "docs",
        "tests",
        "schemas",
    }


def folders_of(place: Path) -> set[str]:
    return {path.name for path in place.iterdir() if path.is_dir() and next(path.rglob("*.py"), None) is not None}


def test_each_room_has_its_folder_of_tests() -> None:
    rooms = folders_of(ROOT / "stiffcal")
    assert {room for room in rooms if not list((ROOT / "tests" / room).glob("test_*.py"))} == set()
    modules = {file.stem for file in (ROOT / "stiffcal").glob("*.py")}
    assert folders_of(ROOT / "tests") <= rooms | modules | set(ACROSS_ROOMS)


def test_the_drawing_of_the_layers_is_the_rule_for_imports() -> None:
    contract = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["importlinter"]["contracts"][0]
    text = (ROOT / "docs" / "architecture.md").read_text("utf-8")
    drawing = text.partition("\n## Layers\n")[2].partition("\n```text check\n")[2].partition("\n```\n")[0]
    drawn = [re.split(r" {2,}", line)[0] for line in drawing.splitlines()]
    assert drawn == contract["layers"]


def test_the_files_that_a_number_comes_from_exist() -> None:
    text = (ROOT / "docs" / "architecture.md").read_text("utf-8")
    named = re.findall(r"`([\w/]+/(?:\w+\.py)?)`", text.partition("\n## Where does this number come from?\n")[2])
    inside = [name for name in named if not name.startswith("stiffcal/") and "NAME" not in name]
    assert len(inside) > 20
    assert [name for name in inside if not (ROOT / "stiffcal" / name).exists()] == []


def test_what_tests_share_stands_in_the_laboratory() -> None:
    """A robot, a table of states or a campaign that is made in a room's folder is made a second time in another."""
    for folder in folders_of(ROOT / "tests") - (set(ACROSS_ROOMS) - WITHOUT_MODULES):
        modules = {file.name for file in (ROOT / "tests" / folder).rglob("*.py")}
        shared = {name for name in modules if not name.startswith("test_")} - {"__init__.py", "conftest.py"}
        assert not shared, f"tests/{folder}: {shared} belong to tests/laboratory"


def test_folders_and_files_with_marks_of_their_own_exist() -> None:
    """A file that is moved would lose its mark, and no kernels would be tried on it."""
    assert [name for name in (*NUMERICAL, *NO_KERNEL, *LONG) if not (ROOT / "tests" / name).exists()] == []


def test_package_data_goes_into_the_wheel(tmp_path: Path) -> None:
    code = "import sys, flit_core.buildapi as build; print(build.build_wheel(sys.argv[1]))"
    command = [sys.executable, "-c", code, str(tmp_path)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    names = set(zipfile.ZipFile(tmp_path / done.stdout.strip()).namelist())
    data = [file for pattern in ("*.toml", "*.typ", "*.md") for file in (ROOT / "stiffcal").rglob(pattern)]
    assert {file.relative_to(ROOT).as_posix() for file in data} <= names
    assert "stiffcal/py.typed" in names


def loaded_by(arguments: list[str]) -> tuple[set[str], int]:
    """Run the command line in a fresh process; return the modules it loaded and its exit code."""
    code = (
        "import sys, json\n"
        "from stiffcal.cli.app import main\n"
        "try:\n    main(sys.argv[1:])\n"
        "except SystemExit as end:\n    print('\\n' + json.dumps([sorted(sys.modules), end.code]))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments], cwd=ROOT, capture_output=True, text=True, check=True
    )
    modules, exit_code = json.loads(done.stdout.splitlines()[-1])
    return set(modules), exit_code


@pytest.mark.parametrize("arguments", LIGHT_CALLS, ids=" ".join)
def test_help_version_and_usage_errors_load_nothing_heavy(arguments: list[str]) -> None:
    modules, exit_code = loaded_by(arguments)
    assert not modules.intersection(HEAVY)
    assert exit_code == (2 if any("no-such" in word for word in arguments) else 0)


def test_files_of_the_command_line_import_nothing_heavy_at_module_level() -> None:
    files = [file for pattern in LIGHT_FILES for file in (ROOT / "stiffcal").glob(pattern)]
    heavy = re.compile(rf"^(?:import|from) (?:{'|'.join(HEAVY)})\b", re.MULTILINE)
    assert len(files) > len(LIGHT_FILES)
    assert [file.name for file in files if heavy.search(file.read_text("utf-8"))] == []


@pytest.mark.long
@pytest.mark.parametrize("command", ["check", "identify"])
def test_commands_on_loads_and_displacements_do_not_load_scipy(command: str, tmp_path: Path) -> None:
    """It takes a tenth of a short command's time to load."""
    write_small_campaign(tmp_path / "campaign")
    modules, exit_code = loaded_by([command, str(tmp_path / "campaign")])
    assert not modules.intersection({"scipy", "matplotlib"})
    assert exit_code == 0


@pytest.mark.parametrize("arguments", LIGHT_CALLS, ids=" ".join)
def test_help_version_and_usage_errors_answer_within_200_ms(arguments: list[str]) -> None:
    # Processor time of the whole process, interpreter included, with byte-code compiled: what a person waits on a
    # machine that does nothing else. On a busy or slow one it is held against a bare interpreter at the same moment:
    # 200 ms are twelve of those.
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    report = "import sys, time, atexit; atexit.register(lambda: print('\\n' + str(time.process_time())))"

    def seconds(code: str) -> float:
        words = [sys.executable, "-c", code, *arguments]
        done = subprocess.run(words, cwd=ROOT, env=environment, capture_output=True, text=True)
        return float(done.stdout.splitlines()[-1])

    ours, bare = [], []
    for _ in range(8):
        bare.append(seconds(report))
        ours.append(seconds(f"{report}; from stiffcal.cli.app import main; main(sys.argv[1:])"))
        if min(ours) < max(0.2, 12 * min(bare)):
            return
    pytest.fail(f"{1e3 * min(ours):.0f} ms; a bare interpreter {1e3 * min(bare):.0f} ms")


def test_one_blas_thread_unless_the_user_says_otherwise() -> None:
    code = "import stiffcal, os; print(os.environ['OPENBLAS_NUM_THREADS'])"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "1"


def test_make_test_and_ci_call_the_same() -> None:
    script = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    for word in ("make --no-print-directory test", "ruff", "mypy", "lint-imports"):
        assert word in script


def test_what_ci_leaves_to_make_practice_is_run_there() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    assert makefile.count("$(PYTEST) -m practice\n") == 1


def test_bundled_example_is_the_campaign() -> None:
    """`make example` renews the copy."""
    campaign, example = ROOT / "campaigns" / "demo", ROOT / "stiffcal" / "commands" / "example"
    copied = [file for file in example.rglob("*") if file.is_file()]
    assert {"campaign.toml", "simulate.toml", "README.md"} <= {file.name for file in copied}
    for file in copied:
        assert file.read_bytes() == (campaign / file.relative_to(example)).read_bytes(), file
