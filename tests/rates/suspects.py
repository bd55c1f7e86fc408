"""`python -m tests.rates.suspects --seed N [--count N]`: how often a faulty run or row is named, and a sound one is.

A fault counts as one that can be found where it changes the run's misfit by five times the noise or more, its
parameters known. Named means the faulty run with the right kind and no sound run; of two runs that are exchanged the
second may be below what can be found. Campaigns are drawn on robots of `tests.laboratory.random_robots`, from which
nothing in the search was taken.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from stiffcal.diagnosis.suspects.find import find_suspects
from tests.rates.faults import FAULTS, FORMS, draw_faulty
from tests.rates.intervals import clopper_pearson

LEAST_CHANGE = 5.0
SOUND = {"nothing": "", "hidden effect": "anywhere", "few poses": "few poses"}
"""Campaigns without a fault: with joint springs alone, and with an effect that the model lacks at 4 × the noise, in any
poses or in few.
"""


@dataclass(frozen=True)
class Outcome:
    """What was named in one campaign."""

    form: str
    fault: str
    number: int
    findable: bool
    right: bool
    any_named: bool
    change: float
    found: str
    settings: str
    seconds: float


def judge(seed: int, form: str, fault: str, number: int) -> Outcome:
    """Draw a campaign and say what was named in it."""
    rng = np.random.default_rng([seed, FORMS.index(form), (*FAULTS, *SOUND).index(fault), number])
    campaign = draw_faulty(rng, form, "" if fault in SOUND else fault, SOUND.get(fault, ""))
    start = time.perf_counter()
    found = find_suspects(campaign.states, campaign.model).suspects
    seconds = time.perf_counter() - start
    named = {suspect.run for suspect in found}
    right = set(campaign.runs[:1]) <= named <= set(campaign.runs)
    right &= all(suspect.kind in campaign.kinds for suspect in found)
    words = "; ".join(f"{suspect.run} {suspect.kind} {suspect.score:.1f}/{suspect.next_score:.1f}" for suspect in found)
    findable = campaign.change >= LEAST_CHANGE and campaign.deflection >= LEAST_CHANGE
    return Outcome(
        form, fault, number, findable, right, bool(found), campaign.change, words, campaign.settings, seconds
    )


def table_of(outcomes: Sequence[Outcome]) -> str:
    """Return the rates as text, with Wilson's 95 % intervals."""
    lines = []
    for form in FORMS:
        for fault in (*FAULTS, *SOUND):
            own = [entry for entry in outcomes if (entry.form, entry.fault) == (form, fault)]
            if not own:
                continue
            if fault in SOUND:
                hits, words = [entry.any_named for entry in own], "a suspect named"
            else:
                hits, words = [entry.right for entry in own if entry.findable], "right runs and kind"
            low, high = clopper_pearson(sum(hits), len(hits))
            lines.append(
                f"{form:<8}{fault:<18}{words:<22}{sum(hits):>4} of {len(hits):<4}({100 * low:.1f}–{100 * high:.1f} %)"
            )
    seconds = [entry.seconds for entry in outcomes]
    return "\n".join([*lines, f"seconds: median {np.median(seconds):.1f}, most {max(seconds):.1f}"])


def main() -> None:
    """Draw, judge, print."""
    parser = argparse.ArgumentParser(prog="python -m tests.rates.suspects", description=__doc__)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--count", type=int, default=50, help="campaigns per form and fault")
    parser.add_argument("--forms", default=",".join(FORMS))
    parser.add_argument("--faults", default=",".join((*FAULTS, *SOUND)))
    parser.add_argument("--verbose", action="store_true", help="a line per campaign that did not go well")
    parser.add_argument("--json", type=Path, help="write every outcome to this file")
    chosen = parser.parse_args()
    outcomes = []
    for form in chosen.forms.split(","):
        for fault in chosen.faults.split(","):
            if (form, fault) == ("mujoco", "few poses"):
                continue  # a bearing that tilts shows in nearly all poses
            for number in range(chosen.count):
                outcome = judge(chosen.seed, form, fault, number)
                outcomes.append(outcome)
                well = not outcome.any_named if fault in SOUND else outcome.right or not outcome.findable
                if chosen.verbose and not well:
                    print(
                        f"{form} {fault} {number}: {outcome.settings}; change {outcome.change:.1f}; "
                        f"found {outcome.found or 'nothing'}",
                        flush=True,
                    )
    print(table_of(outcomes))
    if chosen.json:
        chosen.json.write_text(json.dumps([asdict(entry) for entry in outcomes], indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
