"""Links that lead out of a campaign folder: refused, and no advice opens what a stranger's link points to."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.errors import InputError
from tests.laboratory.campaign_folders import write_campaign

pytestmark = pytest.mark.skipif(os.name != "posix", reason="links need rights of their own on Windows")


@pytest.fixture
def home(tmp_path: Path) -> Path:
    place = tmp_path / "home" / ".ssh"
    place.mkdir(parents=True)
    (place / "id_rsa").write_text("PRIVATE")
    return place


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return write_campaign(tmp_path / "cell")


def refused(folder: Path) -> InputError:
    with pytest.raises(InputError) as raised:
        load_campaign(folder, check_files=False)
    return raised.value


def _to_file(folder: Path, goal: Path) -> None:
    (folder / "raw/table.csv").unlink()
    (folder / "raw/table.csv").symlink_to(goal / "id_rsa")


def _by_way_of_another(folder: Path, goal: Path) -> None:
    (folder / "a").symlink_to(goal)
    (folder / "raw/table.csv").unlink()
    (folder / "raw/table.csv").symlink_to("../a/id_rsa")


def _relative(folder: Path, goal: Path) -> None:
    (folder / "raw/table.csv").unlink()
    (folder / "raw/table.csv").symlink_to("../../home/.ssh/id_rsa")


def _to_folder(folder: Path, goal: Path) -> None:
    (folder / "raw/table.csv").unlink()
    (folder / "raw").rmdir()
    (folder / "raw").symlink_to(goal)


def _model(folder: Path, goal: Path) -> None:
    (folder / "model.toml").unlink(missing_ok=True)
    (folder / "model.toml").symlink_to(goal / "id_rsa")


@pytest.mark.parametrize("make", [_to_file, _by_way_of_another, _relative, _to_folder, _model])
def test_the_advice_names_no_place_to_allow_and_nothing_to_copy(
    folder: Path, home: Path, make: Callable[[Path, Path], None]
) -> None:
    make(folder, home)
    for fault in refused(folder).faults:
        assert "outside the campaign folder" in fault.reason
        assert str(home) in fault.reason  # what the link points to stands there
        assert "home" not in fault.mend
        assert ".ssh" not in fault.mend
        assert "copy" not in fault.mend
        assert "only if you made this link yourself" in fault.mend


@pytest.mark.parametrize("entry", [".", "..", "raw", "../home", "~", "home/.ssh"])
def test_a_relative_place_is_refused(folder: Path, home: Path, entry: str, monkeypatch: pytest.MonkeyPatch) -> None:
    _to_file(folder, home)
    monkeypatch.chdir(home)
    monkeypatch.setenv("STIFFCAL_ALLOW", entry)
    assert (f"STIFFCAL_ALLOW: {entry!r} is a relative path, which depends on where stiffcal is started") in str(
        refused(folder)
    )


@pytest.mark.parametrize("entry", ["/", "//", "/home/..", "/.", "/../.."])
def test_the_root_of_everything_is_refused(
    folder: Path, home: Path, entry: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    _to_file(folder, home)
    monkeypatch.setenv("STIFFCAL_ALLOW", entry)
    assert "would allow every file" in str(refused(folder))


@pytest.mark.parametrize("allowed", ["", ":", "::", "/nowhere", "/nowhere:"])
def test_nothing_is_allowed_by_an_empty_entry(
    folder: Path, home: Path, allowed: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    _to_file(folder, home)
    monkeypatch.chdir(home)
    monkeypatch.setenv("STIFFCAL_ALLOW", allowed)
    assert "outside the campaign folder" in str(refused(folder))


def test_a_place_with_the_same_beginning_is_another(folder: Path, home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    _to_file(folder, home)
    monkeypatch.setenv("STIFFCAL_ALLOW", str(home)[:-1])
    assert "outside the campaign folder" in str(refused(folder))


def test_a_place_inside_the_campaign_does_not_follow_the_links_there(
    folder: Path, home: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _to_folder(folder, home)
    for entry in (folder / "raw", folder, folder / "x" / ".." / "raw"):
        monkeypatch.setenv("STIFFCAL_ALLOW", str(entry))
        assert "outside the campaign folder" in str(refused(folder))


def test_what_the_user_allows_is_read(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    logs = tmp_path / "logs"
    (folder / "raw").rename(logs)
    (folder / "raw").symlink_to(logs)
    monkeypatch.setenv("STIFFCAL_ALLOW", f"/nowhere{os.pathsep}{logs}")
    assert load_campaign(folder).folder == folder


def test_a_wrong_place_disturbs_no_campaign_without_links(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("STIFFCAL_ALLOW", "logs:/")
    assert load_campaign(folder).folder == folder


@pytest.mark.parametrize("name", ["campaign.toml", "model.toml", "simulate.toml", "robot.toml"])
def test_nothing_of_what_a_link_points_to_is_read_and_so_nothing_shown(folder: Path, home: Path, name: str) -> None:
    from stiffcal.simulation.settings import load_settings

    (home / "id_rsa").write_text('schema = "x"\npassword_geheim = "geheim"\n')
    (folder / name).unlink(missing_ok=True)
    (folder / name).symlink_to(home / "id_rsa")
    with pytest.raises(InputError) as raised:
        load_settings(folder) if name == "simulate.toml" else load_campaign(folder, check_files=False)
    assert "geheim" not in str(raised.value)
    assert any(f'"{name}" is a link to' in fault.reason for fault in raised.value.faults)


@pytest.mark.parametrize("goal", ["gone.toml", "model.toml"])
def test_a_model_that_is_a_link_to_nothing_is_not_taken_for_none(folder: Path, goal: str) -> None:
    """The default model would stand in for it, and nothing would say so."""
    (folder / "model.toml").unlink(missing_ok=True)
    (folder / "model.toml").symlink_to(goal)
    fault = refused(folder).faults[0]
    assert fault.file == "model.toml"
    assert "leads to no file" in fault.reason
