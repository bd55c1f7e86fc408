"""Load-deformation curves: the most informative runs large, the others as small multiples; single states run by run."""

from __future__ import annotations

from functools import partial

import numpy as np

from stiffcal.measurements.state_measures import StateMeasure
from stiffcal.report import wording
from stiffcal.report.blocks import Block, LeftOut, Paragraph, PictureBlock, ReportSection
from stiffcal.report.content import ReportContent, ReportStates
from stiffcal.report.figures import along_lines as lines
from stiffcal.report.figures import load_deformation as drawing
from stiffcal.report.figures.canvas import AXES_NAMES

ORDER = 50
_TITLE, _TITLE_OF_PLACES = "Load and deflection", "Measured and predicted positions"
_FEWEST_STATES = 4
_MOST_SMALL = 40
_MOST_SINGLES = 50


def section(content: ReportContent) -> ReportSection | LeftOut:
    """Lay out the curves, and describe how the runs shown large were chosen."""
    states, title = content.states, _TITLE_OF_PLACES if content.absolute_alone else _TITLE
    if states is None or not states.used.any():
        return LeftOut(title, "there are no load states to draw")
    if states.along is not None:
        return ReportSection(_TITLE, tuple(_line_displacement_blocks(content, states)))
    # clamped runs have states too, and no displacement: their pages are their own
    measured_mask = states.used & np.isfinite(states.measured[:, :3]).any(axis=1)
    counts = np.bincount(states.run[measured_mask], minlength=len(content.runs))
    curves = [number for number in range(len(content.runs)) if counts[number] >= _FEWEST_STATES]
    blocks: list[Block] = []
    if curves:
        blocks.extend(_curves(content, states, curves))
    singles = [number for number in range(len(content.runs)) if 0 < counts[number] < _FEWEST_STATES]
    places = [number for number in singles if content.runs[number].measures is StateMeasure.PLACE]
    for chosen, of_places in (([number for number in singles if number not in places], False), (places, True)):
        if chosen:
            blocks.extend(_singles(content, states, chosen, of_places))
    return ReportSection(title, tuple(blocks))


def _line_displacement_blocks(content: ReportContent, states: ReportStates) -> list[Block]:
    """Lay out runs in which displacement was read along the load alone: a panel each."""
    text = (
        "Displacement of the target along the line of action of the force, the only measured direction. Filled "
        "markers: loading; open markers: unloading; lines: fitted model. Below: residual."
    )
    blocks: list[Block] = [Paragraph(text)]
    runs = [number for number in range(len(content.runs)) if (states.used & (states.run == number)).any()]
    for sheet in map(list, wording.in_sheets(runs, lines.PER_SHEET, multiple=lines.PER_ROW)):
        names = [content.runs[number].name for number in sheet]
        off = np.linalg.norm((states.measured - states.predicted)[np.isin(states.run, sheet) & states.used, :3], axis=1)
        caption = (
            f"Displacement along the force in {wording.listing(names)}; the largest residual is "
            f"{wording.length(float(np.nanmax(off)))}."
        )
        blocks.append(PictureBlock(partial(lines.draw_along_lines, states, sheet, names), caption))
    return blocks


def _run_rms(content: ReportContent) -> dict[str, float]:
    """Residual of each run in poses left out of the fit, m."""
    parts = [] if content.validate is None else content.validate.by_run
    return {part.label: part.rms.translation or 0.0 for part in parts}


def most_loaded_runs(content: ReportContent, states: ReportStates, candidates: list[int]) -> dict[int, str]:
    """Choose the runs to show large, with the reason: worst, largest deflection, most ordinary.

    Returns
    -------
    run index to why it was chosen, in this order.
    """
    rms = _run_rms(content)
    known = [number for number in candidates if content.runs[number].name in rms]
    chosen: dict[int, str] = {}
    if known:
        by_error = sorted(known, key=lambda number: rms[content.runs[number].name])
        chosen[by_error[-1]] = "the largest error in a held-out pose"
    size = np.linalg.norm(states.measured[:, :3], axis=1)
    largest = max(candidates, key=lambda number: float(np.max(size[states.used & (states.run == number)])))
    chosen.setdefault(largest, "the largest deflection")
    if known:
        chosen.setdefault(by_error[len(by_error) // 2], "run with the median error")
    return chosen


def _curves(content: ReportContent, states: ReportStates, curves: list[int]) -> list[Block]:
    chosen = most_loaded_runs(content, states, curves) if len(curves) > 3 else dict.fromkeys(curves, "")
    text = (
        "Deflection of the target along each base axis against the force along the same axis, both counted from the "
        "run’s unloaded reference. Filled markers: loading; open markers: unloading; lines: fitted model. A gap "
        "between loading and unloading indicates friction or backlash; a curvature that the line lacks indicates a "
        "load-dependent stiffness."
    )
    blocks: list[Block] = [Paragraph(text)]
    for number, why in chosen.items():
        name = content.runs[number].name
        picture = partial(drawing.draw_load_deformation, states, number, name)
        blocks.append(PictureBlock(picture, _caption(content, states, number, why)))
    rest = [number for number in curves if number not in chosen]
    drawn_runs = (
        rest if len(rest) <= _MOST_SMALL else [rest[i] for i in np.linspace(0, len(rest) - 1, _MOST_SMALL).astype(int)]
    )
    for sheet in map(list, wording.in_sheets(drawn_runs, drawing.ROWS_PER_SHEET)):
        names = [content.runs[number].name for number in sheet]
        other = "the other runs" if len(chosen) else "the runs"
        caption = f"Deflection against force in {other}: {wording.listing(names)}; same scale per axis."
        if len(drawn_runs) < len(rest):
            caption += f" Of {len(rest)} such runs {len(drawn_runs)}, evenly spread, are drawn."
        blocks.append(PictureBlock(partial(drawing.draw_load_deformation_sheet, states, sheet, names), caption))
    return blocks


def _caption(content: ReportContent, states: ReportStates, number: int, why: str) -> str:
    inside = np.flatnonzero(states.used & (states.run == number))
    name = content.runs[number].name
    size = np.linalg.norm(states.measured[inside, :3], axis=1)
    off = np.linalg.norm((states.measured - states.predicted)[inside, :3], axis=1)
    text = f"Run {name}" + (f" ({why})" if why else "")
    text += (
        f": under up to {wording.significant(float(states.load[inside].max()))} N the target moves by up to "
        f"{wording.length(float(size.max()))}; the largest residual is {wording.length(float(off.max()))}."
    )
    heldout = _run_rms(content).get(name)
    if heldout:
        text += f" Error of a fit without this pose: {wording.length(heldout)} rms here."
    against = _against_the_force(states, number)
    if against:
        text += (
            f" The target moves against the force {wording.listing(against, 3)}: apparent negative stiffness, caused "
            "by the force along the other axes."
        )
    return text


def _against_the_force(states: ReportStates, number: int) -> list[str]:
    """Name axes along which, at a direction's largest load, force and deflection have opposite signs and size."""
    inside = np.flatnonzero(states.used & (states.run == number))
    phrases = []
    for label in filter(None, dict.fromkeys(states.direction[inside].tolist())):
        members = inside[states.direction[inside] == label]
        top = int(members[np.argmax(states.load[members])])
        force, deflection = states.force[top], states.measured[top, :3]
        for axis, letter in enumerate(AXES_NAMES):
            significant = abs(force[axis]) > 0.1 * states.load[top] and abs(deflection[axis]) > 0.1 * np.linalg.norm(
                deflection
            )
            if significant and force[axis] * deflection[axis] < 0:
                phrases.append(f"along {letter} under load “{label}” ({wording.length(float(abs(deflection[axis])))})")
    return phrases


def _singles(content: ReportContent, states: ReportStates, singles: list[int], of_places: bool) -> list[Block]:
    """Lay out runs of single states, and rows of absolute places, of which each is a run."""
    few = (
        "one load state each"
        if int(states.used.sum()) <= len(content.runs)
        else f"fewer than {_FEWEST_STATES} load states each"
    )
    drawn_runs = _worst_singles(states, singles)
    verb = "holds" if len(singles) == 1 else "hold"
    what = "Distance from the nominal position" if of_places else "Deflection"
    were = "was" if len(singles) == 1 else "were"
    text = (
        f"{wording.count(len(singles), 'pose')} {were} measured, each once. Measured and predicted distance from the "
        f"nominal position are shown along the base axes; the line between them is the residual."
        if of_places
        else f"{wording.count(len(singles), 'run')} {verb} {few}, so no curve over the force can be drawn for them. "
        f"Measured and predicted deflection are shown by run instead; the line between them is the residual."
    )
    if len(drawn_runs) < len(singles):
        text += f" The {len(drawn_runs)} {'poses' if of_places else 'runs'} with the largest residuals are drawn."
    names = [run.name for run in content.runs]
    blocks: list[Block] = [Paragraph(text)]
    heldout = f" in {content.held_out}" if states.predicted_heldout is not None else " by the fit"
    inside = states.used & np.isin(states.run, singles)
    off = np.where(inside, np.linalg.norm(states.residual[:, :3], axis=1), -1.0)
    worst = int(np.argmax(off))
    caption = (
        f"{what} in each {'row' if of_places else 'run'}, measured and predicted{heldout}. Largest difference: run "
        f"{names[int(states.run[worst])]}, "
        f"{wording.length(float(off[worst]))}"
        + (f" under {wording.significant(float(states.load[worst]))} N." if states.load[worst] > 0.0 else ".")
    )
    picture = partial(drawing.draw_deflection_by_run, states, names, drawn_runs)
    return [*blocks, PictureBlock(picture, caption)]


def _worst_singles(states: ReportStates, singles: list[int]) -> list[int]:
    """Return the runs with the largest residuals, in their order, as many as a picture shows."""
    if len(singles) <= _MOST_SINGLES:
        return singles
    off = np.linalg.norm(np.nan_to_num(states.residual[:, :3]), axis=1)
    largest = {run: float(off[states.used & (states.run == run)].max(initial=0.0)) for run in singles}
    return sorted(sorted(singles, key=lambda run: -largest[run])[:_MOST_SINGLES])
