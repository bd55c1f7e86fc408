"""The tables of a fit's values: compliances as the stiffness people ask for, the others as they are."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from stiffcal.quantity import Units
from stiffcal.results.value_words import SHIFTED, SHIFTED_WORD, as_shown, remark, value_text
from stiffcal.show.builder import PageBuilder, number
from stiffcal.wording import percent, place

if TYPE_CHECKING:
    from stiffcal.identification.answers.fit_results import IdentifiedParameter
    from stiffcal.presentation.values import Column
    from stiffcal.quantity import ShownUnit
    from stiffcal.wording import PlacesOfEffect


MOST_VALUES = 20
MOST_COMPLIANCES = 12
"""Rows of a table of values without details."""


@dataclass(frozen=True)
class NamedParameters:
    """What tells the parameters of a table apart, and what all of them share: that stands in the titles once."""

    names: list[str]
    """Of each row."""
    several: bool
    """Whether they differ in more than their place."""
    shared: str
    """What all values are, "" where they differ."""
    unit: str | None
    """The unit of all values; None where they differ."""

    def title(self, when: str) -> str:
        """Return the title of a column of values."""
        unit = f" [{self.unit}]" if self.unit else ""
        return f"{self.shared} {when}, ± 95 %{unit}".strip()

    @property
    def unit_title(self) -> tuple[str, ...]:
        """The title of the column of units, where there is one."""
        return ("",) if self.unit is None else ()

    def unit_of(self, unit: ShownUnit) -> tuple[str, ...]:
        """Return a row's cell in it."""
        return (unit.name,) if self.unit is None else ()


def names_and_units(parameters: Sequence[tuple[str, PlacesOfEffect, str, str, ShownUnit]]) -> NamedParameters:
    """Return how parameters are named next to each other.

    Parameters
    ----------
    parameters : effect, place, full name, unit of the answer, and the unit in which each is shown.
    """
    symbols = [name.rsplit(".", 1)[1] for _, _, name, _, _ in parameters]
    what = [
        "stiffness" if symbol == "c" and one[3] == "N·m/rad" else symbol
        for symbol, one in zip(symbols, parameters, strict=True)
    ]
    effects = {effect for effect, *_ in parameters}
    alike = len(set(what)) == 1
    several = len(effects) > 1
    names = [
        one[2]
        if several and word != "stiffness"
        else ", ".join([*[one[0]] * several, place(one[1]), *[word] * (not alike)])
        for one, word in zip(parameters, what, strict=True)
    ]
    if len(set(names)) < len(names):  # frames of a set-up have one place
        names = [name for _, _, name, _, _ in parameters]
    units = {unit.name for *_, unit in parameters}
    return NamedParameters(
        names, several or not alike, what[0] if alike else "", units.pop() if len(units) == 1 else None
    )


def add_values(
    made: PageBuilder, titles: Sequence[str | Column], rows: Sequence[Sequence[str]], details: bool, command: str
) -> None:
    """Add a table whose last column is a remark: without details `MOST_VALUES` rows, first those with a remark.

    What shifts values whose remarks call them shifted stands below.

    Parameters
    ----------
    command : the one that shows all of them.
    """
    order = sorted(range(len(rows)), key=lambda k: not rows[k][-1])
    # a line that says one more takes the room of that one
    most = len(rows) if details or len(rows) <= MOST_VALUES + 1 else MOST_VALUES
    shown = [rows[k] for k in sorted(order[:most])]
    made.table(titles, shown)
    if len(shown) < len(rows):
        made.say(f"  and {len(rows) - len(shown)} more ({command} --details)", "more")
    if any(SHIFTED_WORD in row[-1] for row in shown):
        made.say(f"{SHIFTED}: stiffcal diagnose names it", "shifted")


def joined_remarks(remarks: Iterable[str]) -> str:
    """Return what is to be known of a row's values, each remark once."""
    return ", ".join(dict.fromkeys(one for one in remarks if one))


def add_parameters(
    made: PageBuilder,
    parameters: Sequence[IdentifiedParameter],
    unclaimed: Collection[int] = (),
    shifted: Collection[str] = (),
    most: int | None = None,
) -> None:
    """Add identified parameters: compliances as the stiffness people ask for, the others as they are.

    Parameters
    ----------
    parameters : of a fit.
    unclaimed : joints whose compliance has a value and is not identified by these poses, as ``validate`` states.
    shifted : names of values that adding what the model lacks moves beyond their intervals, as ``diagnose`` states.
    most : values that are listed next to stiffness, and of that `MOST_COMPLIANCES`, first those that are known; None:
        all.
    """
    estimates = {one.name: as_shown(one, unclaimed, shifted) for one in parameters}
    units = Units((estimate.quantity, [estimate.value]) for estimate in estimates.values() if estimate.quantity)
    # The column on geometry only where a share is known.
    shared = any(parameter.from_geometry is not None for parameter in parameters)
    from_geometry = (number("share of geometry", is_secondary=True),) if shared else ()
    for of_compliances, titles in (
        (True, ("effect", "place", number("stiffness, ± 95 %"))),
        (False, ("parameter", "place", number("value, ± 95 %"))),
    ):
        members = [parameter for parameter in parameters if parameter.is_compliance == of_compliances]
        # a line that says one more takes the room of that one
        limit = len(members) if most is None else MOST_COMPLIANCES if of_compliances else most
        shown = members
        if len(members) > limit + 1:
            known_first = sorted(members, key=lambda one: not estimates[one.name].is_identifiable)
            chosen = {one.name for one in known_first[:limit]}
            shown = [one for one in members if one.name in chosen]
        rows = []
        for parameter in shown:
            estimate = estimates[parameter.name]
            unit = units.of(estimate.quantity or parameter.quantity)
            words = remark(estimate)
            rows.append(
                (
                    parameter.effect if of_compliances else parameter.name,
                    _place(parameter) if of_compliances else place(parameter.where),
                    value_text(estimate, unit),
                    *(_share_from_geometry(parameter),) * shared,
                    unit.name + (f"  {words}" if words else ""),
                )
            )
        made.table((*titles, *from_geometry, ""), rows)
        if len(shown) < len(members):
            made.say(f"  and {len(members) - len(shown)} more (identify --details)", "more")


def _share_from_geometry(parameter: IdentifiedParameter) -> str:
    """Return how much of the variance the geometry's tolerance makes, in per cent."""
    return "" if parameter.from_geometry is None else percent(parameter.from_geometry)


def _place(parameter: IdentifiedParameter) -> str:
    """Return the place of a compliance, and its axis where its effect has several."""
    symbol = parameter.name.rpartition(".")[2]
    return place(parameter.where) + ("" if symbol == "c" else f", {symbol}")
