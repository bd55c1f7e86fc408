"""The page on what a change of the model did to the values: what moved comes first, the rest is counted."""

from __future__ import annotations

from dataclasses import replace

from stiffcal.identification.answers.before_after import EstimatedParameter, values_before_and_after
from stiffcal.model.summary import Where
from stiffcal.report.blocks import Paragraph, ReportSection, SubheadingBlock, TableBlock
from stiffcal.report.content import FitChange
from stiffcal.report.sections.before_after import section
from tests.laboratory.report_content import made_up_content


def spring(joint: int, value: float, half: float) -> EstimatedParameter:
    return EstimatedParameter(
        name=f"joint-compliance.j{joint}.c", effect="joint-compliance", where=Where(joints=[joint]), unit="N·m/rad",
        value=value, interval=[value - half, value + half],
    )  # fmt: skip


WIDTH = EstimatedParameter(
    name="backlash.j3.width", effect="backlash", where=Where(joints=[3]), unit="rad", value=1.8e-3,
    interval=[1.7e-3, 1.9e-3],
)  # fmt: skip
BEFORE = [spring(1, 7.3e5, 1e4), spring(2, 5e4, 1e3), spring(3, 2.74e4, 150.0)]
AFTER = [spring(1, 7.31e5, 1e4), spring(2, 5.2e4, 1e3), spring(3, 5.99e4, 960.0), WIDTH]


def change(own: bool = True, gained: str = "+ backlash (joint 3)") -> FitChange:
    values = tuple(values_before_and_after(BEFORE, AFTER))
    return FitChange(before="1", after="2", change=gained, values=values, own=own)


def test_what_moved_comes_first_then_what_is_new() -> None:
    made = section(replace(made_up_content(), fit_changes=(change(),)))
    assert isinstance(made, ReportSection)
    lead, heading, table = made.blocks
    assert isinstance(lead, Paragraph)
    assert heading == SubheadingBlock("+ backlash (joint 3): fit 1 → fit 2")
    assert isinstance(table, TableBlock)
    rows = [tuple(cell.replace(chr(0x202F), " ") for cell in row) for row in table.rows]
    assert [row[0] for row in rows] == ["joint 3 (A3)", "joint 2 (A2)", "joint 3 (A3)"]
    assert rows[0][2:] == ("(2.740 ± 0.015)·10⁴", "(5.990 ± 0.096)·10⁴", "N·m/rad", "+119 %")
    assert rows[2][2:] == ("not in the model", "1.80 ± 0.10", "mrad", "–")
    assert "1 other value stays within" in table.caption


def test_fits_of_somebody_else_are_marked() -> None:
    made = section(replace(made_up_content(), fit_changes=(change(own=False),)))
    assert isinstance(made, ReportSection)
    assert any(isinstance(block, SubheadingBlock) and "not computed by you" in block.text for block in made.blocks)


def test_without_a_change_the_page_is_left_out() -> None:
    assert section(made_up_content()) is None


def test_the_parameters_of_frames_are_listed_with_their_frame() -> None:
    tracker, target = (
        EstimatedParameter(
            name=f"frame.{frame}.x", effect="frame", where=Where(), unit="m", value=1e-3, interval=[9e-4, 1.1e-3]
        )
        for frame in ("tracker", "target1")
    )
    drift = EstimatedParameter(
        name="thermal-drift.x", effect="thermal-drift", where=Where(), unit="m/s", value=1e-9, interval=[0.0, 2e-9]
    )
    found = values_before_and_after([], [tracker, target, drift, WIDTH])
    assert [value.setup_part for value in found] == ["tracker", "target1", "", ""]
    made = section(replace(made_up_content(), fit_changes=(replace(change(), values=tuple(found)),)))
    assert isinstance(made, ReportSection)
    (table,) = [block for block in made.blocks if isinstance(block, TableBlock)]
    assert [row[0] for row in table.rows] == ["tracker", "target1", "set-up", "joint 3 (A3)"]
