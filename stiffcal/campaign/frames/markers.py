"""Points on bodies, as the manifest places them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stiffcal.campaign.manifest.manifest import Manifest
from stiffcal.campaign.robot.transforms import placement_matrix
from stiffcal.campaign.signals.signals import Pose
from stiffcal.errors import InputError
from stiffcal.escapes import toml_text
from stiffcal.fault_codes import FaultCode
from stiffcal.measurements.markers import Markers


def markers_of(manifest: Manifest, targets: Sequence[str]) -> tuple[Markers | None, ...]:
    """Return the points of each target, None where its pose is read; empty where no pose comes from points.

    Raises
    ------
    InputError : a marker's place on its body is not written.
    """
    poses: dict[str, Pose] = {}
    for source in manifest.sources.values():
        poses |= source.body_poses()
    markers = tuple(
        _markers(target, poses[target], manifest) if target in poses and poses[target].markers else None
        for target in targets
    )
    return markers if any(markers) else ()


def _markers(body: str, pose: Pose, manifest: Manifest) -> Markers:
    places = []
    for name, marker in pose.markers.items():
        if marker.at_m is not None:
            places.append(np.array(marker.at_m))
        elif name in manifest.frames and manifest.frames[name].parent == body:
            places.append(placement_matrix(manifest.frames[name])[:3, 3])
        else:
            raise InputError.at(
                FaultCode.KEY_MISSING, "campaign.toml", f"markers.{name}", f"its position on {body} is not given",
                "write at_m = [0.0, 0.05, 0.1], say, in metres, or a frame of that name with "
                f"{toml_text.pair('parent', body)}",
            )  # fmt: skip
    return Markers(tuple(pose.markers), np.array(places))
