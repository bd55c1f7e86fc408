"""The loop: diagnose, add, identify, until nothing is missing; every rung of the ladder in the history."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from stiffcal.workflow.diagnose import diagnose_campaign
from stiffcal.workflow.edit_model import edit_model
from stiffcal.workflow.steps import Document, Means
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
    means: Means | None = None,
    ask: Ask = always,
    dry_run: bool = False,
    told: Callable[[Document], None] | None = None,
) -> Document:
    """Add what is missing, one effect after another, each followed by a fit and its error in unseen poses.

    Parameters
    ----------
    folder : the campaign folder.
    means : store, progress and so on.
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
    means = means or Means()
    steps: list[Document] = []

    def reached(action: str, effect: str | None, where: Any) -> Document:
        judged = validate_campaign(folder, means)
        step = {
            "action": action,
            "effect": effect,
            "where": where,
            "heldout_rms": judged["rms"],
            "noise": judged["noise"],
        }
        step["zero_model"] = judged["zero_model"]
        steps.append(step)
        if told is not None:
            told(step)
        return judged

    reached("start", None, {})
    diagnosed = diagnose_campaign(folder, means)
    for _ in range(MOST_STEPS):
        missing = diagnosed["missing"]
        if not missing:
            break
        proposal = missing[0]
        if dry_run:
            steps += [
                {
                    "action": "would add",
                    "effect": one["effect"],
                    "where": one["where"],
                    "heldout_rms": None,
                    "noise": None,
                }
                for one in missing
            ]
            break
        if not ask(proposal):
            break
        edit_model(folder, "add", proposal["effect"], where=places_as_words(proposal["where"]))
        reached("add", proposal["effect"], proposal["where"])
        diagnosed = diagnose_campaign(folder, means)
        _drop_superfluous(folder, diagnosed, reached)
    judged = validate_campaign(folder, means)
    return {
        "schema": SCHEMA,
        "warnings": list(diagnosed["warnings"]),
        "steps": steps,
        "model": _present_model(folder, means),
        "adequate": diagnosed["adequate"],
        "unexplained": diagnosed["unexplained"],
        "missing": diagnosed["missing"],
        "structure": diagnosed["structure"],
        "summary": diagnosed["summary"],
        "heldout_rms": judged["rms"],
        "noise": judged["noise"],
    }


def _drop_superfluous(folder: Path, diagnosed: Document, reached: Callable[[str, str | None, Any], Document]) -> None:
    """Take out what the diagnosis calls superfluous."""
    for one in diagnosed.get("superfluous", []):
        edit_model(folder, "remove", one["effect"], where=places_as_words(one["where"]))
        reached("remove", one["effect"], one["where"])


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


def _present_model(folder: Path, means: Means) -> Document:
    from stiffcal.campaign.loading import load_campaign
    from stiffcal.workflow.history import model_of

    return model_of(load_campaign(Path(folder), check_files=False).model)
