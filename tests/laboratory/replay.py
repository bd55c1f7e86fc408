"""Runs the C code of a compensation over samples, and `CompensationStep` over the same."""

from __future__ import annotations

import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stiffcal.arrays import Booleans, Floats
from stiffcal.compensation.exports.c_code import c_source
from stiffcal.compensation.exports.controller_model import ControllerModel
from stiffcal.compensation.exports.step import CompensationStep
from tests.laboratory.compilers import build

DRIVER = Path(__file__).with_name("replay.c")


@dataclass(frozen=True)
class Replayed:
    """What n calls returned."""

    solved: Booleans
    """(n,)."""
    offsets: Floats
    """(n, L) rad."""
    deflection: Floats
    """(n, 6) m, rad."""
    wrench: Floats
    """(n, 6) N, N·m."""
    words: str
    """Standard error: the model's hash, or times."""


def c_program(model: ControllerModel, folder: Path, *flags: str, compiler: str = "gcc") -> Path:
    """Write and compile the code of a model with the program that replays samples."""
    folder.mkdir(exist_ok=True)
    source, header = c_source(model, ("a test",), "compensation")
    (folder / "compensation.c").write_text(source)
    (folder / "compensation.h").write_text(header)
    return build(compiler, folder / "replay", [folder / "compensation.c", DRIVER], *flags, f"-I{folder}")


def by_program(program: Path, joints: Floats, reading: Floats, alone: bool) -> Replayed:
    """Run the program over samples (n, L), (n, 6); ``alone``: each call after a reset."""
    n_logged = joints.shape[1]
    samples = np.column_stack([np.full(len(joints), float(alone)), joints, reading])
    done = subprocess.run([program], input=samples.tobytes(), capture_output=True, check=False)
    assert done.returncode == 0, done.stderr.decode()
    answers = np.frombuffer(done.stdout).reshape(len(joints), -1)
    parts = np.split(answers, [1, 1 + n_logged, 7 + n_logged], axis=1)
    return Replayed(parts[0][:, 0] != 0.0, parts[1], parts[2], parts[3], done.stderr.decode())


def by_python(step: CompensationStep, joints: Floats, reading: Floats, alone: bool) -> Replayed:
    """Call the step function with the same samples."""
    solved, rows = [], []
    for q, w in zip(np.ascontiguousarray(joints), np.ascontiguousarray(reading), strict=True):
        if alone:
            step.reset()
        offsets = step(q, w).copy()
        solved.append(step.solved)
        rows.append((offsets, step.deflection.copy(), step.wrench.copy()))
    parts = [np.array(part) for part in zip(*rows, strict=True)]
    return Replayed(np.array(solved), parts[0], parts[1], parts[2], "")
