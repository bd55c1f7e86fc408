"""Plugin folders: code that is not trusted never runs, and code that is trusted and returns nonsense is one line.

Names, contents, links, bytes and syntax of the files are spoilt; what trusted code raises and returns too.
"""

from __future__ import annotations

import io
import os
import random
import re
import shutil
from contextlib import redirect_stderr, suppress
from pathlib import Path

from stiffcal.campaign.loading import load_campaign
from stiffcal.model.catalogue.campaign_effects import all_effects, placed_robot, plugin_code
from stiffcal.model.catalogue.plugin_loading import plugin_fault
from stiffcal.trust.record import open_record
from tests.fuzz.fence import FENCE
from tests.fuzz.mutations import NASTY_TEXTS, spoilt_bytes
from tests.fuzz.running import fresh_folder, fresh_state, run_fenced

MARK = "import pathlib\npathlib.Path(__file__).with_name('ran').touch()\n"
CODE = '''"""{doc}"""
import numpy as np
from stiffcal.effects_api import RZ, Law, ParameterSpec, Place, Term, joint_node

class CrossStiffness(Law):
    """{doc}"""
    name = "cross-stiffness"
    place_kind = "joints"
    summary = "the joint's compliance follows joint 1's angle"
    parameters = (ParameterSpec("c", "rad/(N·m)", "amplitude of the change", -1e-3, 1e-3, 1e-7, "our cell"),)
    fingerprint = "the residual is proportional to the joint's torque"
    how_to_check = "Repeat one load on the joint at several angles of joint 1."

    def terms(self, place, chain, loads, shape):
        node = joint_node(place.joints[0])
        values = np.sin(2.3 * loads.angles[0]) * loads.wrench[node, RZ]
        return (Term(node, RZ, "c", values),)
'''
VALUES = (
    "None", "0", "-1", "1.5", "float('nan')", "float('inf')", "''", "'x'", "'c'", "()", "[]", "{}", "object()",
    "(None,)",
    "(1, 2)", "[[1], [2, 3]]", "np.nan", "np.zeros(0)", "np.zeros((3, 3))", "np.full(10**3, np.nan)", "np.array(['a'])",
    "b'x'", "lambda *a: a", "type", "Law", "range(10**9)", "iter(())", "(x for x in [1])", "'\\x1b[31m'", "'a\\nb'",
    "'\\u202e'", "'x' * 5000", "True", "10**400", "np.array(None)", "complex(0, 1)", "Term",
    "NotImplemented",
)  # fmt: skip
TERMS = (
    "values", "values[:1]", "values[None]", "np.append(values, 0)", "values * np.nan", "values * np.inf",
    "values * 1e300",
    "values.astype(complex)", "values.astype(str)", "list(values)", "values.astype(object)", "0.0", "'x'", "None",
    "values.astype(int)", "np.zeros((6, 6))", "values * 0", "-values", "values.reshape(-1, 1)", "np.ma.array(values)",
)  # fmt: skip
NODES = ("node", "-1", "99", "10**30", "None", "'x'", "1.5", "node + 0.0", "(node,)", "np.int64(node)", "True")
WAYS = ("RZ", "-1", "6", "None", "'x'", "2.0", "(RZ, RZ)")
SYMBOLS = ("'c'", "'d'", "''", "None", "1", "('c',)", "'cross-stiffness.j2.c'")
ATTRIBUTES = (
    "name", "kind", "place_kind", "summary", "parameters", "fingerprint", "how_to_check", "looks_like", "__doc__",
    "sort",
)  # fmt: skip
METHODS = (
    "places", "lacking", "terms", "scalar_laws", "nonlinear_grid", "impossible", "covariate", "spec",
    "describe",
    "__init__", "__new__", "__eq__", "__hash__", "__getattribute__", "__class__", "__repr__", "__bool__",
)  # fmt: skip
ENDS = (
    "raise SystemExit(0)", "1 / 0", "raise MemoryError", "raise RecursionError('x' * 9999)",
    "raise OSError(2, 'No such file', 'x')", "raise BaseException", "import nowhere",
    "raise ValueError('a\\nb\\x1b[2J')",
    "raise StopIteration", "f = lambda: f(); f()", "raise EOFError", "raise UnicodeDecodeError('a', b'', 0, 0, 'x')",
    "raise Warning", "import warnings; warnings.warn('x')", "raise Exception from BaseException()",
    "class E(Exception):\n        def __str__(self): raise E\n    raise E", "raise SystemExit('text')",
    "assert False", "raise BrokenPipeError", "raise GeneratorExit", "raise ExceptionGroup('x', [ValueError()])",
)  # fmt: skip
PARAMETERS = (
    "symbol='c.d'", "symbol=''", "symbol=5", "unit=None", "unit=''", "unit='furlong'", "lower=1.0",
    "lower=float('nan')",
    "upper=-1.0", "upper=float('inf')", "typical=0.0", "typical=None", "typical=float('nan')", "typical=1e300",
    "source=None", "compliance='yes'", "meaning='\\x1b[2J'", "shape=True", "lower='a'", "symbol='x' * 5000",
)  # fmt: skip
NAMES = (
    "own.py", "json.py", "numpy.py", "stiffcal.py", "__init__.py", "__main__.py", "own.pyc", "own", "own effect.py",
    ".py",
    "sitecustomize.py", "a/own.py", "../outside/own.py", "/etc/own.py", "./own.py", "a/../own.py", "own.py/", "own.PY",
    "Own.py", "größe.py", "ｏｗｎ.py", "class.py", "a.b.py", "own\x00.py", "own\u202e.py", "x" * 260 + ".py", "", "..",
    "raw/states.csv", "campaign.toml", "store/own.py", "_own.py", "site.py", "re.py", "typing.py", "tests.py", "con.py",
)  # fmt: skip
COMMANDS = (
    "identify {c} --json", "identify {c}", "add {c} cross-stiffness --joints 3", "effects cross-stiffness --from {c}",
    "trust {c} --yes", "trust {c}", "trust {c} --hash", "trust {c} --json", "check {c}", "remove {c} cross-stiffness",
    "export {c} -o {f}/m.json", "plot {c} -o {f}/p.svg", "validate {c} --json", "simulate {f}/out --from {c}",
    "predict {c} --load-path 0,0,0;0,0,-100 --at 0,-70,20,0,30,0",
)  # fmt: skip


def base(place: Path) -> Path:
    """Return a campaign whose model needs its own code, made where it is not there yet; nothing of it is identified."""
    from stiffcal.commands.ingest import ingest_campaign
    from tests.laboratory.small_campaign import write_small_campaign

    folder = place / "base"
    if not folder.is_dir():
        with fresh_state(place / "owner"):
            write_small_campaign(folder, poses=2)
            ingest_campaign(folder)
    return folder


def feed_plugins(chance: random.Random, place: Path) -> None:
    """Spoil a campaign's code, and use it."""
    source, folder = base(place), fresh_folder(place)
    campaign = Path(shutil.copytree(source, folder / "c", symlinks=True))
    trusted = chance.random() < 0.75
    text = CODE.format(doc="The compliance follows joint 1's angle.")
    names = ["own.py"]
    if trusted:
        text = nonsense(chance, text)
    content = text.encode("utf-8", "surrogatepass")
    if chance.random() < 0.15:
        content = spoilt_bytes(chance, content)
    (campaign / "own.py").write_bytes(content if trusted else MARK.encode() + content)
    if chance.random() < (0.2 if trusted else 0.7):
        names = spoil_files(chance, campaign)
    listed = ", ".join('"' + "".join(f"\\u{ord(c):04x}" for c in name) + '"' for name in names)
    manifest = (campaign / "campaign.toml").read_text(encoding="utf-8")
    (campaign / "campaign.toml").write_text(f"plugins = [{listed}]\n{manifest}", encoding="utf-8")
    with (campaign / "model.toml").open("a", encoding="utf-8") as model:
        model.write('\n[[effects]]\ntype = "cross-stiffness"\njoints = [2]\n' if chance.random() < 0.85 else "")
    with fresh_state(folder / "state"), redirect_stderr(io.StringIO()):
        if trusted:
            open_record().allow_folder(campaign)
        try:
            use(chance, campaign, folder, place)
        finally:
            if not trusted and (campaign / "ran").exists():
                raise AssertionError("code that is not trusted has run")


def use(chance: random.Random, campaign: Path, folder: Path, place: Path) -> None:
    """Load the code, or run a command on the folder."""
    if chance.random() < 0.5:
        with FENCE.around((folder,), place / "outside"):
            loaded = load_campaign(campaign)
            plugin_code(loaded).allowed()
            effects = all_effects(loaded)[0]
            try:
                for effect in effects.values():
                    effect.describe()
                placed_robot(loaded)
            except BaseException as error:
                raise plugin_fault(error) or error from None
        return
    words = chance.choice(COMMANDS).format(c=campaign, f=folder).split()
    run_fenced(words, folder)


def nonsense(chance: random.Random, text: str) -> str:
    """Return code whose effect does what no effect does."""
    for _ in range(chance.choice((1, 1, 2))):
        match chance.randrange(8):
            case 0:
                text = re.sub(r"Term\(node, RZ, \"c\", values\)", _term(chance), text)
            case 1:
                text = text.replace('"c", values),)', f'"c", {chance.choice(TERMS)}),)')
            case 2:
                text += f"CrossStiffness.{chance.choice(ATTRIBUTES)} = {chance.choice(VALUES)}\n"
            case 3:
                returned = chance.choice(VALUES)
                text += f"CrossStiffness.{chance.choice(METHODS)} = lambda *a, **k: {returned}\n"
            case 4:
                text += f"    def {chance.choice(METHODS)}(self, *a, **k):\n        pass\n        {_end(chance)}\n"
            case 5:
                text += f"if True:\n    {_end(chance)}\n"
            case 6:
                text += (
                    "import dataclasses\nCrossStiffness.parameters = (dataclasses.replace("
                    f"CrossStiffness.parameters[0], {chance.choice(PARAMETERS)}),) * {chance.choice((1, 1, 1, 2, 0))}\n"
                )
            case _:
                odd = chance.choice((*NASTY_TEXTS, "\x1b[2J", "\u202e", "a\\nb")).replace("\\", "").replace('"', "")
                text = text.replace(
                    chance.choice(("cross-stiffness", "follows joint 1's", "our cell", "rad/(N·m)")), odd
                )
    return text


def _term(chance: random.Random) -> str:
    return f"Term({chance.choice(NODES)}, {chance.choice(WAYS)}, {chance.choice(SYMBOLS)}, {chance.choice(TERMS)})"


def _end(chance: random.Random) -> str:
    return chance.choice(ENDS)


def spoil_files(chance: random.Random, campaign: Path) -> list[str]:
    """Give the file other names, put links, pipes and folders in its place; return what the manifest lists."""
    own, outside = campaign / "own.py", campaign.parents[1] / "outside"
    names = [chance.choice(NAMES) for _ in range(chance.choice((1, 1, 2, 3)))]
    if chance.random() < 0.5:
        names.append("own.py")
    if chance.random() < 0.02:
        names += [f"own{number}.py" for number in range(3000)]
    for name in names:
        with suppress(OSError, ValueError, RuntimeError):  # RuntimeError: a circle of links
            path = campaign / name
            if not path.resolve().is_relative_to(campaign.resolve()) or path.exists():
                continue
            path.parent.mkdir(exist_ok=True)
            match chance.randrange(7):
                case 0:
                    path.symlink_to(outside / "secret.json")
                case 1:
                    path.symlink_to(path.name)
                case 2 if hasattr(os, "mkfifo"):
                    os.mkfifo(path)
                case 3:
                    path.mkdir()
                case 4:
                    path.symlink_to("/dev/zero")
                case _:
                    shutil.copy(own, path)
    return names
