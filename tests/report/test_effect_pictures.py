"""What an effect does to a load-deformation curve, computed by its own law."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.model.catalogue.catalogue import find_effects
from stiffcal.report.effect_pictures.drawing import draw_effect, effect_picture, sketch_effect
from stiffcal.report.effect_pictures.sketch import sketch


@pytest.mark.parametrize("name", sorted(find_effects()))
def test_every_effect_shows(name: str) -> None:
    """Each effect of the catalogue changes a curve of the example, and visibly; its sketch fits into a terminal."""
    picture = effect_picture(find_effects()[name])
    assert picture is not None
    change = np.abs(picture.with_effect - picture.without).max()
    assert change > 0.1 * np.abs(np.concatenate([picture.with_effect, picture.without])).max()
    assert "[" in picture.x_label
    assert picture.y_label.endswith("]")
    lines = sketch(picture)
    assert max(map(len, lines)) < 100
    assert any(mark in "".join(lines[1:-2]) for mark in "ox")


def test_shapes_are_those_of_the_laws() -> None:
    """Backlash jumps at zero load and keeps the slope; friction runs in a loop; a straight spring does neither."""
    backlash = effect_picture(find_effects()["backlash"])
    assert backlash is not None
    far = backlash.x > 0.5 * backlash.x.max()
    added = (backlash.with_effect - backlash.without)[far]
    assert np.ptp(added) < 0.05 * added.mean()
    loop = effect_picture(find_effects()["friction-hysteresis"])
    assert loop is not None
    assert loop.unloading.any()
    assert not backlash.unloading.any()
    middle = np.abs(loop.x - 0.5 * loop.x.max()) < 1.0
    assert loop.with_effect[middle & loop.unloading].mean() > loop.with_effect[middle & ~loop.unloading].mean()


def test_drawn_to_a_file(tmp_path: Path) -> None:
    """A picture; a wrong ending and a missing folder are reported in one line."""
    assert "backlash" in draw_effect("backlash", tmp_path / "one.svg")
    assert (tmp_path / "one.svg").read_text().startswith("<?xml")
    with pytest.raises(InputError, match=FaultCode.FORMAT_UNKNOWN.value):
        draw_effect("backlash", tmp_path / "one.txt")
    with pytest.raises(InputError, match=FaultCode.FILE_MISSING.value):
        draw_effect("backlash", tmp_path / "nowhere" / "one.svg")


def test_a_sketch_shows_the_curve_without_the_effect_too_where_it_lies_apart() -> None:
    assert sum(line.count("·") for line in sketch_effect("backlash")[1:-2]) > 40
    assert sum(line.count("x") for line in sketch_effect("friction-hysteresis")) > 20
    assert all("x" not in line for line in sketch_effect("backlash")[1:-2])
