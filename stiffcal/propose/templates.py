"""The folders that `init` writes: commented manifests to fill in, and the bundled robots."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from pathlib import Path

from stiffcal.campaign.found.found_modules import package_folders
from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.campaign.toml.reach import check_inside
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.files import replacing, temporary_name, write_whole

KINDS, TEMPLATE = "stiffcal.kinds", "template"
"""The package of the kinds of experiment, and the folder in each that holds its template."""

_HERE = Path(__file__).parent
_RAW_NOTE = "Logs go here. stiffcal reads them and never changes them.\n"


def template_kinds() -> tuple[str, ...]:
    """Return the kinds of campaign that `write_template` can write, sorted; nothing is imported for them.

    Examples
    --------
    >>> {"load", "ids", "clamped"} <= set(template_kinds())
    True
    """
    return tuple(sorted(_templates()))


def _templates() -> dict[str, Path]:
    """Return the folder of each kind's template: those of load campaigns, and those that experiments bring."""
    folders = [*(_HERE / "template_files").iterdir()]
    folder_of = {folder.name: folder for folder in folders if folder.is_dir()}
    for package in package_folders(KINDS):
        folder_of |= {
            manifest.parent.parent.name: manifest.parent
            for manifest in Path(package).glob(f"*/{TEMPLATE}/{MANIFEST_FILE}")
        }
    return folder_of


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


def chosen_robot(name: str) -> str:
    """Return the robot.toml of a bundled robot, or of a robot file of one's own.

    Parameters
    ----------
    name : of a bundled robot, or the path of a robot file, ending in .toml.

    Raises
    ------
    InputError
        There is no such robot, or the file is no robot file that is complete by itself.
    """
    path = Path(name)
    if path.suffix.lower() != ".toml":
        return bundled_robot(name)
    if not path.is_file():
        raise InputError.at(FaultCode.FILE_MISSING, name, "", "no such file", "correct the path after --robot")
    from stiffcal.campaign.loading import load_robot

    robot = load_robot(path, name)
    if robot.urdf is not None:
        reason = f"its geometry is in {robot.urdf}"
        raise InputError.at(FaultCode.OPTION_CONFLICT, name, "urdf", reason, "give that file instead: --urdf FILE")
    return path.read_text(encoding="utf-8")


def bundled_robot(name: str) -> str:
    """Return the robot.toml of a bundled robot.

    Raises
    ------
    InputError
        There is no such robot.
    """
    if name not in bundled_robots():
        known_names = ", ".join(bundled_robots())
        mend = f"use one of {known_names}, a robot file that ends in .toml, a URDF or the folder of its package"
        raise InputError.at(FaultCode.OPTION_INVALID, "", "--robot", f'stiffcal has no robot "{name}"', mend)
    return (_HERE / "robots" / f"{name}.toml").read_text(encoding="utf-8")


def write_template(folder: Path, kind: str, *, overwrite: bool = False) -> list[Path]:
    """Write a commented campaign folder to fill in.

    Parameters
    ----------
    folder : made where it does not exist.
    kind : one of `template_kinds`.
    overwrite : also over files that are there.

    Returns
    -------
    list of Path
        The files that were written.

    Raises
    ------
    InputError
        The kind is unknown, or the folder holds a campaign already: nothing is overwritten.
    """
    template = _templates().get(kind)
    if template is None:
        reason = f'there is no kind "{kind}"'
        raise InputError.at(
            FaultCode.OPTION_INVALID, "command line", "--kind", reason, "use one of " + ", ".join(template_kinds())
        )
    texts = {MANIFEST_FILE: template_manifest(kind), "robot.toml": robot_template()}
    for name in ("robot.toml", "model.toml", "simulate.toml"):  # what this kind has of its own
        file = template / name
        texts |= {name: file.read_text(encoding="utf-8")} if file.exists() else {}
    return write_folder(folder, texts, overwrite=overwrite)


def template_manifest(kind: str) -> str:
    """Return the commented campaign.toml of a kind that there is."""
    return (_templates()[kind] / MANIFEST_FILE).read_text(encoding="utf-8")


def write_folder(
    folder: Path, texts: Mapping[str, str], copies: Mapping[str, Path] | None = None, *, overwrite: bool = False
) -> list[Path]:
    """Write the files of a new campaign folder and its `raw/`: all of them or, where that cannot be, none.

    Parameters
    ----------
    folder : the campaign folder.
    texts : file name to contents; campaign.toml gets, as comments, what page 1 of the report states.
    copies : file name to the file that is copied there.
    overwrite : also over files that are there.

    Raises
    ------
    InputError
        One of the files is there already with another content, or cannot be written; then nothing is written.
    """
    keys_of_report = (_HERE / "template_files" / "report.toml").read_text(encoding="utf-8")
    texts = {**texts, MANIFEST_FILE: f"{texts[MANIFEST_FILE].rstrip()}\n\n{keys_of_report}"}
    for name, text in texts.items():
        if (folder / name).exists() and not overwrite and not _holds(folder / name, text):
            mend = "choose another folder, move that file, or add --overwrite"
            raise InputError.at(FaultCode.FILE_EXISTS, str(folder / name), "", "the file already exists", mend)
    if folder.exists() and not folder.is_dir():
        raise InputError.at(
            FaultCode.FILE_KIND, str(folder), "", "this is a file, not a folder", "choose another folder"
        )
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


def _holds(file: Path, text: str) -> bool:
    """Return whether a file holds this text, as the robot file does that a draft was made from."""
    try:
        return file.is_file() and file.stat().st_size <= 4 * len(text) and file.read_bytes() == text.encode()
    except OSError:
        return False


def _fill(folder: Path, texts: Mapping[str, str], copies: Mapping[str, Path]) -> list[Path]:
    written: list[Path] = []
    for name in ("raw", *texts, *copies):
        check_inside(folder, name)
    try:
        (folder / "raw").mkdir(exist_ok=True)
        for name, source in copies.items():
            is_new = not (folder / name).exists()
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            with replacing(folder / name) as temporary:
                shutil.copyfile(source, temporary)
            written += [folder / name] * is_new
        if not any((folder / "raw").iterdir()):
            texts = {**texts, "raw/README.txt": _RAW_NOTE}
        # The manifest, which stands first, is written last: a folder that was left half-made is no campaign yet.
        for name, text in reversed(list(texts.items())):
            is_new = not (folder / name).exists()
            write_whole(folder / name, text)
            written += [folder / name] * is_new
    except BaseException:
        for path in written:
            path.unlink(missing_ok=True)
        raise
    return [folder / name for name in (*texts, *copies)]
