"""What rods on a link can and cannot determine, and where one more would help most."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.links.rods import RodDesign, ShapeError, rod_design, shape_errors
from stiffcal.measurements.rods import BeamProperties, Rods, rods_between
from stiffcal.mechanics.beam import TORSION, UNKNOWNS
from stiffcal.quantity import LENGTH, of_component
from stiffcal.uncertainty import NORMAL_95
from stiffcal.wording import in_unit, percent, significant

# Uncertainty of a length gauge where none is stated: what the paper's class of gauges reaches.
USUAL_SIGMA = 1e-6
# Where a rod may begin and end along the link, as shares of its length.
PLACES = (0.05, 0.5, 0.95)
_COMPONENTS = ("u1", "u2", "u3", "φ1", "φ2", "φ3")


@dataclass(frozen=True)
class ExtraRod:
    """A rod that would help."""

    start: Floats
    """(3,) m, where it would begin, beam frame."""
    end: Floats
    """(3,) m, where it would end, beam frame."""
    determines: tuple[str, ...]
    """Unknowns that could be carried with it and could not without."""
    gain_before: float
    """Error of the link's end over a rod's error at worst, for the unknowns carried before, without it."""
    gain_after: float
    """The same with it."""
    gain: float
    """The same with all that the rods then carry."""
    spare: int
    """Rods beyond the unknowns, with it."""


@dataclass(frozen=True)
class RodObservability:
    """What the rods on one link can and cannot determine."""

    link: str
    """Its name."""
    rods: tuple[str, ...]
    """The rods' names."""
    carried: tuple[str, ...]
    """Names of the unknowns that the rods determine."""
    taken_as_absent: tuple[str, ...]
    """Names of the unknowns that are assumed zero."""
    blind: tuple[str, ...]
    """Names of the unknowns that no rod reads."""
    spare: int
    """Rods beyond the unknowns: the check."""
    condition: float
    """Condition number, see `stiffcal.links.rods.RodDesign`."""
    gain: float
    """Error of the link's end over a rod's error at worst, see `stiffcal.links.rods.RodDesign`."""
    std: Floats
    """(6,) standard uncertainty of the end's displacement in one state, m and rad; NaN where not measured."""
    sigma: float
    """Of a rod, m: as stated, else `USUAL_SIGMA`."""
    stated: bool
    """True where the manifest states ``sigma``."""
    mistakes: tuple[ShapeError, ...]
    """What loads that are not carried do to the estimate."""
    advice: tuple[ExtraRod, ...]
    """Rods that would help, the best first."""

    @property
    def sentences(self) -> tuple[str, ...]:
        """The view in words, for `check`."""
        return (*_observable(self), *_unmeasured(self), *(_advice_text(rod, self) for rod in self.advice[:1]))


def rod_observability(rods: Rods, shape: BeamProperties, outline: Sequence[Floats] | None = None) -> RodObservability:
    """Return what rods can and cannot measure, and the further rod that would help most.

    Parameters
    ----------
    rods, shape : the rods and their link.
    outline : corners (x2, x3) of the section, in order around it, on which a further rod could be fixed; None: the
        places across the link that rods have already.

    Examples
    --------
    >>> corners = np.array([[0.05, y, z] for y in (-0.1, 0.1) for z in (-0.08, 0.08)])
    >>> view = rod_observability(rods_between("swing", corners, corners + [0.9, 0.0, 0.0]), BeamProperties(1.0))
    >>> view.blind, view.taken_as_absent, view.spare
    (('torsion',), ('tip moment 2', 'tip moment 3'), 1)
    >>> view.advice[0].determines
    ('torsion',)
    """
    design = rod_design(rods, shape)
    stated = bool(np.isfinite(rods.sigma).all())
    sigma = rods.sigma if stated else np.full(len(rods.names), USUAL_SIGMA)
    answer = design.end @ np.linalg.pinv(design.matrix)
    std = np.sqrt(answer**2 @ sigma**2)
    std[3] = std[3] if TORSION in design.carried else np.nan
    return RodObservability(
        rods.link, rods.names, design.names, tuple(UNKNOWNS[u] for u in design.left_out),
        tuple(UNKNOWNS[u] for u in design.blind), design.redundancy, design.condition, design.gain, std,
        float(np.sqrt(np.mean(sigma**2))), stated, shape_errors(rods, shape, design),
        _advice(rods, shape, design, outline),
    )  # fmt: skip


def _advice(
    rods: Rods, shape: BeamProperties, design: RodDesign, outline: Sequence[Floats] | None
) -> tuple[ExtraRod, ...]:
    """Try one more rod at every place; first the one which makes most unknowns identifiable, then the most accurate."""
    across = _around(np.asarray(outline) if outline is not None else rods.start[:, 1:])
    tried: list[ExtraRod] = []
    for i, start_point in enumerate(across):
        # Along the wall, or across one of its sides: never through the hollow.
        for end_point in (start_point, across[(i + 1) % len(across)], across[i - 1]):
            for a, first in enumerate(PLACES):
                for last in PLACES[a + 1 :]:
                    start = np.array([first * shape.length, *start_point])
                    end = np.array([last * shape.length, *end_point])
                    tried.append(_try_extra_rod(rods, shape, design, start, end))
    tried.sort(key=_worth)
    useful = [rod for rod in tried if rod.determines or rod.gain_after < 0.9 * rod.gain_before]
    return tuple(useful[:3])


def _worth(rod: ExtraRod) -> tuple[int, list[int], float]:
    """Sort by how many unknowns a rod makes identifiable, in the order in which rods are spent, then by how well."""
    determines = [UNKNOWNS.index(name) for name in rod.determines]
    return -len(determines), determines, rod.gain if determines else rod.gain_after


def _try_extra_rod(rods: Rods, shape: BeamProperties, design: RodDesign, start: Floats, end: Floats) -> ExtraRod:
    """Return what the rods determine with one more between two points of the beam."""
    new = rods_between(rods.link, start[None], end[None])
    all_rods = Rods(
        rods.link, (*rods.names, "new"), np.vstack([rods.start, new.start]), np.vstack([rods.end, new.end]),
        np.vstack([rods.warping, new.warping]), np.append(rods.sigma, np.nan),
    )  # fmt: skip
    full_design = rod_design(all_rods, shape)
    determines = tuple(name for name in full_design.names if name not in design.names)
    # ``gain`` compares equal unknowns; what further unknowns cost is shown by the full design's gain.
    same_unknowns = rod_design(all_rods, shape, design.names)
    return ExtraRod(start, end, determines, design.gain, same_unknowns.gain, full_design.gain, full_design.redundancy)


def _around(points: Floats) -> Floats:
    """Return distinct places across the link in order around their middle."""
    distinct = np.unique(np.round(points, 9), axis=0)
    middle = distinct.mean(axis=0)
    return np.asarray(distinct[np.argsort(np.arctan2(distinct[:, 1] - middle[1], distinct[:, 0] - middle[0]))])


def _observable(view: RodObservability) -> tuple[str, ...]:
    size = in_unit(view.sigma, LENGTH.unit_for([view.sigma]), 2) + ("" if view.stated else " (assumed)")
    shown = [of_component(k).unit_for(view.std[k : k + 3]) for k in (0, 3)]
    determined = [
        f"{name} ± {in_unit(NORMAL_95 * std, shown[i // 3], 2)}"
        for i, (name, std) in enumerate(zip(_COMPONENTS, view.std, strict=True))
        if np.isfinite(std)
    ]
    check = (
        f"{view.spare} redundant, as a check"
        if view.spare
        else ("none redundant: a faulty rod can be found only with the load")
    )
    carried = ", ".join(view.carried) or "nothing"
    determined_text, condition = ", ".join(determined), significant(view.condition)
    return (
        f"{len(view.rods)} rods on {view.link} determine {carried}; {check}; condition number {condition}",
        f"with rods of {size} the end of {view.link} has an uncertainty of {determined_text} in one state (± 95 %)",
    )


def _unmeasured(view: RodObservability) -> tuple[str, ...]:
    sentences = []
    if "torsion" in view.blind:
        sentences.append(
            f"no rod on {view.link} measures its twist: all are parallel to the fibre, where a uniform twist changes "
            "no length"
        )
    elif "torsion" in view.taken_as_absent:
        sentences.append(
            f"the twist of {view.link} is assumed zero: too few rods to separate it from the other components"
        )
    moments = [error for error in view.mistakes if error.load in view.taken_as_absent and "moment" in error.load]
    sentences += [
        f"a {error.load} at the end of {view.link} is interpreted as a force: error of the end displacement "
        f"{percent(error.relative)} of that of the moment"
        for error in moments
    ]
    return tuple(sentences)


def _advice_text(rod: ExtraRod, view: RodObservability) -> str:
    places = " to ".join(
        "[" + ", ".join(f"{LENGTH.usual.factor * value:.0f}" for value in point) + "]" for point in (rod.start, rod.end)
    )
    if rod.determines:
        return f"one more rod from {places} mm would determine {', '.join(rod.determines)}"
    times = rod.gain_before / rod.gain_after
    return (
        f"one more rod from {places} mm would reduce the uncertainty of the end of {view.link} by a factor of "
        f"{significant(times, 2)}"
    )
