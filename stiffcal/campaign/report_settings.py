"""What a customer asks of the report: the manifest's [report]."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import Field

from stiffcal.campaign.typed import Name, TomlTable, Vector3, at_most

MOST_SIGNATURES = 6
MOST_POSES = 12


class MapSettings(TomlTable):
    """[report.map]: a map of the workspace, as `stiffcal map` draws it.

    Attributes
    ----------
    load_N : force at the load point, base axes. plane : the plane that is mapped. at_m : where it cuts the third axis;
        through the middle of the reach where left out. stiffness : "x", "y" or "z", to map the stiffness along it too.
    """

    load_N: Vector3
    plane: Literal["xy", "xz", "yz"] = "xz"
    at_m: float | None = None
    stiffness: Literal["x", "y", "z"] | None = None

    look_alikes: ClassVar[dict[str, str]] = {"load": "load_N", "force_N": "load_N", "at": "at_m"}


class ReportSettings(TomlTable):
    """Optional sections of the report.

    Attributes
    ----------
    acceptance : a section with every limit of [thresholds], the value and whether it passed.
    sign_off : roles of those who sign, such as "measured by", "approved by"; each gets a line for name, date and
        signature. Without roles there is no such section.
    stiffness_at_deg : poses, each a list of joint angles as logged, at which the Cartesian stiffness of the target is
        given. map : a map of the workspace. logo : a PNG or SVG file inside the campaign folder, at most 1 MB, for the
        first page; an SVG without references to other files.
    """

    acceptance: bool = False
    sign_off: Annotated[tuple[Name, ...], Field(strict=False), at_most(MOST_SIGNATURES, "name fewer roles")] = ()
    stiffness_at_deg: Annotated[
        tuple[Annotated[tuple[float, ...], Field(strict=False)], ...],
        Field(strict=False),
        at_most(MOST_POSES, "name fewer poses"),
    ] = ()
    map: MapSettings | None = None
    logo: Name | None = None

    look_alikes: ClassVar[dict[str, str]] = {
        "signoff": "sign_off",
        "signatures": "sign_off",
        "limits": "acceptance",
        "stiffness_at": "stiffness_at_deg",
        "poses_deg": "stiffness_at_deg",
        "workspace": "map",
    }
