"""C compilers of this machine, for code that is written for controllers."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

import pytest

STRICT = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic")
SANITIZED = (*STRICT, "-g", "-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")


def compiler(name: str = "gcc") -> str:
    """Return a compiler's path; without it the test is skipped, but for gcc on a CI runner, which has it."""
    path = shutil.which(name)
    if path is None:
        if name == "gcc" and os.environ.get("CI") and os.name == "posix":
            pytest.fail("gcc is part of the CI image")
        pytest.skip(f"no {name} on this machine")
    return path


def build(name: str, output: Path, sources: Sequence[Path], *flags: str) -> Path:
    """Compile C files into a program or a library; a warning is a failure with the compiler's words."""
    linked = [] if "-c" in flags else ["-lm"]
    command = [compiler(name), *flags, *map(str, sources), "-o", str(output), *linked]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert not done.stderr
    return output
