"""Hostile rather than spoilt: definitions of messages, URDF files, special files; archives have a file of their own."""

from __future__ import annotations

import os
import random
import shutil
import sqlite3
from contextlib import closing, suppress
from pathlib import Path
from types import SimpleNamespace
from unittest import mock

from stiffcal.errors import InputError
from stiffcal.readers import WantedColumns, find_reader
from tests.fuzz.archives import feed_bomb
from tests.fuzz.inputs import bag_bytes
from tests.fuzz.mutations import NASTY_TEXTS, spoilt_bytes
from tests.laboratory.campaign_folders import DATA, write_campaign

NAMES = (
    "x", "X", "_x", "x_", "__x__", "__class__", "__init__", "self", "class", "None", "T", "dataclass", "FIELDDEFS",
    "np", "float64", "x;import os", "x\nimport os", 'x"', "x'", "x\\", "x}", "{x}", "é", "a" * 300, "", " ", "time",
    "header",
)  # fmt: skip
TYPES = (
    "float64", "string", "wstring", "string<=3", "uint8", "bool", "time", "duration", "Header", "wchar", "long double",
    "Other", "pkg/Other", "pkg/msg/Other", "other_pkg/msg/Missing", "pkg/msg/Message", "../pkg", "a//b", "object",
)  # fmt: skip
SIZES = (
    "",
    "",
    "[]",
    "[3]",
    "[<=3]",
    "[0]",
    "[-1]",
    "[1000000000]",
    "[99999999999999999999]",
    "[x]",
    "[3][3]",
    "[1e9]",
)
VALUES = (
    "1", "-1", "1e999", "nan", "'a'", '"a"', '"""', "'\\'", "__import__('os').system('false')", "true", "[1, 2]", "{x}",
    "9" * 300, "0x" + "f" * 50, "1 << 99999999999", "((((((((1))))))))", "(" * 40, "9*9*9",
)  # fmt: skip


class BrokenFenceError(AssertionError):
    """What had to be refused went through."""


def hostile_definition(chance: random.Random) -> tuple[str, str]:
    """Return (kind, text) of a definition with odd names, types, sizes and values."""
    idl = chance.random() < 0.4
    lines: list[str] = []
    for _ in range(chance.choice((1, 2, 3, 8))):
        odd = chance.random() < 0.4
        base = chance.choice(TYPES if odd else ("float64", "uint8", "string", "Other"))
        name = chance.choice(NAMES) if odd else f"f{len(lines)}"
        size = chance.choice(SIZES if odd else ("", "[]", "[3]"))
        value = chance.choice(VALUES)
        if idl:
            lines.append(chance.choice((f"{base} {name}{size};", f"sequence<{base}> {name};", f"double {name};")))
        else:
            lines.append(
                chance.choice(
                    (f"{base}{size} {name}", f"{base} {name.upper()}={value}", f"{base}{size} {name} {value}")
                )
            )
    if not idl:
        other = ["=" * 80, f"MSG: {chance.choice(('pkg/Other', 'pkg/msg/Other', chance.choice(NAMES)))}", "float64 y"]
        text = "\n".join([*lines, *(other if chance.random() < 0.7 else [])])
    else:
        constant = f"const long N = {chance.choice(VALUES)}; " if chance.random() < 0.4 else ""
        text = f"module pkg {{ module msg {{ {constant}struct Other {{ double y; }}; struct Message {{ "
        text += " ".join(lines) + " }; }; };"
    if chance.random() < 0.3:
        text = spoilt_bytes(chance, text.encode()).decode("utf-8", "replace")
    return "idl" if idl else "msg", text


def feed_definition(chance: random.Random, folder: Path) -> None:
    """Read a bag with a hostile definition, within a second; of what is registered every name is plain."""
    from rosbags.interfaces import MessageDefinition, MessageDefinitionFormat

    from stiffcal.parsers.rosbag2.definitions import checked_types, parsed_types
    from stiffcal.readers import damaged_file_errors

    kind, text = hostile_definition(chance)
    name = "pkg/msg/Message" if chance.random() < 0.9 else chance.choice((*NAMES, *TYPES))
    if kind == "msg":  # the other parser may take for ever, in the process of its own alone
        connection = SimpleNamespace(msgtype=name, msgdef=MessageDefinition(MessageDefinitionFormat.MSG, text))
        with suppress(InputError), damaged_file_errors("bag", "raw/log"):
            for type_name, (constants, fields) in checked_types(parsed_types([connection], ""), name, "").items():
                names = [*type_name.split("/"), *(field for field, _ in fields)]
                if constants or not all(word.isidentifier() and word.isascii() and word[:2] != "__" for word in names):
                    raise BrokenFenceError(f"registered: {names}")
    path = folder / "log.db3"
    path.write_bytes(bag_bytes(".db3"))
    with closing(sqlite3.connect(path)) as database:
        database.execute("UPDATE topics SET type = ?, type_description_hash = ''", (name,))
        database.execute(
            "UPDATE message_definitions SET topic_type = ?, encoding = ?, encoded_message_definition = ?,"
            " type_description_hash = ''",
            (name, f"ros2{kind}", text),
        )
        data = b"\0\1\0\0" + chance.randbytes(chance.choice((0, 8, 64, 4000)))
        database.execute("UPDATE messages SET data = ?", (data,))
        database.commit()
    with mock.patch.dict(os.environ, {"STIFFCAL_MAX_SECONDS": "1"}):
        list(find_reader(path).read_batches(path, {"topic": "/ft"}, WantedColumns(("f0",)), "raw/log"))


def feed_urdf(chance: random.Random, folder: Path) -> None:
    """Read a spoilt or hostile URDF."""
    from stiffcal.campaign.robot.urdf.chain import read_urdf

    text = (DATA / "six.urdf").read_text(encoding="utf-8")
    draw = chance.random()
    if draw < 0.2:
        inside = chance.choice(('<!ENTITY a "x">', '<!ENTITY a SYSTEM "file:///etc/passwd">', '<!ENTITY % a "x">%a;'))
        text = f"<!DOCTYPE robot [{inside}]>" + text
    elif draw < 0.4:
        at = chance.choice([place for place, letter in enumerate(text) if letter == ">"]) + 1
        text = text[:at] + chance.choice(("<a>", "<link/>", "<joint/>", "&a;", "]]>", "<![CDATA[")) * 300 + text[at:]
    elif draw < 0.7:
        words = [place for place in range(len(text)) if text.startswith('"', place)]
        at = chance.choice(words) + 1
        text = text[:at] + chance.choice((*NASTY_TEXTS, "nan", "inf", "1e-300", "1e308", "1 2", "9" * 5000)) + text[at:]
    data = text.encode("utf-8", "surrogatepass")
    (folder / "robot.urdf").write_bytes(spoilt_bytes(chance, data) if draw > 0.5 else data)
    read_urdf(folder / "robot.urdf", "robot.urdf", tip_link="tool0")


def feed_mesh(chance: random.Random, folder: Path) -> None:
    """Read and simplify a spoilt mesh, as the child process does."""
    from stiffcal.meshes.answering import FORMATS
    from stiffcal.meshes.simplifying import simplified
    from tests.laboratory.mesh_robot import binary_stl, dae_text, obj_text, text_stl, tube

    part = tube([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], (0.2, 0.1), 8)[:40]
    ending, write = chance.choice(((".stl", binary_stl), (".stl", text_stl), (".obj", obj_text), (".dae", dae_text)))
    data = spoilt_bytes(chance, write(part))
    if chance.random() < 0.3:
        at = chance.randrange(len(data) + 1)
        data = data[:at] + chance.choice((b"nan", b"1e308", b"inf", b"-0", b"f 1 2 ", b"9" * 5000)) + data[at:]
    (less,) = simplified([FORMATS[ending](data, f"part{ending}")], 30)
    assert len(less.triangles) <= 30


def feed_special(chance: random.Random, folder: Path) -> None:
    """Put a pipe, device, circle of links or folder where a file of a campaign, or a log of any format, is expected."""
    from stiffcal.campaign.loading import load_campaign

    shutil.rmtree(folder / "c", ignore_errors=True)
    campaign = write_campaign(folder / "c")
    files = sorted(path for path in campaign.rglob("*") if path.is_file())
    path = chance.choice([*files, *(campaign / "raw" / f"log.{e}" for e in LOG_ENDINGS)])
    path.parent.mkdir(exist_ok=True)
    with suppress(FileNotFoundError):
        path.unlink()
    make_special(chance, path)
    if path in files:
        load_campaign(campaign)
    if path not in files or path.suffix == ".csv":  # a log may be a folder: its reader says so
        reader = find_reader(path, chance.choice((None, LOG_ENDINGS[path.suffix[1:]])), "raw/log")
        list(reader.read_batches(path, {}, WantedColumns(("Fx",)), "raw/log"))
    raise BrokenFenceError(str(path))


LOG_ENDINGS = {
    "csv": "csv", "csv.gz": "csv", "h5": "hdf5", "mat": "mat", "parquet": "parquet", "tdms": "tdms", "mcap": "mcap",
    "db3": "rosbag2", "gz": "csv",
}  # fmt: skip


def make_special(chance: random.Random, path: Path) -> None:
    """Make something that is no regular file."""
    kinds = ["/dev/zero", "/dev/null", "/proc/self/environ", "/proc/kmsg", "circle", "nowhere", "folder"]
    kind = chance.choice([*kinds, "pipe", "pipe"] if hasattr(os, "mkfifo") else kinds[4:])
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "folder":
        path.mkdir()
    else:
        path.symlink_to({"circle": path.name, "nowhere": "no-such-file"}.get(kind, kind))


ATTACKS = {
    "definitions": feed_definition,
    "urdf": feed_urdf,
    "meshes": feed_mesh,
    "special files": feed_special,
    "bombs": feed_bomb,
}
"""Target to what feeds it."""
