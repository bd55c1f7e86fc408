"""Drawings of the pages as SVG: frames, signs, the equation, folds, rooms of the code.

They stand within the page and take its colour, so that they suit light and dark. What can be computed is: the frames
are those of `campaigns/irb4400`, the rooms those of the import rules. `python -m docs.drawings NAME` prints one.
"""

from __future__ import annotations

import sys
import tomllib
from collections.abc import Callable
from html import escape
from itertools import pairwise
from pathlib import Path

import numpy as np

from stiffcal.arrays import Floats

ROOT = Path(__file__).parents[1]
Point = tuple[float, float]
SUSPECT = "#d55e00"
CALM = "#0072b2"


class Drawing:
    """Lines, arrows and words, collected."""

    def __init__(self, width: float, height: float, title: str) -> None:
        self._size = width, height
        self._title = title
        self._parts: list[str] = []

    def line(
        self, start: Point, end: Point, colour: str = "currentColor", width: float = 1.5, dashes: str = ""
    ) -> None:
        """Draw a straight line."""
        dashed = f' stroke-dasharray="{dashes}"' if dashes else ""
        ends = f'x1="{start[0]:.1f}" y1="{start[1]:.1f}" x2="{end[0]:.1f}" y2="{end[1]:.1f}"'
        self._parts.append(f'<line {ends} stroke="{colour}" stroke-width="{width}" stroke-linecap="round"{dashed}/>')

    def arrow(self, start: Point, end: Point, colour: str = "currentColor", width: float = 1.5) -> None:
        """Draw a line with a head at its end."""
        self.line(start, end, colour, width)
        along = np.subtract(end, start)
        along = along / max(float(np.hypot(*along)), 1e-9) * 8.0
        across = np.array([-along[1], along[0]]) * 0.4
        corners = (np.asarray(end), np.asarray(end) - along + across, np.asarray(end) - along - across)
        points = " ".join(f"{x:.1f},{y:.1f}" for x, y in corners)
        self._parts.append(f'<polygon points="{points}" fill="{colour}"/>')

    def text(self, place: Point, words: str, anchor: str = "start", size: float = 13) -> None:
        """Write words in the page's colour; `place` is on their baseline."""
        attributes = (
            f'x="{place[0]:.1f}" y="{place[1]:.1f}" font-size="{size}" fill="currentColor" text-anchor="{anchor}"'
        )
        self._parts.append(f"<text {attributes}>{escape(words)}</text>")

    def box(self, corner: Point, size: Point, colour: str = "currentColor", fill: str = "none") -> None:
        """Draw a rectangle."""
        place = f'x="{corner[0]:.1f}" y="{corner[1]:.1f}" width="{size[0]:.1f}" height="{size[1]:.1f}" rx="4"'
        self._parts.append(f'<rect {place} fill="{fill}" fill-opacity="0.25" stroke="{colour}" stroke-width="1.2"/>')

    def dot(self, place: Point, colour: str = "currentColor", radius: float = 4) -> None:
        """Draw a point."""
        self._parts.append(f'<circle cx="{place[0]:.1f}" cy="{place[1]:.1f}" r="{radius}" fill="{colour}"/>')

    def path(self, data: str, colour: str = "currentColor") -> None:
        """Draw a curve."""
        self._parts.append(f'<path d="{data}" fill="none" stroke="{colour}" stroke-width="1.5"/>')

    def svg(self) -> str:
        """Return the drawing; one line, as HTML within Markdown ends at an empty one."""
        width, height = self._size
        head = f'viewBox="0 0 {width:g} {height:g}" width="{width:g}" style="max-width:100%;height:auto"'
        name = escape(self._title, quote=True)
        body = "".join(self._parts)
        return f'<svg class="drawing" role="img" aria-label="{name}" {head} font-family="sans-serif">{body}</svg>'


# ---- what is drawn


def frames() -> str:
    """The frames of campaigns/irb4400 where they are, in one pose."""
    from stiffcal.campaign.loading import load_campaign
    from stiffcal.mechanics.kinematics import body_poses

    folder = ROOT / "campaigns" / "irb4400"
    chain = load_campaign(folder, check_files=False).chain
    logged = np.radians([[0.0, 5.0, 12.0, 0.0, 45.0, 0.0]])
    positions, rotations = (array[0] for array in body_poses(chain, chain.model_angles(logged)))
    drawing = Drawing(
        660, 500, "The frames of campaigns/irb4400: base, joints 1 to 6, flange, and the frames fixed to them"
    )
    chained = [_on_page(point) for point in positions]
    for start, end in pairwise(chained):
        drawing.line(start, end, width=5)
    for joint in range(1, chain.n_joints + 1):
        axis = positions[joint] + 0.22 * rotations[joint][:, 2]
        drawing.arrow(_on_page(positions[joint] - 0.1 * rotations[joint][:, 2]), _on_page(axis), CALM)
        place = _on_page(axis)
        drawing.text((place[0] + 5, place[1] - 4), f"z of J{joint}", size=12)
        drawing.dot(chained[joint], CALM)
    _axes(drawing, positions[0], rotations[0], 0.3, "base")
    manifest = tomllib.loads((folder / "campaign.toml").read_text(encoding="utf-8"))["frames"]
    where = {"base": (positions[0], rotations[0]), "flange": (positions[-1], rotations[-1])}
    drawing.text((chained[-1][0] - 30, chained[-1][1] + 14), "flange", anchor="end")
    for name, frame in manifest.items():
        origin, turn = where[frame["parent"]]
        place = origin + turn @ np.array(frame["xyz_m"])
        # next to the flange the frames lie within a hand's breadth: drawn three times as far apart as they are
        place = place if frame["parent"] == "base" else origin + 3.0 * (place - origin)
        drawing.line(_on_page(origin), _on_page(place), width=1, dashes="4 3")
        if frame["parent"] == "base":
            _axes(drawing, place, turn @ _turn(frame["rpy_deg"]), 0.22, name)
        else:
            drawing.dot(_on_page(place), SUSPECT)
            drawing.text((_on_page(place)[0] + 8, _on_page(place)[1] + 4), name)
    probe = manifest["probe_point"]["xyz_m"]
    target = positions[-1] + 3.0 * rotations[-1] @ np.array(probe)
    drawing.line(_on_page(np.array(manifest["digitizer"]["xyz_m"])), _on_page(target), SUSPECT, 1, "1 5")
    return drawing.svg()


def _on_page(point: Floats) -> Point:
    """Project a point in m: x to the right, z up, y away and up to the right."""
    x, y, z = (float(value) for value in point)
    return 150.0 + 205.0 * (x + 0.35 * y), 420.0 - 205.0 * (z + 0.22 * y)


def _axes(drawing: Drawing, origin: Floats, rotation: Floats, length: float, name: str) -> None:
    """Draw a frame's three axes and its name."""
    for axis, letter in enumerate("xyz"):
        end = _on_page(origin + length * rotation[:, axis])
        drawing.arrow(_on_page(origin), end)
        drawing.text((end[0] + 4, end[1] + 4), letter, size=12)
    drawing.text((_on_page(origin)[0] - 10, _on_page(origin)[1] + 26), name, anchor="middle")


def _turn(rpy_deg: list[float]) -> Floats:
    """Return the rotation of roll, pitch, yaw about fixed x, y, z."""
    turn = np.eye(3)
    for axis, angle in enumerate(np.radians(rpy_deg)):
        one, other = (axis + 1) % 3, (axis + 2) % 3
        step = np.eye(3)
        step[one, one] = step[other, other] = np.cos(angle)
        step[one, other], step[other, one] = -np.sin(angle), np.sin(angle)
        turn = step @ turn
    return turn


def signs() -> str:
    """What is positive: a lever, unloaded and loaded."""
    drawing = Drawing(700, 250, "A lever unloaded and loaded: force on the robot, joint torque, deflection, residual")
    joint, free, loaded, predicted = (90.0, 200.0), (400.0, 130.0), (388.0, 72.0), (391.0, 86.0)
    drawing.line(joint, free, width=4, dashes="8 6")
    drawing.line(joint, loaded, width=4)
    drawing.dot(joint, radius=8)
    drawing.text((70, 232), "joint: z towards you")
    drawing.arrow((loaded[0], loaded[1]), (loaded[0], loaded[1] - 52), SUSPECT, 2.5)
    drawing.text((loaded[0] + 10, loaded[1] - 36), "wrench w: what the cable does to the robot")
    drawing.arrow(free, loaded, CALM, 2)
    drawing.text((free[0] + 12, free[1] - 8), "deflection δ = loaded − unloaded")
    drawing.text((free[0] + 12, free[1] + 12), "residual = δ measured − δ predicted")
    drawing.dot(predicted, SUSPECT, 4)
    drawing.text((predicted[0] - 12, predicted[1] + 26), "predicted", anchor="end", size=12)
    drawing.path("M 150 200 A 60 60 0 0 0 137 163")
    drawing.arrow((140, 168), (134, 159))
    drawing.text((160, 196), "torque τ and angle grow in the same sense; τ = Jᵀ w > 0 here", size=13)
    drawing.text((300, 232), "work of the load: w · δ > 0, for every robot", size=13)
    return drawing.svg()


def equation() -> str:
    """The path of a load through the equation of joint springs."""
    drawing = Drawing(
        660, 130, "Wrench times transposed Jacobian is torque, times compliance is angle, times Jacobian is deflection"
    )
    boxes = (
        ("wrench w", "at the tool"),
        ("torque τ", "of each joint"),
        ("angle C τ", "of each spring"),
        ("deflection δ", "of the target"),
    )
    for number, (name, where) in enumerate(boxes):
        corner = (8.0 + 168 * number, 40.0)
        drawing.box(corner, (116, 56), fill=CALM)
        drawing.text((corner[0] + 58, 64), name, anchor="middle")
        drawing.text((corner[0] + 58, 84), where, anchor="middle", size=11)
        if number:
            drawing.arrow((corner[0] - 48, 68), (corner[0] - 6, 68))
            drawing.text((corner[0] - 27, 58), ("× Jᵀ", "× C", "× J")[number - 1], anchor="middle")
    drawing.text((8, 120), "J and Jᵀ follow from the robot file and the pose; C is what the fit finds", size=12)
    return drawing.svg()


def folds() -> str:
    """Which runs a fold leaves out, and that the whole search is repeated in each."""
    drawing = Drawing(
        660, 210, "Six runs, six folds: in each fold one run is left out, the whole search is repeated without it"
    )
    for fold in range(6):
        top = 34.0 + 24 * fold
        drawing.text((8, top + 15), f"fold {fold + 1}", size=12)
        for run in range(6):
            left_out = run == fold
            colour = SUSPECT if left_out else CALM
            drawing.box((70.0 + 44 * run, top), (38, 18), colour, colour)
            if left_out:
                drawing.text((89.0 + 44 * run, top + 13), "out", anchor="middle", size=11)
        drawing.arrow((340, top + 9), (364, top + 9))
        drawing.text((370, top + 13), "search all effects, choose one, predict the run left out", size=11)
    drawing.text((70, 24), "runs: one pose each", size=12)
    drawing.text((70, 200), "error in held-out poses: rms over all runs left out, the choice repeated", size=12)
    return drawing.svg()


def rooms() -> str:
    """The rooms of the code, from the import rules of pyproject.toml."""
    rules = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"]["contracts"]
    layers = [[name.strip() for name in layer.split("|")] for layer in rules[0]["layers"]]
    width, high = 640.0, 25.0
    drawing = Drawing(width, high * len(layers) + 30, "Rooms of the code: each may import those below it")
    for number, layer in enumerate(layers):
        each = (width - 60) / len(layer)
        for place, name in enumerate(layer):
            corner = (50 + place * each, number * high + 4)
            drawing.box(corner, (each - 6, high - 5), fill=CALM)
            drawing.text((corner[0] + each / 2 - 3, corner[1] + 15), name, anchor="middle", size=12)
    drawing.arrow((22, 8), (22, high * len(layers)))
    drawing.text(
        (4, high * len(layers) + 20), "imports go down only; rooms side by side do not import each other", size=12
    )
    return drawing.svg()


DRAWINGS: dict[str, Callable[[], str]] = {
    "frames": frames,
    "signs": signs,
    "equation": equation,
    "folds": folds,
    "rooms": rooms,
}
"""Name to the function that draws it."""


if __name__ == "__main__":
    sys.stdout.write(DRAWINGS[sys.argv[1]]() + "\n")
