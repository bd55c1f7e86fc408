"""The pictures: units on every axis, readable without colour, the same bytes twice, all kinds of file."""

from __future__ import annotations

import itertools
import re
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from stiffcal.compensation.predict_result import LoadPath
from stiffcal.errors import no_progress
from stiffcal.measurements.rms import Rms
from stiffcal.report import kept_pictures
from stiffcal.report.content import ResidualCovariate
from stiffcal.report.drawing import draw_pictures
from stiffcal.report.figures import canvas
from stiffcal.report.figures.calibration import draw_calibration
from stiffcal.report.figures.evidence import draw_errors_by_run, draw_evidence
from stiffcal.report.figures.ladder import draw_ladder
from stiffcal.report.figures.load_deformation import (
    branch_stretches,
    direction_styles,
    draw_deflection_by_run,
    draw_load_deformation,
    draw_load_deformation_sheet,
    states_of_run,
)
from stiffcal.report.figures.load_path import apparent_negative, draw_load_path
from stiffcal.report.figures.measured_against_predicted import draw_measured_against_predicted
from stiffcal.report.figures.residual_against import draw_residual_against
from stiffcal.report.figures.residuals_by import draw_residuals_by, draw_residuals_by_run
from stiffcal.report.figures.robot_poses import arrow_scale, draw_pose_sheet, residual_arrows
from tests.laboratory.fits import validation_of
from tests.laboratory.report_content import made_up_content, made_up_states
from tests.report.test_diagnosis_pages import shown

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CONTENT = made_up_content(rotation=True)
STATES = made_up_states(rotation=True)
VALIDATION, FITS = CONTENT.validate or validation_of(), () if CONTENT.history is None else CONTENT.history.fits
NAMES = [run.name for run in CONTENT.runs]
# The path of paper 002's Fig. 2 on a robot whose z deflection follows Fx.
RAMP = np.linspace(0, 1, 9)
FORCE = np.concatenate([np.outer(RAMP[::-1], [-100, 200, -300]), np.outer(RAMP[1:], [100, -200, 100])])
COMPLIANCE = np.array([[5e-6, 0, 0], [0, 4e-6, 0], [-9e-6, 0, 4e-6]])
PATH = LoadPath("ramp", "a pose", FORCE, FORCE @ COMPLIANCE.T, (0, 8, 16))

ALL_THREE = Rms(2e-5, 3e-5, length=2e-6)
WITH_RODS = [replace(part, rms=ALL_THREE, max=ALL_THREE) for part in VALIDATION.by_run]

FIGURES: dict[str, Callable[[], Figure]] = {
    "load_deformation": lambda: draw_load_deformation(STATES, 1, "run_1"),
    "load_deformation_sheet": lambda: draw_load_deformation_sheet(STATES, [0, 1], NAMES),
    "deflection_by_run": lambda: draw_deflection_by_run(STATES, NAMES, [0, 1]),
    "measured_against_predicted": lambda: draw_measured_against_predicted(STATES),
    "residual_against": lambda: draw_residual_against(
        STATES, [ResidualCovariate("torque on joint 4", "N·m", STATES.load)], 2e-5
    ),
    "residuals_by_run": lambda: draw_residuals_by_run(VALIDATION.by_run, Rms(1e-5, None)),
    "residuals_by": lambda: draw_residuals_by([("branch", VALIDATION.by_branch)], None),
    "robot_poses": lambda: draw_pose_sheet(CONTENT.runs, [0, 1], STATES, 100.0),
    "ladder": lambda: draw_ladder(FITS, VALIDATION.zero_model, Rms(1e-5, None)),
    "ladder_rotation": lambda: draw_ladder(FITS, VALIDATION.zero_model, None, "rotation"),
    "load_path": lambda: draw_load_path(PATH),
    "residuals_with_rods": lambda: draw_residuals_by_run(WITH_RODS, Rms(1e-5, 1e-5, length=1e-6)),
    "evidence": lambda: draw_evidence(shown(driver="bending moment at the middle of the upper arm")),
    "errors_of_motors": lambda: draw_errors_by_run(shown(heldout_rms_after=Rms(None, None, motor_angle=2e-5)), 1e-5),
}
# Axes along which things are sorted, not measured.
KINDS = ("run", "branch", "direction of force", "size of load", "joint angle")


@pytest.mark.parametrize("name", FIGURES)
def test_every_axis_has_its_unit(name: str) -> None:
    figure = FIGURES[name]()
    figure.draw_without_rendering()
    for axes in figure.axes:
        shown = axes.get_subplotspec()
        assert shown is not None
        for axis, label in ((axes.xaxis, axes.get_xlabel()), (axes.yaxis, axes.get_ylabel())):
            if label:
                assert label in KINDS or re.search(r"\[(N|mm|µm|mrad|m|N·m)\]", label), label
            else:
                # Shared axes are labelled once; an axis with its own written ticks must not be without a label.
                written = [tick.label1.get_visible() and tick.label1.get_text() for tick in axis.get_major_ticks()]
                assert not any(written) or name.startswith("ladder"), (name, written)


@canvas.styled
def laid_out(figure: Figure) -> Figure:
    """Measure all texts of a figure, in the style in which it is written."""
    figure.draw_without_rendering()
    return figure


@pytest.mark.parametrize("name", FIGURES)
def test_no_text_leaves_the_picture_or_runs_into_another_panel(name: str) -> None:
    figure = laid_out(FIGURES[name]())
    extents = [box for axes in figure.axes if (box := axes.get_tightbbox()) is not None]
    width, height = figure.bbox.width, figure.bbox.height
    pixel = figure.dpi / 72.0
    for box in extents:
        assert box.x0 > -pixel
        assert box.y0 > -pixel
        assert box.x1 < width + pixel
        assert box.y1 < height + pixel
    legends = [legend.get_window_extent() for legend in figure.legends]
    for first, second in itertools.combinations([*extents, *legends], 2):
        across = min(first.x1, second.x1) - max(first.x0, second.x0)
        up = min(first.y1, second.y1) - max(first.y0, second.y0)
        assert min(across, up) < 2.0 * pixel, (name, first, second)


@pytest.mark.parametrize("kind", ["svg", "pdf", "png"])
def test_pictures_repeat_byte_for_byte(kind: str, tmp_path: Path) -> None:
    for number in (1, 2):
        canvas.save_figure(FIGURES["load_path"](), tmp_path / f"{number}.{kind}")
    assert (tmp_path / f"1.{kind}").read_bytes() == (tmp_path / f"2.{kind}").read_bytes()


def test_series_differ_without_colour() -> None:
    styles = direction_styles(STATES, np.arange(len(STATES)))
    assert len(styles) == 3
    assert len({marker for _, marker in styles.values()}) == len(styles)


def test_a_direction_looks_alike_in_all_pictures() -> None:
    """Also where a picture lacks other directions, or they come in another order."""
    whole = direction_styles(STATES, np.arange(len(STATES)))
    last = max(whole)
    assert direction_styles(STATES, np.flatnonzero(STATES.direction == last)) == {last: whole[last]}


def test_opposite_directions_share_a_colour() -> None:
    force = np.concatenate([STATES.force, -STATES.force])
    both = replace(
        STATES,
        run=np.tile(STATES.run, 2),
        force=force,
        direction=np.concatenate([STATES.direction, np.char.replace(STATES.direction, "+", "-")]),
    )
    styles = direction_styles(both, np.arange(len(force)))
    assert styles["near +x"][0] == styles["near -x"][0] != styles["near +y"][0]


def test_stretches_part_loading_from_unloading() -> None:
    stretches = branch_stretches(STATES, states_of_run(STATES, 0))
    assert [branch for branch, _ in stretches] == ["loading", "unloading"] * 3
    loads = [STATES.load[indices] for _, indices in stretches]
    assert all((np.diff(load[1:]) > 0).all() for load in loads[::2])
    assert all((np.diff(load) < 0).all() for load in loads[1::2])
    assert loads[1][0] == STATES.load.max(), "unloading starts where loading ended"


def test_apparent_negative_stiffness_is_found_where_it_is() -> None:
    assert not apparent_negative(PATH, 0).any()
    against = apparent_negative(PATH, 2)
    # Fz and Fx rise together on both halves; Dz = 4 Fz - 9 Fx falls only on the second.
    assert not against[:8].any()
    assert against[8:].all()


def test_arrows_are_the_residuals_of_the_largest_loads() -> None:
    force, residual = residual_arrows(STATES, 1)
    assert np.allclose(np.linalg.norm(force, axis=1), 300.0)
    rows = [int(np.flatnonzero((STATES.run == 1) & (STATES.force == one).all(axis=1))[0]) for one in force]
    assert np.allclose(residual, STATES.residual[rows, :3])


def test_arrow_scale_is_round_and_fits() -> None:
    scale = arrow_scale(CONTENT.runs, STATES)
    assert f"{scale:.0e}"[0] in "125"
    longest = max(np.linalg.norm(residual_arrows(STATES, n)[1], axis=1).max() for n in range(2))
    assert 0.05 < scale * longest < 0.4
    figure = draw_pose_sheet(CONTENT.runs, [0, 1], STATES, scale)
    assert any("for arrows" in text.get_text() for axes in figure.axes for text in axes.texts)


def test_drawing_leaves_the_users_settings_alone(tmp_path: Path) -> None:
    import matplotlib

    with matplotlib.rc_context({"font.size": 31.0, "text.usetex": True}):
        figure = FIGURES["load_path"]()
        assert float(figure.axes[0].xaxis.label.get_fontsize()) < 10
        canvas.save_figure(figure, tmp_path / "f.svg")
        assert matplotlib.rcParams["font.size"] == 31.0


def test_thinning_keeps_the_largest() -> None:
    size = np.random.default_rng(1).random(10_000)
    kept = canvas.thinned(size, 500)
    assert 500 <= len(kept) <= 520
    assert int(np.argmax(size)) in kept


def test_content_and_building_load_neither_matplotlib_nor_typst() -> None:
    code = "import sys, stiffcal.report.building; print([m for m in ('matplotlib', 'typst') if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize("name", FIGURES)
def test_axes_of_one_tick_look_as_matplotlib_draws_them(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    canvas.save_figure(FIGURES[name](), tmp_path / "light.png")
    monkeypatch.setattr(canvas, "lighten_axes", lambda figure: None)
    canvas.save_figure(FIGURES[name](), tmp_path / "usual.png")
    assert (tmp_path / "light.png").read_bytes() == (tmp_path / "usual.png").read_bytes()


def test_ticks_of_a_picture_are_not_made_one_by_one(tmp_path: Path) -> None:
    figure = FIGURES["measured_against_predicted"]()
    canvas.save_figure(figure, tmp_path / "light.svg", text_as_shapes=False)
    assert all(len(axis.majorTicks) == 1 for axes in figure.axes for axis in (axes.xaxis, axes.yaxis))


def test_distances_before_and_after_have_one_scale_of_colours() -> None:
    place, distance = np.random.default_rng(3).uniform(0.5, 1.0, (40, 3)), np.linspace(1e-3, 4e-3, 40)
    before, after = draw_calibration(place, distance, 0.01 * distance).axes[:2]
    (first,), (second,) = before.collections, after.collections
    assert first.norm is second.norm
    low, high = first.get_clim()
    assert high > 50.0 * low


def _counted(text: Any) -> Figure:
    DRAWN.append(text)
    from matplotlib.figure import Figure

    figure = Figure()
    figure.text(0.5, 0.5, str(text))
    return figure


DRAWN: list[Any] = []


def test_a_picture_whose_content_was_drawn_before_is_not_drawn_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("STIFFCAL_STATE", str(tmp_path / "state"))
    DRAWN.clear()
    for name in ("first", "second"):
        pictures = [("", partial(_counted, text), tmp_path / f"{name}-{k}.svg") for k, text in enumerate("ab")]
        draw_pictures(pictures, no_progress)
    assert DRAWN == ["a", "b"]
    assert (tmp_path / "second-1.svg").read_bytes() == (tmp_path / "first-1.svg").read_bytes()
    draw_pictures([("", partial(_counted, "c"), tmp_path / "other.svg")], no_progress)
    assert DRAWN[-1] == "c"
    # computed in this process two names may be one object, read from the store they are two
    name, arrays = "joint 1", [np.arange(3.0), np.arange(3.0)]
    keys = [
        kept_pictures.KeptPictures().key(partial(_counted, [name, again, array]))
        for again, array in zip((name, "".join(("joint", " 1"))), arrays, strict=True)
    ]
    assert keys[0] == keys[1] != kept_pictures.KeptPictures().key(partial(_counted, [name, name, 2.0 * arrays[0]]))
    # nothing is taken that is not whole
    for kept in (tmp_path / "state" / "pictures").iterdir():
        kept.write_bytes(kept.read_bytes()[:-8])
    draw_pictures([("", partial(_counted, "c"), tmp_path / "other.svg")], no_progress)
    assert DRAWN[-2:] == ["c", "c"]


@pytest.mark.parametrize("module", ["quantity.py", "results/fit_pictures.py"])
def test_a_picture_by_other_code_is_another_one(module: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The units are of the one, what a picture of the fit holds of the other; neither is in `report`."""
    monkeypatch.setenv("STIFFCAL_STATE", str(tmp_path / "state"))
    monkeypatch.setattr(kept_pictures, "PACKAGE", tmp_path)
    (tmp_path / module).parent.mkdir(exist_ok=True)
    keys = []
    for text in ("one", "two"):
        (tmp_path / module).write_text(text, encoding="utf-8")
        kept_pictures._code.cache_clear()
        keys.append(kept_pictures.KeptPictures().key(partial(_counted, "a")))
    kept_pictures._code.cache_clear()
    assert keys[0] != keys[1]
