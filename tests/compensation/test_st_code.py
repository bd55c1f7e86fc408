"""The Structured Text of a compensation, compiled by MATIEC and run, by `CompensationStep`.

MATIEC is in no package registry: STIFFCAL_MATIEC names a folder with its ``iec2c`` and ``lib``; without it the code is
not run.
"""

from __future__ import annotations

import os
import re
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stiffcal.compensation.exports.controller_model import ControllerModel, controller_model
from stiffcal.compensation.exports.st_code import st_source
from stiffcal.compensation.exports.step import CompensationStep, StepSettings
from tests.compensation.test_c_code import ACCURACY, TOOL, path, setup_of
from tests.compensation.test_step import every_law, everything_linear, samples, springs_36
from tests.laboratory.compilers import compiler
from tests.laboratory.hostile_names import NAMES
from tests.laboratory.replay import by_program, by_python

DRIVER = Path(__file__).parents[1] / "laboratory" / "replay_st.c"
needs_matiec = pytest.mark.skipif("STIFFCAL_MATIEC" not in os.environ, reason="STIFFCAL_MATIEC names no folder")


def st_program(model: ControllerModel, folder: Path) -> Path:
    """Write the code of a model, and compile it with the program that replays samples."""
    matiec = Path(os.environ["STIFFCAL_MATIEC"])
    (folder / "compensation.st").write_text(st_source(model, ("a test",), "compensation"), encoding="ascii")
    words = [str(matiec / "iec2c"), "-I", str(matiec / "lib"), "-T", str(folder), str(folder / "compensation.st")]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    # what MATIEC writes warns of itself
    command = [compiler("gcc"), "-O1", "-w", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
    command += [f"-I{matiec / 'lib' / 'C'}", f"-I{folder}", str(DRIVER), "-o", str(folder / "replay"), "-lm"]
    subprocess.run(command, check=True)
    return folder / "replay"


@needs_matiec
@pytest.mark.parametrize("make", [springs_36, everything_linear, every_law])
@pytest.mark.parametrize("alone", [True, False])
def test_a_thousand_states(make: object, alone: bool, tmp_path: Path) -> None:
    robot = make()  # type: ignore[operator]
    setup = setup_of(robot)
    settings = StepSettings() if alone else TOOL
    program = st_program(controller_model(robot, setup, settings), tmp_path)
    joints, reading = samples(robot, setup, 1000) if alone else path(1000)
    ours = by_program(program, joints, reading, alone=alone)
    theirs = by_python(CompensationStep(robot, setup, settings), joints, reading, alone=alone)
    assert ours.solved.all()
    assert ours.words.strip() == controller_model(robot, setup, settings).hash
    assert np.abs(ours.offsets - theirs.offsets).max() < ACCURACY
    assert np.abs(ours.deflection - theirs.deflection).max() < ACCURACY
    assert np.abs(theirs.offsets).max() > 1e-3


@needs_matiec
def test_what_is_no_number_gives_no_offsets_and_leaves_nothing_behind(tmp_path: Path) -> None:
    robot = every_law()
    program = st_program(controller_model(robot, setup_of(robot), TOOL), tmp_path)
    joints, reading = path(40)
    joints[10, 2], reading[20, 4], reading[30, 0] = np.nan, np.inf, 1e200
    ours = by_program(program, joints, reading, alone=False)
    with np.errstate(all="ignore"):
        theirs = by_python(CompensationStep(robot, setup_of(robot), TOOL), joints, reading, alone=False)
    assert np.flatnonzero(~ours.solved).tolist() == [10, 20, 30]
    assert not ours.offsets[~ours.solved].any()
    assert np.abs(ours.offsets - theirs.offsets).max() < ACCURACY


def test_names_stay_in_their_comments() -> None:
    """Hostile names in the head and as joints leave the same instructions as plain ones; all is ASCII."""
    robot = springs_36()
    model = controller_model(robot, setup_of(robot))
    plain = re.sub(r"\(\*.*?\*\)", "", st_source(model, ("",), "compensation"), flags=re.DOTALL)
    hostile = [*NAMES.values(), "*) END_TYPE (*", "(*", "*)", "'"]
    named = replace(model, joint_names=tuple(hostile[-6:]))
    text = st_source(named, hostile, "compensation")
    for half in (slice(0, 32), slice(32, 64)):
        text = text.replace(named.hash[half], model.hash[half])
    assert text.isascii()
    assert re.sub(r"\(\*.*?\*\)", "", text, flags=re.DOTALL) == plain
    for word in ("IF", "FOR", "WHILE", "CASE", "TYPE", "FUNCTION"):
        begins = len(re.findall(rf"(?<!END_)(?<!ELS)\b{word}\b", plain))
        assert begins == len(re.findall(rf"\bEND_{word}\b", plain)), word
