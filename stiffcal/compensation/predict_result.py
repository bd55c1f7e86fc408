"""What `predict` answers: deflection and stiffness state by state, and the path of loads that a report shows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from stiffcal.document_arrays import Matrix, Vector
from stiffcal.documents import NOT_IN_DOCUMENT, CommandResult, OrAbsent


@dataclass(frozen=True, slots=True)
class LoadPath:
    """Deflection predicted along a path of loads at one pose (002, Fig. 2)."""

    name: str
    """The campaign's name."""
    pose: str
    """The pose in words, e.g. "A1 … A6 = −45.8°, 4.6°, …", and how it was found."""
    force: Matrix
    """(m, 3) N, base axes, along the path."""
    deflection: Matrix
    """(m, 3) m, base axes."""
    corners: tuple[int, ...] = ()
    """Indices into the path of the loads that were named."""
    origin: OrAbsent[str] = None
    """From whom it comes, where it lies in the store and is not the user's own."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PredictedLink:
    """A link's part of a deflection, by the model and by the 6×6 that its rods gave; null where there is none."""

    link: str
    """The link's name."""
    carried: Vector
    """(6,) N, N·m, beam axes: what its outboard end carries of the load."""
    end: Vector | None
    """(6,) m, rad, beam axes: how far that moves its outboard end."""
    at_target: Vector | None
    """(6,) m, rad, base axes: how far that moves the target."""
    end_by_compliance: Vector | None
    """(6,) m, rad, beam axes: as ``end``, by the rods' compliance."""
    at_target_by_compliance: Vector | None
    """(6,) m, rad, base axes: as ``at_target``, by the rods' compliance."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PredictedState:
    """Deflection and stiffness at the target under one load, base axes."""

    joints: Vector
    """(L,) rad, logged angles."""
    wrench: Vector
    """(6,) N, N·m, at the load point."""
    deflection: Vector
    """(6,) m, rad."""
    covariance: Matrix
    """(6, 6) of the deflection, by the fit's uncertainty."""
    cartesian_compliance: Matrix
    """(6, 6) m/N, rad/(N·m)."""
    cartesian_stiffness: Matrix | None
    """(6, 6) its inverse; null where a direction gives nothing."""
    linear_compliance: Matrix
    """(6, 6) the compliance without complementary stiffness."""
    linear_stiffness: Matrix | None
    """(6, 6) its inverse; null where a direction gives nothing."""
    links: list[PredictedLink]
    """The part of each link that gives or carries rods."""


@dataclass(frozen=True, slots=True, kw_only=True)
class PredictResult(CommandResult):
    """Answer of ``predict``."""

    schema: Literal["stiffcal/predict/1"] = "stiffcal/predict/1"
    values_from: str
    """Where the model's values are from, in words."""
    target: str
    """The frame whose deflection is predicted."""
    states: list[PredictedState]
    """One for each load that was asked for."""
    load_path: OrAbsent[LoadPath] = None
    """The path, where one was asked for."""
    file: OrAbsent[str] = None
    """The table that was written."""
    joint_names: Annotated[tuple[str, ...], NOT_IN_DOCUMENT]
    """Of the logged joints, L of them."""
    joint_units: Annotated[tuple[str, ...], NOT_IN_DOCUMENT]
    """In which tables have their positions: "deg", of prismatic joints "mm"."""
