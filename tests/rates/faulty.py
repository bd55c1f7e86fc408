"""Campaigns of which nothing is wrong but a run or a row: it is to be named, and no effect for it."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from stiffcal.judgement.diagnosed import DiagnosedStates, diagnose_states
from stiffcal.model.catalogue.catalogue import built_in_effects
from tests.rates.faults import FAULTS, Faulty, draw_faulty
from tests.rates.measuring import Player
from tests.rates.scoring import Verdict, found_in_words, is_firm

# By how many times the noise a fault changes the run, and how far the load moves it, where it can be found.
LEAST_CHANGE = 5.0
FORMS_OF_RUNS = ("pairs", "cycles")
FORM_OF_ROWS = "rows"


@dataclass(frozen=True)
class FaultyCampaign:
    """A faulty campaign of a class, and what moved its robot."""

    kind: str
    campaign: Faulty
    player: Player


def simulate_faulty(kind: str, rng: np.random.Generator, player: Player = "balance") -> FaultyCampaign:
    """Draw a campaign of joint springs alone with a fault in a run, or in one row that is a run by itself.

    Parameters
    ----------
    kind : "faulty run" or "faulty row".
    """
    faults: tuple[str, ...] = FAULTS
    form = FORM_OF_ROWS
    if kind == "faulty run":
        form, faults = str(rng.choice(FORMS_OF_RUNS)), tuple(fault for fault in FAULTS if fault != "bad row")
    return FaultyCampaign(kind, draw_faulty(rng, form, str(rng.choice(faults)), player=player), player)


def judge_faulty(drawn: FaultyCampaign) -> Verdict:
    """Judge runs and effects together, as `stiffcal diagnose` does.

    Nothing is hidden: every effect that is named without a doubt is wrong, but a step in the run in which there is one.
    """
    campaign = drawn.campaign
    start = time.perf_counter()
    search = diagnose_states(campaign.states, campaign.model, built_in_effects())
    seconds = time.perf_counter() - start
    named = {off.run for off in search.doubted}
    right = set(campaign.runs[:1]) <= named <= set(campaign.runs)
    findable = min(campaign.change, campaign.deflection) >= LEAST_CHANGE
    firm_wrong = is_firm(search) and not _is_the_step(campaign, search)
    suspects = "; ".join(f"{off.run} {p:.2f}" for off, p in search.doubted.items())
    return Verdict(
        kind=drawn.kind,
        settings=campaign.settings,
        hidden=f"{campaign.fault} {campaign.change:.1f}x",
        found=f"suspects {suspects or 'none'}; missing {found_in_words(search) or 'nothing'}",
        outcome=_outcome(right, findable, bool(named)),
        good=right if findable else not firm_wrong,
        before=search.before.ratio if search.before else np.nan,
        after=search.after.ratio if search.after else np.nan,
        within=False,
        p_parameters=None,
        unexplained=bool(search.unexplained),
        seconds=seconds,
        firm_wrong=firm_wrong,
        player=drawn.player,
    )


def _outcome(right: bool, findable: bool, any_named: bool) -> str:
    if right:
        return "right run"
    return ("other run" if any_named else "not found") if findable else "below what can be found"


def _is_the_step(campaign: Faulty, search: DiagnosedStates) -> bool:
    """Return whether the one effect that is named is the step that a bump made, in the run where it is."""
    names = [one.candidate.effect.name for one in search.found]
    if campaign.fault != "bump" or names != ["seat-shift"]:
        return False
    placed = next(one for one in search.last.fit.robot.placed if one.effect.name == "seat-shift")
    return int(campaign.states.run[round(placed.values["state"]) - 1]) in campaign.runs
