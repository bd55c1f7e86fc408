"""What is installed on this machine, what is missing, and how to get it."""

from __future__ import annotations

import platform
import re
from collections.abc import Sequence
from importlib import metadata
from pathlib import Path

from stiffcal import __version__
from stiffcal.campaign.found.file_formats import format_names
from stiffcal.escapes.shell import escaped
from stiffcal.results.doctor_result import DoctorResult, LibraryStatus
from stiffcal.trust.state import fault_of_place, state_folder

PURPOSES = {
    "dask": "batch on a Dask cluster (--scheduler)",
    "section": "stiffness of links from drawn sections",
    "tdms": "logs of LabVIEW (TDMS)",
    "ros": "logs of ROS 1, ROS 2 and MCAP",
    "c3d": "logs of motion capture (C3D)",
    "postgres": "logs in a PostgreSQL database",
}
"""What each extra of the package is for."""
ENTRY_POINTS = ("stiffcal.effects", "stiffcal.readers")
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*")
_EXTRA = re.compile(r"extra\s*==\s*['\"]([^'\"]+)['\"]")


def examine_installation() -> DoctorResult:
    """Return what is installed and what is missing; nothing is imported for it."""
    warnings = []
    try:
        requirements = metadata.requires("stiffcal") or []
    except metadata.PackageNotFoundError:
        requirements = []
        install = f"python -m pip install {escaped(str(Path(__file__).parents[2]))}"
        warnings.append(f"stiffcal is not installed but run from its source: what it requires is not known; {install}")
    libraries = library_statuses(requirements)
    folder = state_folder()
    points = (point for group in ENTRY_POINTS for point in metadata.entry_points(group=group))
    return DoctorResult(
        version=__version__,
        python=platform.python_version(),
        platform=f"{platform.system()} {platform.machine()}",
        complete=all(library.version is not None for library in libraries if not library.extra),
        libraries=libraries,
        formats=list(format_names()),
        plugins=sorted(f"{point.group.rpartition('.')[2]}: {point.name} ({point.value})" for point in points),
        state_folder=None if folder is None else str(folder),
        state_fault="" if folder is None or not folder.exists() else fault_of_place(folder),
        warnings=warnings,
    )


def library_statuses(requirements: Sequence[str]) -> list[LibraryStatus]:
    """Return the state of each requirement, those without an extra first.

    Parameters
    ----------
    requirements : as a package's metadata lists them, ``npTDMS>=1.9,<2 ; extra == "tdms"``.

    Examples
    --------
    >>> [library.install for library in library_statuses(['no-such-library>=2 ; extra == "tdms"'])]
    ['python -m pip install "no-such-library>=2"']
    """
    statuses = []
    for requirement in requirements:
        wanted, _, condition = requirement.partition(";")
        name = _NAME.match(wanted)
        if name is None:
            continue
        extra = _EXTRA.search(condition)
        of = "" if extra is None else extra.group(1)
        package = name.group() + wanted[name.end() :].strip()
        statuses.append(
            LibraryStatus(
                name=name.group(),
                required=wanted[name.end() :].strip(),
                version=_installed(name.group()),
                extra=of,
                purpose=PURPOSES.get(of, ""),
                install=f'python -m pip install "{package}"',
            )
        )
    return sorted(statuses, key=lambda status: (status.extra != "", status.extra, status.name.lower()))


def _installed(name: str) -> str | None:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None
