"""The whole compliance of a joint."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.mechanics.chain import Chain
from stiffcal.model.effect import (
    RZ,
    TZ,
    Covariate,
    Law,
    NodeLoads,
    ParameterSpec,
    Place,
    Term,
    Values,
    joint_node,
)
from stiffcal.wording import significant

_PAIRS = tuple((i, j) for i in range(6) for j in range(i, 6))
_COMPONENTS = ("x", "y", "z", "rotation about x", "rotation about y", "rotation about z")
# Eigenvalues may be this share of the largest below zero before a compliance counts as impossible: rounding.
_ROUNDING = 1e-9
# Lengths scaled by 0.1 m, so that translations and rotations can stand in one eigenvalue.
_SCALE = np.array([10.0, 10.0, 10.0, 1.0, 1.0, 1.0])


def _unit(i: int, j: int) -> str:
    return ("m/N", "rad/N", "rad/(N·m)")[(i >= 3) + (j >= 3)]


def _bound(i: int, j: int) -> float:
    return (1e-5, 1e-4, 1e-3)[(i >= 3) + (j >= 3)]


def _spec(i: int, j: int) -> ParameterSpec:
    on_diagonal = i == j
    meaning = f"compliance: {_COMPONENTS[i]}" if on_diagonal else f"coupling: {_COMPONENTS[i]} with {_COMPONENTS[j]}"
    source = (
        "rotations 1e-7 to 1e-6 (KUKA KR240, Rösch); Schneider et al. 2014, section III.C: translations below 4e-8; "
        "couplings up to the geometric mean of these, the limit of positive energy"
    )
    typical = (5e-9, 2.6e-8, 1.4e-7)[(i >= 3) + (j >= 3)]
    return ParameterSpec(
        f"c{i + 1}{j + 1}", _unit(i, j), meaning, 0.0 if on_diagonal else -_bound(i, j), _bound(i, j), typical, source,
        compliance=on_diagonal, along=i if on_diagonal else None,
    )  # fmt: skip


class JointFull(Law):
    """A joint is compliant in all six directions, and a load in one direction may move it in another.

    Law: δ = C w, with C the symmetric, positive semidefinite 6×6 compliance of the joint, δ and w the displacement and
    wrench at the joint's node in its axes, ordered (translation, rotation) and (force, moment): c11 is along x, c66
    about the joint's axis. Schneider et al. 2014, eq. 1 and section II (36 degrees of freedom: three rotations and
    three translations at six joints); symmetric after Maxwell and Betti.

    Assumes an elastic joint: proportional, and with an energy, whence the symmetry and the non-negative eigenvalues.

    Limits: 21 parameters a joint. Twelve poses seldom identify more than a few; those that cannot be identified are
    reported so. It includes joint-compliance (c66), bearing-tilt (c44, c55) and joint-translation (c11, c22, c33) and
    takes their place; prefer these where they suffice.
    """

    name = "joint-full"
    place_kind = "joints"
    general = True
    summary = "full symmetric 6×6 compliance of a joint"
    includes = ("joint-compliance", "bearing-tilt", "joint-translation")
    parameters = tuple(_spec(i, j) for i, j in _PAIRS)
    # c33 is along the axis
    prismatic = parameters
    looks_like = ("bearing-tilt", "joint-translation", "axis-coupling", "link-beam")
    fingerprint = (
        "a load in one direction at the joint displaces the link in another direction, in proportion, the "
        "same in every pose"
    )
    how_to_check = (
        "Track the links on both sides of the joint (one target each) while the tool is loaded in three directions: "
        "their relative motion over the wrench on the joint gives C, column by column."
    )

    def terms(self, place: Place, chain: Chain, loads: NodeLoads, shape: Values) -> Sequence[Term]:
        """δ = C w, with one amplitude for each of the 21 different elements of C."""
        node = joint_node(place.joints[0])
        terms = []
        for i, j in _PAIRS:
            symbol = f"c{i + 1}{j + 1}"
            terms.append(Term(node, i, symbol, loads.wrench[node, j]))
            if i != j:
                terms.append(Term(node, j, symbol, loads.wrench[node, i]))
        return terms

    def impossible(self, values: Values) -> str | None:
        """Return a reason where C has a negative eigenvalue: the joint would give work away under load."""
        eigenvalues = np.linalg.eigvalsh(_matrix([values.get(f"c{i + 1}{j + 1}", 0.0) for i, j in _PAIRS]))
        if eigenvalues[0] < -_ROUNDING * max(abs(float(eigenvalues[-1])), 1e-300):
            return (
                f"the joint's compliance has a negative eigenvalue "
                f"({significant(eigenvalues[0], 2)}): it would release energy"
            )
        return None

    def covariate(self, place: Place, chain: Chain, loads: NodeLoads) -> Covariate:
        """The torque about the joint's axis, the largest part as a rule."""
        joint = place.joints[0]
        if joint in chain.prismatic_joints:
            return Covariate(f"force on joint {joint}", "N", loads.wrench[joint_node(joint), TZ])
        return Covariate(f"torque on joint {joint}", "N·m", loads.wrench[joint_node(joint), RZ])


def _matrix(elements: Sequence[float] | Floats) -> Floats:
    """Return C (6, 6) from its 21 elements, lengths scaled by 0.1 m: translations and rotations share eigenvalues."""
    compliance = np.zeros((6, 6))
    for (i, j), value in zip(_PAIRS, elements, strict=True):
        compliance[i, j] = compliance[j, i] = _SCALE[i] * _SCALE[j] * value
    return compliance
