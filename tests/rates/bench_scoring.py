"""What `improve` and `diagnose` make of a joint on a bench, in words that can be counted."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import numpy as np

from stiffcal.commands.diagnose import diagnose_campaign
from stiffcal.commands.improve import improve_campaign
from stiffcal.diagnosis.answers.results import DiagnoseResult, ProposedEffect
from stiffcal.model.summary import EffectAt
from stiffcal.results.improve_results import ImproveResult
from stiffcal.stages.steps import RunContext, up_to_date_states
from tests.rates import clamped_robots
from tests.rates.benches import Bench, write_bench
from tests.rates.measuring import Player
from tests.rates.practice_joints import over_noise
from tests.rates.scoring import Verdict


def judge_bench(kind: str, rng: np.random.Generator, player: Player) -> Verdict:
    """Draw a campaign of one joint, or of a clamped robot, diagnose and improve it, and compare with what is hidden."""
    with tempfile.TemporaryDirectory(prefix="bench-") as temporary:
        folder = Path(temporary) / "bench"
        robot = kind in clamped_robots.CLASSES
        bench = (
            clamped_robots.write_clamped_robot(folder, kind, rng, player)
            if robot
            else write_bench(folder, kind, rng, player)
        )
        context = RunContext()
        up_to_date_states(folder, context)
        start = time.perf_counter()
        first = diagnose_campaign(folder, context)
        improved = improve_campaign(folder, context)
        seconds = time.perf_counter() - start
    named = [
        (step.effect, (step.where.joints or [0])[0])
        for step in improved.steps
        if step.action == "add" and step.effect is not None
    ]
    outcome, good = _outcome_of(bench, first, improved, named)
    after = over_noise(improved.heldout_rms, improved.noise)
    sizes = zip(bench.hidden.items(), bench.sizes, strict=True)
    return Verdict(
        kind=kind,
        settings=bench.settings,
        hidden=", ".join(
            f"{name} j{joint} {size:.1f}x({','.join(f'{symbol}={value:.2g}' for symbol, value in values.items())})"
            for ((name, joint), values), size in sizes
        ),
        found=" + ".join(f"{name} j{joint}" for name, joint in named)
        + "".join(f" [first: {_in_words(effect)}]" for effect in first.missing[:1])
        + " undecided" * bool(first.undecided),
        outcome=outcome,
        good=good,
        before=over_noise(improved.steps[0].heldout_rms, improved.noise),
        after=after,
        within=bool(after <= 1.05),
        p_parameters=None,
        unexplained=bool(improved.unexplained),
        seconds=seconds,
        firm_wrong=_is_firm_and_wrong(bench, first),
        player=player,
    )


def _in_words(effect: ProposedEffect) -> str:
    return " or ".join(f"{name} j{joint}" for name, joint in (_named(effect), *map(_named, effect.alternatives)))


def _named(effect: ProposedEffect | EffectAt) -> tuple[str, int]:
    return effect.effect, (effect.where.joints or [0])[0]


def _is_firm_and_wrong(bench: Bench, first: DiagnoseResult) -> bool:
    certain = [effect for effect in first.missing if effect.firm]
    return any(bench.outside or _named(effect) not in bench.hidden for effect in certain)


def _outcome_of(
    bench: Bench, first: DiagnoseResult, improved: ImproveResult, named: list[tuple[str, int]]
) -> tuple[str, bool]:
    truth = set(bench.hidden)
    if not truth:
        quiet = not named and not improved.unexplained
        return ("quiet" if quiet else "false alarm" if named else "not adequate"), quiet
    if bench.outside:
        if improved.unexplained or first.unexplained:
            return ("unexplained, named too" if named else "unexplained"), True
        return ("wrong name alone" if named else "nothing"), False
    if len(truth) > 1:
        if set(named) == truth and not improved.unexplained:
            return "both", True
        return f"{len(truth - set(named))} missed, {len(set(named) - truth)} wrong", False
    if not first.missing:
        return ("undecided" if first.undecided else "unexplained" if first.unexplained else "nothing"), False
    foremost = first.missing[0]
    if _named(foremost) in truth:
        return "right" + " + more" * (set(named) != truth), True
    if truth & set(map(_named, foremost.alternatives)):
        return "look-alike", True
    return "wrong", False
