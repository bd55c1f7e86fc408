"""The code that a campaign brings along: exactly the files listed under `plugins`, read once and known by one hash.

Nothing here runs any of it.
"""

from __future__ import annotations

import ast
import hashlib
import io
import sys
import tokenize
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from importlib.machinery import PathFinder
from pathlib import Path, PurePosixPath

from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.campaign.toml.reach import escapes, leads_outside, link_fault
from stiffcal.errors import InputError
from stiffcal.escapes.shell import command_line
from stiffcal.fault_codes import FaultCode
from stiffcal.files import read_regular, refusal
from stiffcal.limits import PLUGIN, PLUGINS
from stiffcal.trust.record import open_record

HASH_FORM = b"stiffcal plugins 1\n"


@dataclass(frozen=True)
class PluginFile:
    """A file of plugin code."""

    name: str
    """As campaign.toml lists it, with `/` between folders."""
    path: Path
    """Where it is."""
    content: bytes
    """Its bytes, as they were read: these run, and no others."""

    @property
    def module(self) -> str:
        """The name by which the other files import it."""
        return PurePosixPath(self.name).stem

    @cached_property
    def text(self) -> str:
        """The code as text, in the one encoding in which it is shown and run."""
        return self.content.decode("utf-8-sig")

    def effect_names(self) -> list[str]:
        """Return the names of the effects that it defines, found without running it; its own name where none is found.

        Examples
        --------
        >>> PluginFile("own.py", Path("own.py"), b'class Own: name = "own-effect"').effect_names()
        ['own-effect']
        """
        try:
            body = ast.parse(self.text).body
        except (SyntaxError, ValueError, RecursionError, MemoryError):
            body = []
        names = [
            line.value.value
            for node in body
            if isinstance(node, ast.ClassDef)
            for line in node.body
            if isinstance(line, ast.Assign | ast.AnnAssign)
            and [target.id for target in _targets(line) if isinstance(target, ast.Name)] == ["name"]
            and isinstance(line.value, ast.Constant)
            and isinstance(line.value.value, str)
        ]
        return [name for name in names if name] or [self.name]


def _targets(line: ast.Assign | ast.AnnAssign) -> list[ast.expr]:
    return line.targets if isinstance(line, ast.Assign) else [line.target]


@dataclass(frozen=True)
class PluginCode:
    """All plugin code of a campaign."""

    folder: Path
    """The campaign folder."""
    files: tuple[PluginFile, ...]
    """In the order of campaign.toml."""

    @cached_property
    def digest(self) -> str:
        """The SHA-256 over names and bytes of all files; neither the order nor the folder counts."""
        digest = hashlib.sha256(HASH_FORM)
        for file in sorted(self.files, key=lambda file: file.name):
            name = file.name.encode("utf-8", "surrogateescape")
            for content in (name, file.content):
                digest.update(b"%d\n" % len(content) + content)
        return digest.hexdigest()

    def allowed(self) -> bool:
        """Return whether the user trusts this code: by its hash, or the folder while working on it."""
        record = open_record()
        return record.plugin_allowed(self.digest) or record.folder_allowed(self.folder)

    def check_allowed(self) -> None:
        """Raise an `InputError` where the user has not allowed this code."""
        if not self.allowed():
            reason = f"contains code and is not trusted (SHA-256 {self.digest})"
            raise InputError.at(
                FaultCode.PLUGIN_UNTRUSTED,
                MANIFEST_FILE,
                "plugins",
                reason,
                f"read it and allow it: {allow_line(self.folder)}",
            )


def allow_line(folder: Path) -> str:
    """Return the command that shows a campaign's code and allows it."""
    return command_line("trust", folder)


def read_plugins(folder: Path, names: Iterable[str]) -> PluginCode:
    """Read the plugin code of a campaign folder.

    Parameters
    ----------
    folder : the campaign folder.
    names : as campaign.toml lists them.

    Raises
    ------
    InputError : a file is missing, lies outside the folder, is no Python module, too large, or takes a name that is
        taken.
    """
    listed = list(dict.fromkeys(PurePosixPath(name).as_posix() for name in names))
    PLUGINS.check(len(listed), MANIFEST_FILE, "plugins")
    files: list[PluginFile] = []
    for name in listed:
        module = PurePosixPath(name).stem
        check_plugin_name(name, folder)
        if module in (file.module for file in files):
            reason = f"two files have the module name {module}: only one of them can be imported"
            raise InputError.at(FaultCode.PLUGIN_INVALID, MANIFEST_FILE, "plugins", reason, "rename one of them")
        files.append(PluginFile(name, folder / name, _read(folder, name)))
    return PluginCode(folder, tuple(files))


def check_plugin_name(name: str, folder: Path) -> None:
    """Raise an `InputError` where a file of this name cannot be a campaign's plugin.

    Parameters
    ----------
    name : as campaign.toml lists it.
    folder : the campaign folder.
    """
    module = PurePosixPath(name).stem
    if escapes(name):
        reason = f'"{name}" lies outside the campaign folder'
        raise InputError.at(
            FaultCode.FILE_OUTSIDE, MANIFEST_FILE, "plugins", reason, "copy the file into the campaign folder"
        )
    if not name.endswith(".py"):
        raise InputError.at(
            FaultCode.PLUGIN_INVALID,
            MANIFEST_FILE,
            "plugins",
            f"{name} is not a Python file",
            "use a file that ends in .py",
        )
    if not module.isidentifier() or module in ("__init__", "__main__"):
        reason = f"{name} cannot be imported: {module} is not a valid module name"
        raise InputError.at(
            FaultCode.PLUGIN_INVALID, MANIFEST_FILE, "plugins", reason, "use letters, digits and _ in its name"
        )
    reserved = {__name__.partition(".")[0], *sys.builtin_module_names, *sys.stdlib_module_names}
    if module in reserved or is_installed(module, folder):
        reason = f"{name} has the name of a module of Python or of an installed package"
        raise InputError.at(FaultCode.PLUGIN_INVALID, MANIFEST_FILE, "plugins", reason, "rename the file")


def is_installed(module: str, folder: Path) -> bool:
    """Return whether a module of this name is installed; what lies in the current or the campaign's folder is not."""
    try:
        return PathFinder.find_spec(module, path_without_local(folder)) is not None
    except (ImportError, ValueError):
        return True


def path_without_local(folder: Path) -> list[str]:
    """Return the folders of installed packages: `sys.path` without the current folder and without the campaign's."""
    local = {_real("."), _real(str(folder))}
    return [entry for entry in sys.path if entry and _real(entry) not in local]


def _real(entry: str) -> str:
    try:
        return str(Path(entry).resolve())
    except (OSError, RuntimeError):
        return entry


def _read(folder: Path, name: str) -> bytes:
    goal = leads_outside(folder, name)
    if goal is not None:
        raise InputError(link_fault(MANIFEST_FILE, "plugins", name, goal))
    try:
        content = read_regular(folder / name, name, limit=PLUGIN)
    except FileNotFoundError:
        mend = "correct the name in campaign.toml"
        raise InputError.at(FaultCode.FILE_MISSING, MANIFEST_FILE, "plugins", f"no such file: {name}", mend) from None
    except OSError as error:
        refused = refusal(error, name)
        reason = error.strerror or str(error)
        raise refused or InputError.at(
            FaultCode.FILE_UNREADABLE, name, "", f"cannot be read: {reason}", "check the file"
        ) from None
    try:
        encoding = tokenize.detect_encoding(io.BytesIO(content).readline)[0]
        content.decode("utf-8-sig")
    except (SyntaxError, UnicodeDecodeError):
        encoding = ""
    if encoding not in ("utf-8", "utf-8-sig"):
        raise InputError.at(
            FaultCode.ENCODING_WRONG,
            name,
            "",
            "its encoding is not UTF-8",
            "save it as UTF-8, without another coding line",
        )
    return content
