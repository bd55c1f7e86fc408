"""The page of the documentation on numbers that decide in the reduction of logs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from tests.limits.logs import SOUND
from tests.limits.numbers import FIXED, Number

PAGE = Path(__file__).parents[2] / "docs" / "reference" / "limits.md"

HEAD = """# Numbers that decide in the reduction of logs

Made by `make limits` (`python -m tests.limits`). The logs of
{sound} (three runs of each that lists them) were reduced with each
number 20 % smaller and 20 % larger, a count by one at least, and identified anew where anything of the reduction
changed. Answers move by so many load states and by so many standard uncertainties of the parameter that moves most, in
the campaign in which they move most. What these logs do not ask for was varied with the first of {further}
that does; where such a log has a mistake, the answer is the line that names it.

{moving} of {total} numbers move an answer, {still} are asked for and move none,
{unasked} are asked for by none of these logs: most of them distinguish a mistake from what is right. What a
number rests on stands at it in the code. Varied are numbers with a name of their own: in holds and clocks no other
decides (`tests/limits/test_limits.py`), elsewhere literals inside functions may.

"""
FOOT = """
## Definitions

No decisions, and not varied: {names}.
"""


@dataclass(frozen=True)
class Moved:
    """How an answer of ``identify`` moves."""

    states: int = 0
    """Load states more."""
    sigma: float = 0.0
    """Largest change of a parameter, in its standard uncertainties."""
    other: bool = False
    """Whether other states were set aside, or other parameters answered."""
    named: bool = False
    """Whether the line that refuses the campaign says something else, or there is none any more."""
    refused: bool = False
    """Whether the campaign is refused."""

    @property
    def size(self) -> tuple[bool, bool, float, int, bool]:
        """What is compared."""
        return self.refused, self.named, self.sigma, abs(self.states), self.other

    def __str__(self) -> str:
        """Return it as the table has it."""
        if self.refused:
            return "refused"
        if self.named:
            return "named otherwise"
        parts = [f"{self.states:+d} states"] if self.states else []
        parts += [f"{self.sigma:.2g} σ"] if self.sigma >= 0.005 else []
        parts += ["set aside otherwise"] if self.other and not self.states else []
        return ", ".join(parts) or "–"


Found = Mapping[str, Mapping[str, tuple[Moved, Moved]]]


def written(chosen: Sequence[Number], found: Found) -> str:
    """Return the page.

    Parameters
    ----------
    chosen : the numbers. found : by campaign and place how answers move.
    """
    moving, still, unasked = list[str](), list[str](), list[str]()
    for number in chosen:
        own = {name: moves for name, of in found.items() if (moves := of.get(number.place)) is not None}
        less, more = (max((of[k] for of in own.values()), key=lambda one: one.size, default=Moved()) for k in (0, 1))
        name, value = f"`{number.place}`", shown(number.value)
        if not own:
            unasked.append(f"{name} {value}: {number.reason}")
        elif str(less) == str(more) == "–":
            still.append(f"{name} {value}")
        else:
            where = max(own, key=lambda one: max(own[one][0].size, own[one][1].size))
            moving.append(f"| {name} | {value} | {less} | {more} | {where} | {number.reason} |")
    head = HEAD.format(
        sound=", ".join(f"`{name}`" for name in found if name in SOUND),
        further=", ".join(f"`{name}`" for name in found if name not in SOUND),
        moving=len(moving), total=len(chosen), still=len(still), unasked=len(unasked),
    )  # fmt: skip
    table = ["| number | value | −20 % | +20 % | most in | rests on |", "|---|---|---|---|---|---|", *moving]
    parts = [*table, "", "## Asked for, and no answer moves", ""]
    parts += [f"- {line}" for line in still] + ["", "## Not asked for by these logs", ""]
    parts += [f"- {line}" for line in unasked]
    return (
        head
        + "\n".join(parts)
        + "\n"
        + FOOT.format(names=", ".join(f"`{name}` ({why})" for name, why in FIXED.items()))
    )


def shown(value: object) -> str:
    """Return a number, or several, as the table has them."""
    parts = value if isinstance(value, tuple) else (value,)
    return ", ".join(f"{part:.6g}" for part in parts)
