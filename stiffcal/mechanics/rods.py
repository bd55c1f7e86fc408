"""What rods on a link read: ΔL = (u(E) − u(B))·e, paper 000, eq. 6 for a rod at any angle."""

from __future__ import annotations

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.measurements.rods import BeamProperties, Rods
from stiffcal.mechanics.beam import UNKNOWNS, amplitudes_from_end_displacement, fields_at_points


def rod_fields(rods: Rods, beam: BeamProperties) -> Floats:
    """Return (m, 8): what each rod reads of a unit of each field of `stiffcal.mechanics.beam`, m."""
    along = (rods.end - rods.start) / rods.length[:, None]
    at_end = fields_at_points(beam, rods.end, rods.warping[:, 1])
    at_start = fields_at_points(beam, rods.start, rods.warping[:, 0])
    return np.asarray(np.einsum("fmc,mc->mf", at_end - at_start, along))


def rod_matrix(rods: Rods, beam: BeamProperties) -> Floats:
    """Return (m, 6): what each rod reads per displacement of the link's outboard end, m per m and rad.

    Examples
    --------
    A rod of the link's whole length reads its whole stretch, and nothing of its bending when it lies on the axis:

    >>> from stiffcal.measurements.rods import rods_between
    >>> rods = rods_between("swing", np.zeros((1, 3)), np.array([[1.2, 0.0, 0.0]]))
    >>> rod_matrix(rods, BeamProperties(length=1.2)).round(12).tolist()
    [[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]]
    """
    return np.asarray(rod_fields(rods, beam)[:, : len(UNKNOWNS)] @ amplitudes_from_end_displacement(beam))
