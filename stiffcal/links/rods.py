"""Links measured by integral deformation sensors (paper 000): from the rods' lengths to how the link's end has moved.

The known side is the link: its rods determine how it bends, whatever the joints do. Unknown are the amplitudes of the
fields that a wrench at its end can make (`stiffcal.mechanics.beam`): one for each degree of freedom first, tip force
per plane, tension and torsion, then a tip moment per plane, because the next link puts a moment on this one's end. Each
is taken up as long as the rods can carry it. What they cannot carry counts as zero, and what that may cost is reported.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.estimation.leave_out import LeaveOut
from stiffcal.links.sigma_source import SigmaSource
from stiffcal.measurements.rods import BeamProperties, Rods
from stiffcal.mechanics.beam import OTHER_FIELDS, TORSION, UNKNOWNS, end_fields, fibre_fields
from stiffcal.mechanics.rods import rod_fields
from stiffcal.wording import angle

# Beyond this an error of 1 µm in a rod would stand for 1 mm at the link's end: such an unknown is not carried.
LARGEST_GAIN = 1e3
# Least torsional rigidity per sum of the bending rigidities, GJ/(EI2 + EI3), of closed or full sections no flatter than
# three to one: J/(I2 + I3) is 0.32 for a full rectangle of 3:1, 0.42 for a box of even wall, up to 1 for a circle; G/E
# is 0.37 or more for Poisson's ratios up to 0.35. An open section has next to none.
LEAST_TORSION = 0.11
# A rod that reads less than this of a field that moves the end by one does not measure it.
BLIND = 1e-9


@dataclass(frozen=True)
class ShapeError:
    """What a load that the assumed shape cannot carry does to the estimate."""

    load: str
    """Which field it makes (`UNKNOWNS` and `OTHER_FIELDS` of `stiffcal.mechanics.beam`)."""
    relative: float
    """Error of the end's displacement over the displacement (translations; for torsion the twist)."""
    error: Floats
    """(6,) error of the end's displacement for a unit of the field, m and rad."""
    truth: Floats
    """(6,) the end's displacement for a unit of the field, m and rad."""


@dataclass(frozen=True)
class Torsion:
    """Whether the rods determine how the link twists."""

    identifiable: bool
    """True where the estimate's fourth component is an estimate."""
    bound: float | None
    """rad; where it is not: the largest twist that the end can have had. None where nothing bounds it."""
    cause: str
    """In words, what of the rods lets them carry the twist or not."""
    bounded_by: Literal["readings", "load"] = "readings"
    """What the bound rests on: the rods' readings, or the moment about the link."""

    @property
    def why(self) -> str:
        """In words, what the bound rests on among them."""
        if self.bound is None:
            return self.cause
        if self.bounded_by == "load":
            return (
                f"{self.cause}; under these loads a closed section with an aspect ratio up to 3:1 and the same "
                f"bending stiffness twists by {angle(self.bound)} at most"
            )
        return f"{self.cause}; a twist above {angle(self.bound)} would have extended a rod by more than its reading"


@dataclass(frozen=True)
class RodDesign:
    """What m rods carry of a link's k unknowns."""

    carried: tuple[int, ...]
    """k indices into `UNKNOWNS`."""
    blind: tuple[int, ...]
    """Indices of what no rod measures."""
    left_out: tuple[int, ...]
    """Indices of the rest."""
    matrix: Floats
    """(m, k) what the rods read per amplitude."""
    end: Floats
    """(6, k) what the end does per amplitude."""
    gain: float
    """Displacement of the end per error of the rods, in the worst direction; turns count at one link's length."""
    condition: float
    """Condition number of the rods' matrix, each unknown scaled to one displacement of the end."""

    @property
    def names(self) -> tuple[str, ...]:
        """The carried unknowns by name."""
        return tuple(UNKNOWNS[u] for u in self.carried)

    @property
    def redundancy(self) -> int:
        """Rods beyond the unknowns."""
        return len(self.matrix) - len(self.carried)


@dataclass(frozen=True)
class LinkEstimate:
    """How a link's end moved in n states, by m rods; beam axes."""

    rods: Rods
    """The rods."""
    shape: BeamProperties
    """The link they are on."""
    design: RodDesign
    """What the rods carry."""
    displacement: Floats
    """(n, 6) m and rad; NaN where not known."""
    covariance: Floats
    """(6, 6) of one state's displacement, from the rods' uncertainty; NaN where not known."""
    amplitudes: Floats
    """(n, k) of the carried unknowns."""
    amplitude_covariance: Floats
    """(k, k)."""
    residual: Floats
    """(n, m) read minus explained, m."""
    disagreement: Floats
    """(m,) by how many of its standard uncertainties each rod differs from what the others give for it, rms over the
    states; NaN where the others do not determine it.
    """
    sigma: Floats
    """(m,) m, as stated, or from the residuals."""
    sigma_source: SigmaSource
    """"stated", "residuals" or "none"."""
    torsion: Torsion
    """Whether the twist is known."""
    shape_errors: tuple[ShapeError, ...]
    """What loads that are not carried would do."""

    @property
    def known(self) -> Booleans:
        """(6,) which components of the end's displacement are known."""
        determined = np.ones(6, dtype=np.bool_)
        determined[3] = self.torsion.identifiable
        return determined

    @property
    def carried(self) -> tuple[str, ...]:
        """The unknowns that the rods carry, by name."""
        return self.design.names

    @property
    def condition(self) -> float:
        """Condition number of the rods' matrix."""
        return self.design.condition

    @property
    def redundancy(self) -> int:
        """Rods beyond the unknowns."""
        return self.design.redundancy

    @property
    def untwisted(self) -> Floats:
        """(n, 6) the displacement with an unknown twist taken as none, to be carried on to the tool."""
        return np.asarray(np.where(self.known, self.displacement, 0.0))

    def interval(self, level: float = 0.95) -> Floats:
        """Return (6,) half-widths of the displacement's interval in one state, m and rad."""
        from scipy.special import ndtri, stdtrit

        tail = 0.5 + level / 2.0
        dof = len(self.residual) * self.redundancy
        factor = stdtrit(dof, tail) if self.sigma_source == "residuals" else ndtri(tail)
        return np.asarray(factor * np.sqrt(np.diag(self.covariance)))


def rod_design(rods: Rods, shape: BeamProperties, unknowns: tuple[str, ...] | None = None, spare: int = 0) -> RodDesign:
    """Return the unknowns that the rods determine.

    Parameters
    ----------
    rods, shape : the rods and their link.
    unknowns : names to carry whatever it costs; None: as many as the rods can carry.
    spare : so many rods are kept as a check.

    Examples
    --------
    Four rods at the corners of a link, all alike, carry a force in each plane and tension; a moment would look to them
    like a force, and no rod along the fibre measures an even twist.

    >>> from stiffcal.measurements.rods import rods_between
    >>> corners = np.array([[0.05, y, z] for y in (-0.1, 0.1) for z in (-0.08, 0.08)])
    >>> rods = rods_between("swing", corners, corners + [0.8, 0.0, 0.0])
    >>> rod_design(rods, BeamProperties(1.0)).names
    ('tip force 2', 'tip force 3', 'tension')
    """
    fields, ends = rod_fields(rods, shape)[:, : len(UNKNOWNS)], end_fields(shape)[:, : len(UNKNOWNS)]
    # Turns count by what they move at one link's length.
    motions = ends * np.array([1.0, 1.0, 1.0, shape.length, shape.length, shape.length])[:, None]
    size = np.linalg.norm(motions, axis=0)
    fields, motions = fields / size, motions / size
    blind = tuple(u for u in range(len(UNKNOWNS)) if np.abs(fields[:, u]).max(initial=0.0) < BLIND)
    if unknowns is not None:
        carried = [UNKNOWNS.index(name) for name in unknowns]
    else:
        carried = []
        for unknown in range(len(UNKNOWNS)):
            extended = [*carried, unknown]
            if unknown not in blind and len(extended) <= len(rods.names) - spare:
                carried = extended if _gain(fields[:, extended], motions[:, extended]) < LARGEST_GAIN else carried
    singular = np.linalg.svd(fields[:, carried], compute_uv=False) if carried else np.ones(1)
    absent = tuple(u for u in range(len(UNKNOWNS)) if u not in carried and u not in blind)
    return RodDesign(
        tuple(carried), tuple(u for u in blind if u not in carried), absent, fields[:, carried] * size[carried],
        ends[:, carried], _gain(fields[:, carried], motions[:, carried]),
        float(singular[0] / max(singular[-1], np.finfo(float).tiny)),
    )  # fmt: skip


def _gain(fields: Floats, motions: Floats) -> float:
    """Return by how much an error of the rods can be magnified at the link's end; infinite where undetermined."""
    if not fields.shape[1] or np.linalg.svd(fields, compute_uv=False)[-1] < BLIND:
        return np.inf if fields.shape[1] else 0.0
    return float(np.linalg.norm(motions @ np.linalg.pinv(fields), 2))


def estimate_link(
    rods: Rods,
    shape: BeamProperties,
    lengths: Floats,
    sigma: Floats | None = None,
    unknowns: tuple[str, ...] | None = None,
    spare: int = 0,
) -> LinkEstimate:
    """Estimate how the link's end moved from the rods' changes of length (eq. 6, for rods at any angle).

    Parameters
    ----------
    rods, shape : the rods and their link.
    lengths : (n, m) changes of length since the state that counts as unloaded, m.
    sigma : (m,) standard uncertainty of one such change, m; None: as the rods state, else from their disagreement.
    unknowns, spare : see `rod_design`.
    """
    design = rod_design(rods, shape, unknowns, spare)
    stated = rods.sigma if sigma is None else np.broadcast_to(np.asarray(sigma, dtype=np.float64), len(rods.names))
    has_sigma = bool(np.isfinite(stated).all())
    weight = 1.0 / stated if has_sigma else np.ones(len(rods.names))
    solve = np.linalg.pinv(weight[:, None] * design.matrix) * weight
    amplitudes = lengths @ solve.T
    residual = lengths - amplitudes @ design.matrix.T
    source: SigmaSource = "stated"
    used = stated
    if not has_sigma:
        free = design.redundancy * len(lengths)
        scatter = np.sqrt(np.sum(residual**2) / free) if free > 0 else np.nan
        used, source = np.full(len(rods.names), scatter), "residuals" if free > 0 else "none"
    spread = solve @ np.diag(used**2) @ solve.T
    twist_known = TORSION in design.carried
    displacement, covariance = amplitudes @ design.end.T, design.end @ spread @ design.end.T
    if not twist_known:
        displacement[:, 3], covariance[3], covariance[:, 3] = np.nan, np.nan, np.nan
    return LinkEstimate(
        rods, shape, design, displacement, covariance, amplitudes, spread, residual,
        _disagreement(design, residual, used), used, source,
        _torsion(rods, shape, design, lengths, used), shape_errors(rods, shape, design, solve),
    )  # fmt: skip


def _disagreement(design: RodDesign, residual: Floats, sigma: Floats) -> Floats:
    """Return (m,) leave-one-rod-out residuals over their standard uncertainty, rms over the states.

    Without its rod a residual r is s² r, of standard uncertainty s σ, with s the same in every state
    (`LeaveOut.spread`): their quotient is s r/σ.
    """
    m, k = design.matrix.shape
    result = np.full(m, np.nan)
    if not len(residual) or not np.all(sigma > 0.0):
        return result
    white = np.vstack([design.matrix.T / sigma, np.zeros(m)])
    free = np.full(k, np.inf)
    spread = LeaveOut(white, list(np.arange(m)[:, None]), np.zeros((0, k + 1)), -free, free).spread
    determined = np.isfinite(spread)
    rms = np.sqrt(np.mean(residual[:, determined] ** 2, axis=0))
    result[determined] = rms * spread[determined] / sigma[determined]
    return result


def shape_errors(
    rods: Rods, shape: BeamProperties, design: RodDesign, solve: Floats | None = None
) -> tuple[ShapeError, ...]:
    """Return the error of the end's estimate by each field that the rods do not carry.

    Parameters
    ----------
    solve : (k, m) amplitudes per reading; None: rods of equal weight.
    """
    inverse = np.linalg.pinv(design.matrix) if solve is None else solve
    fields, ends = rod_fields(rods, shape), end_fields(shape)
    errors = []
    for field, name in enumerate((*UNKNOWNS, *OTHER_FIELDS)):
        if field in design.carried:
            continue
        truth = ends[:, field]
        error = design.end @ (inverse @ fields[:, field]) - truth
        rows = slice(3, 4) if field == TORSION else slice(0, 3)
        relative = float(np.linalg.norm(error[rows]) / np.linalg.norm(truth[rows]))
        errors.append(ShapeError(name, relative, error, truth))
    return tuple(errors)


def _torsion(rods: Rods, shape: BeamProperties, design: RodDesign, lengths: Floats, sigma: Floats) -> Torsion:
    if TORSION in design.carried:
        return Torsion(True, None, "the rods measure the torsion of the link")
    bound = twist_bound(rods, shape, lengths, sigma)
    if TORSION in design.blind:
        cause = (
            "no rod measures a uniform twist: all are parallel to the fibre. An oblique rod would measure it, or "
            "warping_decay_m with the warping at the ends of the rods"
        )
    else:
        cause = f"{len(rods.names)} rods determine {', '.join(design.names)}, but not the twist"
    return Torsion(False, bound, cause)


def twist_bound(rods: Rods, shape: BeamProperties, lengths: Floats, sigma: Floats) -> float | None:
    """Return the twist of the link's end above which a rod would have grown by more than it ever read, rad.

    A rod is straight: when its ends turn about the twist centre by Δφ against each other it grows by (r Δφ)²/(2 l), r
    its distance from that centre and l its length, whatever the section. Lax, but it needs to know nothing of the link.
    """
    if not len(lengths):
        return None
    places = np.concatenate([rods.start[:, 0], rods.end[:, 0]])
    twist = fibre_fields(shape, places)[TORSION, 3].reshape(2, -1)
    share = (twist[1] - twist[0]) / end_fields(shape)[3, TORSION]
    centre = (rods.start[:, 1:] + rods.end[:, 1:]) / 2.0 - np.array(shape.twist_centre)
    radius = np.linalg.norm(centre, axis=1)
    largest = np.abs(lengths).max(axis=0) + 2.0 * np.nan_to_num(sigma)
    informative = (radius * np.abs(share) > 1e-6) & (largest > 0.0)
    if not informative.any():
        return None
    most = np.sqrt(2.0 * rods.length[informative] * largest[informative]) / (
        radius[informative] * np.abs(share[informative])
    )
    return float(most.min())


def bounded_by_load(torsion: Torsion, moment: Floats, bending: Floats) -> Torsion:
    """Return the torsion with the bound that the load sets, where that is the tighter one.

    Parameters
    ----------
    torsion : as the rods alone give it.
    moment : (n,) moment about the link that its end carried, N·m.
    bending : (2,) the end's turns about x2 and x3 per moment, rad/(N·m), as the rods give them; NaN where they do not.
    """
    if torsion.identifiable or not np.all(bending > 0.0):
        return torsion
    bound = float(np.abs(moment).max(initial=0.0) / (LEAST_TORSION * np.sum(1.0 / bending)))
    if torsion.bound is not None and torsion.bound <= bound:
        return torsion
    return Torsion(False, bound, torsion.cause, "load")
