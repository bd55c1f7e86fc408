"""Friction of the drives: a table, and torque over velocity for every joint (004, Fig. 4)."""

from __future__ import annotations

from functools import partial

from stiffcal.report import wording
from stiffcal.report.blocks import Block, Items, LeftOut, Paragraph, Picture, ReportSection, TableBlock, TableColumn
from stiffcal.report.content import ReportContent
from stiffcal.report.figures.friction import draw_friction
from stiffcal.report.friction_curves import FrictionCurve

ORDER = 45
_TITLE = "Friction of the drives"
_PER_PICTURE = 3
_SYMBOLS = ("coulomb", "viscous", "stribeck", "velocity", "exponent")


def section(content: ReportContent) -> ReportSection | LeftOut | None:
    """Lay out the law, its parameters, and the curves; nothing where the campaign holds no friction runs."""
    curves: tuple[FrictionCurve, ...] = tuple(content.extra.get("friction", ()))
    if not curves:
        told = content.identify is not None and content.identify.friction is not None
        return LeftOut(_TITLE, "no reading of the friction runs can be used") if told else None
    blocks: list[Block] = [Paragraph(_law_words(curves)), _table(curves)]
    remarks = [f"{curve.joint}: {words}" for curve in curves for words in curve.remarks]
    if remarks:
        blocks += [Paragraph("What these runs do not show:"), Items(tuple(remarks))]
    for start in range(0, len(curves), _PER_PICTURE):
        part = curves[start : start + _PER_PICTURE]
        blocks.append(Picture(partial(draw_friction, part), _caption(part)))
    return ReportSection(_TITLE, tuple(blocks), new_page=True)


def identified_friction(content: ReportContent) -> frozenset[str]:
    """Return the names of the parameters that this section shows: others need not show them again."""
    fit = content.identify
    if not content.extra.get("friction") or fit is None or fit.friction is None:
        return frozenset()
    laws = set(fit.friction.effects or ())
    of_laws = [parameter for parameter in fit.parameters if parameter.effect in laws]
    places = [parameter.where for parameter in of_laws if parameter.value is not None]
    return frozenset(parameter.name for parameter in of_laws if parameter.where in places)


def _law_words(curves: tuple[FrictionCurve, ...]) -> str:
    words = (
        "Friction torque at a velocity ω, at the joint's side of the gear: (coulomb + stribeck · exp(−|ω / velocity|^"
        "exponent)) · sign ω + viscous · ω (paper 004, eq. 1). "
    )
    if any(curve.steady for curve in curves):
        words += (
            "Velocities are as logged, both ways; half the difference of the two directions over the same stretch of "
            "angle is free of weight. "
        )
    if not all(curve.steady for curve in curves):
        words += "Where no velocity was held, weight and inertia of the moving links were fitted with the friction. "
    return words.strip()


def _table(curves: tuple[FrictionCurve, ...]) -> TableBlock:
    columns = (
        TableColumn("joint", align="left"),
        TableColumn("coulomb", "N·m"),
        TableColumn("viscous", "N·m·s/rad"),
        TableColumn("stribeck", "N·m"),
        TableColumn("velocity", "rad/s"),
        TableColumn("exponent"),
        TableColumn("left, rms", "N·m"),
        TableColumn("noise", "N·m"),
    )
    rows = []
    for curve in curves:
        known = {symbol: (value, half) for symbol, value, half, _ in curve.parameters}
        cells = []
        for symbol in _SYMBOLS:
            if symbol not in known:
                cells.append(wording.DASH)
                continue
            value, half = known[symbol]
            cells.append(wording.digits(value) + (f" ± {wording.digits(half, 2)}" if half is not None else " (held)"))
        noise = wording.DASH if curve.noise is None else wording.digits(curve.noise)
        rows.append((curve.joint, *cells, wording.digits(curve.rms), noise))
    return TableBlock(columns, tuple(rows), "Friction of the drives, with 95 % uncertainty. A dash: not seen.")


def _caption(curves: tuple[FrictionCurve, ...]) -> str:
    names = wording.listing([curve.joint for curve in curves])
    fastest = max(float(abs(curve.velocity).max()) for curve in curves)
    return (
        f"Friction torque over speed of {names}, up to {wording.digits(fastest)} rad/s: as measured both ways (folded "
        "onto positive speeds), the fitted law, and the 95 % interval of its curve. Left the slow range on a scale of "
        "its own."
    )
