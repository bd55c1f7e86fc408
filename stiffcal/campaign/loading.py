"""Loading a campaign folder: manifest, robot and model, with every fault at once."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from stiffcal.campaign.checks.together import (
    file_faults,
    manifest_faults,
    model_match_faults,
    robot_match_faults,
)
from stiffcal.campaign.manifest.file_patterns import FoundFiles
from stiffcal.campaign.manifest.found_runs import nothing_found, pattern_faults, with_found_runs
from stiffcal.campaign.manifest.manifest import Manifest
from stiffcal.campaign.manifest.manifest_type import manifest_type, validate_manifest
from stiffcal.campaign.model.model_file import MODEL_FILE, ModelFile, default_model, load_model
from stiffcal.campaign.robot.robot_checks import RobotOutline, outline_of, robot_faults
from stiffcal.campaign.robot.robot_file import RobotFile
from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.campaign.toml.pruning import unrelated_faults, validate_without_wrong_keys
from stiffcal.campaign.toml.reach import check_own, escapes, leads_outside, link_fault, links_outside
from stiffcal.campaign.toml.toml_reading import read_toml, validate
from stiffcal.errors import Fault, InputError, raise_faults
from stiffcal.escapes import escape_invisible
from stiffcal.escapes.shell import command_line
from stiffcal.fault_codes import FaultCode

if TYPE_CHECKING:
    from stiffcal.mechanics.chain import Chain


STORE = "store"

Loaded = TypeVar("Loaded")


@dataclass(frozen=True)
class Campaign:
    """A campaign folder, read and checked."""

    folder: Path
    """The campaign folder."""
    manifest: Manifest
    """campaign.toml, and the runs of the files that match its patterns."""
    robot: RobotFile
    """robot.toml."""
    model: ModelFile
    """model.toml."""
    model_written: bool = True
    """False where there is no model.toml and the default model stands in."""
    found: FoundFiles | None = None
    """The files that the patterns of the sources match; None where no source has a pattern."""

    @property
    def name(self) -> str:
        """Return the campaign's name: as written, or the folder's with what is no text in it written out."""
        return self.manifest.name or escape_invisible(self.folder.resolve().name)

    @property
    def robot_path(self) -> Path:
        """Return the robot file's path."""
        return self.folder / self.manifest.robot

    @property
    def model_path(self) -> Path:
        """Return the model file's path, whether or not it exists."""
        return self.folder / MODEL_FILE

    @cached_property
    def chain(self) -> Chain:
        """The robot as a chain of bodies, built on first use (imports numpy).

        A drawn section is solved where rods sit on its link: only they ask for its fibres and its warping.
        """
        from stiffcal.campaign.robot.geometry import chain_of  # numpy: not at the manifest's import

        chain = chain_of(self.robot, self.robot_path.parent)
        links = {rod.link for rod in self.manifest.ids.values()}
        if not links or all(link.section is None for link in self.robot.links.values()):
            return chain
        from stiffcal.campaign.robot.link_sections import with_sections

        return with_sections(chain, self.robot, links, self.manifest.robot)


def load_campaign(folder: Path, *, check_files: bool = True) -> Campaign:
    """Load a campaign folder.

    Parameters
    ----------
    folder : with campaign.toml, the robot file it names, and optionally model.toml.
    check_files : False where the logs are not needed (predict, add, …): they may then be missing.

    Raises
    ------
    InputError
        With every fault that can be detected: each with file and key path.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise InputError.at(
            FaultCode.FILE_MISSING,
            str(folder),
            "",
            "no such folder",
            "give a campaign folder, or create one: stiffcal init DIR",
        )
    faults: list[Fault] = []
    manifest, doubtful = _what_is_right(folder, faults)
    found: FoundFiles | None = None
    if manifest is not None:
        manifest, found = with_found_runs(manifest, folder)
    robot_file = manifest.robot if manifest is not None else "robot.toml"
    robot = None
    faults += _links(folder, STORE)
    if (
        not escapes(robot_file)
        and not _links(folder, robot_file)
        and (manifest is not None or (folder / robot_file).exists())
    ):
        if (folder / robot_file).exists():
            robot = _collect(faults, lambda: load_robot(folder / robot_file, robot_file))
        else:
            mend = "write it, or correct the key (stiffcal init DIR --from TABLE.csv --robot NAME writes one)"
            faults.append(Fault(FaultCode.FILE_MISSING, MANIFEST_FILE, "robot", f"no such file: {robot_file}", mend))
    if robot is not None and robot.urdf is not None:
        inside = os.path.relpath(folder / Path(robot_file).parent / robot.urdf, folder)
        leading = leads_outside(folder, inside)
        if leading is not None:
            faults.append(link_fault(robot_file, "urdf", robot.urdf, leading))
            robot = None
    outline = _collect(faults, lambda: outline_of(robot, folder / robot_file)) if robot is not None else None
    count = len(outline.joint_names) if outline is not None else 6
    experiments = {run.experiment for run in manifest.runs} if manifest is not None else set()
    model = _collect(faults, lambda: load_model(folder, count, experiments))
    if manifest is not None:
        certain = manifest_faults(manifest, outline.link_names if outline is not None else None)
        certain += file_faults(manifest, folder, must_exist=check_files)
        certain += pattern_faults(manifest, found)
        if check_files:
            certain += [
                Fault(FaultCode.FILE_MISSING, MANIFEST_FILE, *entry) for entry in nothing_found(manifest, found)
            ]
        if outline is not None:
            certain += robot_match_faults(manifest, outline, robot_file)
        faults += unrelated_faults(doubtful, certain)
    if model is not None and outline is not None:
        faults += model_match_faults(model, outline.joint_names, outline.link_names)
    raise_faults(faults)
    if manifest is None or robot is None or model is None:  # each of them would have left a fault
        raise InputError.at(
            FaultCode.FILE_UNREADABLE, str(folder), "", "the campaign could not be read", "correct its files"
        )
    return Campaign(folder, manifest, robot, model, (folder / MODEL_FILE).exists(), found)


def _links(folder: Path, *files: str) -> list[Fault]:
    """Return a fault for every file of the folder that leads out of it by a link, or holds one that does."""
    return [link_fault(name, "", name, goal) for file in files for name, goal in links_outside(folder, file)]


def _what_is_right(folder: Path, faults: list[Fault]) -> tuple[Manifest | None, tuple[str, ...]]:
    """Load the manifest; where keys are wrong, what is left without them, and the places around them."""
    manifest = _collect(faults, lambda: load_manifest(folder))
    if manifest is not None:
        return manifest, ()
    if leads_outside(folder, MANIFEST_FILE) is not None:
        return None, ()
    document = _collect([], lambda: read_toml(folder / MANIFEST_FILE, MANIFEST_FILE))
    return validate_without_wrong_keys(document, manifest_type()) if document is not None else (None, ())


def _collect(faults: list[Fault], load: Callable[[], Loaded]) -> Loaded | None:
    """Load one part; what is wrong with it joins the other faults."""
    try:
        return load()
    except InputError as error:
        faults.extend(error.faults)
        return None


def load_manifest(folder: Path) -> Manifest:
    """Read campaign.toml alone, without looking at robot, model or logs.

    Raises
    ------
    InputError
        With every fault of the file's own keys and values.
    """
    path = Path(folder) / MANIFEST_FILE
    if not path.exists():
        mend = f"create one: {command_line('init', Path(folder), '--kind', 'load')}"
        raise InputError.at(FaultCode.FILE_MISSING, MANIFEST_FILE, "", f"there is no {MANIFEST_FILE} in {folder}", mend)
    check_own(Path(folder), MANIFEST_FILE)
    return validate_manifest(read_toml(path, MANIFEST_FILE))


def load_robot(path: Path, file: str | None = None) -> RobotFile:
    """Read a robot file alone.

    Parameters
    ----------
    path : where it lies.
    file : how to call it in a fault; its name where left out.

    Raises
    ------
    InputError
        With every fault of the file.
    """
    file = file if file is not None else path.name
    robot = validate(read_toml(path, file), file, RobotFile)
    raise_faults(robot_faults(robot, file))
    return robot


__all__ = [
    "Campaign",
    "RobotOutline",
    "default_model",
    "load_campaign",
    "load_manifest",
    "load_model",
    "load_robot",
]
