"""One campaign of the field mix, drawn and judged."""

from __future__ import annotations

import importlib
import traceback
from dataclasses import asdict
from typing import Any

from tests.calibration.answers import Answer, firm_wrong, is_good, outcome, truth_of
from tests.calibration.field_mix import draw_campaign


def judged(judge: str, seed: int, number: int) -> dict[str, Any]:
    """Draw one campaign and judge it; a crash is an answer too."""
    campaign = draw_campaign(seed, number)
    try:
        answer = importlib.import_module(f"tests.calibration.{judge}").judge(campaign)
    except Exception:
        nan = float("nan")
        answer = Answer((), False, (), nan, nan, nan, traceback.format_exc())
    return {
        "number": number, "category": campaign.category, "noise": campaign.noise_known, "player": campaign.player,
        "settings": campaign.settings, "readings": campaign.n_readings, "sizes": campaign.sizes,
        "truth": truth_of(campaign), "hidden": [f"{h.effect.name} {h.place.label}" for h in campaign.hidden],
        "runs": campaign.runs, "answer": asdict(answer), "outcome": outcome(campaign, answer),
        "good": is_good(campaign, answer), "firm_wrong": firm_wrong(campaign, answer),
    }  # fmt: skip
