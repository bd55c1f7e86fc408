"""One campaign of the field mix or of a stress class, drawn and judged."""

from __future__ import annotations

import importlib
import json
import traceback
from dataclasses import asdict, dataclass

from tests.calibration.answers import Answer, firm_wrong, is_good, outcome, truth_of
from tests.calibration.field_mix import Category, NoiseKnown, draw_campaign
from tests.calibration.stress.classes import draw_stress
from tests.rates.measuring import Player


@dataclass(frozen=True)
class JudgedCampaign:
    """What was in a campaign and what a judge said of it: a line of the kept file."""

    number: int
    """Of the seed's campaigns."""
    category: Category
    """What is wrong."""
    noise: NoiseKnown
    """How the noise is known."""
    player: Player
    """What moved the robot."""
    settings: str
    """In words."""
    readings: int
    """Measured components."""
    sizes: tuple[float, ...]
    """Of what is hidden, in noises."""
    truth: tuple[str, ...]
    """Names that are right."""
    hidden: tuple[str, ...]
    """Names of what is hidden, of laws outside the catalogue too."""
    runs: tuple[int, ...]
    """Numbers of faulty runs."""
    answer: Answer
    """What the judge said."""
    outcome: str
    """In a word."""
    good: bool
    """By the table of `tests.calibration.answers`."""
    firm_wrong: int
    """Names that are firm and wrong."""

    def line(self) -> str:
        """Return it as JSON."""
        return json.dumps(asdict(self))


def read_line(line: str) -> JudgedCampaign:
    """Return a judged campaign from its line."""
    from pydantic import TypeAdapter

    return TypeAdapter(JudgedCampaign).validate_python(json.loads(line))


def judged(judge: str, seed: int, number: int, stress: str = "") -> JudgedCampaign:
    """Draw one campaign and judge it; a crash is an answer too.

    Parameters
    ----------
    stress : a class of `tests.calibration.stress`; "" for the field mix.
    """
    campaign = draw_stress(stress, seed, number) if stress else draw_campaign(seed, number)
    try:
        answer: Answer = importlib.import_module(f"tests.calibration.{judge}").judge(campaign)
    except Exception:
        nan = float("nan")
        answer = Answer((), False, (), nan, nan, nan, traceback.format_exc())
    return JudgedCampaign(
        number=number,
        category=campaign.category,
        noise=campaign.noise_known,
        player=campaign.player,
        settings=campaign.settings,
        readings=campaign.n_readings,
        sizes=campaign.sizes,
        truth=truth_of(campaign),
        hidden=tuple(f"{one.effect.name} {one.place.label}" for one in campaign.hidden),
        runs=campaign.runs,
        answer=answer,
        outcome=outcome(campaign, answer),
        good=is_good(campaign, answer),
        firm_wrong=firm_wrong(campaign, answer),
    )
