"""What a controller's language consists of, and a program in it."""

from __future__ import annotations

import textwrap
from dataclasses import dataclass
from string import Template

import numpy as np

from stiffcal.arrays import Floats
from stiffcal.escapes.robot_program import escaped

# Of the largest joint speeds, per cent.
SPEED = 10
AXES = 6


@dataclass(frozen=True)
class Language:
    """The language of a controller; every template takes the names that its field states."""

    maker: str
    """Of the robots, and the language's name."""
    ending: str
    """Of the files."""
    longest_name: int
    """Characters of a program's name."""
    reserved: frozenset[str]
    """Names, in lower case, that start by themselves or belong to the controller."""
    program: Template
    """``program`` (name), ``comments``, ``body``, ``positions``."""
    comment: Template
    """``text``; one line."""
    comment_width: int
    """Characters of ``text``."""
    stop: Template
    """``text``, one line of at most 60 plain characters: the program waits until a person starts it again."""
    move: Template
    """``number`` of the move, ``j1`` to ``j6``: all joints move in proportion, and stop at the end."""
    position: Template | None
    """``number``, ``j1`` to ``j6``, where positions are listed apart from moves."""
    radians: bool
    """Angles are in radians, otherwise in degrees."""
    numbered: bool
    """Lines of ``body`` are numbered."""


@dataclass(frozen=True)
class Halt:
    """The program waits for a person."""

    text: str
    """What is to be done; plain characters."""


@dataclass(frozen=True)
class Move:
    """A joint move."""

    joints: Floats
    """(6,) logged angles, rad."""


@dataclass(frozen=True)
class Remark:
    """A comment."""

    text: str
    """Names in it need not be escaped."""


def program_text(language: Language, name: str, head: list[str], steps: list[Halt | Move | Remark]) -> str:
    """Return a program.

    Parameters
    ----------
    language : of the controller.
    name : of the program.
    head : lines of the comment at its head; names in them need not be escaped.
    steps : what it does, in order.
    """
    body: list[str] = []
    positions: list[str] = []
    for step in steps:
        if isinstance(step, Move):
            numbers = angles(language, step.joints)
            words = {f"j{k}": number for k, number in enumerate(numbers, start=1)}
            words["number"] = str(len(positions) + 1)
            body += language.move.substitute(words).splitlines()
            positions.append(language.position.substitute(words) if language.position is not None else "")
        elif isinstance(step, Halt):
            body += language.stop.substitute(text=step.text).splitlines()
        else:
            body += comment_lines(language, step.text)
    comments = [line for text in head for line in comment_lines(language, text)]
    if language.numbered:
        body = [f"{number:4d}:{line}" for number, line in enumerate([*comments, *body], start=1)]
    return language.program.substitute(
        program=name, comments="\n".join(comments), body="\n".join(body), positions="\n".join(positions)
    )


def angles(language: Language, joints: Floats) -> list[str]:
    """Return angles as the language has them: to a thousandth of a degree, or five digits of a radian."""
    if language.radians:
        return [f"{angle + 0.0:.5f}" for angle in joints]
    return [f"{angle + 0.0:.3f}" for angle in np.degrees(joints)]


def comment_lines(language: Language, text: str) -> list[str]:
    """Return a comment, wrapped."""
    wrapped = textwrap.wrap(escaped(text), language.comment_width, subsequent_indent="  ") or [""]
    return [language.comment.substitute(text=line) for line in wrapped]
