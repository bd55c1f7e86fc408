"""What the pages on links with rods show: paper 000's Fig. 5 to 7, and the bent link."""

from __future__ import annotations

from dataclasses import dataclass

from stiffcal.arrays import Booleans, Floats


@dataclass(frozen=True)
class LinkRun:
    """One run, as a link with rods saw it: n states in the order in which they were reached.

    Attributes
    ----------
    name : the run's id. along : the direction of its load in words, base axes.
    force : (n,) N, the load along that direction since the reference.
    unloading : (n,) True where the load went back.
    lengths : (n, m) m, what each rod changed by; modelled : the same by the fitted model, or None where it holds no
        effect on the link.
    end : (n, 6) m and rad, the link's end from the rods, beam axes; NaN where they do not tell.
    end_std : (6,) standard uncertainty of one state.
    by_wrench : (n, 6) the same by the link's compliance and the wrench that it carries, without rods.
    tool, with_link, without_link : (n,) m, the tool's displacement along the load: measured, by the model, and by the
        model with the link rigid; None where it was not measured.
    """

    name: str
    along: str
    force: Floats
    unloading: Booleans
    lengths: Floats
    modelled: Floats | None
    end: Floats
    end_std: Floats
    by_wrench: Floats
    tool: Floats | None
    with_link: Floats | None
    without_link: Floats | None


@dataclass(frozen=True)
class BentLink:
    """A link drawn bent, in beam axes.

    Attributes
    ----------
    x1 : (p,) m, along the axis from the clamped end. moved : (p, 3) m, how the axis moved.
    start, end : (m, 3) m, where the rods are fixed.
    change : (m,) m, what they read.
    force : N, of the load. run : in which.
    """

    x1: Floats
    moved: Floats
    start: Floats
    end: Floats
    change: Floats
    force: float
    run: str


@dataclass(frozen=True)
class LinkPicture:
    """All that is shown of one link.

    Attributes
    ----------
    link : its name. rods : m names. rod_lengths : (m,) m. opposite : pairs of rods on opposite sides, by index.
    runs : those with readings, in the campaign's order; shown : indices of those drawn large.
    bent : under the largest reading.
    sentences : what is to be said, in words.
    """

    link: str
    rods: tuple[str, ...]
    rod_lengths: Floats
    opposite: tuple[tuple[int, int], ...]
    runs: tuple[LinkRun, ...]
    shown: tuple[int, ...]
    bent: BentLink
    sentences: tuple[str, ...]
