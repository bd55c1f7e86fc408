"""`make practice`: the campaigns whose truth is known, through the library as ingest and diagnose use it.

A table of what was hidden, what is named first and whether that is right, with the error in held-out poses before and
after, over the noise. ``campaigns/hidden`` holds those of loads, ``campaigns/joints`` those of single joints,
``campaigns/absolute`` those of absolute places. A folder given on the command line is scored alone, as one of loads or
of absolute places.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stiffcal.campaign.loading import load_campaign
from stiffcal.errors import no_progress
from stiffcal.ingest.reading.reducing import reduce_campaign
from stiffcal.judgement.diagnosed import DiagnosedStates, diagnose_states
from stiffcal.judgement.found import FoundEffect
from stiffcal.model.catalogue.campaign_effects import placed_robot
from stiffcal.model.catalogue.catalogue import built_in_effects
from stiffcal.model.effect import Place
from tests.rates.practice_joints import JOINTS, ask_joint, joint_table, read_truths
from tests.rates.workers import one_thread_each

HIDDEN = Path(__file__).resolve().parents[2] / "campaigns" / "hidden"
ABSOLUTE = HIDDEN.with_name("absolute")


@dataclass(frozen=True)
class Answer:
    """What was said of one campaign.

    Attributes
    ----------
    folder : its name.
    hidden : names of what is in it; empty where nothing is.
    outside : none of the catalogue's effects explains it.
    named : what is missing by the tool, with look-alikes in brackets.
    right : see `is_right`.
    before, after : error in held-out poses over the noise.
    noise : mm, as the tool reports it.
    seconds : of reading and judging.
    """

    folder: str
    hidden: str
    outside: bool
    named: str
    right: bool
    before: float
    after: float
    noise: float
    seconds: float


def truth(folder: Path = HIDDEN) -> dict[str, dict[str, Any]]:
    """Return what was hidden, by folder name."""
    entries = json.loads((folder / "truth.json").read_text("utf-8"))
    return {one["folder"]: one for one in entries}


def hidden_name(entry: dict[str, Any]) -> str:
    """Return an entry's effect as candidates are named."""
    return f"{entry['effect']} {hidden_place(entry).label}"


def hidden_place(entry: dict[str, Any]) -> Place:
    """Return where an entry has its effect."""
    where = entry["where"]
    if "joints" in where:
        return Place("joints", tuple(where["joints"]))
    if "pairs" in where:
        return Place("pairs", tuple(where["pairs"][0]))
    return Place("links", (), where["links"][0]) if "links" in where else Place("setup")


def diagnosed_campaign(folder: Path) -> DiagnosedStates:
    """Read a campaign as ingest does, bumped readings set aside, and find what its model lacks."""
    campaign = load_campaign(folder)
    states = reduce_campaign(campaign, no_progress).states
    return diagnose_states(states, placed_robot(campaign), built_in_effects())


def is_right(hidden: Sequence[str], outside: bool, answer: DiagnosedStates) -> bool:
    """Return whether an answer says what is true.

    Nothing hidden: nothing named, and the model is adequate. Outside the catalogue: unexplained. Else exactly the
    hidden ones are named, or look-alikes that name them, and nothing is left unexplained.
    """
    if outside:
        return bool(answer.unexplained)
    left = list(hidden)
    for one in answer.found:
        known = [one.candidate.name, *(candidate.name for candidate, _ in one.alternatives)]
        match = next((name for name in known if name in left), None)
        if match is None:
            return False
        left.remove(match)
    return not left and not answer.unexplained


def ask(folder: Path) -> Answer:
    """Diagnose one campaign and compare with its truth."""
    entry = truth(folder.parent)[folder.name]
    start = time.perf_counter()
    answer = diagnosed_campaign(folder)
    seconds = time.perf_counter() - start
    hidden = [hidden_name(one) for one in entry["hidden"]]
    noise = answer.last.fit.noise_length["translation"]
    return Answer(
        folder=folder.name,
        hidden=" + ".join(hidden),
        outside=entry["outside_the_catalogue"],
        named=" + ".join(_identified(one) for one in answer.found) or ("none of these" if answer.unexplained else ""),
        right=is_right(hidden, entry["outside_the_catalogue"], answer),
        before=answer.before.ratio if answer.before else float("nan"),
        after=answer.after.ratio if answer.after else float("nan"),
        noise=1e3 * noise if noise else float("nan"),
        seconds=seconds,
    )


def _identified(one: FoundEffect) -> str:
    others = ", ".join(candidate.name for candidate, _ in one.alternatives)
    return one.candidate.name + (f" (or {others})" if others else "")


def table_of(answers: Sequence[Answer]) -> str:
    """Return the table."""
    hidden = [(one.hidden + (" (outside the catalogue)" if one.outside else "")) or "nothing" for one in answers]
    named = [one.named or "nothing" for one in answers]
    first, second = (2 + max(map(len, [title, *column])) for title, column in (("hidden", hidden), ("named", named)))
    lines = [
        f"{'':<4}{'hidden':<{first}}{'named':<{second}}{'right':<7}{'before':>7}{'after':>7}  {'noise mm':>8}{'s':>6}"
    ]
    lines += [
        f"{one.folder:<4}{there:<{first}}{answer:<{second}}{'yes' if one.right else 'NO':<7}"
        f"{one.before:>7.2f}{one.after:>7.2f}  {one.noise:>8.4f}{one.seconds:>6.1f}"
        for one, there, answer in zip(answers, hidden, named, strict=True)
    ]
    right = sum(one.right for one in answers)
    lines.append(f"{right} of {len(answers)} right; errors in held-out poses, over the noise")
    return "\n".join(lines)


def main(arguments: Sequence[str]) -> int:
    """Ask all; the folder may be given."""
    chosen = [Path(argument) for argument in arguments[:1]] or [HIDDEN, ABSOLUTE]
    folders = [folder / name for folder in chosen for name in sorted(truth(folder))]
    folders = [folder for folder in folders if (folder / "campaign.toml").is_file()]
    joints = [] if arguments else [JOINTS / name for name in sorted(read_truths())]
    with one_thread_each(2) as pool:
        answers, of_joints = list(pool.map(ask, folders)), list(pool.map(ask_joint, joints))
    tables = [table_of([a for a, f in zip(answers, folders, strict=True) if f.parent == folder]) for folder in chosen]
    if of_joints:
        tables.insert(1, f"Joints\n{joint_table(of_joints)}")
        tables[2] = f"Absolute places\n{tables[2]}"
    print("\n\n".join(tables))
    right = [answer.right for answer in answers] + [answer.right for answer in of_joints]
    return 0 if all(right) else 1


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
