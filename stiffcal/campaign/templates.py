"""The folders that `init` writes: commented manifests to fill in, and the bundled robots."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Literal, TypeAlias, get_args

from stiffcal.campaign.naming import MANIFEST_FILE
from stiffcal.campaign.reach import check_inside
from stiffcal.errors import InputError
from stiffcal.files import replacing, temporary_name, write_whole

Kind: TypeAlias = Literal["load", "clamped", "ids", "friction"]

_HERE = Path(__file__).parent
_RAW_NOTE = "Logs go here. stiffcal reads them and never changes them.\n"


def template_text(kind: Kind) -> str:
    """Return the commented campaign.toml of one kind of campaign.

    Examples
    --------
    >>> "A load campaign" in template_text("load")
    True
    """
    return (_HERE / "template_files" / f"{kind}.toml").read_text(encoding="utf-8")


def robot_template() -> str:
    """Return the commented robot.toml of a six-axis robot."""
    return (_HERE / "template_files" / "robot.toml").read_text(encoding="utf-8")


def bundled_robots() -> tuple[str, ...]:
    """Return the names of the robots that come with stiffcal.

    Examples
    --------
    >>> {"irb4400", "kr125"} <= set(bundled_robots())
    True
    """
    return tuple(sorted(path.stem for path in (_HERE / "robots").glob("*.toml")))


def bundled_robot(name: str) -> str:
    """Return the robot.toml of a bundled robot.

    Raises
    ------
    InputError
        There is no such robot.
    """
    if name not in bundled_robots():
        known = ", ".join(bundled_robots())
        mend = f"use one of {known}, or give a URDF: --urdf FILE"
        raise InputError.at("", "--robot", f'no robot "{name}" comes with stiffcal', mend)
    return (_HERE / "robots" / f"{name}.toml").read_text(encoding="utf-8")


def write_template(folder: Path, kind: str) -> list[Path]:
    """Write a commented campaign folder to fill in.

    Parameters
    ----------
    folder : made where it does not exist. kind : load, clamped, ids or friction.

    Returns
    -------
    list of Path
        The files that were written.

    Raises
    ------
    InputError
        The kind is unknown, or the folder holds a campaign already: nothing is overwritten.
    """
    for known in get_args(Kind):
        if kind == known:
            texts = {MANIFEST_FILE: template_text(known), "robot.toml": robot_template()}
            for name in ("model", "simulate"):  # what else this kind has
                file = _HERE / "template_files" / f"{kind}_{name}.toml"
                texts |= {f"{name}.toml": file.read_text(encoding="utf-8")} if file.exists() else {}
            return write_folder(folder, texts)
    raise InputError.at("", "--kind", f'there is no kind "{kind}"', "use one of " + ", ".join(get_args(Kind)))


def write_folder(folder: Path, texts: Mapping[str, str], copies: Mapping[str, Path] | None = None) -> list[Path]:
    """Write the files of a new campaign folder and its `raw/`: all of them or, where that cannot be, none.

    Parameters
    ----------
    folder : the campaign folder. texts : file name to contents. copies : file name to the file that is copied there.

    Raises
    ------
    InputError
        One of the files is there already, or cannot be written; then nothing is written.
    """
    for name in texts:
        if (folder / name).exists():
            mend = "name another folder, or move that file away"
            raise InputError.at(str(folder / name), "", "the file is there already", mend)
    if folder.exists() and not folder.is_dir():
        raise InputError.at(str(folder), "", "this is a file, not a folder", "name another folder")
    if folder.is_dir():
        return _fill(folder, texts, copies or {})
    temporary = folder.with_name(temporary_name())
    try:
        temporary.mkdir(parents=True)
        written = _fill(temporary, texts, copies or {})
        temporary.rename(folder)
    except BaseException:
        shutil.rmtree(temporary, ignore_errors=True)
        raise
    return [folder / path.relative_to(temporary) for path in written]


def _fill(folder: Path, texts: Mapping[str, str], copies: Mapping[str, Path]) -> list[Path]:
    written: list[Path] = []
    for name in ("raw", *texts, *copies):
        check_inside(folder, name)
    try:
        (folder / "raw").mkdir(exist_ok=True)
        for name, source in copies.items():
            with replacing(folder / name) as temporary:
                shutil.copyfile(source, temporary)
            written.append(folder / name)
        if not any((folder / "raw").iterdir()):
            texts = {**texts, "raw/README.txt": _RAW_NOTE}
        # The manifest, which stands first, is written last: a folder that was left half-made is no campaign yet.
        for name, text in reversed(list(texts.items())):
            write_whole(folder / name, text)
            written.append(folder / name)
    except BaseException:
        for path in written:
            path.unlink(missing_ok=True)
        raise
    return [folder / name for name in (*texts, *copies)]
