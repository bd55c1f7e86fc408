"""The URDF that a person gives: a file, or the folder of a robot's package, whose meshes are of no concern here."""

from __future__ import annotations

from itertools import islice
from pathlib import Path

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.propose.templates import bundled_robots

URDF, XACRO = ".urdf", ".xacro"
MOST_FILES = 20_000
"""Files of a folder that are looked at: a package has hundreds."""


def is_urdf_or_package(robot: str) -> bool:
    """Return whether what names a robot is a URDF, or the folder of a package, and no robot that is bundled."""
    path = Path(robot)
    return path.suffix.lower() in (URDF, XACRO) or (robot not in bundled_robots() and path.is_dir())


def chosen_urdf(given: Path, option: str = "--urdf") -> Path:
    """Return a URDF: the file itself, or the only one in a folder.

    Parameters
    ----------
    given : the file, or the folder of a package. option : of the command line, with which it was given.

    Raises
    ------
    InputError
        It is written in xacro, or the folder holds none, or several.
    """
    if given.suffix.lower() == XACRO:
        raise _to_expand(given, option)
    if not given.is_dir():
        return given
    files = [path for path in islice(given.rglob("*"), MOST_FILES) if path.suffix.lower() in (URDF, XACRO)]
    urdfs = sorted(path for path in files if path.suffix.lower() == URDF and path.is_file())
    if len(urdfs) == 1:
        return urdfs[0]
    if urdfs:
        listed = ", ".join(str(path) for path in urdfs[:12])
        reason = f"the folder holds {len(urdfs)} URDFs"
        raise InputError.at(FaultCode.OPTION_INVALID, str(given), option, reason, f"give one of them: {listed}")
    xacros = sorted(path for path in files if ".urdf" in path.name or "macro" not in path.stem)
    if xacros:
        raise _to_expand(xacros[0], option)
    raise InputError.at(FaultCode.FILE_MISSING, str(given), option, "the folder holds no URDF", "give the file *.urdf")


def _to_expand(path: Path, option: str) -> InputError:
    name = path.name.removesuffix(XACRO).removesuffix(URDF)
    mend = f"expand it where ROS is installed: xacro {path} > {name}.urdf, and give that file"
    return InputError.at(FaultCode.URDF_INVALID, str(path), option, "xacro is a program that writes a URDF", mend)
