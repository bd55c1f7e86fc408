"""What a judge says of a campaign, in the form in which judges are compared, and when that is good.

The table below was written before the first campaign was judged, but for two lines: that a knock leaves a step in its
run, and that the step is as right a name as the run, was added after the fifth set; what is good where an assumption
can be seen to be broken was added before the first stress class was judged.

========= ====================================================================================================
nothing   quiet: no effect named, nothing unexplained, no run doubted
visible   an assumption is broken so that the readings can show it, nothing else is wrong: no effect named, no run
          doubted; unexplained is as right as quiet
one       the effect is in the first group that is named (leading, alike, or undecided); one that an oracle cannot
          find may also be left unnamed
several   every group that is named holds one of them, and those that an oracle finds are in a group
outside   something is unexplained, or groups are named without being firm; unnamed where an oracle cannot find it
mistake   the faulty runs are named and no others, or of a knock the step that it leaves; where the fault is below what
          can be found: no firm name
========= ====================================================================================================

A firm name is wrong where neither it nor what is alike is in the campaign.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

from tests.calibration.field_mix import FieldCampaign

FOUND_BY_ORACLE = 30.0
"""Δχ² of an effect with all else known, from which on an oracle finds it."""
FAULT_FOUND = 5.0
"""Rms of what a fault changes over the noise, from which on it can be found (`tests.rates.faulty`)."""
LEAST = 0.01
"""Probability of an effect from which on it is kept."""
KNOCK, STEP = "bump", "seat-shift setup"
"""A fault that is a step in time, and the name of that."""


@dataclass(frozen=True)
class Named:
    """A group: effects and mistakes of which one is there, as far as the data distinguish them."""

    names: tuple[str, ...]
    """Its credible set: ``effect place``, the leading one first, until they have `ALTERNATIVES` of the group."""
    probability: float
    """That one of the whole group is there; NaN where the judge states none."""
    in_group: tuple[float, ...]
    """Of each of the names, given that one of the group is there; NaN where the judge states none."""
    firm: bool
    """Whether the leading one is named without doubt."""
    others: tuple[str, ...] = ()
    """What else is in the group."""
    runs: tuple[int, ...] = ()
    """Runs of which a mistake is in the group."""

    def holds(self, names: Collection[str], runs: Collection[int]) -> bool:
        """Return whether the group holds one of some effects or runs: the event that its probability is of."""
        return not set(names).isdisjoint((*self.names, *self.others)) or not set(runs).isdisjoint(self.runs)


@dataclass(frozen=True)
class Answer:
    """What a judge says of a campaign."""

    named: tuple[Named, ...]
    """What is missing, the largest first."""
    unexplained: bool
    """Something is left that is none of the effects."""
    doubted: tuple[int, ...]
    """Numbers of runs that are named as faulty."""
    p_nothing: float
    """Probability that nothing is missing; NaN where the judge states none."""
    p_unknown: float
    """Probability that something is that nobody has written down; NaN where the judge states none."""
    seconds: float
    """Of processor time."""
    crash: str = ""
    """The last line of a crash."""
    hangs_on: tuple[str, ...] = ()
    """Priors that, three times larger or smaller, change which groups are named or whether a law of no catalogue is."""
    effects: Mapping[str, float] = field(default_factory=dict)
    """By ``effect place`` the probability that it is there, of those that have `LEAST` and more."""

    @property
    def quiet(self) -> bool:
        """True where nothing is said to be wrong."""
        return not (self.named or self.unexplained or self.doubted or self.crash)


def name_of(effect: str, place: str) -> str:
    """Return the name by which truth and answers are compared."""
    return f"{effect} {place}"


def truth_of(campaign: FieldCampaign) -> tuple[str, ...]:
    """Return the names that are right; none where what is hidden is not in the catalogue."""
    if campaign.category == "outside":
        return ()
    if campaign.fault == KNOCK:
        return (STEP,)
    return tuple(name_of(one.effect.name, one.place.label) for one in campaign.hidden)


def firm_wrong(campaign: FieldCampaign, answer: Answer) -> int:
    """Return how many names are firm and wrong."""
    truth = set(truth_of(campaign))
    return sum(one.firm and not truth.intersection(one.names) for one in answer.named)


def is_good(campaign: FieldCampaign, answer: Answer) -> bool:
    """Return whether an answer is good, by the table of this module."""
    if answer.crash:
        return False
    if campaign.category == "nothing":
        return answer.quiet or (campaign.visible and not answer.named and not answer.doubted)
    if campaign.category == "mistake":
        if min(campaign.sizes) < FAULT_FOUND:
            return not firm_wrong(campaign, answer)
        as_step = any(set(truth_of(campaign)) & set(one.names) for one in answer.named)
        return set(campaign.runs[: not as_step]) <= set(answer.doubted) <= set(campaign.runs)
    hidden = zip(truth_of(campaign) or ("",), campaign.sizes, strict=True)
    found = [size**2 * campaign.n_readings >= FOUND_BY_ORACLE for size in campaign.sizes]
    if campaign.category == "outside":
        noticed = answer.unexplained or any(not one.firm for one in answer.named)
        return not firm_wrong(campaign, answer) and (noticed or not any(found))
    if answer.quiet:
        return not any(found)
    groups = [set(one.names) for one in answer.named]
    if campaign.category == "one":
        return bool(groups) and truth_of(campaign)[0] in groups[0]
    strange = [group for group in groups if not group.intersection(truth_of(campaign))]
    missed = [name for (name, _), f in zip(hidden, found, strict=True) if f and not any(name in g for g in groups)]
    return not strange and not missed


def outcome(campaign: FieldCampaign, answer: Answer) -> str:
    """Return the answer in one word, for tables."""
    if answer.crash:
        return "crash"
    if answer.quiet:
        return "quiet"
    truth = set(truth_of(campaign))
    right = sum(bool(truth.intersection(one.names)) for one in answer.named)
    wrong = len(answer.named) - right
    words = [f"{right} right"] * bool(right) + [f"{wrong} wrong"] * bool(wrong)
    words += [f"{firm_wrong(campaign, answer)} firm"] * bool(firm_wrong(campaign, answer))
    words += ["unexplained"] * answer.unexplained + ["runs doubted"] * bool(answer.doubted)
    return ", ".join(words)
