"""A run or a row that disagrees with all the others: what is known of it, as a result."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Annotated

from stiffcal.documents import NOT_PROMISED, Number, OrAbsent
from stiffcal.escapes import toml_text
from stiffcal.mistakes.suspect_kinds import SuspectKind
from stiffcal.model.summary import EffectAt


class NotCheckedReason(StrEnum):
    """Why runs, or some of their states, were not compared with each other."""

    FEW_RUNS = "few-runs"
    UNIT_AND_SIGN_ONLY = "unit-and-sign-only"
    SOME_STATES = "some-states"
    NO_EFFECT = "no-effect"
    NO_FIT = "no-fit"
    ABSOLUTE_ROWS = "absolute-rows"
    CLAMPED_RUNS = "clamped-runs"


@dataclass(frozen=True, slots=True, kw_only=True)
class RunsNotChecked:
    """What was not compared with the other runs."""

    code: NotCheckedReason
    """Why not."""
    sentence: str
    """The same in words."""


@dataclass(frozen=True, slots=True, kw_only=True)
class WithoutParameter:
    """A parameter of the fit without the suspects."""

    name: str
    """Its full name."""
    value: Number
    """Its estimate; null where these data do not determine it."""
    std: Number
    """Its standard uncertainty."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FitWithout:
    """The present model, fitted without a suspect or all of them."""

    rms: dict[str, Number]
    """What is left, by measure, m and rad."""
    parameters: list[WithoutParameter]
    """All parameters of the model."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Suspect:
    """A run, or a row of it, that disagrees with all the others."""

    run: str
    """The run's name."""
    row: int | None
    """The row of the table, or the state's number in the run; null where the whole run is meant."""
    kind: SuspectKind
    """What is wrong with it."""
    why: str
    """What was found, with numbers."""
    likely: str
    """The likely cause, and its cure."""
    factor: Number
    """By what the readings are to be multiplied, where that is the cure."""
    without: FitWithout | None
    """The fit without this run alone; null after the first twelve of many suspects."""
    between: OrAbsent[list[int]] = None
    """The two rows between which the base or the tracker moved, with 95 % probability; ``row`` is the most likely first
    row after the move. Only of such a move.
    """
    between_runs: OrAbsent[list[str]] = None
    """The run of each of these two rows. Only of such a move."""
    or_drift: OrAbsent[bool] = None
    """Whether a drift over the rows is an explanation too. Only of such a move."""
    probability: OrAbsent[float] = None
    """That it is off, as `diagnose` judges it next to all effects."""
    firm: OrAbsent[bool] = None
    """Whether that is certain."""
    explained_by: OrAbsent[list[EffectAt]] = None
    """Effects of the catalogue with which the run agrees with the others as well; only where effects were searched."""
    exclude: Annotated[list[str], NOT_PROMISED] = field(default_factory=list)
    """Lines of campaign.toml that leave it out."""

    @property
    def is_left_out(self) -> bool:
        """Whether effects are searched without it; a move that may be a drift is not: an effect explains that too."""
        return self.between is None or not self.or_drift


def exclusion_lines(source: str, rows: list[int], why: str, run: str = "") -> list[str]:
    r"""Return the lines of campaign.toml that leave rows of a table out.

    Parameters
    ----------
    source : the table's name in the manifest.
    rows : data rows, from 1.
    why : the reason, as it will stand in the manifest.
    run : whose file the rows are counted in, "" where one table serves all runs.

    Examples
    --------
    >>> print("\n".join(exclusion_lines("table", [3, 4], "forces in lbf")))
    [[exclude]]
    source = "table"
    rows = [3, 4]
    why = "forces in lbf"
    """
    of_run = [toml_text.pair("run", run)] if run else []
    counted = [toml_text.pair("rows", rows), toml_text.pair("why", why)]
    return ["[[exclude]]", toml_text.pair("source", source), *of_run, *counted]
