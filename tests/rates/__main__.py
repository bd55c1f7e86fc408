"""`make rates SEED=… [COUNT=…]`: fresh campaigns, the rates of the issue, and the campaigns behind each.

Ten campaigns of one class: `python -m tests.rates --seed 7 --count 10 --classes "clamped 3x"`; the names of all classes
are `tests.rates.playing.CLASSES` and `tests.rates.workers.BENCHES`. Intervals are exact (`tests.rates.intervals`).
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np

from tests.rates import benches
from tests.rates.intervals import clopper_pearson, highest
from tests.rates.playing import CLASSES, FAULTY, PLAYED_BY_BALANCE, player_of
from tests.rates.scoring import Verdict
from tests.rates.workers import BENCHES, Job, one_campaign, one_thread_each

# What the issue asks of each class.
ASKED = {
    "none": 0.98, "one 4x": 0.98, "one 1x": 0.90, "one 0.5x": 0.75, "several": 0.80, "outside 4x": 0.90,
    "outside 1x": 0.90,
    "clamped none": 0.98, "clamped 3x": 0.95, "clamped 1x": 0.85, "clamped two": 0.80, "clamped outside": 0.90,
    "friction none": 0.98, "friction 3x": 0.95, "friction 1x": 0.85, "friction two": 0.80, "friction outside": 0.90,
    "robot none": 0.98, "robot 3x": 0.95, "robot 1x": 0.85, "robot two": 0.80,
    "absolute none": 0.98, "absolute 3x": 0.95, "absolute 1x": 0.85, "absolute two": 0.80, "absolute outside": 0.90,
}  # fmt: skip


def table_of(verdicts: Sequence[Verdict]) -> str:
    """Return the rates as text."""
    lines = [f"{'class':<17}{'good':>6}{'of':>5}{'rate':>8}   95 % interval   asked  firm wrong  MuJoCo  outcomes"]
    for kind in (*CLASSES, *BENCHES):
        own = [v for v in verdicts if v.kind == kind]
        if not own:
            continue
        good = sum(v.good for v in own)
        low, high = clopper_pearson(good, len(own))
        counts = ", ".join(f"{n} {name}" for name, n in Counter(v.outcome for v in own).most_common())
        asked = f"{100 * ASKED[kind]:.0f} %" if kind in ASKED else "–"
        firm = sum(v.firm_wrong for v in own)
        mujoco = sum(v.player == "mujoco" for v in own)
        lines.append(
            f"{kind:<17}{good:>6}{len(own):>5}{100 * good / len(own):>7.1f}%   {100 * low:5.1f}–{100 * high:5.1f} %"
            f"   {asked:>5}  {firm:>10}  {mujoco:>6}  {counts}"
        )
    named = [v for v in verdicts if v.good and v.hidden and "outside" not in v.kind and v.kind not in FAULTY]
    judged = [v.p_parameters for v in verdicts if v.p_parameters is not None]
    outside = [v for v in verdicts if "outside" in v.kind]
    new = [v.firm_wrong for v in verdicts if v.kind not in PLAYED_BY_BALANCE]
    lines += [
        _share("a firm wrong name (asked: at most 1 %)", [v.firm_wrong for v in verdicts]),
        _pooled(new),
        _share("after adding, held-out error within 5 % of the noise", [v.within for v in named]),
        _share("hidden parameters jointly with χ² p > 0.001", [p > 0.001 for p in judged]),
        _share("outside: a wrong name alone (asked: at most 2 %)", [v.outcome == "wrong name alone" for v in outside]),
    ]
    seconds = [v.seconds for v in verdicts if not v.crash] or [np.nan]
    lines.append(f"seconds per search: median {np.median(seconds):.1f}, most {max(seconds):.1f}")
    return "\n".join(line for line in lines if line)


def _share(what: str, hits: Sequence[bool]) -> str:
    if not hits:
        return ""
    low, high = clopper_pearson(sum(hits), len(hits))
    return f"{what}: {sum(hits)} of {len(hits)} ({100 * low:.1f}–{100 * high:.1f} %)"


def _pooled(firm_wrong: Sequence[bool]) -> str:
    if not firm_wrong:
        return ""
    count, total = sum(firm_wrong), len(firm_wrong)
    return f"of these in the new classes: {count} of {total}, one-sided 95 % limit {100 * highest(count, total):.1f} %"


def line_of(number: int, verdict: Verdict) -> str:
    """Return what there is to say of a campaign that did not go well; empty where all is well."""
    firm = " FIRM WRONG" if verdict.firm_wrong else ""
    p, inside = verdict.p_parameters, verdict.hidden and "outside" not in verdict.kind
    inside = inside and verdict.kind not in FAULTY
    if not verdict.firm_wrong and verdict.good and (p is None or p > 0.001) and (verdict.within or not inside):
        return ""
    return (
        f"{verdict.kind} {number} ({verdict.settings}, {verdict.player}) {verdict.outcome}{firm}: "
        f"hidden {verdict.hidden or 'nothing'} | "
        f"found {verdict.found or 'nothing'} | {verdict.before:.3f} → {verdict.after:.3f}"
        f"{' unexplained' if verdict.unexplained else ''}{'' if p is None else f' p={p:.2g}'} {verdict.seconds:.1f} s"
    )


def main(arguments: Sequence[str]) -> int:
    """Draw, judge, print."""
    parser = argparse.ArgumentParser(prog="python -m tests.rates", description=__doc__)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--count", type=int, default=0, help="per class; 0: 150 with nothing hidden, 50 of each other")
    parser.add_argument("--first", type=int, default=0, help="number of the first campaign of each class")
    parser.add_argument("--classes", default="", help="comma-separated; all where empty")
    parser.add_argument("--effect", default="", help="hide only this effect in the classes of one")
    parser.add_argument("--without", default="", help="comma-separated effects to leave out of the catalogue")
    parser.add_argument(
        "--player",
        choices=("mixed", "balance", "mujoco"),
        default="mixed",
        help="what moves the robot; mixed: MuJoCo every third campaign of the new classes, the balance all others",
    )
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--verbose", action="store_true", help="a line per campaign that did not go well")
    parser.add_argument("--json", type=Path, help="write every verdict to this file")
    chosen = parser.parse_args(arguments)
    kinds = [kind.strip() for kind in chosen.classes.split(",") if kind.strip()] or [*CLASSES, *BENCHES]
    jobs = [
        Job(
            chosen.seed,
            kind,
            number,
            benches.player_of(kind, number) if kind in BENCHES else player_of(chosen.player, kind, number),
            chosen.effect,
            tuple(chosen.without.split(",")),
        )
        for kind in kinds
        for number in range(chosen.first, chosen.first + (chosen.count or (150 if kind == "none" else 50)))
    ]
    verdicts, start = [], time.perf_counter()
    with one_thread_each(chosen.workers) as pool:
        for job, verdict in zip(jobs, pool.map(one_campaign, jobs), strict=True):
            verdicts.append(verdict)
            if verdict.crash:
                print(f"{job.kind} {job.number}: {verdict.crash}", file=sys.stderr)
            line = line_of(job.number, verdict)
            if chosen.verbose and line:
                print(line, flush=True)
    print(f"seed {chosen.seed}, {len(jobs)} campaigns in {time.perf_counter() - start:.0f} s")
    print(table_of(verdicts))
    if chosen.json:
        chosen.json.write_text(json.dumps([asdict(v) for v in verdicts], indent=1), encoding="utf-8")
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
