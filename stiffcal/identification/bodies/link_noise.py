"""How well joints are known where their links' part was taken out of the tool's motion: the rods' noise goes into them.

What the rods give for it is a compliance with a covariance. An error of it is taken out of the tool's motion with it,
in all states alike, and the fit of what remains lays it at the joints' door: δθ = (Aᵀ W A)⁻¹ Aᵀ W δy. It does not show
in the fit's residuals, so that it is added to what the fit itself states.
"""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.identification.bodies.measured_links import MeasuredLink
from stiffcal.identification.fitting.fit import Fit
from stiffcal.identification.readings.observations import Observations
from stiffcal.links.compliance import LinkCompliance, carried_to_target


def spread_by_rods(fit: Fit, links: tuple[MeasuredLink, ...], observations: Observations) -> dict[str, float]:
    """Return full parameter name to the standard uncertainty that the rods' noise adds to the amplitude, SI.

    Parameters
    ----------
    fit : of the motion without the links' part.
    links : measured links whose motion was subtracted.
    observations : the observations before the subtraction.
    """
    model = fit.linearised()
    rows = model.white[:-1]
    size = np.linalg.norm(rows, axis=1)
    scaled = (rows / np.where(size > 0.0, size, 1.0)[:, None]).T
    variance = np.zeros(len(rows))
    for link in links:
        errors = np.stack(
            [_motion_of_link_error(error, link, fit, observations) for error in _directions(link.compliance)]
        )
        solution = np.linalg.lstsq(scaled, model.space.rows(errors).T, rcond=1e-12)[0]
        change = solution / np.where(size > 0.0, size, 1.0)[:, None]
        variance += np.sum(change**2, axis=1)
    return dict(zip(model.unknowns.names, np.sqrt(variance).tolist(), strict=True))


def _directions(compliance: LinkCompliance) -> Floats:
    """Return (p, 6, 6) independent errors of the matrix, one standard uncertainty each; none where it is not known."""
    value, vector = np.linalg.eigh(compliance.covariance)
    roots = vector * np.sqrt(np.maximum(value, 0.0))
    errors = (compliance.slopes @ roots).T.reshape(-1, 6, 6)
    return np.asarray(np.where(np.isfinite(compliance.matrix), errors, 0.0))


def _motion_of_link_error(error: Floats, link: MeasuredLink, fit: Fit, observations: Observations) -> Floats:
    """Return (m, n) what an error of a link's compliance adds to the rows of the fit."""
    data = fit.data
    states = observations.index[link.index]
    place = np.searchsorted(data.index, states)
    measured = (place < len(data.index)) & (data.index[np.minimum(place, len(data.index) - 1)] == states)
    angles = np.ascontiguousarray(observations.angles[:, link.index[measured]].T)
    displacement = link.wrench[measured] @ error.T
    displacements = np.zeros((len(data.setup.targets), 6, data.n_states))
    for body, target in enumerate(data.setup.targets):
        displacements[body][:, place[measured]] = carried_to_target(
            fit.robot.chain, angles, link.link, displacement, target
        ).T
    return data.layout.of_targets(displacements)
