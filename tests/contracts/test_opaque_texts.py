"""Nothing hangs on a sentence: with the sentences of the code made opaque, commands answer the same but for words."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.laboratory.friction_campaigns import rehearsed
from tests.laboratory.hidden_campaigns import copied
from tests.laboratory.opaque_texts import COMMANDS, PREFIX
from tests.laboratory.small_campaign import write_small_campaign

ROOT = Path(__file__).parents[2]
# Digests of what a result was made from, the words of the states' table among it; and how fast it was made.
NOT_COMPARED = ("key", "pace")
PLAY = """
[[effects]]
type = "backlash"
joints = [4]
parameters = { "backlash.j4.width" = { value = 1.5e-3 }, "backlash.j4.band" = { value = 2.0 } }
"""

pytestmark = pytest.mark.long


def hidden_11(folder: Path) -> Path:
    """Load states of which some readings were bumped, and a missing effect."""
    return copied("11", folder)


def logs(folder: Path) -> Path:
    """Logs of several devices with clocks of their own."""
    return copied("13-raw", folder)


def small(folder: Path) -> Path:
    """Load states of four poses, of a robot with play that its model does not hold."""
    return write_small_campaign(folder, hidden=PLAY)


def friction(folder: Path) -> Path:
    """Joints at steady velocities and in free motion."""
    return rehearsed(folder)


def answers(folder: Path, *options: str) -> dict[str, Any]:
    call = [sys.executable, "-P", "-m", "tests.laboratory.opaque_texts", *options, str(folder)]
    done = subprocess.run(call, cwd=ROOT, capture_output=True, text=True, encoding="utf-8", check=False)
    assert done.returncode == 0, done.stderr
    return dict(json.loads(done.stdout))


def differences(plain: Any, opaque: Any, place: str = "") -> Iterator[str]:
    """Yield where two documents differ in more than the words of a sentence."""
    if isinstance(plain, dict) and isinstance(opaque, dict):
        if list(plain) != list(opaque):
            yield f"{place}: other keys {sorted(set(plain) ^ set(opaque))}"
        for key in plain.keys() & opaque.keys() - set(NOT_COMPARED):
            yield from differences(plain[key], opaque[key], f"{place}/{key}")
    elif isinstance(plain, list) and isinstance(opaque, list):
        if len(plain) != len(opaque):
            yield f"{place}: {len(plain)} entries and {len(opaque)}"
        for number, pair in enumerate(zip(plain, opaque, strict=False)):
            yield from differences(*pair, f"{place}/{number}")
    elif isinstance(plain, str) and isinstance(opaque, str) and PREFIX in opaque:
        if " " not in plain:
            yield f"{place}: the word {plain} became opaque"
    elif plain != opaque:
        yield f"{place}: {plain!r} and {opaque!r}"


@pytest.mark.parametrize("campaign", [small, hidden_11, logs, friction])
def test_all_json_but_the_words_is_equal(campaign: Callable[[Path], Path], tmp_path: Path) -> None:
    folder = campaign(tmp_path / "plain")
    shutil.copytree(folder, tmp_path / "opaque")
    plain, opaque = answers(folder), answers(tmp_path / "opaque", "--opaque")
    assert list(differences(plain, opaque)) == []
    assert {plain[f"{command} exit code"] for command in COMMANDS} == {0}
    assert json.dumps(opaque).count(PREFIX) > 5  # the sentences were opaque indeed
