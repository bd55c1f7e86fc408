"""Effects that rows of one kind of experiment may show."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from stiffcal.diagnosis.answers.results import UntestableEffect
from stiffcal.diagnosis.scans.candidates import Candidate, stands_in_the_way
from stiffcal.kinds.row_search import RowProblem, merged_lacking
from stiffcal.model.assembled.composite import CompliantRobot
from stiffcal.model.effect import Effect


def row_candidates(
    problem: RowProblem, robot: CompliantRobot, catalogue: Mapping[str, Effect], basic: Collection[str] = ()
) -> tuple[list[Candidate], list[UntestableEffect]]:
    """Return the effects that can be added to a model, and those that these rows cannot show, with the reason.

    Parameters
    ----------
    problem : the rows. robot : the model. catalogue : effects by name.
    basic : names of effects on top of which all others come: of a place without any effect they are tried alone.
    """
    in_model = {(placed.effect.name, placed.place) for placed in robot.placed}
    begun = {place for _, place in in_model}
    candidates: list[Candidate] = []
    lacking: dict[str, list[str]] = {}
    for effect in catalogue.values():
        for place in problem.places(effect):
            if (effect.name, place) in in_model or stands_in_the_way(effect, place, robot):
                continue
            if basic and effect.name not in basic and place not in begun:
                continue
            reason = problem.lacking(effect, place)
            if reason is not None:
                lacking.setdefault(effect.name, []).append(reason)
            else:
                candidates.append(Candidate(effect, place, len(effect.parameters)))
    return candidates, [UntestableEffect(name, text) for name, text in merged_lacking(lacking)]
