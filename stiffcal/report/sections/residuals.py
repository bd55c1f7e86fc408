"""Residuals: by run, direction, load, branch and joint angle, and against what they might follow."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

from stiffcal.quantity import ANGLE, FORCE, LENGTH, MOMENT, ShownUnit, Units, of_joint
from stiffcal.report import wording
from stiffcal.report.blocks import (
    Block,
    LeftOut,
    Paragraph,
    PictureBlock,
    ReportSection,
    SubheadingBlock,
    TableBlock,
    TableColumn,
)
from stiffcal.report.content import ReportContent, ReportStates
from stiffcal.report.figures.residual_against import MOST_POINTS, draw_residual_against
from stiffcal.report.figures.residuals_by import draw_residuals_by, draw_residuals_by_run
from stiffcal.report.fit_sentences import noise_sentence
from stiffcal.results.validate_result import NEARLY_ALIKE, ValidateResult
from stiffcal.validation.results import ErrorSlice
from stiffcal.validation.schemes import held_out

ORDER = 70
_TITLE = "Residuals"
_GROUPS: tuple[tuple[Callable[[ValidateResult], list[ErrorSlice]], str, str], ...] = (
    (lambda validation: validation.by_direction, "direction of force", ""),
    (lambda validation: validation.by_load, "load", " [N]"),
    (lambda validation: validation.by_branch, "branch", ""),
)
_COVARIATES_PER_PICTURE = 4
_MOST_RUNS_PER_PICTURE = 60
_JOINTS_PER_PICTURE = 7
_MOST_WORST = 10


def section(content: ReportContent) -> ReportSection | LeftOut:
    """Lay out the residuals every way they were sorted."""
    validation = content.validate
    if validation is not None and validation.noise is not None:
        # one noise in a report: what is missing swells the scatter of repeats
        validation = replace(validation, noise=content.known_noise)
    blocks: list[Block] = []
    if content.states is None and validation is not None:
        return LeftOut(_TITLE, "there are no load states to draw")
    if validation is not None:
        blocks.append(Paragraph(_lead(validation)))
        blocks.extend(_by_run(validation, content))
        blocks.extend(_by_groups(validation, content))
    if content.states is not None and content.states.used.any() and content.covariates and content.identify is not None:
        blocks.extend(_covariate_blocks(content, content.states))
    if validation is not None:
        blocks.extend(_worst(validation, content.absolute_alone))
    if not blocks:
        return LeftOut(_TITLE, "the model has not been validated yet: run “stiffcal validate”")
    return ReportSection(_TITLE, tuple(blocks))


def _lead(validation: ValidateResult) -> str:
    return (
        f"Residual: measured minus predicted, in {held_out(validation.scheme)}; rms of its length. "
        f"Over all states: {wording.measure_text(validation.rms)} rms, {wording.measure_text(validation.max)} at most. "
        f"{noise_sentence(validation)}"
    )


def _translation(part: ErrorSlice) -> float:
    return part.rms.translation or 0.0


def _extremes(parts: Sequence[ErrorSlice], kind: str = "") -> str:
    """Name the parts with the largest and the smallest residual, or state that all are alike."""
    # a part without a measured position, as of clamped runs alone, has no length to compare
    with_length = [part for part in parts if _translation(part) > 0.0] or list(parts)
    low, high = min(with_length, key=_translation), max(with_length, key=_translation)
    least, most = _translation(low), _translation(high)
    if len(with_length) < 2 or least <= 0:
        return f"{high.label} {wording.measure_text(high.rms)} rms."
    if most < NEARLY_ALIKE * least:
        return f"nearly the same everywhere, {wording.length(least)} to {wording.length(most)} rms."
    return (
        f"largest {wording.length(most)} rms ({kind}{high.label}), smallest {wording.length(least)} "
        f"({kind}{low.label}), a factor of {wording.significant(most / least, 2)}."
    )


def _noise_words(validation: ValidateResult) -> str:
    if validation.noise is None:
        return " No noise line: noise cannot be judged."
    return f" The dashed line is the noise, {wording.measure_text(validation.noise)}."


def _by_run(validation: ValidateResult, content: ReportContent) -> list[Block]:
    # runs whose flange was held have errors of motor angles and torques alone: they are on their own pages
    parts = [
        part
        for part in validation.by_run
        if any(wording.part(part.rms, measure) is not None for measure in ("translation", "rotation", "length"))
    ]
    blocks: list[Block] = []
    # the poses of one absolute run are one part: its only bar is the rms of the first sentence
    if len(parts) == 1 and content.absolute_alone:
        return blocks
    for start in range(0, len(parts), _MOST_RUNS_PER_PICTURE):
        group = parts[start : start + _MOST_RUNS_PER_PICTURE]
        caption = f"Residual by run: {_extremes(group, 'run ')}{_noise_words(validation)}"
        blocks.append(PictureBlock(partial(draw_residuals_by_run, group, validation.noise), caption))
    return blocks


def _by_groups(validation: ValidateResult, content: ReportContent) -> list[Block]:
    # a place that is measured once is on no branch
    known = [group for group in _GROUPS if not (content.absolute_alone and group[1] == "branch")]
    prismatic = content.prismatic_joints
    several = [
        (title, unit, short_ranges(parts, ShownUnit("")))
        for select, title, unit in known
        if len(parts := select(validation)) > 1
    ]
    blocks: list[Block] = []
    if several:
        text = " ".join(f"By {title}{unit}: {_extremes(parts)}" for title, unit, parts in several)
        missing = [title for select, title, _ in known if len(select(validation)) <= 1]
        if missing:
            text += f" Not grouped by {wording.listing(missing)}: only one group in these data."
        names = wording.listing([title for title, _, _ in several])
        caption = f"Residual by {names}. {text}{_noise_words(validation)}"
        groups = [(f"{title}{unit}", parts) for title, unit, parts in several]
        blocks.append(PictureBlock(partial(draw_residuals_by, groups, validation.noise), caption))
    angles = validation.by_joint_angle
    if len(angles) > 1:
        named = [
            replace(part, label=f"joint {part.joint}, {label}")
            for part, label in zip(angles, ranges_of_joints(angles, prismatic), strict=True)
        ]
        caption = f"Residual by joint angle: {_extremes(named)}{_noise_words(validation)}"
        joints = list(dict.fromkeys(part.joint for part in angles))
        for sheet in wording.in_sheets(range(len(joints)), _JOINTS_PER_PICTURE):
            groups = [
                (
                    f"joint {joints[number]} [{_unit_of(joints[number], prismatic).name}]",
                    short_ranges(
                        [part for part in angles if part.joint == joints[number]],
                        _unit_of(joints[number], prismatic),
                    ),
                )
                for number in sheet
            ]
            blocks.append(PictureBlock(partial(draw_residuals_by, groups, validation.noise), caption))
    return blocks


def _unit_of(joint: int | None, prismatic: frozenset[int]) -> ShownUnit:
    return of_joint(joint in prismatic).usual


def ranges_of_joints(parts: Sequence[ErrorSlice], prismatic: frozenset[int] = frozenset()) -> list[str]:
    """Return ranges of angles, or of the positions of prismatic joints, in words; the label of a part that is none."""
    words = []
    for part in parts:
        if part.low is None or part.high is None:
            words.append(part.label)
            continue
        unit = _unit_of(part.joint, prismatic)
        low, high = (f"{round(end * unit.factor)}{unit.mark}" for end in (part.low, part.high))
        words.append(f"{low} to {high}".replace("-", "−"))
    return words


def short_ranges(parts: Sequence[ErrorSlice], unit: ShownUnit) -> list[ErrorSlice]:
    """Write ranges as labels of whole numbers of a unit; other labels stay."""
    return [
        part
        if part.low is None or part.high is None
        else replace(
            part, label=f"{round(part.low * unit.factor)} … {round(part.high * unit.factor)}".replace("-", "−")
        )
        for part in parts
    ]


def _worst(validation: ValidateResult, of_places: bool) -> list[Block]:
    """List the worst states; of one branch alone, and of places, without the branch."""
    worst = validation.worst[:_MOST_WORST]
    if not worst:
        return []
    shown = Units([("m", [state.residual_m for state in worst]), ("rad", [state.residual_rad for state in worst])])
    units = {shown.of(LENGTH if state.residual_rad is None else ANGLE) for state in worst}
    alike = len(units) == 1
    columns = [
        TableColumn("run", align="left"),
        TableColumn("row"),
        TableColumn("residual", "".join(u.name for u in units) * alike),
    ]
    rows: list[tuple[str, ...]] = []
    for state in worst:
        value, quantity = (state.residual_m, LENGTH) if state.residual_rad is None else (state.residual_rad, ANGLE)
        unit = shown.of(quantity)
        cell = wording.significant(unit.factor * (value or 0.0)) + ("" if alike else f" {unit.name}")
        # a row of absolute runs is named by its run
        row = "" if of_places and state.run.endswith(f" {state.row}") else str(state.row)
        rows.append((state.run.replace(" ", "\u00a0"), row, cell))
    if any(state.load for state in worst):
        of_loads = [(FORCE if state.residual_rad is None else MOMENT).usual.name for state in worst]
        columns.append(TableColumn("load", of_loads[0] if alike else ""))
        loads = [wording.significant(state.load) for state in worst]
        cells = loads if alike else [f"{load} {unit}" for load, unit in zip(loads, of_loads, strict=True)]
        rows = [(*row, cell) for row, cell in zip(rows, cells, strict=True)]
    branches = [state.branch for state in worst]
    if len(set(branches)) > 1 and not of_places:
        columns.append(TableColumn("branch", align="left"))
        rows = [(*row, branch) for row, branch in zip(rows, branches, strict=True)]
    caption = "States with the largest residuals; check these readings first."
    return [SubheadingBlock("States with the largest residuals"), TableBlock(tuple(columns), tuple(rows), caption)]


def _covariate_blocks(content: ReportContent, states: ReportStates) -> list[Block]:
    """Return the pictures of the residual against each covariate, several to a sheet."""
    fit_noise = None if content.identify is None else content.identify.noise
    noise = wording.part(fit_noise if content.validate is None else content.known_noise, "translation")
    caption = "Residual against {}. Without a trend, the residual does not depend on the variable."
    if noise is not None:
        caption += " Grey band: ± two standard deviations of the noise."
    n_used = int(states.used.sum())
    if n_used > MOST_POINTS:
        caption += (
            f" About {MOST_POINTS} of {wording.count(n_used, 'state')} are drawn, including the largest residuals."
        )
    blocks: list[Block] = [SubheadingBlock("Residual against possible causes")]
    for sheet in wording.in_sheets(range(len(content.covariates)), _COVARIATES_PER_PICTURE):
        group = [content.covariates[number] for number in sheet]
        text = caption.format(wording.listing([covariate.name for covariate in group]))
        blocks.append(PictureBlock(partial(draw_residual_against, states, group, noise), text))
    return blocks
