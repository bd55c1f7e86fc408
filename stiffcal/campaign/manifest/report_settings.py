"""What a customer asks of the report: the manifest's [report]."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import Field

from stiffcal.campaign.toml.typed import Name, TomlTable, Vector3, at_most

MOST_SIGNATURES = 6
MOST_POSES = 12
MOST_INSTRUMENTS = 12


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


class CertifiedInstrument(TomlTable):
    """[[report.instruments]]: what was measured with, for the first page.

    Attributes
    ----------
    name : make and type, serial number. certificate : number of the calibration certificate. certified : its date.
    """

    name: Name
    certificate: Name | None = None
    certified: Name | None = None

    look_alikes: ClassVar[dict[str, str]] = {"date": "certified", "certificate_date": "certified", "type": "name"}


class ReportSettings(TomlTable):
    """What the first page states of robot and measurement, and optional sections of the report.

    Attributes
    ----------
    serial_number, site, operator, measured, temperature : of the robot, where, by whom, when and at what temperature it
        was measured, as they are to be printed. instruments : with their certificates.
    acceptance : a section with every limit of [thresholds], the value and whether it passed.
    sign_off : roles of those who sign, such as "measured by", "approved by"; each gets a line for name, date and
        signature. Without roles there is no such section.
    stiffness_at_deg : poses, each a list of joint angles as logged, at which the Cartesian stiffness of the target is
        given. map : a map of the workspace. logo : a PNG or SVG file inside the campaign folder, at most 1 MB, for the
        first page; an SVG without references to other files.
    """

    serial_number: Name | None = None
    site: Name | None = None
    operator: Name | None = None
    measured: Name | None = None
    temperature: Name | None = None
    instruments: Annotated[
        tuple[CertifiedInstrument, ...], Field(strict=False), at_most(MOST_INSTRUMENTS, "name fewer instruments")
    ] = ()
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
        "serial": "serial_number",
        "date": "measured",
        "signoff": "sign_off",
        "signatures": "sign_off",
        "limits": "acceptance",
        "stiffness_at": "stiffness_at_deg",
        "poses_deg": "stiffness_at_deg",
        "workspace": "map",
    }
