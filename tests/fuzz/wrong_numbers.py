"""Wrong numbers in every file and option that a user writes, and every command on them.

A number is replaced by zero, by its negative, by what a unit's slip makes of it, or by what no lab measures; then one
command runs on the folder, in this process. It ends with 0, 1 or 2, each fault is one line with a mend (with ``--json``
one document), and no library's warning reaches standard error.
"""

from __future__ import annotations

import contextlib
import io
import json
import math
import os
import random
import re
import shutil
import tomllib
from pathlib import Path
from typing import Any
from unittest import mock

from stiffcal.cli.app import main
from stiffcal.errors import Fault, InputError
from stiffcal.fault_codes import FaultCode
from tests.fuzz.mutations import places_of, toml_text

FACTORS = (1e-6, 1e-3, 1e-2, 1e2, 1e3, 1e6, 1e9, math.pi / 180.0, 180.0 / math.pi, 9.81)
ODD = (
    0, 0.0, -0.0, 1, -1, 2, 1e-300, 5e-324, -5e-324, 1e-12, 1e12, 1e29, 1e30, 1e31, 1e300, -1e300, 1.7e308,
    math.nan, math.inf, -math.inf, 10**6, -(10**6), 2**31, 2**63 - 1, 10**30,
)  # fmt: skip
ODD_WORDS = (
    "0", "-1", "nan", "inf", "-inf", "1e308", "-1e308", "1e-300", "5e-324", "1e400", "1e9", "", " ", "x", "1,", ",",
    "9" * 30, "-0", "1e3", "1e6", "NaN", "٣",
)  # fmt: skip

POSE, LOAD = "0,-70,20,0,30,0", "0,50,-100"
POSES = "A1,A2,A3,A4,A5,A6,Fx,Fy,Fz\n0,-70,20,0,30,0,10,20,-100\n5,-70,20,0,30,0,0,0,-100\n"
PATH = "A1,A2,A3,A4,A5,A6\n0,-70,20,0,30,0\n5,-70,20,0,30,0\n9,-70,20,0,30,0\n"
SPATIAL = "x,y,z,rx,ry,rz\n1200,0,1000,0,90,0\n1210,0,1000,0,90,0\n"

COMMANDS: tuple[tuple[int, str], ...] = (
    (6, "identify {c}"),
    (4, "check {c}"),
    (1, "check {c} --quick"),
    (3, "validate {c}"),
    (2, "diagnose {c}"),
    (1, "ingest {c}"),
    (2, "predict {c} --poses {f}/poses.csv"),
    (2, "predict {c} --load-path 0,0,0;LOAD --at POSE"),
    (2, "map {c} --load LOAD --points 5"),
    (1, "map {c} --load LOAD --points 4 --plane xz --at 0.4"),
    (1, "map {c} --mass 12.0 --points 3 --stiffness x --slices 2"),
    (2, "compensate {c} --path {f}/path.csv --force LOAD -o {f}/q.csv"),
    (1, "compensate {c} --path {f}/path.csv --force LOAD --normal radial --picture {f}/p.svg"),
    (1, "plot {c} -o {f}/p.svg"),
    (1, "plot {c} --against torque:2 -o {f}/p.svg"),
    (1, "export {c} -o {f}/s.csv"),
    (1, "export {c} -o {f}/m.urdf"),
    (1, "export {c} -o {f}/m.json"),
    (1, "history {c}"),
    (1, "compare {c} {c}"),
    (3, "simulate {f}/out --from {c} --seed 3"),
    (1, "add {c} bearing-tilt --joints 2"),
)

MORE_OF_THE_MANIFEST: dict[str, Any] = {
    "tool": {"mass_kg": 12.0, "com_m": [0.0, 0.0, 0.09]},
    "thresholds": {"max_rms_m": 0.001, "max_relative": 0.5},
}
SIGMA = {"wrench": {"force": 0.5}, "pose": {"position": 0.015, "rotation": 0.00003}}
MORE_OF_THE_ROBOT: dict[str, Any] = {
    "gravity_mps2": [0.0, 0.0, -9.81],
    "gravity_compensator": {
        "joint": 2, "anchor_m": [-0.2, 0.0, 0.1], "arm_m": [0.0, -0.2, 0.0], "rate_N_m": 20000.0, "preload_N": 500.0,
    },
    "links": {
        "swing": {
            "from_m": [0.0, 0.0, 0.0], "to_m": [0.89, 0.0, 0.0], "expansion_per_K": 1.2e-5,
            "section": {"EI": 7e6, "GJ": 5e6, "EA": 3e9},
        }
    },
}  # fmt: skip
MORE_EFFECTS: tuple[dict[str, Any], ...] = (
    {"type": "backlash", "joints": [4], "parameters": {"backlash.j4.width": {"value": 1e-3}}},
    {"type": "bearing-tilt", "joints": [2], "parameters": {"bearing-tilt.j2.x": {"value": 2e-6, "fixed": True}}},
    {"type": "cubic-stiffness", "joints": [3]},
    {"type": "link-beam", "links": ["swing"]},
    {"type": "gravity-compensator", "joints": [2]},
    {"type": "two-slope", "joints": [2]},
    {"type": "periodic-stiffness", "joints": [1]},
    {"type": "friction-hysteresis", "joints": [2]},
    {"type": "base-compliance"},
    {"type": "target-offset"},
    {"type": "wrench-bias"},
)


SHORTENED = {
    "clamped": (("rest_s = 1.5", "rest_s = 1.5\npoints = 60"),),
    "ids": (
        ("levels = [0.33, 0.67, 1.0]\ncycles = 2\nhold_s = 2.0", "levels = [0.5, 1.0]\ncycles = 1\nhold_s = 1.6"),
        ("rate_hz = 100.0", "rate_hz = 50.0"),
    ),
}
BASES = ("small",) * 4 + ("fuller",) * 3 + ("urdf", "clamped", "clamped template", "ids template")
"""Campaigns that numbers are changed in, some more often than others."""


def base(place: Path, name: str) -> Path:
    """Return one of `BASES` below a folder, made where it is not there yet."""
    from stiffcal.commands.simulate import simulate_campaign
    from stiffcal.commands.validate import validate_campaign
    from stiffcal.propose.templates import write_template
    from tests.laboratory.small_campaign import write_small_campaign

    folder = place / name
    if folder.is_dir():
        return folder
    if name == "small":
        validate_campaign(write_small_campaign(folder, poses=3))
    elif name == "fuller":
        _complete(write_small_campaign(folder, poses=3))
    elif name == "urdf":
        shutil.copytree(base(place, "small"), folder, symlinks=True)
        command_ends(["export", str(folder), "-o", str(folder / "robot.urdf")])
        (folder / "robot.toml").write_text('schema = "stiffcal/robot/1"\nurdf = "robot.urdf"\n', encoding="utf-8")
    elif name.endswith(" template"):
        kind = name.removesuffix(" template")
        write_template(folder, kind)
        file = folder / "simulate.toml"
        text = file.read_text(encoding="utf-8")
        for old, new in SHORTENED[kind]:
            text = text.replace(old, new)
        file.write_text(text, encoding="utf-8")
    else:
        simulate_campaign(base(place, f"{name} template"), folder)
    return folder


def _complete(folder: Path) -> None:
    """Write the optional numbers of all three files."""
    manifest, robot, model = (_document(folder / f"{name}.toml") for name in ("campaign", "robot", "model"))
    manifest |= MORE_OF_THE_MANIFEST
    for signal, sigma in SIGMA.items():
        manifest["sources"]["table"][signal]["sigma"] = sigma
    robot |= MORE_OF_THE_ROBOT
    for joint in robot["joints"]:
        joint |= {"limits_deg": [-170, 170], "gear_ratio": 80.0, "gear_orders": [80, 160], "bearing_m": 0.01}
    for name, document in (("campaign", manifest), ("robot", robot), ("model", model)):
        (folder / f"{name}.toml").write_text(toml_text(document), encoding="utf-8")


def _document(path: Path) -> dict[str, Any]:
    return tomllib.loads(path.read_text(encoding="utf-8"))


def odd_number(chance: random.Random, value: float) -> float:
    """Return what may stand there by mistake."""
    kind = chance.randrange(10)
    if kind < 4:
        return value * chance.choice(FACTORS) if value else chance.choice(FACTORS)
    if kind < 5:
        return -value
    return chance.choice(ODD)


def change_toml(chance: random.Random, path: Path) -> None:
    """Change one or more numbers of a TOML file."""
    document = _document(path)
    if path.name == "model.toml" and chance.random() < 0.7:
        document.setdefault("effects", []).append(json.loads(json.dumps(chance.choice(MORE_EFFECTS))))
    numbers = [way for way in places_of(document) if _is_number(_value_at(document, way))]
    for _ in range(chance.choice((1, 1, 1, 2, 3))):
        if not numbers:
            break
        way = chance.choice(numbers)
        holder = _value_at(document, way[:-1])
        alike = [other for other in numbers if other[-1] == way[-1] and len(other) == len(way)]
        if len(alike) > 1 and chance.random() < 0.25:  # the same slip in every joint, or axis
            factor = chance.choice(FACTORS)
            for other in alike:
                _value_at(document, other[:-1])[other[-1]] *= factor
        else:
            holder[way[-1]] = odd_number(chance, holder[way[-1]])
    path.write_text(toml_text(document), encoding="utf-8")


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _value_at(document: Any, way: tuple[Any, ...]) -> Any:
    for key in way:
        document = document[key]
    return document


_NUMBER = re.compile(r"(?<![\w.])-?\d+(\.\d+)?(e-?\d+)?(?![\w.])")


def change_text(chance: random.Random, path: Path) -> None:
    """Change numbers of a table or a URDF, or all of a column."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".csv" and chance.random() < 0.3:
        lines = text.splitlines()
        match chance.randrange(6):
            case 0:
                text = ""
            case 1:
                text = lines[0] + "\n"
            case 2:
                text = "\n".join(lines[:2]) + "\n"
            case _:
                column, factor = chance.randrange(len(lines[0].split(","))), chance.choice((*FACTORS, 0.0, -1.0))
                rows = [line.split(",") for line in lines]
                for row in rows[1:]:
                    with contextlib.suppress(ValueError, IndexError):
                        row[column] = repr(float(row[column]) * factor)
                text = "\n".join(",".join(row) for row in rows) + "\n"
        path.write_text(text, encoding="utf-8")
        return
    found = list(_NUMBER.finditer(text))
    for match in sorted(chance.sample(found, min(len(found), chance.choice((1, 1, 2, 5)))), key=lambda m: -m.start()):
        new = repr(odd_number(chance, float(match[0]))) if chance.random() < 0.7 else chance.choice(ODD_WORDS)
        text = text[: match.start()] + new + text[match.end() :]
    path.write_text(text, encoding="utf-8")


def change_words(chance: random.Random, words: list[str]) -> list[str]:
    """Change numbers among a command's words."""
    places = [k for k, word in enumerate(words) if k > 1 and re.fullmatch(r"[-\d.,;]+", word)]
    if not places:
        return words
    k = chance.choice(places)
    parts = re.split(r"([,;])", words[k])
    at = 2 * chance.randrange((len(parts) + 1) // 2)
    parts[at] = chance.choice(ODD_WORDS)
    return [*words[:k], "".join(parts), *words[k + 1 :]]


def feed_numbers(chance: random.Random, place: Path) -> None:
    """Change numbers, run a command, and look at how it ends."""
    folder = place / "try"
    shutil.rmtree(folder, ignore_errors=True)
    name = chance.choice(BASES)
    with mock.patch.dict(os.environ, {"STIFFCAL_STATE": str(place / "state")}):
        campaign = base(place / "bases", name)
    shutil.copytree(campaign, folder / "c", symlinks=True)
    for table, text in (("poses", POSES), ("path", chance.choice((PATH, PATH, SPATIAL)))):
        (folder / f"{table}.csv").write_text(text, encoding="utf-8")
    (pattern,) = chance.choices([words for _, words in COMMANDS], [weight for weight, _ in COMMANDS])
    if "template" in name:
        pattern = chance.choice(("simulate {f}/out --from {c} --seed 3", "check {c}"))
    words = [
        word.format(c=folder / "c", f=folder).replace("LOAD", LOAD).replace("POSE", POSE) for word in pattern.split()
    ]
    files = list((folder / "c").glob("*.toml"))
    files += [file for file in folder.glob("**/*.csv") if str(file) in words or file.parent.name == "raw"]
    files += list((folder / "c").glob("*.urdf")) * 3
    for _ in range(chance.choice((1, 1, 2))):
        if chance.random() < 0.2:
            words = change_words(chance, words)
            continue
        file = chance.choice(sorted(files))
        (change_toml if file.suffix == ".toml" else change_text)(chance, file)
    if chance.random() < 0.4:
        words.append("--json")
    with mock.patch.dict(os.environ, {"STIFFCAL_STATE": str(place / "state")}):  # never the user's own record
        code, out, err = command_ends(words)
    if code == 2:
        raise refusal_of(out, err, "--json" in words)
    if code not in (0, 1):
        raise AssertionError(f"exit code {code}: {err}")
    if "--json" in words:
        json.loads(out, parse_constant=_no_constant)
    if re.search(r"Warning: |Traceback", err):
        raise AssertionError(f"noise: {err}")


def _no_constant(name: str) -> None:
    raise AssertionError(f"{name} in a JSON document")


def command_ends(words: list[str]) -> tuple[int, str, str]:
    """Run a command; an internal fault is raised as it is, to be looked at."""
    out, err = io.StringIO(), io.StringIO()
    with (
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
        mock.patch("stiffcal.cli.app.report_traceback", side_effect=_raise),
    ):
        try:
            main([*words, "--debug"])
        except SystemExit as end:
            code = int(end.code or 0)
    return code, out.getvalue(), err.getvalue()


def _raise(error: Exception) -> None:
    raise error


def refusal_of(out: str, err: str, as_json: bool) -> InputError:
    """Return the refusal that a command printed."""
    if as_json:
        document = json.loads(out, parse_constant=_no_constant)
        faults = [document["error"], *document.get("others", [])]
        return InputError(*(Fault(**{**fault, "code": FaultCode(fault["code"])}) for fault in faults))
    lines = [line for line in err.splitlines() if line.strip()]
    faulty = [line for line in lines if "; " in line]
    if not faulty or "; " not in lines[-1]:
        raise AssertionError(f"a refusal without a mend: {err}")
    split = (line.rsplit("; ", 1) for line in faulty)
    return InputError(*(Fault(FaultCode.VALUE_INVALID, "", "", reason, mend) for reason, mend in split))
