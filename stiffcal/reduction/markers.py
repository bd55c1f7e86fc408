"""The pose of a body from several points on it, some of them hidden at times."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from stiffcal.campaign.manifest import Manifest
from stiffcal.campaign.signals import Pose
from stiffcal.campaign.transforms import placement_matrix
from stiffcal.errors import InputError

Floats = NDArray[np.float64]


def poses_of_markers(body: str, pose: Pose, signals: Mapping[str, Floats], manifest: Manifest) -> tuple[Floats, Floats]:
    """Return position (n, 3) m and rotation (n, 3, 3) of a body in the instrument's frame.

    A state in which fewer than three markers are seen is NaN.

    Raises
    ------
    InputError
        A marker's place on the body is not written.
    """
    places, seen = [], []
    for name, marker in pose.markers.items():
        if marker.at_m is not None:
            places.append(np.array(marker.at_m))
        elif name in manifest.frames and manifest.frames[name].parent == body:
            places.append(placement_matrix(manifest.frames[name])[:3, 3])
        else:
            raise InputError.at(
                "campaign.toml", f"markers.{name}", f"its place on {body} is not written",
                'write at_m = [x, y, z] in metres, or a frame of that name with parent = "' + body + '"',
            )  # fmt: skip
        seen.append(signals[f"marker.{body}.{name}"])
    return fitted_poses(np.array(places), np.stack(seen, axis=1))


def fitted_poses(places: Floats, seen: Floats) -> tuple[Floats, Floats]:
    """Fit rigid poses: places (m, 3) on the body, seen (n, m, 3), NaN where hidden (Arun 1987; Umeyama 1991).

    Examples
    --------
    >>> import numpy as np
    >>> places = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    >>> position, rotation = fitted_poses(places, places[None] + [5.0, 0, 0])
    >>> position.round(9).tolist(), bool(np.allclose(rotation[0], np.eye(3)))
    ([[5.0, 0.0, 0.0]], True)
    """
    n = len(seen)
    weight: Floats = np.asarray(np.isfinite(seen).all(axis=2), dtype=np.float64)
    enough: NDArray[np.bool_] = np.asarray(np.sum(weight, axis=1) >= 3, dtype=np.bool_)
    shown = np.where(weight[:, :, None] > 0, seen, 0.0)
    total: Floats = np.asarray(np.maximum(np.sum(weight, axis=1), 1.0))
    centre_body = np.einsum("nm,mk->nk", weight, places) / total[:, None]
    centre_seen = shown.sum(axis=1) / total[:, None]
    away_body = (places[None] - centre_body[:, None]) * weight[:, :, None]
    away_seen = (shown - centre_seen[:, None]) * weight[:, :, None]
    left, _, right = np.linalg.svd(np.einsum("nmi,nmj->nij", away_seen, away_body))
    sign = np.ones((n, 3))
    sign[:, 2] = np.sign(np.linalg.det(left @ right))
    rotation: Floats = np.asarray((left * sign[:, None, :]) @ right)
    position: Floats = np.asarray(centre_seen - np.einsum("nij,nj->ni", rotation, centre_body))
    position[~enough], rotation[~enough] = np.nan, np.nan
    return position, rotation
