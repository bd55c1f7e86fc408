"""`stiffcal doctor`: every library that the package asks for, and the command for each that is missing."""

from __future__ import annotations

import json
import tomllib
from importlib import metadata
from pathlib import Path

import pytest

from stiffcal.cli.app import main
from stiffcal.commands import doctor

ROOT = Path(__file__).parents[2]


def project() -> dict[str, object]:
    table: dict[str, object] = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return table


def answer(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[str, object]:
    with pytest.raises(SystemExit) as end:
        main(["doctor", *words])
    return capsys.readouterr().out, end.value.code


def without(monkeypatch: pytest.MonkeyPatch, missing: str) -> None:
    installed = metadata.version

    def version(name: str) -> str:
        if name == missing:
            raise metadata.PackageNotFoundError(name)
        return installed(name)

    monkeypatch.setattr(metadata, "version", version)


def test_a_clone_that_is_not_installed_is_a_warning(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def requires(name: str) -> list[str]:
        raise metadata.PackageNotFoundError(name)

    monkeypatch.setattr(metadata, "requires", requires)
    out, code = answer(capsys, "--json")
    assert code == 0
    assert len(json.loads(out)["warnings"]) == 1


def test_each_extra_has_a_purpose() -> None:
    extras = project()["optional-dependencies"]
    assert isinstance(extras, dict)
    assert set(doctor.PURPOSES) == set(extras)


def test_each_requirement_is_listed_with_its_version(capsys: pytest.CaptureFixture[str]) -> None:
    text, code = answer(capsys, "--json")
    libraries = json.loads(text)["libraries"]
    needed = project()["dependencies"]
    assert isinstance(needed, list)
    assert code == 0
    assert len([library for library in libraries if not library["extra"]]) == len(needed)
    versions = {library["name"]: library["version"] for library in libraries}
    assert versions["numpy"] == metadata.version("numpy")


def test_a_missing_library_of_an_extra_comes_with_its_command(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    without(monkeypatch, "npTDMS")
    text, code = answer(capsys)
    assert 'npTDMS: python -m pip install "npTDMS' in text
    assert code == 0


def test_a_missing_library_that_everything_needs_is_exit_code_1(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    without(monkeypatch, "typst")
    text, code = answer(capsys)
    assert 'typst: python -m pip install "typst' in text
    assert "next:" not in text
    assert code == 1


def test_a_state_folder_that_cannot_be_used_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "campaign.toml").touch()
    (tmp_path / "state").mkdir()
    monkeypatch.setenv("STIFFCAL_STATE", str(tmp_path / "state"))
    assert json.loads(answer(capsys, "--json")[0])["state_fault"]
