"""The pose of a body from several points on it, some of them hidden at times."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.measurements.markers import Markers


def fitted_poses(markers: Markers, measured: Floats) -> tuple[Floats, Floats, Booleans]:
    """Fit rigid poses to measured points (n, k, 3), NaN where hidden (Arun 1987; Umeyama 1991).

    Returns
    -------
    Position (n, 3) and rotation (n, 3, 3) of the body in the instrument's frame, NaN where fewer than three points are
    measured or all on one line; and (n, k) which points were measured.

    Examples
    --------
    >>> import numpy as np
    >>> three = Markers(("a", "b", "c"), np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]))
    >>> position, rotation, _ = fitted_poses(three, three.places[None] + [5.0, 0, 0])
    >>> position.round(9).tolist(), bool(np.allclose(rotation[0], np.eye(3)))
    ([[5.0, 0.0, 0.0]], True)
    """
    n, places = len(measured), markers.places
    shows: Booleans = np.asarray(np.isfinite(measured).all(axis=2), dtype=np.bool_)
    weight: Floats = shows.astype(np.float64)
    enough = markers.enough(shows)
    filled = np.where(weight[:, :, None] > 0, measured, 0.0)
    total: Floats = np.asarray(np.maximum(np.sum(weight, axis=1), 1.0))
    centre_body = np.einsum("nm,mk->nk", weight, places) / total[:, None]
    centre_measured = filled.sum(axis=1) / total[:, None]
    away_body = (places[None] - centre_body[:, None]) * weight[:, :, None]
    away_measured = (filled - centre_measured[:, None]) * weight[:, :, None]
    left, _, right = np.linalg.svd(np.einsum("nmi,nmj->nij", away_measured, away_body))
    sign = np.ones((n, 3))
    sign[:, 2] = np.sign(np.linalg.det(left @ right))
    rotation: Floats = np.asarray((left * sign[:, None, :]) @ right)
    position: Floats = np.asarray(centre_measured - np.einsum("nij,nj->ni", rotation, centre_body))
    position[~enough], rotation[~enough] = np.nan, np.nan
    return position, rotation, shows
