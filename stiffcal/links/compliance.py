"""A link's 6×6 compliance from its rods and the wrench it carries, so that it predicts with no rods (000, section 6).

The end's displacement is δ = T z, z the amplitudes that the rods carry. A conservative link answers the wrench w at its
end by δ = C w with C symmetric, so that z = S Tᵀ w and C = T S Tᵀ with S symmetric: that is what is fitted, to the
rods' readings themselves, each run with an offset of its own, because the reading that they count from is as noisy as
the others. Rods that leave a bending moment out cannot determine so much. Then the link counts as an even beam, which
answers every wrench with five flexibilities, and the wrench gives how much of the bending each load makes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from stiffcal.arrays import Floats, Integers
from stiffcal.links.rods import LEAST_TORSION, LinkEstimate, RodDesign, Torsion
from stiffcal.measurements.load_states import Attachment
from stiffcal.measurements.rods import BeamProperties, Rods
from stiffcal.mechanics.beam import (
    FORCE_2,
    FORCE_3,
    MOMENT_2,
    MOMENT_3,
    TENSION,
    UNKNOWNS,
    end_fields,
    flexibility_patterns,
)
from stiffcal.mechanics.chain import Chain
from stiffcal.mechanics.rods import rod_fields
from stiffcal.model.balance.deformed_chain import deformed_chain
from stiffcal.model.balance.equilibrium import displacement_between
from stiffcal.uncertainty import NORMAL_95

# Below this share of the largest singular value a combination of loads counts as not applied.
SMALLEST_LOAD = 1e-9
# Where the twist stands among an even beam's flexibilities.
TWIST = 3


@dataclass(frozen=True)
class LinkCompliance:
    """Compliance of a link's end, beam axes: displacement (m, rad) per wrench (N, N·m) about the outboard end."""

    link: str
    """The link's name."""
    matrix: Floats
    """(6, 6); NaN where these rods or these loads do not determine it."""
    std: Floats
    """(6, 6) standard uncertainty."""
    slopes: Floats
    """(36, p) of the matrix by the fitted coefficients."""
    coefficients: Floats
    """(p,) values in the same order."""
    covariance: Floats
    """(p, p)."""
    structure: Literal["symmetric", "beam"]
    """"symmetric": any C = Cᵀ; "beam": an even beam, where the rods leave out a bending moment."""
    reduced_chi2: float
    """Of the readings against the stated uncertainty; NaN where none is stated."""
    dof: int
    """Readings beyond coefficients and offsets."""
    factor: float
    """Of the 95 % interval."""
    twist: Torsion | None = None
    """The rods' verdict on the twist, where its compliance is not known; None where it is."""
    gaps: tuple[str, ...] = ()
    """In words, what else these loads do not determine."""

    @property
    def not_identifiable(self) -> tuple[str, ...]:
        """In words, what is not known."""
        return self.gaps if self.twist is None else (f"torsion of the link: {self.twist.why}", *self.gaps)

    @property
    def interval(self) -> Floats:
        """(2, 6, 6) low and high end of the 95 % interval."""
        return np.stack([self.matrix - self.factor * self.std, self.matrix + self.factor * self.std])

    def predict(self, wrench: Floats) -> Floats:
        """Return (n, 6) displacement of the end under (n, 6) wrenches; what is not known counts as none."""
        return np.asarray(wrench @ np.nan_to_num(self.matrix).T)


def regress_compliance(estimate: LinkEstimate, wrench: Floats, run: Integers | None = None) -> LinkCompliance:
    """Regress a link's compliance on the wrench it carries.

    Parameters
    ----------
    estimate : of n states.
    wrench : (n, 6) at the link's outboard end in beam axes, N and N·m: since the state that counts as unloaded.
    run : (n,) runs, each with its own offset; None: the readings count from no load, exactly.
    """
    design = estimate.design
    lengths = estimate.amplitudes @ design.matrix.T + estimate.residual
    stated = estimate.sigma_source == "stated"
    weight = 1.0 / estimate.sigma if stated else np.ones(lengths.shape[1])
    symmetric = not any(unknown in design.left_out for unknown in (FORCE_2, FORCE_3, TENSION, MOMENT_2, MOMENT_3))
    basis = _symmetric_basis(design) if symmetric else _beam_basis(estimate.rods, estimate.shape)
    # What a rod reads per coefficient, and what the compliance has of it.
    columns = np.stack([rods @ wrench.T for rods, _ in basis], axis=-1)  # (m, n, p)
    slopes = np.stack([end for _, end in basis], axis=-1).reshape(36, -1)
    centred = _centring(run, len(lengths))
    rows = centred(np.moveaxis(columns, 0, 1) * weight[None, :, None]).reshape(-1, len(basis))
    target = centred(lengths * weight).reshape(-1)
    offsets = 0 if run is None else len(np.unique(run)) * lengths.shape[1]
    solved = _solve(rows, target, offsets, stated)
    if not symmetric and _twist_is_guessed(solved, stated):
        rows[:, TWIST] = 0.0
        solved = _solve(rows, target, offsets, stated)
    identified = _identified_elements(
        slopes / solved.size, solved.undetermined, estimate.torsion.identifiable or not symmetric
    )
    matrix = np.where(identified, (slopes @ solved.coefficients).reshape(6, 6), np.nan)
    std = np.sqrt(np.einsum("ip,pq,iq->i", slopes, solved.covariance, slopes)).reshape(6, 6)
    return LinkCompliance(
        estimate.rods.link, matrix, np.where(identified, std, np.nan), slopes, solved.coefficients, solved.covariance,
        "symmetric" if symmetric else "beam", solved.chi2 if stated else np.nan, solved.dof,
        _factor(solved.dof, stated), None if identified[3, 3] else estimate.torsion, _gaps(identified),
    )  # fmt: skip


@dataclass(frozen=True)
class _Solved:
    """Least squares of p coefficients; ``undetermined``: (l, p) combinations, scaled by ``size``, without a load."""

    coefficients: Floats
    covariance: Floats
    size: Floats
    undetermined: Floats
    chi2: float
    dof: int


def _solve(rows: Floats, target: Floats, offsets: int, stated: bool) -> _Solved:
    size = np.linalg.norm(rows, axis=0)
    # What nothing turns is counted like what is turned most: a millionth of it in an element is none.
    size[size == 0.0] = size.max() if size.any() else 1.0
    left, singular, right = np.linalg.svd(rows / size, full_matrices=False)
    significant = singular > SMALLEST_LOAD * max(float(singular[0]), np.finfo(float).tiny)
    inverse = (right[significant].T / singular[significant]) / size[:, None]
    coefficients = inverse @ (left[:, significant].T @ target)
    dof = len(target) - int(significant.sum()) - offsets
    chi2 = float(np.sum((target - rows @ coefficients) ** 2) / dof) if dof > 0 else np.nan
    return _Solved(coefficients, inverse @ inverse.T * (1.0 if stated else chi2), size, right[~significant], chi2, dof)


def _twist_is_guessed(solved: _Solved, stated: bool) -> bool:
    """Return whether the twist's flexibility is known no better than what a closed section can have at most."""
    about_3, about_2 = solved.coefficients[:2]
    if min(about_3, about_2) <= 0.0:
        return True
    most = 1.0 / (LEAST_TORSION * (1.0 / about_3 + 1.0 / about_2))
    return bool(_factor(solved.dof, stated) * np.sqrt(solved.covariance[TWIST, TWIST]) > 0.5 * most)


def _symmetric_basis(design: RodDesign) -> list[tuple[Floats, Floats]]:
    """Return for each coefficient of S what the rods read per wrench (m, 6), and its share of C (6, 6)."""
    basis = []
    for a in range(design.end.shape[1]):
        for b in range(a, design.end.shape[1]):
            unit = np.zeros((design.end.shape[1], design.end.shape[1]))
            unit[a, b] = unit[b, a] = 1.0
            basis.append((design.matrix @ unit @ design.end.T, design.end @ unit @ design.end.T))
    return basis


def _beam_basis(rods: Rods, shape: BeamProperties) -> list[tuple[Floats, Floats]]:
    """Return the same for an even beam's flexibilities."""
    fields, ends = rod_fields(rods, shape)[:, : len(UNKNOWNS)], end_fields(shape)[:, : len(UNKNOWNS)]
    return [(fields @ per_load, ends @ per_load) for per_load in flexibility_patterns(shape)]


def _centring(run: Integers | None, n: int) -> Callable[[Floats], Floats]:
    """Return a function that takes each run's mean out of (n, …) rows."""
    if run is None:
        return lambda rows: rows
    _, number = np.unique(run, return_inverse=True)
    count = np.bincount(number)

    def centred(rows: Floats) -> Floats:
        flat = rows.reshape(n, -1)
        means = np.stack([np.bincount(number, column) / count for column in flat.T], axis=1)
        return np.asarray((flat - means[number]).reshape(rows.shape))

    return centred


def _identified_elements(slopes: Floats, undetermined: Floats, twist: bool) -> NDArray[np.bool_]:
    """Return (6, 6) True where an element depends on no combination of coefficients that the loads left open."""
    identified = np.ones((6, 6), dtype=np.bool_)
    if len(undetermined):
        undetermined_share = np.linalg.norm(slopes @ undetermined.T, axis=1).reshape(6, 6)
        identified = undetermined_share <= 1e-6 * np.linalg.norm(slopes, axis=1).reshape(6, 6)
    if not (twist and identified[3, 3]):
        identified[3, :] = identified[:, 3] = False
    return identified


def _factor(dof: int, stated: bool) -> float:
    from scipy.special import stdtrit

    return NORMAL_95 if stated else float(stdtrit(max(dof, 1), 0.975))


def _gaps(identified: NDArray[np.bool_]) -> tuple[str, ...]:
    """Return in words which elements other than the twist's (6, 6) are not identified."""
    without_twist = identified.copy()
    without_twist[3], without_twist[:, 3] = True, True
    if without_twist.all():
        return ()
    names = ("u1", "u2", "u3", "φ1", "φ2", "φ3")
    loads = ("F1", "F2", "F3", "M1", "M2", "M3")
    missing = ", ".join(f"{names[i]} per {loads[j]}" for i, j in np.argwhere(~without_twist) if i <= j)
    return (f"these loads do not identify {missing}",)


def carried_to_target(
    chain: Chain, angles: Floats, link: str, tip: Floats, target: Attachment, other_displacement: Floats | None = None
) -> Floats:
    """Carry the displacement of a link's end through the chain to a target.

    Parameters
    ----------
    chain : the robot.
    angles : (n, J) model angles, rad.
    link : its name among ``chain.beams``.
    tip : (n, 6) displacement of its outboard end, beam axes, m and rad.
    target : the frame that is looked at.
    other_displacement : (n, 2J + 2, 6) displacements of all other nodes, where the robot stands deformed; None: rigid.

    Returns
    -------
    (n, 6) displacement of the target, base axes, m and rad; exact, not first order.
    """
    joints = np.ascontiguousarray(angles.T)
    small = np.zeros((2 * chain.n_joints + 2, 6, len(angles)))
    if other_displacement is not None:
        small[:] = np.moveaxis(other_displacement, 0, -1)
    node = 2 * chain.beams[link].joint
    small[node] = 0.0
    before = deformed_chain(chain, joints, small).bodies[target.body].moved(target.transform)
    small[node] = tip.T
    after = deformed_chain(chain, joints, small).bodies[target.body].moved(target.transform)
    return np.ascontiguousarray(displacement_between(after, before).T)


def share_of_tool(link_displacement: Floats, displacement: Floats) -> float:
    """Return the share of a displacement that a part of it makes up, along the whole (translations).

    Parts that sum up to the whole have shares that sum up to one.

    Examples
    --------
    >>> whole = np.array([[0.0, 0.0, 2.0, 0.0, 0.0, 0.0]])
    >>> share_of_tool(0.25 * whole, whole)
    0.25
    """
    return float(np.sum(link_displacement[:, :3] * displacement[:, :3]) / np.sum(displacement[:, :3] ** 2))
