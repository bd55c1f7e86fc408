"""Residuals: by run, direction, load, branch and joint angle, and against what they might follow."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

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
from stiffcal.report.content import Document, ReportContent, ReportStates
from stiffcal.report.figures.residual_against import MOST_POINTS, draw_residual_against
from stiffcal.report.figures.residuals_by import draw_residuals_by, draw_residuals_by_run
from stiffcal.report.sections.summary import noise_sentence

ORDER = 70
_TITLE = "Where the model fails"
_GROUPS = (("by_direction", "direction of force"), ("by_load", "load [N]"), ("by_branch", "branch"))
_WORST_COLUMNS = {
    "residual_m": (TableColumn("residual", "mm"), 1e3),
    "load": (TableColumn("load", "N"), 1.0),
    "row": (TableColumn("row"), 1.0),
}
_COVARIATES_PER_PICTURE = 4
_MOST_RUNS_PER_PICTURE = 60
_JOINTS_PER_PICTURE = 7


def section(content: ReportContent) -> ReportSection | LeftOut:
    """Lay out the residuals every way they were sorted."""
    validation = content.validate
    blocks: list[Block] = []
    if content.states is None and validation is not None:
        return LeftOut(_TITLE, "there are no load states to draw")
    if validation is not None:
        blocks.append(Paragraph(_lead(validation)))
        blocks.extend(_by_run(validation))
        blocks.extend(_by_groups(validation))
    if content.states is not None and content.states.used.any() and content.covariates and content.identify is not None:
        blocks.extend(_against(content, content.states))
    if validation is not None:
        blocks.extend(_worst(validation))
    if not blocks:
        return LeftOut(_TITLE, "the model has not been validated yet: run “stiffcal validate”")
    return ReportSection(_TITLE, tuple(blocks))


def _lead(validation: Document) -> str:
    scheme = validation.get("scheme")
    scheme_words = f" ({scheme})" if isinstance(scheme, str) else ""
    return (
        f"Residual: measured minus predicted, in poses the fit had not seen{scheme_words}; rms of its length. Over all "
        f"states: {wording.both(validation.get('rms'))} rms, {wording.both(validation.get('max'))} at most. "
        f"{noise_sentence(validation)}"
    )


def _translation(entry: dict[str, Any]) -> float:
    return wording.part(entry.get("rms"), "translation") or 0.0


def _extremes(entries: list[dict[str, Any]], kind: str = "") -> str:
    """Name the entries with the largest and the smallest residual, or state that all are alike."""
    low, high = min(entries, key=_translation), max(entries, key=_translation)
    least, most = _translation(low), _translation(high)
    if len(entries) < 2 or least <= 0:
        return f"{high['label']} {wording.both(high.get('rms'))} rms."
    if most < 1.15 * least:
        return f"much the same everywhere, {wording.length(least)} to {wording.length(most)} rms."
    return (
        f"largest in {kind}{high['label']} ({wording.length(most)} rms), smallest in {kind}{low['label']} "
        f"({wording.length(least)}), a factor of {wording.digits(most / least, 2)}."
    )


def _noise_words(validation: Document) -> str:
    noise = validation.get("noise")
    return (
        f" The dashed line is the noise, {wording.both(noise)}." if noise else " No noise line: noise cannot be judged."
    )


def _by_run(validation: Document) -> list[Block]:
    # runs whose flange was held have errors of motor angles and torques alone: they are on their own pages
    measures = ("translation", "rotation", "length")
    entries = [
        run_entry
        for run_entry in validation.get("by_run", [])
        if any(run_entry["rms"].get(key) is not None for key in measures)
    ]
    if not entries:
        return []
    blocks: list[Block] = []
    for start in range(0, len(entries), _MOST_RUNS_PER_PICTURE):
        group = entries[start : start + _MOST_RUNS_PER_PICTURE]
        caption = f"Residual by run: {_extremes(group, 'run ')}{_noise_words(validation)}"
        blocks.append(PictureBlock(partial(draw_residuals_by_run, group, validation.get("noise")), caption))
    return blocks


def _by_groups(validation: Document) -> list[Block]:
    groups = [(title, _short(validation[key], "")) for key, title in _GROUPS if len(validation.get(key) or []) > 1]
    blocks: list[Block] = []
    if groups:
        several = [(key, title) for key, title in _GROUPS if len(validation.get(key) or []) > 1]
        text = " ".join(f"By {_plain(title)}: {_extremes(validation[key])}" for key, title in several)
        missing = [_plain(title) for key, title in _GROUPS if len(validation.get(key) or []) <= 1]
        if missing:
            text += f" Not sorted by {wording.listing(missing)}: these data hold only one kind."
        names = wording.listing([_plain(title) for title, _ in groups])
        caption = f"Residual by {names}. {text}{_noise_words(validation)}"
        blocks.append(PictureBlock(partial(draw_residuals_by, groups, validation.get("noise")), caption))
    angles = validation.get("by_joint_angle") or []
    if len(angles) > 1:
        caption = f"Residual by joint angle: {_extremes(angles)}{_noise_words(validation)}"
        joints = list(dict.fromkeys(_joint_of(entry) for entry in angles))
        for sheet in wording.in_sheets(range(len(joints)), _JOINTS_PER_PICTURE):
            parts = [
                (
                    f"{joints[number]} [°]",
                    _short([entry for entry in angles if _joint_of(entry) == joints[number]], "°"),
                )
                for number in sheet
            ]
            blocks.append(PictureBlock(partial(draw_residuals_by, parts, validation.get("noise")), caption))
    return blocks


def _plain(title: str) -> str:
    return title.partition(" [")[0]


def _joint_of(entry: dict[str, Any]) -> str:
    """Which joint an entry of ``by_joint_angle`` is about: its label before the colon."""
    return str(entry["label"]).partition(":")[0]


def _short(entries: list[dict[str, Any]], unit: str) -> list[dict[str, Any]]:
    """Write ranges as labels of whole numbers, degrees where `unit` is degrees; other labels stay."""
    factor = 180.0 / math.pi if unit == "°" else 1.0
    ranged = [entry for entry in entries if entry.get("low") is not None and entry.get("high") is not None]
    labels = {
        id(entry): f"{entry['low'] * factor:.0f} … {entry['high'] * factor:.0f}".replace("-", "−") for entry in ranged
    }
    return [entry | {"label": labels.get(id(entry), entry["label"])} for entry in entries]


def _worst(validation: Document) -> list[Block]:
    """List the worst states, whatever columns the document gives them."""
    worst = [entry for entry in validation.get("worst") or [] if isinstance(entry, dict)]
    if not worst:
        return []
    keys = [key for key in worst[0] if any(entry.get(key) not in (None, "") for entry in worst)]
    keys = [key for key in keys if not isinstance(worst[0][key], dict | list)]
    if len({entry.get("branch") for entry in worst}) == 1:
        keys = [key for key in keys if key != "branch"]
    columns = tuple(_WORST_COLUMNS.get(key, (TableColumn(key.replace("_", " "), align="left"), 1.0))[0] for key in keys)
    rows = tuple(
        tuple(_cell(entry.get(key), _WORST_COLUMNS.get(key, (None, 1.0))[1]) for key in keys) for entry in worst[:10]
    )
    caption = "The states with the largest residuals; look at these readings first."
    return [SubheadingBlock("The worst states"), TableBlock(columns, rows, caption)]


def _cell(value: Any, scale: float) -> str:
    return wording.digits(value * scale) if isinstance(value, float) else wording.DASH if value is None else str(value)


def _against(content: ReportContent, states: ReportStates) -> list[Block]:
    fit_noise = None if content.identify is None else content.identify.noise
    noise = wording.part(content.validate["noise"] if content.validate else fit_noise, "translation")
    caption = "Residual against {}. A cloud without a trend says that the residual does not follow it."
    if noise is not None:
        caption += " Grey band: two standard deviations of the noise to either side."
    n_used = int(states.used.sum())
    if n_used > MOST_POINTS:
        caption += (
            f" About {MOST_POINTS} of {wording.count(n_used, 'state')} are drawn, the largest residuals among them."
        )
    blocks: list[Block] = [SubheadingBlock("What the residual might follow")]
    for sheet in wording.in_sheets(range(len(content.covariates)), _COVARIATES_PER_PICTURE):
        group = [content.covariates[number] for number in sheet]
        text = caption.format(wording.listing([covariate.name for covariate in group]))
        blocks.append(PictureBlock(partial(draw_residual_against, states, group, noise), text))
    return blocks
