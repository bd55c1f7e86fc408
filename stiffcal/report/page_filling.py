"""How large pictures are set, so that no page ends far above its foot.

A picture is not broken: where it is a little higher than what is left of a page it would go to the next page, and leave
that room empty. Pictures around such a place are set somewhat smaller instead, all by the same factor; those of the
whole report, or wider spaces, where the last page would hold a few lines only.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

FULL = 2.0 / 3.0
"""Share of a page down to which it has to be filled."""
SMALLEST = 0.84
"""Least size of a picture: its smallest letters, of 6.5 pt, are 5.5 pt then."""
LOOSENESS = (1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6)
"""Spaces between blocks over their usual size, in the order in which they are tried: wider ones fill a last page."""
MOST_LAYOUTS = 24
"""Layouts that are tried in all; one takes some hundredths of a second, and most reports need 2 to 13."""
TOP_MM, FOOT_MM = 24.0, 277.0
"""Where the text of a page begins and ends, in the template too."""
_SPACES_MM = 7.0
"""Space above a picture, and from where the last line of a caption begins to where it ends."""
_LEAST_MM = 1.0
"""A change is no smaller, so that there is an end."""


@dataclass(frozen=True)
class PageLayout:
    """Where blocks are on the pages; places are page from 1, and mm from its top."""

    pages: int
    """How many there are."""
    begins: tuple[tuple[int, float], ...]
    """Where blocks of text, tables and pictures begin, in order."""
    ends: tuple[tuple[int, float], ...]
    """Where each of them ends."""
    pictures: tuple[tuple[int, float], ...]
    """Upper edges of the pictures among them, in order."""
    heights: tuple[float, ...]
    """mm, theirs, without captions."""

    def foot(self, page: int) -> float:
        """Return where the last block of a page ends; its top where none does."""
        return max((y for on, y in self.ends if on == page), default=TOP_MM)

    def is_full(self, page: int) -> bool:
        """Return whether a page is filled far enough, as one is on which a block goes on to the next."""
        goes_on = any(begin[0] <= page < end[0] for begin, end in zip(self.begins, self.ends, strict=True))
        return goes_on or self.foot(page) - TOP_MM >= FULL * (FOOT_MM - TOP_MM)

    @property
    def n_empty(self) -> int:
        """Pages that are not filled far enough."""
        return sum(not self.is_full(page) for page in range(1, self.pages + 1))


def layout_from(data: Mapping[str, Any]) -> PageLayout:
    """Return the layout that the template states."""
    places = {name: tuple((int(on), float(y)) for on, y in data[name]) for name in ("begins", "ends", "pictures")}
    return PageLayout(int(data["pages"]), heights=tuple(data["heights"]), **places)


@dataclass(frozen=True)
class Setting:
    """What the pages are laid out with."""

    sizes: tuple[float, ...]
    """Of pictures: 1 is the width of the page."""
    looseness: float = 1.0
    """Spaces between blocks over their usual size."""


def filled(n_pictures: int, laid_out: Callable[[Setting], PageLayout]) -> Setting:
    """Return the setting with which the fewest pages are more than a third empty.

    Parameters
    ----------
    n_pictures : how many there are. laid_out : lays the pages out.
    """
    best, fewest, left = Setting((1.0,) * n_pictures), None, MOST_LAYOUTS
    for looseness in LOOSENESS:
        setting = Setting((1.0,) * n_pictures, looseness)
        given_up: set[int] = set()
        while left:
            left -= 1
            layout = laid_out(setting)
            if fewest is None or layout.n_empty < fewest:
                best, fewest = setting, layout.n_empty
            smaller = None if layout.n_empty == 0 else _smaller(layout, setting.sizes, given_up)
            if smaller is None:
                break
            setting = replace(setting, sizes=tuple(smaller))
        if fewest == 0:
            break
    return best


def _smaller(layout: PageLayout, sizes: Sequence[float], given_up: set[int]) -> list[float] | None:
    """Return sizes that fill the first page which is not full; None where none can be filled.

    Parameters
    ----------
    given_up : pages that cannot be filled so; those found here are added.
    """
    for page in range(1, layout.pages + 1):
        if layout.is_full(page) or page in given_up:
            continue
        if page == layout.pages:
            chosen, too_much = list(range(len(sizes))), layout.foot(page) - TOP_MM + _SPACES_MM
        else:
            chosen, too_much = _about(layout, page)
        smaller = _by(layout.heights, sizes, chosen, max(too_much, _LEAST_MM))
        if smaller is not None:
            return smaller
        given_up.add(page)
    return None


def _about(layout: PageLayout, page: int) -> tuple[list[int], float]:
    """Return pictures on a page, with one that opens the next page, and what is too much for this one, mm.

    No picture where a block passes over the whole of the next page: no size of a picture fills this one.
    """
    after = page + 1
    opening = next((k for k, (on, _) in enumerate(layout.ends) if on == after), None)
    if opening is None:
        return [], 0.0
    needed = layout.ends[opening][1] - TOP_MM + _SPACES_MM
    moved = layout.begins[opening]
    chosen = [k for k, at in enumerate(layout.pictures) if at[0] == page or at == moved]
    return chosen, needed - (FOOT_MM - layout.foot(page))


def _by(heights: Sequence[float], sizes: Sequence[float], chosen: Sequence[int], less_mm: float) -> list[float] | None:
    """Return sizes with which the chosen pictures take so much less height; None where they would be too small.

    Parameters
    ----------
    heights : mm, with the sizes that they have.
    """
    total = sum(heights[k] for k in chosen)
    factor = 1.0 - less_mm / total if total else 0.0
    if not chosen or any(factor * sizes[k] < SMALLEST for k in chosen):
        return None
    return [size * factor if k in chosen else size for k, size in enumerate(sizes)]
