"""The loop: diagnose, add, identify, until nothing is missing; every rung of the ladder in the history."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from stiffcal.documents import document_of
from stiffcal.workflow.diagnose import diagnose_campaign
from stiffcal.workflow.edit_model import edit_model
from stiffcal.workflow.steps import Document, RunContext
from stiffcal.workflow.validate import validate_campaign

SCHEMA = "stiffcal/improve/1"
# More rungs than effects that a diagnosis looks for: the loop ends by itself long before.
MOST_STEPS = 12

Ask = Callable[[Document], bool]


def always(step: Document) -> bool:
    """Agree to every step."""
    return True


def improve_campaign(
    folder: Path,
    context: RunContext | None = None,
    ask: Ask = always,
    dry_run: bool = False,
    told: Callable[[Document], None] | None = None,
) -> Document:
    """Add what is missing, one effect after another, each followed by a fit and its error in unseen poses.

    Parameters
    ----------
    folder : the campaign folder.
    context : store, progress and so on.
    ask : asked before each step; the loop stops where it says no.
    dry_run : only say what would be added.
    told : told each rung of the ladder as it is reached.

    Returns
    -------
    dict
        The `improve` document (interface, section 4).

    Raises
    ------
    InputError : the input is wrong.
    """
    context = context or RunContext()
    ladder = _Ladder(folder, context, told)
    ladder.reached("start", None, {})
    diagnosed = diagnose_campaign(folder, context)
    if dry_run:
        ladder.steps += [_would_add(one) for one in diagnosed["missing"]]
    else:
        diagnosed = _climb(ladder, diagnosed, ask)
    judged = validate_campaign(folder, context)
    return {
        "schema": SCHEMA,
        "warnings": list(diagnosed["warnings"]),
        "steps": ladder.steps,
        "model": _present_model(folder, context),
        "adequate": diagnosed["adequate"],
        "unexplained": diagnosed["unexplained"],
        "missing": diagnosed["missing"],
        "structure": diagnosed["structure"],
        "summary": diagnosed["summary"],
        "heldout_rms": judged["rms"],
        "noise": judged["noise"],
    }


@dataclass
class _Ladder:
    """The rungs reached so far, each a change of the model with the error in unseen poses after it.

    Attributes
    ----------
    folder, means, told : as `improve_campaign` was given them.
    steps : the rungs, first the model as it was.
    """

    folder: Path
    context: RunContext
    told: Callable[[Document], None] | None
    steps: list[Document] = field(default_factory=list)

    def reached(self, action: str, effect: str | None, where: Any) -> None:
        """Judge the present model and note what was done to get there."""
        judged = validate_campaign(self.folder, self.context)
        step = {
            "action": action,
            "effect": effect,
            "where": where,
            "heldout_rms": judged["rms"],
            "noise": judged["noise"],
            "zero_model": judged["zero_model"],
        }
        self.steps.append(step)
        if self.told is not None:
            self.told(step)

    def edit(self, action: Literal["add", "remove"], change: Document) -> None:
        """Change the model, and judge it."""
        edit_model(self.folder, action, change["effect"], where=places_as_words(change["where"]))
        self.reached(action, change["effect"], change["where"])


def _climb(ladder: _Ladder, diagnosed: Document, ask: Ask) -> Document:
    """Add what is missing until nothing is, or the answer is no; return the last diagnosis."""
    for _ in range(MOST_STEPS):
        if not diagnosed["missing"] or not ask(diagnosed["missing"][0]):
            break
        ladder.edit("add", diagnosed["missing"][0])
        diagnosed = diagnose_campaign(ladder.folder, ladder.context)
        for one in diagnosed.get("superfluous", []):
            ladder.edit("remove", one)
    return diagnosed


def _would_add(proposal: Document) -> Document:
    """Return the rung of a dry run: nothing is changed, so nothing is known of the error."""
    return {
        "action": "would add",
        "effect": proposal["effect"],
        "where": proposal["where"],
        "heldout_rms": None,
        "noise": None,
    }


def places_as_words(where: Document) -> dict[str, str | None]:
    """Return places as the command line takes them.

    Examples
    --------
    >>> places_as_words({"pairs": [[5, 6]]})["pairs"]
    '5-6'
    """
    return {
        "joints": ",".join(str(joint) for joint in where.get("joints", [])) or None,
        "links": ",".join(where.get("links", [])) or None,
        "pairs": ",".join(f"{a}-{b}" for a, b in where.get("pairs", [])) or None,
    }


def _present_model(folder: Path, context: RunContext) -> Document:
    from stiffcal.campaign.loading import load_campaign
    from stiffcal.workflow.history import model_of

    return document_of(model_of(load_campaign(Path(folder), check_files=False).model))
