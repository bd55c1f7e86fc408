"""Pages on links with rods, and on displacement read along a line: what is drawn and what is said."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from stiffcal.report.blocks import Items, LeftOut, PictureBlock, ReportSection, TableBlock
from stiffcal.report.figures.along_lines import draw_along_lines
from stiffcal.report.link_pictures import BentLink, LinkPicture, LinkRun
from stiffcal.report.sections import links, load_deformation
from tests.laboratory.fits import with_fit
from tests.laboratory.report_content import made_up_content

FORCE = np.concatenate([np.linspace(0, 900, 7), np.linspace(750, -900, 12), np.linspace(-750, 0, 6)])
START = np.array([[0.05, 0.09, 0.1], [0.05, -0.09, -0.1], [0.5, 0.11, 0.0]])
END = np.array([[0.85, 0.09, 0.1], [0.85, -0.09, -0.1], [0.9, 0.11, 0.0]])


def run_of(name: str, with_model: bool = True) -> LinkRun:
    rods = FORCE[:, None] * np.array([1e-8, -1e-8, 0.4e-8])
    end = FORCE[:, None] * np.array([1e-9, 6e-8, 2e-8, np.nan, 3e-8, 1e-7])
    tool = 2e-6 * FORCE
    return LinkRun(
        name=name, along="y", force=FORCE, unloading=np.abs(np.append(FORCE[1:], 0.0)) < np.abs(FORCE), lengths=rods,
        modelled=rods if with_model else None, end=end, end_std=np.full(6, 1e-6), by_wrench=np.nan_to_num(end),
        tool=tool, with_link=tool, without_link=0.9 * tool if with_model else None,
    )  # fmt: skip


def picture_of(with_model: bool = True) -> LinkPicture:
    x1 = np.linspace(0.0, 0.95, 11)
    moved = np.stack([0.0 * x1, 1e-4 * x1**2, -2e-5 * x1**2], axis=1)
    runs = tuple(run_of(f"pose{k}", with_model) for k in (1, 2, 3))
    bent = BentLink(x1, moved, START, END, runs[0].lengths[6], 900.0, "pose2")
    said = ("torsion is not known: rods along the fibre are blind to it",)
    return LinkPicture(
        "swing", ("ids1", "ids2", "ids3"), np.array([0.8, 0.8, 1.2344]), ((0, 1),), runs, (0, 1, 2), bent, said
    )


def laid_out(picture: LinkPicture) -> ReportSection:
    content = made_up_content()
    reported = {
        "link": "swing", "rods": ["ids1", "ids2", "ids3"], "n_states": 9, "carried": [], "spare": 0, "condition": None,
        "sigma": None, "sigma_source": "none", "displacement_std": [None] * 6, "compliance_structure": "symmetric",
        "compliance_std": np.zeros((6, 6)).tolist(), "reduced_chi2": None, "not_identifiable": [], "not_carried": [],
        "faults": [], "share_of_tool": 0.039, "torsion": {"identifiable": False, "bound": None, "why": ""},
        "compliance": np.diag([8e-10, 3e-8, 4e-8, 1e-7, 1.4e-7, 1.2e-7]).tolist(),
        "compliance_interval": [
            np.diag([7e-10, 2.9e-8, 3.9e-8, -2e-7, 1.3e-7, 1.1e-7]).tolist(),
            np.diag([9e-10, 3.1e-8, 4.1e-8, 4e-7, 1.5e-7, 1.3e-7]).tolist(),
        ],
    }  # fmt: skip
    content = replace(with_fit(content, links=[reported]), link_pictures=(picture,))
    made = links.section(content)
    assert isinstance(made, ReportSection)
    return made


def test_without_rods_there_is_no_such_page() -> None:
    assert links.section(made_up_content()) is None


def test_rods_end_tool_and_the_bent_link_are_drawn() -> None:
    made = laid_out(picture_of())
    pictures = [block for block in made.blocks if isinstance(block, PictureBlock)]
    assert len(pictures) == 4
    words = [" ".join(text.get_text() for axes in p.draw().axes for text in (axes.xaxis.label, axes.yaxis.label))
             for p in pictures]  # fmt: skip
    assert "change of length [µm]" in words[0]
    assert "displacement of the link's end [mm]" in words[1]
    assert "turn of the link's end [mrad]" in words[1]
    assert "tool [mm]" in words[2]
    assert "force along y [N]" in words[2]
    assert "displacements drawn 1 000 times" in words[3]
    assert "φ1: not identifiable from these rods" in pictures[1].caption
    # rods of nearly one height: their names stand one above the other
    for panel in pictures[3].draw().axes:
        low, high = panel.get_ylim()
        places = sorted(text.get_position()[1] for text in panel.texts)
        assert len(places) == 3
        assert min(np.diff(places)) > 0.09 * (high - low)
    assert "they mirror each other within 0" in pictures[0].caption
    assert "The contribution of the link is up to 0.180 mm" in pictures[2].caption
    items = [block for block in made.blocks if isinstance(block, Items)]
    assert "torsion is not known" in items[0].texts[0]


def test_the_links_compliance_says_what_is_not_reported() -> None:
    (table,) = [block for block in laid_out(picture_of()).blocks if isinstance(block, TableBlock)]
    rows = {row[0]: row[1:] for row in table.rows}
    assert rows["u2 per force along x2"] == ("0.0300 ± 0.0010", "µm/N")
    assert rows["twist per moment"][0] == "below 0.40"
    assert "3.90 % of the tool deflection comes from this link, its torsion not included" in table.caption


def test_a_model_without_the_link_is_said_so() -> None:
    captions = [
        block.caption for block in laid_out(picture_of(with_model=False)).blocks if isinstance(block, PictureBlock)
    ]
    assert "The model contains no effect on this link" in captions[2]
    assert "the fitted model" not in captions[0]


def test_displacement_along_a_line_has_a_panel_per_run() -> None:
    content = made_up_content(n_runs=4)
    assert content.states is not None
    line = np.tile([0.0, -1.0, 0.0], (len(content.states), 1))
    along = np.sum(line * content.states.force, axis=1)[:, None] * line
    states = replace(content.states, force=along, measured=2e-6 * along, predicted=1.9e-6 * along, along=line)
    figure = draw_along_lines(states, [0, 1, 2, 3], ["a", "b", "c", "d"])
    assert [axes.get_title(loc="left") or axes.get_title() for axes in figure.axes if axes.axison][::2]
    made = load_deformation.section(replace(content, states=states))
    assert not isinstance(made, LeftOut)
    (picture,) = [block for block in made.blocks if isinstance(block, PictureBlock)]
    assert picture.caption.endswith("the largest residual is 0.0300 mm.")


@pytest.mark.parametrize("name", ["draw_rods", "draw_end", "draw_tool", "draw_bent"])
def test_no_picture_leaves_a_panel_without_units(name: str) -> None:
    from stiffcal.report.figures import links as drawing

    picture = picture_of()
    figure = drawing.draw_end(picture, 0) if name == "draw_end" else getattr(drawing, name)(picture)
    for axes in figure.axes:
        if axes.axison:
            assert "[" in axes.get_ylabel()
    if name == "draw_rods":
        assert "ids3, 1234 mm" in [text.get_text() for text in figure.legends[0].get_texts()]


def test_coupling_errors_stand_in_a_table_of_their_own() -> None:
    content = made_up_content()
    rms = {"translation": None, "rotation": None}
    unknown: dict[str, Any] = {"rms": rms, "condition": None, "not_identifiable": [], "left_out": []}
    ways = [
        {"way": way, "says": "", **unknown} for way in ("links-rigid", "tool-alone", "links-taken-out", "with-rods")
    ]
    reported = {"value": 3e-7, "std": 3e-9, "against_rods": 0.163}
    entry = {
        "name": "joint-compliance.j2.c", "links-rigid": reported, "tool-alone": None, "links-taken-out": reported,
        "with-rods": reported,
    }  # fmt: skip
    coupling = {"links": ["swing"], "ways": ways, "parameters": [entry]}
    made = links.section(replace(with_fit(content, coupling=coupling), link_pictures=(picture_of(),)))
    assert isinstance(made, ReportSection)
    table = [block for block in made.blocks if isinstance(block, TableBlock)][-1]
    assert [column.title for column in table.columns][1:] == [
        "links rigid", "tool alone", "link deflection subtracted", "tool and rods",
    ]  # fmt: skip
    assert table.rows[0] == (
        "joint-compliance.j2.c",
        "+16.3 % (± 2.0 %)",
        "–",
        "+16.3 % (± 2.0 %)",
        "3.00·10⁻⁷ ± 2.0 %",
    )
