"""Observability indices: how well a set of poses determines the parameters, in one number (five of them in use)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.identification.fitting.fit import Fit


@dataclass(frozen=True, slots=True, kw_only=True)
class ObservabilityIndices:
    """Indices of the observation matrix, noise 1 per row and each parameter in units of its typical size.

    With singular values σ1 ≥ … ≥ σp of that matrix and n poses (Sun and Hollerbach, Observability index selection for
    robot calibration, ICRA 2008, section II). Larger is better; 1/σp is the standard deviation of the combination that
    is known worst.
    """

    O1: float
    """(σ1 … σp)^(1/p) / √n (Borm and Menq): the volume of the confidence region, whatever the number of poses."""
    O2: float
    """σp / σ1 (Driels and Pathre): the inverse condition number."""
    O3: float
    """σp (Nahvi, Hollerbach and Hayward): the combination that is known worst."""
    O4: float
    """σp² / σ1 (Nahvi and Hollerbach): the noise amplification index."""
    O5: float
    """1 / (1/σ1 + … + 1/σp) (Sun and Hollerbach): the average standard deviation."""
    n_poses: int
    """n, rows that were fitted."""
    n_parameters: int
    """p, those that these poses determine."""


def observability_of(fit: Fit) -> ObservabilityIndices | None:
    """Return the indices of a fit's poses; None where it determines no parameter.

    Parameters
    ----------
    fit : parameters that its poses do not determine are left out.
    """
    names = list(fit.free_names)
    if not names:
        return None
    specs = {parameter.name: parameter.spec for parameter in fit.parameters}
    size = np.array([abs(specs[name].amplitude_of(specs[name].typical)) or 1.0 for name in names])
    return indices_of(fit.covariance / np.outer(size, size), fit.data.n_states)


def indices_of(covariance: Floats, n_poses: int) -> ObservabilityIndices:
    """Return the indices of a covariance.

    Parameters
    ----------
    covariance : (p, p), each parameter in units of its typical size.
    n_poses : how many poses it is of.
    """
    deviations = np.sqrt(np.linalg.eigvalsh(covariance))
    singular = 1.0 / np.maximum(deviations, np.finfo(np.float64).tiny)
    least, largest = float(singular.min()), float(singular.max())
    return ObservabilityIndices(
        O1=float(np.exp(np.mean(np.log(singular)))) / float(np.sqrt(n_poses)),
        O2=least / largest,
        O3=least,
        O4=least * least / largest,
        O5=1.0 / float(np.sum(1.0 / singular)),
        n_poses=n_poses,
        n_parameters=len(covariance),
    )
