"""What the code of every language for a controller holds: names, counts, numbers, and templates to put them into."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable, Sequence
from importlib import resources

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.compensation.exports.controller_model import ControllerModel
from stiffcal.compensation.exports.law_tables import LawTables
from stiffcal.compensation.exports.step import FIRST_SWEEPS
from stiffcal.escapes import code_comment

LINE = 110
"""Characters of a line, about."""


def shared_words(
    model: ControllerModel,
    tables: LawTables,
    n_springs: int,
    number: Callable[[float], str],
    array: Callable[[Floats], str],
    endless: float,
) -> dict[str, str]:
    """Return the words of the templates that differ between languages by how they write numbers alone.

    Parameters
    ----------
    model, tables : the numbers.
    n_springs : rows of the table of springs.
    number, array : how the language writes them.
    endless : stands for infinity, rad.
    """
    words = {
        "JOINT_NAMES": ", ".join(
            code_comment.escaped(name) + (" (m)" if k in model.prismatic else "")
            for k, name in enumerate(model.joint_names)
        ),
        "CYCLE": number(model.cycle_s),
        "N_SPRINGS": str(n_springs),
        "N_LAWS": str(len(tables.laws)),
        "N_BALANCERS": str(len(model.springs)),
        "SWEEPS": str(model.sweeps),
        "FIRST_SWEEPS": str(FIRST_SWEEPS),
        "LOAD_NODE": str(model.load_node),
        "TARGET_NODE": str(model.target_node),
        "LARGEST": number(model.largest),
        "DAMPING": number(model.damping),
    }
    arrays = {
        "FIXED": model.fixed[:, :3], "MASS": model.mass, "MASS_MOMENT": model.mass_moment, "GRAVITY": model.gravity,
        "COUPLING": model.coupling, "OFFSET": model.offset, "LIMITS": np.clip(model.limits, -endless, endless),
        "AXES": model.axes, "LOAD_POINT": model.load_point, "TARGET": model.target, "B": model.filter_b,
        "A": model.filter_a, "TOOL": model.tool, "ZEROED": model.zeroed,
    }  # fmt: skip
    return words | {name: array(values) for name, values in arrays.items()}


def identifier(stem: str) -> str:
    """Return a name of C and of Structured Text made of a file's name.

    Examples
    --------
    >>> identifier("cell 4/arm"), identifier("7-axes"), identifier("Müller__x_")
    ('cell_4_arm', 'r7_axes', 'M_ller_x')
    """
    name = re.sub(r"_+", "_", re.sub(r"[^A-Za-z0-9]", "_", stem)).strip("_") or "robot"
    return f"r{name}" if name[0].isdigit() else name


def wrapped(head: Sequence[str]) -> list[str]:
    """Return lines of a comment, escaped, none much longer than a page is wide."""
    lines: list[str] = []
    for line in head:
        lines += textwrap.wrap(code_comment.escaped(line), LINE, subsequent_indent="    ") or [""]
    return lines


def filled(template: str, words: dict[str, str]) -> str:
    """Return a template of `code_templates` with words for what stands between two @."""
    text = (
        resources.files("stiffcal.compensation.exports")
        .joinpath("code_templates", template)
        .read_text(encoding="utf-8")
    )
    # one pass: what a name holds is not looked at again
    return re.sub(r"@([A-Z_0-9]+)@", lambda match: words[match[1]], text)
