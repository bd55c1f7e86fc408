"""Running plugin code that the user trusts: the bytes that were hashed, as modules that import each other only.

Each set of files is a package of its own in `sys.modules`, named by its hash, so that two campaigns with files of the
same name stay apart. Its modules import each other by their plain names; what is not among them comes from installed
packages, never from the current or the campaign's folder. Nothing compiled is read or written.

This is no sandbox: the code runs with the user's rights.
"""

from __future__ import annotations

import builtins
import hashlib
import importlib
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, redirect_stdout
from importlib.abc import InspectLoader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import CodeType, ModuleType
from typing import Any

from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.model.catalogue.plugin_code import PluginCode, PluginFile, path_without_local
from stiffcal.trust.running import about_to_run, is_interruption, place_in_plugin

PACKAGE = "stiffcal_plugins_"
_MOST_TEXT = 500
_loaded: dict[str, list[ModuleType]] = {}


def load_modules(code: PluginCode) -> list[ModuleType]:
    """Run plugin code, once in a process, and return its modules in the order of campaign.toml.

    Raises
    ------
    InputError : the user has not allowed this code, or it does not run.
    """
    code.check_allowed()
    place = hashlib.sha256(str(code.folder.resolve()).encode("utf-8", "surrogateescape")).hexdigest()
    package = f"{PACKAGE}{code.digest[:32]}_{place[:8]}"
    about_to_run([(_shown_in_traceback(file), file.name) for file in code.files])
    if package not in _loaded:
        finder = _Finder(package, code)
        sys.meta_path.insert(0, finder)
        try:
            _loaded[package] = [_run(finder, file) for file in code.files]
        except BaseException:
            for name in [name for name in sys.modules if name == package or name.startswith(f"{package}.")]:
                del sys.modules[name]
            sys.meta_path.remove(finder)
            raise
    return _loaded[package]


def _shown_in_traceback(file: PluginFile) -> str:
    return str(file.path.absolute())


def _run(finder: _Finder, file: PluginFile) -> ModuleType:
    with plugin_faults(file.name), redirect_stdout(sys.stderr):  # what it prints must not get into an answer
        return finder.module(file.module)


@contextmanager
def plugin_faults(name: str) -> Iterator[None]:
    """Turn whatever ends plugin code into one line about it: an exception, `sys.exit`, an interruption of its own.

    Raises
    ------
    InputError : the code has failed.
    """
    try:
        yield
    except KeyboardInterrupt as error:
        if is_interruption():
            raise
        raise fault_of(error, name) from error
    except InputError:
        raise
    except BaseException as error:
        raise fault_of(error, name) from error


def plugin_fault(error: BaseException) -> InputError | None:
    """Return the one line about an exception that came out of plugin code, None where it did not."""
    return fault_of(error, "") if place_in_plugin(error) is not None else None


def fault_of(error: BaseException, name: str) -> InputError:
    """Return the one line about plugin code that has failed.

    Parameters
    ----------
    error : what it raised.
    name : the file, where the exception does not name it.
    """
    file, line, error = place_in_plugin(error) or (name, 0, error)
    if isinstance(error, SyntaxError) and error.lineno:
        line = error.lineno
    verb = "does not run" if isinstance(error, Exception) else "ends the program"
    text = _text_of(error)
    reason = f"{verb}: {type(error).__name__}" + (f": {text}" if text else "")
    absent = isinstance(error, ModuleNotFoundError)
    mend = "add its file to plugins too, or install the package" if absent else "correct the file"
    return InputError.at(FaultCode.PLUGIN_FAILED, file, f"line {line}" if line else "plugins", reason, mend)


def _text_of(error: BaseException) -> str:
    """Return the message of an exception of plugin code, shortened; "" where that raises another one."""
    try:
        text = str(error.msg if isinstance(error, SyntaxError) else error)
    except BaseException:
        if is_interruption() and isinstance(sys.exc_info()[1], KeyboardInterrupt):
            raise
        return ""
    return text if len(text) <= _MOST_TEXT else f"{text[:_MOST_TEXT]}…"


class _Finder(MetaPathFinder, InspectLoader):
    """Finds and runs the modules of one set of plugin files, from the bytes that were read."""

    def __init__(self, package: str, code: PluginCode) -> None:
        self._package = package
        self._code = code
        self._files = {file.module: file for file in code.files}
        self._builtins = {**vars(builtins), "__import__": self._import}

    def module(self, name: str) -> ModuleType:
        """Return a module of the set; it is run where that has not been done yet."""
        return importlib.import_module(f"{self._package}.{name}")

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return the import spec of the package or one of its modules."""
        package, _, name = fullname.partition(".")
        if package != self._package or (name and name not in self._files):
            return None
        spec = ModuleSpec(fullname, self, is_package=not name)
        if name:
            spec.origin = _shown_in_traceback(self._files[name])
            spec.has_location = True
        return spec

    def get_source(self, fullname: str) -> str | None:
        """Return the text of a module, for tracebacks."""
        file = self._files.get(fullname.rpartition(".")[2])
        return file.text if file is not None else None

    def get_code(self, fullname: str) -> CodeType | None:
        """Return the compiled module; nothing compiled is kept on a disk."""
        file = self._files.get(fullname.partition(".")[2])
        return None if file is None else compile(file.text, _shown_in_traceback(file), "exec", dont_inherit=True)

    def exec_module(self, module: ModuleType) -> None:
        """Run a module."""
        code = self.get_code(module.__name__)
        if code is not None:
            vars(module)["__builtins__"] = self._builtins
            exec(code, vars(module))

    def _import(
        self,
        name: str,
        names: Mapping[str, Any] | None = None,
        local: Mapping[str, Any] | None = None,
        wanted: Sequence[str] = (),
        level: int = 0,
    ) -> ModuleType:
        """Import as Python does, with the set's modules first and no module of the current or the campaign's folder."""
        if level == 0 and name in self._files:
            return self.module(name)
        before, installed = list(sys.path), path_without_local(self._code.folder)
        sys.path[:] = installed
        try:
            return builtins.__import__(name, names, local, wanted, level)
        finally:
            sys.path[:] = [*before, *(entry for entry in sys.path if entry not in before)]
