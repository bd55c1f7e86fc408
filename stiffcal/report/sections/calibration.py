"""Robot geometry from absolute places: distances before and after, regions, targets, axes and zeros."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from stiffcal.identification.answers.geometry_results import GeometryFound
from stiffcal.quantity import JOINT_ANGLE, LENGTH, ShownUnit, of_joint
from stiffcal.report import wording
from stiffcal.report.blocks import Block, Items, PictureBlock, ReportSection, TableBlock, TableColumn
from stiffcal.report.content import ReportContent
from stiffcal.report.figures.calibration import draw_calibration
from stiffcal.results.geometry_words import HEADER, convention_in_words, sentences, table_rows
from stiffcal.results.model_words import STEPS
from stiffcal.validation.distance_results import Distances, LadderStep

ORDER = 17
_TITLE = "Robot geometry"


def section(content: ReportContent) -> ReportSection | None:
    """Lay out what absolute places show; nothing where none were measured."""
    found = None if content.identify is None else content.identify.geometry
    distance = None if content.validate is None else content.validate.distance
    ladder = None if content.validate is None else content.validate.ladder
    blocks: list[Block] = []
    if distance is not None:
        blocks += [*_over_the_workspace(content), _distances(distance)]
        if distance.by_region:
            blocks.append(regions_table(distance, content.prismatic_joints))
    if ladder:
        blocks.append(_ladder(ladder))
    if isinstance(found, GeometryFound):
        columns = tuple(TableColumn(title, unit) for title, unit in HEADER)
        blocks.append(TableBlock(columns, tuple(table_rows(found)), f"{wording.capital(convention_in_words(found))}."))
        blocks.append(Items(tuple(f"{wording.capital(sentence)}." for sentence in sentences(found))))
    return ReportSection(_TITLE, tuple(blocks)) if blocks else None


def _over_the_workspace(content: ReportContent) -> Iterator[Block]:
    """Yield the picture of distances before and after, where targets' places are known."""
    states = content.states
    if states is None or states.predicted_heldout is None:
        return
    places = [content.runs[run].target for run in states.run]
    known = np.array([place is not None for place in places]) & states.used
    before = np.linalg.norm(states.measured[:, :3], axis=1)
    after = np.linalg.norm(states.residual[:, :3], axis=1)
    known &= np.isfinite(before) & np.isfinite(after)
    if not known.any():
        return
    place = np.array([target for target, drawn in zip(places, known, strict=True) if drawn])
    caption = "Distance between predicted and measured positions, before and after, in the same colours."
    yield PictureBlock(partial(draw_calibration, place, before[known], after[known]), caption)


def _distances(distance: Distances) -> TableBlock:
    """Return the table of distances: the fit and what was left out, and the targets of the latter."""
    summaries = [("fit", distance.fit), ("poses held out at random", distance.heldout_random)]
    summaries.append(("held-out regions", distance.heldout_region))
    unit = LENGTH.unit_for(of.max for _, of in summaries if of is not None)
    rows = [(name, *_cells(of, unit), str(of.n)) for name, of in summaries if of is not None]
    judged = distance.heldout_region or distance.fit
    if len(judged.by_target) > 1:
        rows += [(f"of these, {target.target}", *_cells(target, unit), str(target.n)) for target in judged.by_target]
    noise = distance.noise
    if noise is not None:
        cells = (wording.significant(unit.factor * value) for value in (noise.mean, noise.median, noise.p95))
        rows.append(("noise alone", *cells, "", wording.significant(unit.factor * noise.rms), ""))
    caption = (
        "Distances between predicted and measured positions. The value for held-out regions applies to new "
        "regions of the workspace."
    )
    if noise is not None:
        caption += (
            " Noise alone: distances of a right model from the readings, σ the uncertainty of one axis: mean 1.60 σ, "
            "rms 1.73 σ."
        )
    return TableBlock(_columns("data", "places", unit), tuple(rows), caption)


def regions_table(distance: Distances, prismatic: frozenset[int] = frozenset()) -> TableBlock:
    """Return the table of the regions that were left out, each with the mean direction of its joints.

    Parameters
    ----------
    prismatic : joints, from 1, whose mean is a position.
    """
    unit, angle = LENGTH.unit_for(region.max for region in distance.by_region), JOINT_ANGLE.usual.name
    columns = (*_columns("region", "places", unit), TableColumn("mean joint angles", angle, align="left"))
    if prismatic:
        both = f"{angle} and {LENGTH.usual.name}"
        columns = (*columns[:-1], TableColumn("mean joint positions", both, align="left"))
    rows = tuple(
        (str(region.region), *_cells(region, unit), str(region.n), _centre(region.centre, prismatic))
        for region in distance.by_region
    )
    return TableBlock(columns, rows, "Distances in each region, by a fit without that region.")


def _centre(angles: list[float], prismatic: frozenset[int]) -> str:
    """Return joint angles and positions in whole units; nothing where an older store does not have them."""
    whole = [round(of_joint(k in prismatic).usual.factor * a) for k, a in enumerate(angles, start=1)]
    return ", ".join(map(str, whole)).replace("-", "−")


def _columns(first: str, last: str, unit: ShownUnit) -> tuple[TableColumn, ...]:
    names = ("mean", "median", "95 %", "worst", "rms")
    return (TableColumn(first, align="left"), *(TableColumn(name, unit.name) for name in names), TableColumn(last))


def _cells(of: object, unit: ShownUnit) -> tuple[str, ...]:
    names = ("mean", "median", "p95", "max", "rms")
    return tuple(wording.significant(unit.factor * float(getattr(of, name))) for name in names)


def _ladder(ladder: list[LadderStep]) -> TableBlock:
    """Return the ladder from the nominal robot to the present model."""
    unit = LENGTH.unit_for(error for step in ladder for error in _errors(step))
    columns = (
        TableColumn("model", align="left"), TableColumn("parameters"), TableColumn("fit, rms", unit.name),
        TableColumn("random, rms", unit.name), TableColumn("region, rms", unit.name),
        TableColumn("region, mean", unit.name),
    )  # fmt: skip
    rows = tuple(
        (
            STEPS.get(step.step, step.step),
            str(step.n_parameters),
            *(_length(error, unit) for error in _errors(step)),
        )
        for step in ladder
    )
    return TableBlock(columns, rows, "From the nominal robot to the model: each row adds parameters to the row above.")


def _errors(step: LadderStep) -> tuple[float | None, ...]:
    return step.fit, step.heldout_random, step.heldout_region, step.mean_region


def _length(metres: float | None, unit: ShownUnit) -> str:
    return wording.DASH if metres is None else wording.significant(unit.factor * metres)
