"""`make calibration`: the field mix judged, campaign by campaign, and whether the judge is right as often as it says.

    python -m tests.calibration evidence --seed 1 --count 300 --to build/calibration

Judged campaigns are kept by judge, seed and number; a second call goes on where the first stopped. With `--stress` the
campaigns are of one class of `tests.calibration.stress.classes`, or of all, kept under the class's name; they are in no
laboratory's proportions, so that no probability is held against them. `self-check` judges
small problems drawn from the very priors, whose probabilities have to be right exactly; `numbers` doubles each number
of the computation and reports the largest change of a probability; with folders after `--practice` it doubles and
halves the priors and what is ours, in these campaigns.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from tests.calibration import numbers, self_check
from tests.calibration.judging import JudgedCampaign, judged, read_line
from tests.calibration.stress.classes import CLASSES
from tests.calibration.stress.tables import stress_table
from tests.calibration.tables import table
from tests.rates.workers import one_thread_each

JUDGES = ("evidence", "self-check", "numbers")


def main(arguments: Sequence[str]) -> int:
    """Judge what has not been judged yet, and print the tables."""
    parser = argparse.ArgumentParser(prog="python -m tests.calibration", description=__doc__)
    parser.add_argument("judge", choices=JUDGES)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--stress", choices=[*CLASSES, "all"], metavar="CLASS")
    parser.add_argument("--practice", type=Path, nargs="+", metavar="DIR")
    parser.add_argument("--only", nargs="+", metavar="NUMBER", help="of the numbers of the computation")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--to", type=Path, default=Path("build/calibration"))
    chosen = parser.parse_args(arguments)
    if chosen.judge == "self-check":
        print(self_check.table(self_check.drawn_and_judged(chosen.seed, chosen.count)))
        return 0
    if chosen.judge == "numbers":
        if chosen.practice:
            changed = {k: v for name in (*numbers.OURS, *numbers.PRIORS) for k, v in numbers.changes(name).items()}
            print(numbers.table(numbers.of_practice(chosen.practice), changed))
        else:
            doubled = {name: numbers.COMPUTED[name] for name in chosen.only or numbers.COMPUTED}
            print(numbers.table(numbers.of_field_mix(chosen.seed, chosen.first, chosen.count), doubled))
        return 0
    chosen.to.mkdir(parents=True, exist_ok=True)
    wanted = range(chosen.first, chosen.first + chosen.count)
    if chosen.stress:
        names = list(CLASSES) if chosen.stress == "all" else [chosen.stress]
        print(stress_table({name: _judged_now(chosen, wanted, name) for name in names}))
    else:
        print(table(_judged_now(chosen, wanted)))
    return 0


def _judged_now(chosen: argparse.Namespace, wanted: range, stress: str = "") -> list[JudgedCampaign]:
    """Return the judged campaigns that are wanted; those that are not kept yet are judged and kept."""
    kept = chosen.to / "-".join([chosen.judge, *([stress] if stress else []), f"{chosen.seed}.jsonl"])
    known = [read_line(line) for line in kept.read_text(encoding="utf-8").splitlines()] if kept.exists() else []
    left = sorted(set(wanted) - {record.number for record in known})
    if left:
        one = partial(judged, chosen.judge, chosen.seed, stress=stress)
        with one_thread_each(chosen.workers) as pool, kept.open("a", encoding="utf-8") as file:
            for record in pool.map(one, left):
                known.append(record)
                file.write(record.line() + "\n")
                file.flush()
    return [record for record in known if record.number in wanted]


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
