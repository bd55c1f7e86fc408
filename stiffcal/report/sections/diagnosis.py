"""The answer of the diagnosis: good enough, what is missing, and what a remainder follows."""

from __future__ import annotations

from stiffcal.report import wording
from stiffcal.report.blocks import (
    Block,
    Facts,
    Items,
    LeftOut,
    Paragraph,
    ReportSection,
    Subheading,
    TableBlock,
    TableColumn,
)
from stiffcal.report.content import Document, ReportContent

ORDER = 72
_TITLE = "What is missing"


def section(content: ReportContent) -> ReportSection | LeftOut:
    """Lay out the answer first, then what it rests on."""
    document = content.diagnose
    if document is None:
        return LeftOut(_TITLE, content.not_diagnosed)
    blocks: list[Block] = [Paragraph(str(document["summary"]), "key")]
    if content.states is not None:
        blocks.append(Paragraph(_meaning(document)))
    missing = document["missing"]
    if missing:
        blocks.append(Items(tuple(_missing_words(one) for one in missing)))
    blocks.append(Facts(tuple(_facts(document))))
    if document["structure"]:
        blocks.extend(_remainder(document))
    if document.get("superfluous"):
        names = wording.listing([_named(one) for one in document["superfluous"]])
        blocks.append(Paragraph(f"Not needed: {names}. Without it the error in unseen poses is no larger."))
    blocks.extend(_way_here(content))
    return ReportSection(_TITLE, tuple(blocks))


def _named(one: Document) -> str:
    return f"{one['effect']} ({wording.place(one['where'])})"


def _meaning(document: Document) -> str:
    """Say what the answer means for whoever has to act on it."""
    n = document.get("n_candidates")
    tried = f"{wording.count(n, 'effect')} at their places were tried beside the present model, " if n else ""
    tried += "everything else fitted again with each, judged in poses the fit had not seen."
    text = f"{tried[:1].upper()}{tried[1:]} "
    if document["adequate"] is None:
        return text + "Whether what is left is noise cannot be judged: no load was repeated, and no uncertainty stated."
    if document["adequate"]:
        return text + (
            "No effect lowers the error by more than chance would. What is left scatters like the instruments and the "
            "setting of loads; a better model needs better instruments first."
        )
    if document.get("could_be"):
        names = wording.listing([_named(one) for one in document["could_be"]], 40)
        return text + (
            "The error is larger than the noise. In these poses and loads the following look alike, each of them able "
            f"to make all of it: {names}. More poses, or loads along other axes in these, tell them apart."
        )
    if document["unexplained"]:
        words = "beyond what is named here " if document["missing"] else ""
        return text + (
            f"The error is larger than the noise, and {words}no effect of the catalogue, nor several together, brings "
            "it down to it. No name is given rather than a wrong one; what the remainder follows stands below."
        )
    return text + "With what is named here the error falls to the noise:"


def _missing_words(one: Document) -> str:
    names = [_named(each) for each in one["alternatives"]]
    alike = f"; in these poses and loads {wording.listing(names, 6)} would look the same" if names else ""
    return f"{_named(one)}{alike}"


def _facts(document: Document) -> list[tuple[str, str]]:
    facts = [("present model", f"{wording.both(document['rms'])} rms in unseen poses")]
    if document["missing"]:
        after = document.get("heldout_rms_with_missing")
        facts.append(("with what is missing", f"{wording.both(after)} rms in unseen poses"))
    noise = wording.both(document["noise"]) + " rms" if document["noise"] else "not known"
    facts.append(("noise", noise))
    lack = document.get("lack_of_fit")
    if lack:
        dof = wording.digits(lack["dof"][0]), wording.digits(lack["dof"][1]) if lack["dof"][1] else "∞"
        p = lack["p_value"]
        chance = f"p = {wording.digits(p, 2)}" if p >= 1e-12 else "p below 10⁻¹²"
        facts.append(
            (
                "lack of fit",
                f"F = {wording.digits(lack['statistic'])} with {dof[0]} and {dof[1]} degrees of freedom, {chance}",
            )
        )
    explained = document.get("explained_by_missing")
    if explained is not None and document["missing"] and document["noise"]:
        facts.append(("explained", f"{wording.percent(explained)} of the avoidable error goes with it"))
    return facts


def _remainder(document: Document) -> list[Block]:
    columns = (
        TableColumn("follows", align="left"), TableColumn("share", "of what is left"),
        TableColumn("what was seen", align="left", width=1.0),
    )  # fmt: skip
    rows = tuple((one["follows"], wording.percent(one["share"]), str(one["seen"])) for one in document["structure"])
    caption = (
        "What the remainder follows: the share of its squares beyond noise that smooth curves over each of these take "
        "away. Shares overlap; the largest says where to look first."
    )
    return [Subheading("What the remainder follows"), TableBlock(columns, rows, caption)]


def _way_here(content: ReportContent) -> list[Block]:
    """Name the earlier diagnoses that made the model what it is."""
    if not content.earlier_diagnoses:
        return []
    points = tuple(f"Fit {one['fit_id']}: {one['summary']}" for one in content.earlier_diagnoses)
    return [Subheading("How the model came to this"), Items(points)]
