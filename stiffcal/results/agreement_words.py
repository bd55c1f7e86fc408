"""How kinds of experiment agree, in words that terminal and report share."""

from __future__ import annotations

from stiffcal.identification.answers.agreement_results import Agreement
from stiffcal.identification.readings.state_kinds import state_kinds
from stiffcal.quantity import Units, quantity_of
from stiffcal.uncertainty import NORMAL_95
from stiffcal.wording import count, plus_minus, significant


def runs_of_kinds(agreement: Agreement) -> tuple[str, str]:
    """Return what the runs of both kinds are called; of a kind that is not installed here its name."""
    called = {name: kind.runs for name, kind in state_kinds().items()}
    return called.get(agreement.first, agreement.first), called.get(agreement.second, agreement.second)


def verdict(agreement: Agreement) -> str:
    """Return whether two kinds of experiment agree, in one sentence."""
    kinds = " and ".join(runs_of_kinds(agreement))
    number = count(agreement.dof, "parameter")
    test = f"χ² {significant(agreement.statistic)} of {agreement.dof}, p {significant(agreement.p_value, 2)}"
    if agreement.agree:
        return f"{kinds} agree on the {number} that each determines separately ({test})"
    worst = max(agreement.parameters, key=lambda parameter: abs(parameter.standard_errors))
    return (
        f"{kinds} disagree on parameters that each determines separately, {worst.name} most, by "
        f"{significant(abs(worst.standard_errors))} "
        f"standard errors ({test}): the model lacks an effect, or a sensor's scale is wrong"
    )


def rows(agreement: Agreement) -> list[tuple[str, str, str, str, str]]:
    """Return for each parameter its name, both values ± 95 %, unit, and the difference in standard errors."""
    units = Units((one.unit, [one.first, one.second]) for one in agreement.parameters)
    cells = []
    for parameter in agreement.parameters:
        unit = units.of(quantity_of(parameter.unit))
        first = plus_minus(unit.factor * parameter.first, unit.factor * NORMAL_95 * parameter.first_std)
        second = plus_minus(unit.factor * parameter.second, unit.factor * NORMAL_95 * parameter.second_std)
        cells.append((parameter.name, first, second, unit.name, significant(parameter.standard_errors, 2)))
    return cells
