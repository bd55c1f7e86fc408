"""A campaign reads and writes inside its folder and where its user said, nowhere else."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest

from stiffcal.campaign.loading import load_campaign
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.readers import WantedColumns, find_reader
from stiffcal.store import Store
from tests.laboratory.campaign_folders import DATA, MANIFEST, ROBOT, changed, write_campaign
from tests.readers.test_mat import write73

URDF = 'schema = "stiffcal/robot/1"\nurdf = "{}"\n'


def _linked(name: str) -> Callable[[Path, Path], None]:
    """Put a link to a file outside in a file's place."""

    def act(folder: Path, outside: Path) -> None:
        goal = outside / Path(name).name
        (folder / name).rename(goal)
        (folder / name).symlink_to(goal)

    return act


def _raw_linked(folder: Path, outside: Path) -> None:
    (folder / "raw").rename(outside / "raw")
    (folder / "raw").symlink_to(outside / "raw")


def _urdf_linked(folder: Path, outside: Path) -> None:
    (outside / "six.urdf").write_bytes((DATA / "six.urdf").read_bytes())
    (folder / "six.urdf").symlink_to(outside / "six.urdf")
    (folder / "robot.toml").write_text(URDF.format("six.urdf"))


def _store_linked(folder: Path, outside: Path) -> None:
    (folder / "store").symlink_to(outside)


def _generations_linked(folder: Path, outside: Path) -> None:
    (folder / "store").mkdir()
    (folder / "store" / "generations").symlink_to(outside)


def _bag_linked(folder: Path, outside: Path) -> None:
    (folder / "raw" / "table.csv").unlink()
    (folder / "raw" / "table.csv").mkdir()
    (outside / "log.db3").write_text("")
    (folder / "raw" / "table.csv" / "log.db3").symlink_to(outside / "log.db3")


def _model_linked(folder: Path, outside: Path) -> None:
    (outside / "model.toml").write_text('schema = "stiffcal/model/1"\n')
    (folder / "model.toml").symlink_to(outside / "model.toml")


LINKS: dict[str, tuple[Callable[[Path, Path], None], str]] = {
    "a log": (_linked("raw/table.csv"), "raw/table.csv"),
    "the folder of logs": (_raw_linked, "raw/table.csv"),
    "the robot file": (_linked("robot.toml"), "robot.toml"),
    "the URDF": (_urdf_linked, "six.urdf"),
    "the model file": (_model_linked, "model.toml"),
    "the store": (_store_linked, "store"),
    "the store's generations": (_generations_linked, "store/generations"),
    "a file in a bag": (_bag_linked, "raw/table.csv/log.db3"),
    "the manifest": (_linked("campaign.toml"), "campaign.toml"),
}


@pytest.fixture
def outside(tmp_path: Path) -> Path:
    place = tmp_path / "outside"
    place.mkdir()
    return place


@pytest.mark.parametrize("what", LINKS)
def test_a_link_that_leads_out_is_refused_unless_allowed(
    what: str, tmp_path: Path, outside: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = write_campaign(tmp_path / "c")
    spoil, name = LINKS[what]
    spoil(folder, outside)
    with pytest.raises(InputError, match="outside the campaign folder") as raised:
        load_campaign(folder, check_files=False)
    assert f'"{name}" is a link to {outside}' in str(raised.value)
    assert "STIFFCAL_ALLOW" in str(raised.value)
    monkeypatch.setenv("STIFFCAL_ALLOW", f"/nowhere:{outside}")
    load_campaign(folder, check_files=False)


def test_a_store_that_points_elsewhere_is_damaged(tmp_path: Path, outside: Path) -> None:
    theirs = Store(outside)
    theirs.commit({}, {"ingest": {"secret": 1}})
    (tmp_path / "store").mkdir()
    (tmp_path / "store" / "current.id").write_text(f"../../outside/generations/{theirs.generation}")
    with pytest.raises(InputError):
        Store(tmp_path / "store").read_document("ingest")


def test_links_inside_and_a_linked_campaign_folder_are_fine(tmp_path: Path) -> None:
    folder = write_campaign(tmp_path / "c")
    (folder / "raw/table.csv").rename(folder / "kept.csv")
    (folder / "raw/table.csv").symlink_to("../kept.csv")
    (tmp_path / "there").symlink_to(folder)
    load_campaign(tmp_path / "there")


@pytest.mark.parametrize("path", ["../x", "/etc/passwd", "raw/../../x", "C:/x", "\\\\host\\x", "raw\\..\\..\\x"])
def test_no_path_leads_out(path: str, tmp_path: Path) -> None:
    quoted = path.replace("\\", "\\\\")
    folder = write_campaign(tmp_path / "c", changed(MANIFEST, ('"robot.toml"', f'"{quoted}"')))
    for manifest, robot in (
        (changed(MANIFEST, ('"robot.toml"', f'"{quoted}"')), ROBOT),
        (changed(MANIFEST, ('robot = "robot.toml"', f'robot = "robot.toml"\nplugins = ["{quoted}"]')), ROBOT),
        (MANIFEST, URDF.format(quoted)),
    ):
        (folder / "campaign.toml").write_text(manifest)
        (folder / "robot.toml").write_text(robot)
        with pytest.raises(InputError, match="outside the campaign folder"):
            load_campaign(folder, check_files=False)


def _external(path: Path, secret: Path) -> str:
    with h5py.File(path, "w") as file:
        file["t"] = np.arange(5.0)
        file["Fx"] = h5py.ExternalLink(str(secret), "/Fx")
    return "Fx"


def _virtual(path: Path, secret: Path) -> str:
    layout = h5py.VirtualLayout((5,), "f8")
    layout[:] = h5py.VirtualSource(str(secret), "Fx", (5,))
    with h5py.File(path, "w") as file:
        file["t"] = np.arange(5.0)
        file.create_virtual_dataset("Fx", layout)
    return "Fx"


def _raw_bytes(path: Path, secret: Path) -> str:
    with h5py.File(path, "w") as file:
        file["t"] = np.arange(5.0)
        file.create_dataset("Fx", (5,), "f8", external=[(str(secret), 0, 40)])
    return "Fx"


@pytest.mark.parametrize("make", [_external, _virtual, _raw_bytes])
def test_an_hdf5_file_does_not_lead_to_others(make: Callable[[Path, Path], str], tmp_path: Path) -> None:
    with h5py.File(tmp_path / "secret.h5", "w") as file:
        file["Fx"] = np.arange(5.0)
    name = make(tmp_path / "log.h5", tmp_path / "secret.h5")
    reader = find_reader(tmp_path / "log.h5")
    for wanted in (("t", name), ("t",)):  # the whole file is refused, whatever is asked of it
        with pytest.raises(InputError) as raised:
            list(reader.read_batches(tmp_path / "log.h5", {}, WantedColumns(wanted), "raw/log.h5"))
        assert raised.value.code is FaultCode.FILE_OUTSIDE


def test_a_whole_group_elsewhere_is_refused(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "secret.h5", "w") as file:
        file["g/Fx"] = np.arange(5.0)
    with h5py.File(tmp_path / "log.h5", "w") as file:
        file["log"] = h5py.ExternalLink(str(tmp_path / "secret.h5"), "/g")
    reader = find_reader(tmp_path / "log.h5")
    with pytest.raises(InputError, match="is in another file"):
        list(reader.read_batches(tmp_path / "log.h5", {"group": "/log"}, WantedColumns(("Fx",)), "raw/log.h5"))


def test_a_mat_file_does_not_lead_to_others(tmp_path: Path) -> None:
    path = write73(tmp_path / "log.mat", {"t": np.arange(5.0)})
    write73(tmp_path / "secret.mat", {"Fx": np.arange(5.0)})
    with h5py.File(path, "r+") as file:
        file["Fx"] = h5py.ExternalLink(str(tmp_path / "secret.mat"), "/Fx")
    with pytest.raises(InputError) as raised:
        list(find_reader(path).read_batches(path, {}, WantedColumns(("t", "Fx")), "raw/log.mat"))
    assert raised.value.code is FaultCode.FILE_OUTSIDE


def test_an_entity_of_a_urdf_is_no_file(tmp_path: Path, outside: Path) -> None:
    (outside / "name").write_text("stolen")
    folder = write_campaign(tmp_path / "c", robot=URDF.format("six.urdf"))
    text = (DATA / "six.urdf").read_text()
    head = f'<?xml version="1.0"?><!DOCTYPE robot [<!ENTITY x SYSTEM "file://{outside}/name">]>'
    body = text[text.index("<robot") :].replace("<robot name=", "<robot alias='&x;' name=", 1)
    (folder / "six.urdf").write_text(head + body)
    with pytest.raises(InputError, match="six.urdf"):
        load_campaign(folder, check_files=False)
