"""A robot's compensation as C99: `code_templates/step.c` and ``step.h`` with the robot's numbers in them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.compensation.exports.code_words import LINE, filled, identifier, shared_words, wrapped
from stiffcal.compensation.exports.controller_model import ControllerModel
from stiffcal.compensation.exports.law_tables import ENDLESS, LawTables, law_tables, spring_rows


def c_source(model: ControllerModel, head: Sequence[str], stem: str) -> tuple[str, str]:
    """Return the source file and the header.

    Parameters
    ----------
    model : the numbers.
    head : lines of the comment at the head of both files, not yet escaped.
    stem : name of both files without ending; functions begin with it.
    """
    tables = law_tables(model)
    prefix = identifier(stem)
    springs = spring_rows(model)
    words = shared_words(model, tables, len(springs), _number, _array, ENDLESS) | {
        "HEAD": "\n".join(f" * {line}".rstrip() for line in wrapped(head)),
        "PREFIX": prefix,
        "CAPS": prefix.upper(),
        "GUARD": f"{prefix.upper()}_H",
        "HEADER": header_name(stem),
        "HASH": model.hash,
        "N_JOINTS": str(len(model.coupling)),
        "N_LOGGED": str(model.coupling.shape[1]),
        "N_NODES": str(len(model.fixed)),
        "N_WEIGHTS": str(len(tables.weights)),
        "N_MEMORIES": str(max(tables.n_memories, 1)),
        "N_PLAYS": str(tables.n_memories),
        "DEFORMED": str(int(model.deformed)),
        "MOMENTS": str(int(model.moments)),
        "AXES_NODE": str(model.axes_node) if model.axes_node >= 0 else f"({model.axes_node})",
        "JOINT": _rows(str(int(joint)) for joint in model.joint),
        **_sliding_words(model),
        "SPRING": _rows([f"{{{to}, {source}, {_number(c)}}}" for to, source, c in springs] or ["{0, 0, 0.0}"]),
        "LAW": _rows(_laws(tables) or ["{0, 0, 0, 0, 0, {0.0}}"]),
        "WEIGHT": _rows([f"{{{index}, {_number(factor)}}}" for index, factor in tables.weights] or ["{0, 0.0}"]),
        "BALANCER": _rows(_balancers(model) or ["{0, 0, {0.0}, {0.0}, 0.0, 0.0}"]),
    }  # fmt: skip
    return filled("step.c", words), filled("step.h", words)


def _sliding_words(model: ControllerModel) -> dict[str, str]:
    """Return the lines for prismatic joints, which turn nothing and move along z; none where there are none."""
    at = {f"AT_{word}": f"fixed[{index}][3]" for word, index in (("I", "i"), ("0", "0"), ("1", "1"), ("2", "2"))}
    if not model.prismatic:
        return at | dict.fromkeys(("SLIDES", "SLIDES_ORIGIN", "SLIDES_COLUMN", "SLIDES_ANGLE"), "")
    flags = ", ".join(str(int(joint in model.prismatic)) for joint in range(len(model.coupling)))
    return {
        **{word: text.replace("fixed", "origin").replace("[3]", "") for word, text in at.items()},
        "SLIDES": "/* 1: the joint moves along its axis, and its angle, limits and offset are m. */\n"
        f"static const int SLIDES[JOINTS] = {{{flags}}};\n",
        "SLIDES_ORIGIN": """        double origin[3];
        for (i = 0; i < 3; ++i) {
            int slides = JOINT[k] >= 0 && SLIDES[JOINT[k]];
            origin[i] = fixed[i][3] + (slides ? w->angle[JOINT[k]] * fixed[i][2] : 0.0);
        }
""",
        "SLIDES_COLUMN": """            if (SLIDES[JOINT[k]]) {
                for (i = 0; i < 3; ++i) {
                    column[i] = r[i][2];
                    column[3 + i] = 0.0;
                }
            }
""",
        "SLIDES_ANGLE": """        if (SLIDES[k]) {
            w.cosine[k] = 1.0;
            w.sine[k] = 0.0;
        }
""",
    }


def header_name(stem: str) -> str:
    r"""Return the header's file name; a name that an include line cannot hold becomes another one.

    Examples
    --------
    >>> header_name("cell-4"), header_name('a"b\\')
    ('cell-4.h', 'a_b_.h')
    """
    return f"{re.sub(r'[^A-Za-z0-9_.-]', '_', stem)}.h"


def _laws(tables: LawTables) -> list[str]:
    rows = []
    for row in tables.laws:
        form = row.form.name
        numbers = ", ".join(_number(number) for number in row.numbers)
        rows.append(f"{{{form}, {row.joint}, {row.first}, {row.count}, {row.memory}, {{{numbers}}}}}")
    return rows


def _balancers(model: ControllerModel) -> list[str]:
    node_of = {int(joint): node for node, joint in enumerate(model.joint) if joint >= 0}
    return [
        f"{{{node_of[spring.joint - 1]}, {spring.joint - 1}, {_array(np.array(spring.anchor))}, "
        f"{_array(np.array(spring.arm))}, {_number(spring.rate)}, {_number(spring.free_length)}}}"
        for spring in model.springs
    ]


def _number(value: float) -> str:
    # the shortest text that reads back as the same double; adding zero turns −0 into 0
    text = repr(float(value) + 0.0)
    return text if any(mark in text for mark in ".e") else f"{text}.0"


def _array(values: Floats) -> str:
    if values.ndim == 1:
        return "{" + ", ".join(_number(value) for value in values) + "}"
    return _rows(_array(row) for row in values)


def _rows(rows: Iterable[str]) -> str:
    lines = ["{"]
    for row in rows:
        if len(lines[-1]) + len(row) > LINE or lines[-1] == "{" or "\n" in row:
            lines.append("    " + row.replace("\n", "\n    ") + ",")
        else:
            lines[-1] += f" {row},"
    return "\n".join([*lines, "}"])
