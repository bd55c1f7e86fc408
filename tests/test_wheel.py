"""The wheel that `make dist` builds, without the repository: it holds all that commands need.

`tests/whole_campaigns/test_demo.py` looks at what its demo finds.
"""

from __future__ import annotations

from pathlib import Path

from stiffcal.propose.templates import template_kinds
from tests.laboratory.wheel import run, unpack_wheel


def test_the_wheel_holds_what_commands_need(tmp_path: Path) -> None:
    unpack_wheel(tmp_path)
    packages = tmp_path / "packages"
    for kind in template_kinds():
        run(packages, tmp_path, "init", kind, "--kind", kind)
    run(packages, tmp_path, "simulate", "twin", "--from", str(packages / "stiffcal" / "commands" / "example"))
    assert (tmp_path / "twin" / "truth.json").is_file()
