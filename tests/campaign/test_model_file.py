"""model.toml: read, edited with the user's comments kept."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from stiffcal.campaign.model import model_editing
from stiffcal.campaign.model.model_file import default_model, load_model
from stiffcal.errors import InputError
from tests.laboratory.campaign_folders import DATA

MODEL = """# our robot, since the service of May
schema = "stiffcal/model/1"
balance = "deformed"

# every drive
[[effects]]
type = "joint-compliance"
joints = [1, 2, 3, 4, 5, 6]   # all six

# seen on the bench
[[effects]]
type = "backlash"
joints = [4]
parameters = { "backlash.j4.width" = { value = 1.0e-3, fixed = true } }

# couplings of the wrist
[[effects]]
type = "axis-coupling"
pairs = ["5-6"]
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "model.toml").write_text(MODEL, encoding="utf-8")
    return tmp_path


def text(folder: Path) -> str:
    return (folder / "model.toml").read_text(encoding="utf-8")


def test_interface_example(tmp_path: Path) -> None:
    (tmp_path / "model.toml").write_text((DATA / "interface_model.toml").read_text(encoding="utf-8"), encoding="utf-8")
    model = load_model(tmp_path, 6)
    assert [(entry.type, entry.places) for entry in model.effects] == [
        ("joint-compliance", ("j1", "j2", "j3", "j4", "j5", "j6")),
        ("backlash", ("j4",)),
    ]


def add_effect(folder: Path, effect: str, *, n_joints: int, **places: Any) -> tuple[str, ...]:
    edited, new = model_editing.add_effect(
        model_editing.editable_text(folder, n_joints), effect, **places, n_joints=n_joints
    )
    model_editing.save_model(folder, edited)
    return new


def remove_effect(folder: Path, effect: str, *, n_joints: int, **places: Any) -> tuple[str, ...]:
    edited, removed = model_editing.remove_effect(
        model_editing.editable_text(folder, n_joints), effect, **places, n_joints=n_joints
    )
    model_editing.save_model(folder, edited)
    return removed


def test_places_and_parameters(folder: Path) -> None:
    model = load_model(folder, 6)
    assert model.effects[2].pairs == ((5, 6),)
    assert model.effects[2].places == ("j5-j6",)
    assert model.parameter_settings()["backlash.j4.width"].fixed
    assert model.balance == "deformed"


def test_default_model_has_all_joints() -> None:
    assert default_model(7).effects[0].joints == (1, 2, 3, 4, 5, 6, 7)


def test_add_to_nothing_starts_from_the_default(tmp_path: Path) -> None:
    assert add_effect(tmp_path, "backlash", joints=[4], n_joints=6) == ("j4",)
    model = load_model(tmp_path, 6)
    assert [entry.type for entry in model.effects] == ["joint-compliance", "backlash"]
    assert model.effects[0].joints == (1, 2, 3, 4, 5, 6)


def test_add_keeps_comments_and_extends(folder: Path) -> None:
    assert add_effect(folder, "backlash", joints=[4, 5], n_joints=6) == ("j5",)
    assert add_effect(folder, "link-beam", links=["swing"], n_joints=6) == ("swing",)
    assert add_effect(folder, "axis-coupling", pairs=[(4, 5)], n_joints=6) == ("j4-j5",)
    assert add_effect(folder, "thermal-drift", n_joints=6) == ("setup",)
    assert add_effect(folder, "thermal-drift", n_joints=6) == ()
    model = load_model(folder, 6)
    assert [(entry.type, entry.places) for entry in model.effects] == [
        ("joint-compliance", ("j1", "j2", "j3", "j4", "j5", "j6")),
        ("backlash", ("j4", "j5")),
        ("axis-coupling", ("j5-j6", "j4-j5")),
        ("link-beam", ("swing",)),
        ("thermal-drift", ("setup",)),
    ]
    for line in MODEL.splitlines():
        if line.startswith("#"):
            assert line in text(folder).splitlines()
    assert "# all six" in text(folder)
    assert '\n\n[[effects]]\ntype = "thermal-drift"' in text(folder)


def test_remove_places_and_whole_effects(folder: Path) -> None:
    assert remove_effect(folder, "joint-compliance", joints=[6], n_joints=6) == ("j6",)
    assert remove_effect(folder, "backlash", n_joints=6) == ("j4",)
    assert remove_effect(folder, "axis-coupling", pairs=[(5, 6)], n_joints=6) == ("j5-j6",)
    model = load_model(folder, 6)
    assert [(entry.type, entry.joints) for entry in model.effects] == [("joint-compliance", (1, 2, 3, 4, 5))]
    for comment in ("# our robot", "# every drive", "# all six", "# seen on the bench", "# couplings of the wrist"):
        assert comment in text(folder)
    assert remove_effect(folder, "joint-compliance", n_joints=6) == ("j1", "j2", "j3", "j4", "j5")
    assert load_model(folder, 6).effects == ()
    assert add_effect(folder, "joint-compliance", joints=[1], n_joints=6) == ("j1",)


def test_add_then_remove_gives_the_file_back(folder: Path) -> None:
    add_effect(folder, "creep", joints=[2], n_joints=6)
    remove_effect(folder, "creep", n_joints=6)
    assert text(folder).strip() == MODEL.strip()


def test_joints_all_and_inline_effects(tmp_path: Path) -> None:
    (tmp_path / "model.toml").write_text(
        'schema = "stiffcal/model/1"\neffects = [{ type = "joint-compliance", joints = "all" }] # short\n'
    )
    assert add_effect(tmp_path, "joint-compliance", joints=[3], n_joints=6) == ()
    assert add_effect(tmp_path, "backlash", joints=[3], n_joints=6) == ("j3",)
    assert remove_effect(tmp_path, "joint-compliance", joints=[1], n_joints=6) == ("j1",)
    model = load_model(tmp_path, 6)
    assert [entry.joints for entry in model.effects] == [(2, 3, 4, 5, 6), (3,)]


def test_removing_what_is_not_there(folder: Path) -> None:
    for arguments in ({}, {"joints": [5]}):
        keywords: dict[str, Any] = arguments
        with pytest.raises(InputError, match="the model contains no "):
            remove_effect(folder, "backlash" if keywords else "creep", **keywords, n_joints=6)
    assert text(folder) == MODEL


def test_a_faulty_file_is_not_touched(folder: Path) -> None:
    (folder / "model.toml").write_text(MODEL.replace("balance", "balanse"), encoding="utf-8")
    before = text(folder)
    with pytest.raises(InputError, match='did you mean "balance"'):
        add_effect(folder, "creep", joints=[1], n_joints=6)
    assert text(folder) == before


@pytest.mark.parametrize("pairs", ['["5-5"]', '["a-b"]', "[[5]]", "[[0, 1]]"])
def test_wrong_pairs(tmp_path: Path, pairs: str) -> None:
    (tmp_path / "model.toml").write_text(
        f'schema = "stiffcal/model/1"\n[[effects]]\ntype = "axis-coupling"\npairs = {pairs}\n'
    )
    with pytest.raises(InputError, match="is not a pair of joints"):
        load_model(tmp_path, 6)
