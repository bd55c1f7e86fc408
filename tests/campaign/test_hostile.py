"""Whatever a person writes into the files, the answer is a campaign or faults in words; never anything else."""

from __future__ import annotations

import copy
import tempfile
import tomllib
from pathlib import Path
from typing import Any

import pytest
import tomlkit
from hypothesis import given, settings
from hypothesis import strategies as st

from stiffcal.campaign.frames.frames import measurement_setup, resolve_frames
from stiffcal.campaign.loading import load_campaign
from stiffcal.errors import InputError
from tests.laboratory.campaign_folders import DATA, ROBOT, write_campaign

MANIFEST: dict[str, Any] = tomllib.loads((DATA / "everything.toml").read_text(encoding="utf-8"))
ROBOT_FILE: dict[str, Any] = tomllib.loads(ROBOT)
MODEL: dict[str, Any] = tomllib.loads((DATA / "interface_model.toml").read_text(encoding="utf-8"))


def paths(document: Any, here: tuple[int | str, ...] = ()) -> list[tuple[int | str, ...]]:
    found = [here] if here else []
    entries = (
        document.items() if isinstance(document, dict) else enumerate(document) if isinstance(document, list) else ()
    )
    for key, value in entries:
        found += paths(value, (*here, key))
    return found


SCALARS = st.one_of(
    st.none().map(lambda _: "remove"),
    st.booleans(),
    st.integers(-3, 10**6),
    st.floats(allow_nan=True, allow_infinity=True),
    st.sampled_from(
        ["", "base", "A1..A6", "A6..A1", "../x", "raw/x.csv", "mm", "tracker", "swing", "Größe [mm]", "all"]
    ),
)
VALUES = st.one_of(
    SCALARS,
    st.lists(SCALARS.filter(lambda value: value != "remove"), max_size=4),
    st.dictionaries(st.sampled_from(["xyz_m", "parent", "columns", "id", "odd"]), st.integers(), max_size=2),
)


@st.composite
def broken(draw: st.DrawFn, document: dict[str, Any]) -> dict[str, Any]:
    changed = copy.deepcopy(document)
    for _ in range(draw(st.integers(1, 3))):
        *outer, last = draw(st.sampled_from(paths(changed)))
        here: Any = changed
        for part in outer:
            here = here[part]
        value = draw(VALUES)
        if value == "remove":
            del here[last]
        else:
            here[last] = value
        if not changed:
            break
    return changed


@settings(max_examples=50)
@given(
    manifest=st.one_of(st.just(MANIFEST), broken(MANIFEST)),
    robot=st.one_of(st.just(ROBOT_FILE), broken(ROBOT_FILE)),
    model=st.one_of(st.just(MODEL), broken(MODEL)),
)
def test_a_campaign_or_faults(manifest: dict[str, Any], robot: dict[str, Any], model: dict[str, Any]) -> None:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file, document in (("campaign.toml", manifest), ("robot.toml", robot), ("model.toml", model)):
            (folder / file).write_text(tomlkit.dumps(document), encoding="utf-8")
        try:
            campaign = load_campaign(folder, check_files=False)
            measurement_setup(campaign.manifest, campaign.chain, resolve_frames(campaign.manifest, campaign.chain))
        except InputError as error:
            for fault in error.faults:
                assert fault.reason, fault
                assert fault.mend, fault
                assert "\n" not in str(fault)
                assert "pydantic" not in str(fault)


def test_a_marker_without_a_place_is_one_line(tmp_path: Path) -> None:
    """The mend can be pasted, as every one that a test of ours prints."""
    folder = write_campaign(tmp_path / "c")
    manifest = (DATA / "everything.toml").read_text(encoding="utf-8")
    at_m = ", at_m = [0.1, 0, 0]"
    assert at_m in manifest
    (folder / "campaign.toml").write_text(manifest.replace(at_m, ""), encoding="utf-8")
    with pytest.raises(InputError, match=r"at_m = \[0.0, 0.05, 0.1\]") as refused:
        load_campaign(folder, check_files=False)
    assert [fault.place for fault in refused.value.faults if "at_m" in fault.mend] == [
        "sources.k600.poses.target.markers.m2"
    ]


def test_a_file_whose_name_holds_a_nul_is_one_line(tmp_path: Path) -> None:
    folder = write_campaign(tmp_path / "c")
    text = (folder / "campaign.toml").read_text(encoding="utf-8")
    (folder / "campaign.toml").write_text(text.replace('"robot.toml"', '"raw/\\u0000"'), encoding="utf-8")
    with pytest.raises(InputError, match=r"contains U\+0000"):
        load_campaign(folder)
