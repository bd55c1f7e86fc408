"""No command takes a module or settings from the current folder or from the campaign's."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import stiffcal
from stiffcal.module_path import child_environment, leave_out_current_folder, without_current_folder
from tests.laboratory.small_campaign import write_small_campaign

ROOT = Path(__file__).parents[2]
MARK = "POISONED"
MODULES = (
    "json", "numpy", "random", "stiffcal", "typing", "re", "os", "io", "sitecustomize", "usercustomize", "pandas",
    "encodings", "matplotlib", "typst", "pyarrow", "scipy", "h5py", "tomllib", "logging", "queue", "evil",
)  # fmt: skip
COMMANDS = (
    ["check"], ["history"], ["plot", "-o", "picture.svg"], ["export", "-o", "states.csv"],
    ["map", "--load", "0,0,-100", "--plane", "xz", "--at", "0.4", "--points", "3"], ["diagnose"], ["effects"],
    ["batch", "--jobs", "1", "--no-report"],
)  # fmt: skip


def poison(folder: Path) -> None:
    """Put files into a folder that run, or fail, when a Python or a library looks there."""
    for name in MODULES:
        (folder / f"{name}.py").write_text(
            f"open({str(folder / MARK)!r}, 'a').write('{name}\\n')\nraise SystemExit(9)\n"
        )
    (folder / "poison.pth").write_text(f"import os; open({str(folder / MARK)!r}, 'a').write('pth')\n")
    (folder / "matplotlibrc").write_text("figure.hooks: evil:hook\nbackend: module://evil\nno such key: 1\n")
    (folder / "setup.cfg").write_text("[nothing]\n")
    (folder / ".env").write_text("STIFFCAL_ALLOW=/\n")
    for name in (".netrc", "netrc", ".numpyrc", "pg_service.conf", ".pg_service.conf", "dask.yaml", ".condarc"):
        (folder / name).write_text("poison\n")


@pytest.fixture(scope="module")
def clean(tmp_path_factory: pytest.TempPathFactory) -> Path:
    from stiffcal.commands.validate import validate_campaign

    folder = write_small_campaign(tmp_path_factory.mktemp("clean") / "cell")
    validate_campaign(folder)
    return folder


@pytest.fixture
def poisoned(clean: Path, tmp_path: Path) -> Path:
    folder = Path(shutil.copytree(clean, tmp_path / "cell", symlinks=True))
    poison(folder)
    return folder


def environment(**further: str) -> dict[str, str]:
    without = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    return {**without, "PYTHONPATH": str(ROOT), **further}


# What the `stiffcal` script does: its own folder stands first on the path, not the current one.
SCRIPT = "import sys; from stiffcal.cli.app import main; sys.argv[0] = 'stiffcal'; sys.exit(main())"


def start(folder: Path, *words: str, **further: str) -> subprocess.CompletedProcess[str]:
    script = folder.parent / "bin" / "stiffcal"
    script.parent.mkdir(exist_ok=True)
    script.write_text(SCRIPT)
    command = [sys.executable, str(script), *words]
    return subprocess.run(command, cwd=folder, env=environment(**further), capture_output=True, text=True, check=False)


WATCH = """
import os, sys
here = os.path.realpath(os.environ["WATCHED"])
log = os.open(os.environ["WATCH_LOG"], os.O_WRONLY | os.O_CREAT | os.O_APPEND)
def watch(event, arguments):
    if event == "open" and isinstance(arguments[0], (str, bytes)):
        path = os.path.abspath(os.fsdecode(arguments[0]))
        if path.startswith(here + os.sep) and os.path.lexists(path):
            os.write(log, (os.path.relpath(path, here) + "\\n").encode())
    elif event == "socket.connect":
        os.write(log, b"socket.connect\\n")
sys.addaudithook(watch)
"""
OWN_FILES = re.compile(
    r"store|store/.*|raw|raw/.*|(campaign|robot|model)\.toml|(\.stiffcal[^/]*|\.?)(picture|states|report)[^/]*"
    r"|\.stiffcal-[0-9a-f]+\.\w+|\.[^/]*\.(toml|svg|csv|pdf)[^/]*"
)


@pytest.mark.parametrize("command", COMMANDS, ids=lambda words: words[0])
def test_a_command_opens_only_the_campaigns_own_files_and_no_connection(poisoned: Path, command: list[str]) -> None:
    sites = poisoned.parent / "site"
    sites.mkdir()
    (sites / "sitecustomize.py").write_text(WATCH)
    log = poisoned.parent / "opened"
    words = [command[0], "."] if command[0] == "batch" else [command[0]]
    path = os.pathsep.join((str(sites), str(ROOT)))
    done = start(poisoned, *words, *command[1:], PYTHONPATH=path, WATCHED=str(poisoned), WATCH_LOG=str(log))
    assert done.returncode in (0, 1), done.stderr
    assert not (poisoned / MARK).exists()
    opened = set(log.read_text().split("\n")) - {""} if log.exists() else set()
    assert {name for name in opened if not OWN_FILES.fullmatch(name)} == set()
    assert "matplotlibrc" not in opened


def test_the_workers_of_a_batch_import_nothing_from_the_current_folder(poisoned: Path) -> None:
    done = start(poisoned, "batch", ".", "--no-report", "--json")
    document = json.loads(done.stdout)
    assert [one["error"] for one in document["campaigns"]] == [None]
    assert not (poisoned / MARK).exists()


def test_neither_do_they_with_an_empty_entry_in_pythonpath(poisoned: Path) -> None:
    # What Python itself and the first lines of the process need from there is taken before any line of ours runs.
    for name in set(MODULES) - {"numpy", "scipy", "pandas", "pyarrow", "h5py", "matplotlib"}:
        (poisoned / f"{name}.py").unlink()
    done = start(poisoned, "batch", ".", "--no-report", "--json", PYTHONPATH=os.pathsep.join((str(ROOT), "")))
    assert not (poisoned / MARK).exists(), done.stderr
    assert [one["error"] for one in json.loads(done.stdout)["campaigns"]] == [None]


def test_python_m_stiffcal_imports_nothing_further_from_the_current_folder(poisoned: Path) -> None:
    for name in MODULES:  # what Python itself loads to find `stiffcal`, before any line of ours runs
        if name not in ("numpy", "pyarrow", "pandas", "evil", "random", "matplotlib", "scipy"):
            (poisoned / f"{name}.py").unlink()
    done = subprocess.run(
        [sys.executable, "-m", "stiffcal", "check", "--json"],
        cwd=poisoned, env=environment(), capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert not (poisoned / MARK).exists()


def test_python_with_p_imports_nothing_at_all(poisoned: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-P", "-m", "stiffcal", "check", "--json"],
        cwd=poisoned, env=environment(), capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert not (poisoned / MARK).exists()


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes in the file system here")
def test_settings_of_matplotlib_in_the_current_folder_are_not_even_opened(poisoned: Path) -> None:
    (poisoned / "matplotlibrc").unlink()
    os.mkfifo(poisoned / "matplotlibrc")
    code = (
        "from stiffcal.report.drawing_library import drawing_library as d; import os; f = os.path.exists; m = d();"
        "print(m.matplotlib_fname.__name__, os.path.exists is f, m.rcParams['figure.hooks'])"
    )
    done = subprocess.run(
        [sys.executable, "-P", "-c", code],
        cwd=poisoned, env=environment(), capture_output=True, text=True, timeout=30, check=True,
    )  # fmt: skip
    assert done.stdout.split() == ["matplotlib_fname", "True", "[]"]


def test_the_users_own_settings_of_matplotlib_are_read(tmp_path: Path) -> None:
    (tmp_path / "mine").write_text("figure.dpi: 33\n")
    code = "from stiffcal.report.drawing_library import drawing_library as d; print(d().rcParams['figure.dpi'])"
    done = subprocess.run(
        [sys.executable, "-P", "-c", code],
        cwd=tmp_path, env=environment(MATPLOTLIBRC=str(tmp_path / "mine")), capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert done.stdout.strip() == "33.0"


def test_no_module_of_the_report_loads_matplotlib_by_itself() -> None:
    guarded = {"report/drawing_library.py"}
    for file in (ROOT / "stiffcal").rglob("*.py"):
        name = file.relative_to(ROOT / "stiffcal").as_posix()
        loads = re.search(r"^\s*import matplotlib\b(?!\.)", file.read_text(encoding="utf-8"), re.MULTILINE)
        assert loads is None or name in guarded, name


def test_makefile_and_documents_start_stiffcal_with_p() -> None:
    files = [ROOT / "Makefile", ROOT / "README.md", ROOT / ".ci" / "run", *(ROOT / "docs").rglob("*.md")]
    files += [*(ROOT / "campaigns").rglob("*.md"), *(ROOT / ".github").rglob("*.y*ml")]
    for file in files:
        for line in file.read_text(encoding="utf-8").splitlines():
            assert not re.search(r"python\S*\s+(?!-P\b)(-\w+\s+)*-m\s+stiffcal\b", line), f"{file.name}: {line}"


class TestModulePath:
    def test_the_current_folder_is_left_out_and_the_package_is_still_found(self) -> None:
        packages = str(Path(stiffcal.__file__).parents[1].resolve())
        assert without_current_folder(["", "/usr/lib"]) == ["/usr/lib", packages]
        assert without_current_folder(["/usr/lib", packages]) == ["/usr/lib", packages]

    def test_an_empty_entry_of_pythonpath_is_not_passed_on(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setenv("PYTHONPATH", os.pathsep.join(("", "/lab/modules", "")))
        assert child_environment()["PYTHONPATH"] == "/lab/modules"
        assert child_environment()["PYTHONSAFEPATH"] == "1"
        monkeypatch.setenv("PYTHONPATH", os.pathsep)
        assert "PYTHONPATH" not in child_environment()

    def test_a_folder_that_the_user_names_stays(self, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
        monkeypatch.chdir(tmp_path)
        monkeypatch.setenv("PYTHONPATH", os.pathsep.join(("", str(tmp_path))))
        monkeypatch.setattr(sys, "path", [str(tmp_path), "/usr/lib"])
        leave_out_current_folder()
        assert str(tmp_path) in sys.path
        monkeypatch.setenv("PYTHONPATH", os.pathsep.join(("", "/lab")))
        leave_out_current_folder()
        assert str(tmp_path) not in sys.path

    def test_a_deleted_current_folder_is_no_fault(self, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
        (tmp_path / "gone").mkdir()
        monkeypatch.chdir(tmp_path / "gone")
        monkeypatch.setenv("PYTHONPATH", os.pathsep)
        monkeypatch.setattr(sys, "path", list(sys.path))
        (tmp_path / "gone").rmdir()
        leave_out_current_folder()
        monkeypatch.chdir(tmp_path)
