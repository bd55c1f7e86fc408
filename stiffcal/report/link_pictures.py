"""What the pages on links with rods show: paper 000's Fig. 5 to 7, and the bent link."""

from __future__ import annotations

from dataclasses import dataclass

from stiffcal.arrays import Booleans, Floats


@dataclass(frozen=True)
class LinkRun:
    """One run, of a link with rods: n states in the order in which they were reached."""

    name: str
    """The run's id."""
    along: str
    """The direction of its load in words, base axes."""
    force: Floats
    """(n,) N, the load along that direction since the reference."""
    unloading: Booleans
    """(n,) True where the load went back."""
    lengths: Floats
    """(n, m) m, measured change of each rod."""
    modelled: Floats | None
    """(n, m) m, the same by the fitted model; None where it holds no effect on the link."""
    end: Floats
    """(n, 6) m and rad, the link's end from the rods, beam axes; NaN where they do not determine it."""
    end_std: Floats
    """(6,) standard uncertainty of one state."""
    by_wrench: Floats
    """(n, 6) the same by the link's compliance and the wrench that it carries, without rods."""
    tool: Floats | None
    """(n,) m, the tool's measured displacement along the load; None where not measured."""
    with_link: Floats | None
    """(n,) m, the same by the model; None where ``tool`` is."""
    without_link: Floats | None
    """(n,) m, the same by the model with the link rigid; None where ``tool`` is."""


@dataclass(frozen=True)
class BentLink:
    """A link drawn bent, in beam axes."""

    x1: Floats
    """(p,) m, along the axis from the clamped end."""
    displacement: Floats
    """(p, 3) m, of the axis."""
    start: Floats
    """(m, 3) m, where the rods begin."""
    end: Floats
    """(m, 3) m, where they end."""
    change: Floats
    """(m,) m, what the rods read."""
    force: float
    """N, of the load."""
    run: str
    """Name of the run."""


@dataclass(frozen=True)
class LinkPicture:
    """All that is shown of one link."""

    link: str
    """The link's name."""
    rods: tuple[str, ...]
    """m names."""
    rod_lengths: Floats
    """(m,) m."""
    opposite: tuple[tuple[int, int], ...]
    """Pairs of rods on opposite sides, by index."""
    runs: tuple[LinkRun, ...]
    """The runs with readings, in the campaign's order."""
    large_runs: tuple[int, ...]
    """Indices of the runs that are drawn large."""
    bent_link: BentLink
    """The link under the largest reading."""
    sentences: tuple[str, ...]
    """Sentences of the section's text."""
