"""`stiffcal demo`, of the wheel: what is hidden is found and added, the error is the noise; it ends with the view."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from stiffcal.commands import demo
from tests.laboratory.wheel import run, unpack_wheel

pytestmark = pytest.mark.long


class BegunError(Exception):
    """The search for what is missing has begun."""


def begin(*_: object, **__: object) -> None:
    raise BegunError


def test_the_demo_finds_what_is_hidden(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    unpack_wheel(tmp_path)
    lines = run(tmp_path / "packages", tmp_path, "demo").splitlines()
    assert lines[0].startswith("PASS  Nothing is missing")
    assert lines[-1] == "next: stiffcal view demo"
    ladder = [line for line in lines if line.startswith(("1  ", "2  "))]
    assert "joint-compliance (joints 1–6)" in ladder[0]
    assert "+ backlash (joint 1)" in ladder[1]
    assert max(map(len, ladder)) <= 80
    assert (tmp_path / "demo" / "report.pdf").read_bytes().startswith(b"%PDF")
    assert (tmp_path / "demo" / "view.html").is_file()
    main_document = json.loads((tmp_path / "demo" / "store" / "current" / "validate.json").read_text())
    error, noise = (main_document[key]["translation"] for key in ("rms", "noise"))
    assert error <= 1.05 * noise
    # a second demo takes the folder again, although `improve` has changed its model file
    changed = (tmp_path / "demo" / "model.toml").read_text("utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(demo, "improve_campaign", begin)
    with pytest.raises(BegunError):
        demo.run_demo(Path("demo"))
    assert "backlash" in changed
    assert "backlash" not in (tmp_path / "demo" / "model.toml").read_text("utf-8")
