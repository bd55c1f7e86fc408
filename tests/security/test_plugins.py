"""Code of a campaign runs only when its user has allowed exactly this code, and sees nothing that is not listed."""

from __future__ import annotations

import json
import shutil
import sys
from pathlib import Path
from typing import Any

import pytest

from stiffcal.batch.task import run_task
from stiffcal.campaign.loading import load_campaign
from stiffcal.cli.app import main
from stiffcal.commands.diagnose import diagnose_campaign
from stiffcal.errors import InputError
from stiffcal.model.catalogue.campaign_effects import all_effects, key_of_plugins, model_effects, plugin_code
from stiffcal.results.batch_results import BatchTask
from stiffcal.trust.record import open_record
from tests.laboratory.few_effects import few_effects
from tests.laboratory.plugin_campaigns import MARK, NAME, list_plugins, ran, stranger, write_plugin


@pytest.fixture
def folder(state: Path, tmp_path: Path) -> Path:
    """A stranger's campaign whose model needs its code; nothing of it is trusted."""
    return stranger(tmp_path / "stranger")


def run(capsys: pytest.CaptureFixture[str], *words: str | Path) -> tuple[int, str, str]:
    """Run a command in this process; return exit code, standard output and standard error."""
    with pytest.raises(SystemExit) as end:
        main([str(word) for word in words])
    assert isinstance(end.value.code, int)
    shown = capsys.readouterr()
    return end.value.code, shown.out, shown.err


def document(capsys: pytest.CaptureFixture[str], *words: str | Path) -> tuple[int, dict[str, Any]]:
    code, out, _ = run(capsys, *words, "--json")
    return code, json.loads(out)


def digest_of(folder: Path) -> str:
    return plugin_code(load_campaign(folder)).digest


def runs(folder: Path) -> bool:
    """Whether the model's effects can be had now, and the plugin has run for it."""
    ran(folder)
    campaign = load_campaign(folder)
    if plugin_code(campaign).allowed():
        return "cross-stiffness" in model_effects(campaign)
    with pytest.raises(InputError, match="contains code and is not trusted"):
        model_effects(campaign)
    assert not ran(folder)
    return False


COMMANDS = (
    ["identify"],
    ["validate"],
    ["diagnose"],
    ["improve", "--yes"],
    ["run"],
    ["report"],
    ["plot", "-o", "{}/p.svg"],
    ["predict", "--load-path", "0,0,0;0,0,-100", "--at", "0,-70,20,0,30,0"],
    ["map", "--load", "0,0,-500", "--plane", "xz", "--at", "0"],
    ["export", "-o", "{}/model.json"],
    ["add", "cross-stiffness", "--joints", "3"],
)


@pytest.mark.parametrize("words", COMMANDS, ids=lambda words: str(words[0]))
def test_without_trust_no_command_runs_code_that_the_model_needs(
    folder: Path, capsys: pytest.CaptureFixture[str], words: list[str]
) -> None:
    name, *further = (word.format(folder) for word in words)
    code, _, error = run(capsys, name, folder, *further)
    assert code == 2
    (line,) = (line for line in error.splitlines() if "trusted" in line)
    reason = f"contains code and is not trusted (SHA-256 {digest_of(folder)})"
    assert line == f"campaign.toml: plugins: {reason}; read it and allow it: stiffcal trust {folder} [plugin-untrusted]"
    assert not ran(folder)


def test_without_trust_a_simulation_does_not_run_it(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, _, error = run(capsys, "simulate", folder.parent / "out", "--from", folder)
    assert code == 2, error
    assert not ran(folder)


def test_commands_that_do_not_need_the_code_go_on_without_it(
    state: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = stranger(tmp_path / "stranger", needed=False)
    for words in (["check"], ["identify"], ["history"]):
        code, _, error = run(capsys, words[0], folder, *words[1:])
        assert code == 0, error
        assert "trust" not in error
    assert not ran(folder)


def test_a_diagnosis_lists_effects_of_code_that_is_not_trusted_as_not_tried_and_has_them_when_it_is(
    state: Path, tmp_path: Path
) -> None:
    folder = stranger(tmp_path / "stranger", needed=False)
    with few_effects():
        entries = {entry.effect: entry.needs for entry in diagnose_campaign(folder).not_tried}
    needs = f"this campaign's code, which is not trusted (SHA-256 {digest_of(folder)}); to allow it: stiffcal trust "
    assert entries["cross-stiffness"] == f"{needs}{folder}"
    assert not ran(folder)
    before = key_of_plugins(load_campaign(folder))
    open_record().allow_plugin(digest_of(folder), "")
    campaign = load_campaign(folder)
    effects, left_out = all_effects(campaign)
    assert "cross-stiffness" in effects
    assert left_out == []
    assert ran(folder)
    assert key_of_plugins(campaign) != before  # the stored diagnosis is stale


def test_code_whose_files_cannot_be_used_does_not_stop_a_diagnosis_that_can_do_without(
    state: Path, tmp_path: Path
) -> None:
    folder = stranger(tmp_path / "stranger", needed=False)
    shutil.copy(folder / NAME, folder / "json.py")
    list_plugins(folder, "json.py")
    _, left_out = all_effects(load_campaign(folder))
    assert "json.py has the name of a module of Python" in left_out[0].needs


def test_in_a_batch_only_that_campaign_is_broken(folder: Path) -> None:
    outcome = run_task(BatchTask(folder=str(folder), campaign="stranger", report=False))
    assert outcome.state == "broken"
    assert outcome.error is not None
    assert "is not trusted" in outcome.error.reason
    assert not ran(folder)


def test_one_changed_byte_a_new_name_a_further_file_or_one_less_needs_trust_anew(folder: Path) -> None:
    open_record().allow_plugin(digest_of(folder), "")
    assert runs(folder)
    text = (folder / NAME).read_text(encoding="utf-8")
    (folder / NAME).write_text(text + " ", encoding="utf-8")
    assert not runs(folder)
    (folder / NAME).write_text(text, encoding="utf-8")
    assert runs(folder)
    (folder / NAME).rename(folder / "renamed.py")
    list_plugins(folder, "renamed.py")
    assert not runs(folder)
    (folder / "renamed.py").rename(folder / NAME)
    (folder / "more.py").write_text("", encoding="utf-8")
    list_plugins(folder, NAME, "more.py")
    assert not runs(folder)
    open_record().allow_plugin(digest_of(folder), "")
    assert runs(folder)
    list_plugins(folder, "more.py", NAME)  # the order does not count
    assert runs(folder)


def test_no_names_and_contents_have_the_hash_of_others(state: Path, tmp_path: Path) -> None:
    folder = stranger(tmp_path / "stranger")
    digests = set()
    for files in ({"a.py": "bc", "d.py": ""}, {"a.py": "b", "d.py": "c"}, {"ab.py": "c", "d.py": ""}, {"a.py": "bc"}):
        for name, text in files.items():
            (folder / name).write_text(text, encoding="utf-8")
        list_plugins(folder, *files)
        digests.add(digest_of(folder))
    assert len(digests) == 4


def test_a_link_that_leads_to_other_code_needs_trust_anew(folder: Path) -> None:
    (folder / NAME).rename(folder / "first.txt")
    (folder / "second.txt").write_text((folder / "first.txt").read_text(encoding="utf-8") + "#", encoding="utf-8")
    (folder / NAME).symlink_to("first.txt")
    open_record().allow_plugin(digest_of(folder), "")
    assert runs(folder)
    (folder / NAME).unlink()
    (folder / NAME).symlink_to("second.txt")
    assert not runs(folder)


def test_the_same_code_elsewhere_is_trusted(folder: Path, tmp_path: Path) -> None:
    open_record().allow_plugin(digest_of(folder), str(folder))
    assert runs(Path(shutil.copytree(folder, tmp_path / "elsewhere" / "copy")))


def test_a_folder_under_development_is_trusted_whatever_changes_in_it_and_no_copy_of_it(
    folder: Path, tmp_path: Path
) -> None:
    open_record().allow_folder(folder)
    assert runs(folder)
    write_plugin(folder, MARK + "# changed\n")
    assert runs(folder)
    assert not runs(Path(shutil.copytree(folder, tmp_path / "copy")))


def test_the_hash_in_the_environment_is_enough(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("STIFFCAL_TRUST", digest_of(folder))
    assert runs(folder)
    write_plugin(folder, MARK + "# changed\n")
    assert not runs(folder)


def test_files_import_each_other_by_name_and_numpy_and_stiffcal(folder: Path) -> None:
    (folder / "shapes_of_cells.py").write_text("from pathlib import Path\nFACTOR = 2.3\n", encoding="utf-8")
    further = "\nimport shapes_of_cells\nfrom shapes_of_cells import FACTOR\nassert shapes_of_cells.FACTOR == FACTOR\n"
    later = "def later():\n    import shapes_of_cells\n    from . import shapes_of_cells as same\nlater()\n"
    write_plugin(folder, MARK + further + later)
    list_plugins(folder, NAME, "shapes_of_cells.py")
    open_record().allow_folder(folder)
    assert runs(folder)
    assert "shapes_of_cells" not in sys.modules


@pytest.mark.parametrize("place", ["campaign", "current", "path"])
def test_a_file_that_is_not_listed_cannot_be_imported(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, place: str
) -> None:
    elsewhere = {"campaign": folder, "current": tmp_path / "current", "path": folder}[place]
    elsewhere.mkdir(exist_ok=True)
    (elsewhere / "not_listed.py").write_text("", encoding="utf-8")
    if place == "current":
        monkeypatch.chdir(elsewhere)
        monkeypatch.syspath_prepend("")
    if place == "path":
        monkeypatch.syspath_prepend(str(folder))
    write_plugin(folder, "\nimport not_listed\n")
    open_record().allow_folder(folder)
    with pytest.raises(InputError, match="No module named 'not_listed'; add its file to plugins too") as error:
        model_effects(load_campaign(folder))
    assert error.value.faults[0].file == NAME
    assert "not_listed" not in sys.modules


def test_two_campaigns_with_files_of_one_name_stay_apart(folder: Path, tmp_path: Path) -> None:
    other = stranger(tmp_path / "other", further="\nCrossStiffness.summary = 'another'\n")
    for campaign in (folder, other):
        open_record().allow_folder(campaign)
    first, second = (model_effects(load_campaign(place))["cross-stiffness"] for place in (folder, other))
    assert (first.summary, second.summary) == ("the joint's compliance follows joint 1's angle", "another")


def test_nothing_compiled_is_written_or_read(folder: Path) -> None:
    (folder / "helper_file.py").write_text("", encoding="utf-8")
    write_plugin(folder, MARK + "\nimport helper_file\n")
    list_plugins(folder, NAME, "helper_file.py")
    open_record().allow_folder(folder)
    assert runs(folder)
    assert not list(folder.rglob("*.pyc"))
    assert not list(folder.rglob("__pycache__"))


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("json.py", "has the name of a module of Python or of an installed package"),
        ("numpy.py", "has the name of a module of Python or of an installed package"),
        ("stiffcal.py", "has the name of a module of Python or of an installed package"),
        ("own.pyc", "is not a Python file"),
        ("own.so", "is not a Python file"),
        ("own-effect.py", "own-effect is not a valid module name"),
        ("own effect.py", "own effect is not a valid module name"),
        ("a.b.py", "a.b is not a valid module name"),
        ("__init__.py", "__init__ is not a valid module name"),
    ],
)
def test_names_that_cannot_be_a_plugins_are_refused(folder: Path, name: str, words: str) -> None:
    (folder / NAME).rename(folder / name)
    list_plugins(folder, name)
    open_record().allow_folder(folder)
    with pytest.raises(InputError, match=words) as error:
        model_effects(load_campaign(folder))
    assert len(error.value.faults) == 1


def test_two_files_of_one_module_name_are_refused(folder: Path) -> None:
    (folder / "below").mkdir()
    shutil.copy(folder / NAME, folder / "below" / NAME)
    list_plugins(folder, NAME, f"below/{NAME}")
    with pytest.raises(InputError, match="two files have the module name cross_stiffness"):
        model_effects(load_campaign(folder))


def test_code_in_another_encoding_than_the_one_it_is_shown_in_is_refused(folder: Path) -> None:
    open_record().allow_folder(folder)
    for content in (b"# coding: utf-7\n+AGkAbQBwAG8AcgB0- os\n", b"# coding: latin-1\nx = '\xe9'\n", b"x = '\xff'\n"):
        (folder / NAME).write_bytes(content)
        with pytest.raises(InputError, match="its encoding is not UTF-8"):
            model_effects(load_campaign(folder))


def test_code_is_limited_in_size(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("STIFFCAL_MAX_PLUGIN", "100 B")
    with pytest.raises(InputError, match="more than 100 B of code; check the file, or raise STIFFCAL_MAX_PLUGIN"):
        model_effects(load_campaign(folder))


@pytest.mark.parametrize(
    ("further", "words"),
    [
        ("raise SystemExit(0)", "line 24: ends the program: SystemExit: 0"),
        ("import sys; sys.exit()", "line 24: ends the program: SystemExit"),
        ("class Own(BaseException): pass\nraise Own('x')", "line 25: ends the program: Own: x"),
        ("1 / 0", "line 24: does not run: ZeroDivisionError: division by zero"),
        ("x = (", "line 24: does not run: SyntaxError: '(' was never closed"),
        ("exec('1 +')", "does not run: SyntaxError"),
        ("class Second(CrossStiffness):\n    def __init__(self): raise SystemExit", "line 25: ends the program"),
        ("CrossStiffness.name = 'backlash'", "this effect exists already"),
    ],
)
def test_whatever_ends_the_code_while_it_is_loaded_is_one_line(folder: Path, further: str, words: str) -> None:
    write_plugin(folder, "\n\n" + further + "\n")
    open_record().allow_folder(folder)
    with pytest.raises(InputError) as error:
        model_effects(load_campaign(folder))
    (fault,) = error.value.faults
    assert str(fault).startswith(f"{NAME}: ")
    assert words in str(fault)


def test_what_the_code_prints_does_not_get_into_the_answer(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_plugin(folder, "\nprint('while it is loaded')\n" + IN_TERMS.format("print('while it is used')"))
    open_record().allow_folder(folder)
    code, out, error = run(capsys, "identify", folder, "--json")
    assert code == 0, error
    assert json.loads(out)["n_states"] > 0
    assert "while it is loaded" in error
    assert "while it is used" in error


IN_TERMS = """
_terms = CrossStiffness.terms
def terms(self, *arguments):
    {}
    return _terms(self, *arguments)
CrossStiffness.terms = terms
"""


@pytest.mark.parametrize("error", ["SystemExit(0)", "EOFError", "BrokenPipeError(32, 'x')", "KeyError('x')"])
def test_an_exception_out_of_an_effect_is_a_fault_of_its_file(
    folder: Path, capsys: pytest.CaptureFixture[str], error: str
) -> None:
    write_plugin(folder, IN_TERMS.format(f"raise {error}"))
    open_record().allow_folder(folder)
    code, document_ = document(capsys, "identify", folder)
    assert code == 2
    assert document_["error"]["file"] == NAME
    assert document_["error"]["place"] == "line 25"
    outcome = run_task(BatchTask(folder=str(folder), campaign="stranger", report=False))
    assert outcome.state == "broken"
    assert outcome.error is not None
    assert outcome.error.file == NAME


def test_removing_the_code_from_the_list_of_effects_changes_no_fit(state: Path, tmp_path: Path) -> None:
    """Code that the model does not need is no part of the fit: with it, changed and without it, nothing is refitted."""
    from stiffcal.stages.steps import RunContext, key_of_fit, up_to_date_states

    folder = stranger(tmp_path / "stranger", needed=False)
    keys = []
    for further in ("", "# changed\n"):
        write_plugin(folder, further)
        keys.append(key_of_fit(up_to_date_states(folder, RunContext()), "linear"))
    assert keys[0] == keys[1]
