"""What the pages on links with rods show: paper 000's Fig. 5 to 7, and the bent link."""

from __future__ import annotations

from dataclasses import dataclass

from stiffcal.arrays import Booleans, Floats


@dataclass(frozen=True)
class LinkRun:
    """One run, of a link with rods: n states in the order in which they were reached."""

    name: str
    """The run's id. ``along``: the direction of its load in words, base axes."""
    along: str
    force: Floats
    """(n,) N, the load along that direction since the reference."""
    unloading: Booleans
    """(n,) True where the load went back."""
    lengths: Floats
    """(n, m) m, what each rod changed by; ``modelled``: the same by the fitted model, or None where it holds no effect
    on the link.
    """
    modelled: Floats | None
    end: Floats
    """(n, 6) m and rad, the link's end from the rods, beam axes; NaN where they do not determine it."""
    end_std: Floats
    """(6,) standard uncertainty of one state."""
    by_wrench: Floats
    """(n, 6) the same by the link's compliance and the wrench that it carries, without rods."""
    tool: Floats | None
    with_link: Floats | None
    without_link: Floats | None
    """``tool``, ``with_link``, ``without_link``: (n,) m, the tool's displacement along the load: measured, by the
    model, and by the model with the link rigid; None where it was not measured.
    """


@dataclass(frozen=True)
class BentLink:
    """A link drawn bent, in beam axes."""

    x1: Floats
    """(p,) m, along the axis from the clamped end. ``moved``: (p, 3) m, how the axis moved."""
    displacement: Floats
    start: Floats
    end: Floats
    """``start``, ``end``: (m, 3) m, where the rods are fixed."""
    change: Floats
    """(m,) m, what they read."""
    force: float
    """N, of the load. ``run``: in which."""
    run: str


@dataclass(frozen=True)
class LinkPicture:
    """All that is shown of one link."""

    link: str
    """Its name. ``rods``: m names. ``rod_lengths``: (m,) m. ``opposite``: pairs of rods on opposite sides, by index."""
    rods: tuple[str, ...]
    rod_lengths: Floats
    opposite: tuple[tuple[int, int], ...]
    runs: tuple[LinkRun, ...]
    """Those with readings, in the campaign's order; ``shown``: indices of those drawn large."""
    large_runs: tuple[int, ...]
    bent_link: BentLink
    """Under the largest reading."""
    sentences: tuple[str, ...]
    """Sentences of the section's text."""
