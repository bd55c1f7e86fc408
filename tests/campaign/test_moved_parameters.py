"""Model files of version 0.1 that give Stribeck friction as parameters of joint-friction."""

from __future__ import annotations

from pathlib import Path

import pytest

from stiffcal.campaign.model_editing import add_effect, remove_effect
from stiffcal.campaign.model_file import ModelFile, load_model, model_of_text
from stiffcal.errors import InputError
from stiffcal.model.assembly import compliant_robot, fixed_parameters
from stiffcal.model.catalogue import built_in_effects
from tests.laboratory.robots import six_axes

OLD = """# friction of the cell
schema = "stiffcal/model/1"

[[effects]]
type = "joint-friction"
joints = [1, 2, 3]
[effects.parameters]
"joint-friction.j1.coulomb" = { value = 60.0 }     # N·m
"joint-friction.j1.stribeck" = { value = 15.0 }    # N·m
"joint-friction.j1.velocity" = { value = 0.03, fixed = true }
"joint-friction.j1.viscous" = { value = 90.0 }
"joint-friction.j3.exponent" = { value = 2.0, fixed = true }
"joint-friction.j3.stribeck" = { value = 0.0 }

# what gives
[[effects]]
type = "joint-compliance"
joints = "all"
"""


def effects(model: ModelFile) -> list[tuple[str, tuple[str, ...], dict[str, tuple[float, bool]]]]:
    return [
        (entry.type, entry.places, {name: (one.value, one.fixed) for name, one in entry.parameters.items()})
        for entry in model.effects
    ]


def test_it_is_read_as_two_effects() -> None:
    model = model_of_text(OLD, 6)
    first, second, third = effects(model)
    coulomb, viscous = "joint-friction.j1.coulomb", "joint-friction.j1.viscous"
    assert first == ("joint-friction", ("j1", "j2", "j3"), {coulomb: (60.0, False), viscous: (90.0, False)})
    assert second == (
        "stribeck",
        ("j1", "j3"),
        {
            "stribeck.j1.stribeck": (15.0, False),
            "stribeck.j1.velocity": (0.03, True),
            "stribeck.j3.exponent": (2.0, True),
            "stribeck.j3.stribeck": (0.0, False),
        },
    )
    assert third[0] == "joint-compliance"
    assert fixed_parameters(model) == {"stribeck.j1.velocity", "stribeck.j3.exponent"}
    robot = compliant_robot(six_axes(), model, built_in_effects())
    assert robot.placed[3].values["stribeck"] == 15.0


def test_all_joints() -> None:
    model = model_of_text(OLD.replace("[1, 2, 3]", '"all"'), 6)
    assert model.effects[0].joints == (1, 2, 3, 4, 5, 6)
    assert model.effects[1].joints == (1, 3)


def test_both_ways_at_one_joint_are_a_fault() -> None:
    text = OLD + '\n[[effects]]\ntype = "stribeck"\njoints = [1]\n'
    with pytest.raises(InputError, match="is given twice at j1"):
        compliant_robot(six_axes(), model_of_text(text, 6), built_in_effects())


def test_a_symbol_that_never_was_stays_a_fault() -> None:
    text = OLD.replace("j3.exponent", "j3.sharpness")
    with pytest.raises(InputError, match="no such parameter"):
        compliant_robot(six_axes(), model_of_text(text, 6), built_in_effects())


def test_editing_writes_the_new_names(tmp_path: Path) -> None:
    """Comments, order and values stay; the effect can be added to, and taken out."""
    (tmp_path / "model.toml").write_text(OLD, encoding="utf-8")
    before = effects(load_model(tmp_path, 6))
    assert add_effect(tmp_path, "stribeck", joints=[1, 2], n_joints=6) == ("j2",)
    text = (tmp_path / "model.toml").read_text(encoding="utf-8")
    assert "joint-friction.j1.stribeck" not in text
    assert "# friction of the cell" in text
    assert "# what gives" in text
    after = effects(load_model(tmp_path, 6))
    assert [one[0] for one in after] == [one[0] for one in before]
    assert [one[2] for one in after] == [one[2] for one in before]
    assert after[1][1] == ("j1", "j3", "j2")
    assert set(remove_effect(tmp_path, "stribeck", n_joints=6)) == {"j1", "j2", "j3"}
    assert [one[0] for one in effects(load_model(tmp_path, 6))] == ["joint-friction", "joint-compliance"]
