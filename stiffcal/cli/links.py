"""Links with rods, as `identify` and `check` show them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiffcal.cli.answers import Document
from stiffcal.cli.tables import plain_table
from stiffcal.cli.wording import interval, share

if TYPE_CHECKING:
    from rich.console import Console

# Elements of the 6×6 that people look at: the beam's own. (row, column, words, factor from SI, unit)
_ELEMENTS = (
    (0, 0, "stretch per force along", 1e9, "µm/kN"),
    (1, 1, "u2 per force along x2", 1e9, "µm/kN"),
    (5, 5, "turn about x3 per moment", 1e9, "µrad/(kN·m)"),
    (2, 2, "u3 per force along x3", 1e9, "µm/kN"),
    (4, 4, "turn about x2 per moment", 1e9, "µrad/(kN·m)"),
    (3, 3, "twist per moment", 1e9, "µrad/(kN·m)"),
)


def show_links(console: Console, links: list[Document]) -> None:
    """Draw what the rods say of each link: what they carry, the compliance of its end, what they cannot tell."""
    for link in links:
        part = link["share_of_tool"]
        of_tool = "" if part is None else f"; {share(part)} of the tool's deflection is the link's"
        console.print(f"{link['link']}: {len(link['rods'])} rods carry {', '.join(link['carried'])}{of_tool}")
        table = plain_table("compliance of the link's end", "value, ± 95 %>", "")
        low, high = link["compliance_interval"]
        for row, column, words, factor, unit in _ELEMENTS:
            value = link["compliance"][row][column]
            ends = (low[row][column], high[row][column])
            known = value is not None and None not in ends
            shown = interval(value * factor, ends[0] * factor, ends[1] * factor) if known else "cannot be told"
            table.add_row(words, shown, unit)
        console.print(table)
        for sentence in link["not_identifiable"]:
            console.print(f"{link['link']}: {sentence}", soft_wrap=True)
        for fault in link["faults"]:
            console.print(f"{link['link']}: {fault['why']}", soft_wrap=True)
