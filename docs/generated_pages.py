"""Reference pages made from the code when the documentation is built: commands, TOML keys, effects, columns, faults.

Each function returns the Markdown of one page.
"""

from __future__ import annotations

import importlib
import inspect
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import typer

from stiffcal.cli.app import COMMANDS
from stiffcal.fault_codes import FaultCode
from stiffcal.workflow.command_results import EffectDescription
from stiffcal.workflow.effect_pictures import sketch_effect
from stiffcal.workflow.effects import describe_effects

SCHEMAS = Path(__file__).parents[1] / "schemas"
TOML_FILES = {
    "campaign": "campaign.toml",
    "robot": "robot.toml",
    "model": "model.toml",
    "simulate": "simulate.toml",
    "plan": "plan.toml",
    "thresholds": "thresholds.toml",
}


def write_pages(folder: Path) -> None:
    """Write all generated pages into `folder`; a page whose text has not changed keeps its date."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, make in PAGES.items():
        text = make().rstrip() + "\n"
        page = folder / f"{name}.md"
        if not page.exists() or page.read_text(encoding="utf-8") != text:
            page.write_text(text, encoding="utf-8")


def cell(text: object) -> str:
    """Return a text as it stands in a cell of a Markdown table."""
    return " ".join(str(text).split()).replace("|", "\\|").replace("<", "&lt;").replace("*", "\\*")


def code(text: object) -> str:
    """Return a text as code in a cell of a Markdown table."""
    return "`" + str(text).replace("|", "\\|") + "`"


def table(header: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> str:
    """Return a Markdown table."""
    lines = [header, ("---",) * len(header), *rows]
    return "\n".join("| " + " | ".join(row) + " |" for row in lines) + "\n"


# ---- commands


def command_page() -> str:
    """Every command with its arguments and options, as `--help` lists them."""
    first = [(f"[{code(name)}](#{name})", cell(summary)) for name, summary in COMMANDS.items()]
    parts = ["# Commands\n", "`DIR` is a campaign folder, `.` where left out.\n", table(("command", "purpose"), first)]
    for name in COMMANDS:
        function = getattr(importlib.import_module(f"stiffcal.cli.{name}"), name)
        parts += [f"## {name}\n", *command_description(function), parameter_table(function)]
    return "\n".join(parts)


def command_description(function: Callable[..., int]) -> Iterator[str]:
    """Yield a command's paragraphs; its examples as code."""
    for paragraph in inspect.cleandoc(function.__doc__ or "").split("\n\n"):
        words = " ".join(paragraph.split())
        if words.startswith("Example"):
            yield "```sh\n" + words.partition(": ")[2] + "\n```\n"
        else:
            yield cell(words) + "\n"


def parameter_table(function: Callable[..., int]) -> str:
    """Return the table of a command's arguments and options."""
    app = typer.Typer(add_completion=False, rich_markup_mode=None)
    app.command()(function)
    rows = []
    for parameter in typer.main.get_command(app).params:
        metavar = getattr(parameter, "metavar", None) or ""
        if parameter.param_type_name == "option":
            shown = f"{', '.join(parameter.opts)} {metavar}".strip()
        else:
            shown = metavar or str(parameter.name)
        rows.append((code(shown), cell(getattr(parameter, "help", None) or "")))
    return table(("argument or option", "meaning"), rows)


# ---- TOML files, answers, tables


def toml_page(name: str) -> str:
    """Every table and key of one TOML file."""
    schema = read_schema(name)
    parts = [f"# {TOML_FILES[name]}\n", cell(schema.get("description", "")) + "\n", "## Top level\n", key_table(schema)]
    return "\n".join([*parts, *definitions(schema)])


def read_schema(name: str) -> dict[str, Any]:
    """Read one file of schemas/."""
    document: dict[str, Any] = json.loads((SCHEMAS / f"{name}.schema.json").read_text(encoding="utf-8"))
    return document


def definitions(schema: Mapping[str, Any]) -> Iterator[str]:
    """Yield a section for every table that the top level refers to."""
    for name, definition in sorted(schema.get("$defs", {}).items()):
        yield f"## {name}\n"
        yield cell(definition.get("description", "")) + "\n"
        yield key_table(definition) if "properties" in definition else f"Type: {type_of(definition)}\n"


def key_table(schema: Mapping[str, Any]) -> str:
    """Return the table of a table's keys."""
    required = set(schema.get("required", ()))
    rows = [
        (
            code(name),
            type_of(entry),
            "required" if name in required else default_of(entry),
            cell(entry.get("description", "")),
        )
        for name, entry in schema.get("properties", {}).items()
    ]
    return table(("key", "type", "default", "meaning"), rows) if rows else ""


def default_of(entry: Mapping[str, Any]) -> str:
    """Return a key's default as code, nothing where it has none."""
    value = entry.get("default")
    return "" if value is None else code(json.dumps(value, ensure_ascii=False))


def type_of(entry: Mapping[str, Any]) -> str:
    """Return a schema's type in words."""
    if "$ref" in entry:
        name = entry["$ref"].rpartition("/")[2]
        return f"[{name}](#{name.lower()})"
    if "const" in entry:
        return code(json.dumps(entry["const"]))
    if "enum" in entry:
        return ", ".join(code(json.dumps(choice)) for choice in entry["enum"])
    if "anyOf" in entry or "oneOf" in entry:
        return " or ".join(type_of(choice) for choice in entry.get("anyOf", entry.get("oneOf")))
    if "allOf" in entry:
        return " and ".join(type_of(choice) for choice in entry["allOf"])
    return plain_type(entry)


def plain_type(entry: Mapping[str, Any]) -> str:
    """Return the type of a schema that refers to no other."""
    kind = entry.get("type", "any")
    if isinstance(kind, list):
        return " or ".join(kind)
    if kind == "array":
        low, high = entry.get("minItems"), entry.get("maxItems")
        count = f"{low} " if low is not None and low == high else ""
        return f"list of {count}{type_of(entry.get('items', {}))}"
    inner = entry.get("additionalProperties")
    return f"table of {type_of(inner)}" if kind == "object" and isinstance(inner, Mapping) else str(kind)


def column_page() -> str:
    """Columns of the Parquet tables in the store."""
    parts = [
        "# Columns of the store's tables\n",
        "The tables are Parquet files in `DIR/store/current/`. A missing number is NaN.\n",
        "In names, `<joint>` is a joint of the robot and `<target>` a measured target.\n",
    ]
    for file in sorted(SCHEMAS.glob("*.table.schema.json")):
        schema = json.loads(file.read_text(encoding="utf-8"))
        parts += [f"## {schema['title']}\n", cell(schema["description"]) + "\n"]
        columns = {**schema.get("properties", {}), **schema.get("patternProperties", {})}
        rows = [
            (code(name), cell(entry.get("parquet", "")), cell(entry.get("unit", "")), cell(entry["description"]))
            for name, entry in columns.items()
        ]
        parts.append(table(("column", "Parquet type", "unit", "meaning"), rows))
    return "\n".join(parts)


def document_page() -> str:
    """Keys of the JSON documents that the commands print with `--json`."""
    parts = [
        "# JSON documents\n",
        "What each command prints with `--json`. Numbers are in SI units.\n",
        "The JSON Schemas, `schemas/NAME.document.schema.json` of the source, list the nested types.\n",
    ]
    for file in sorted(SCHEMAS.glob("*.document.schema.json")):
        schema = json.loads(file.read_text(encoding="utf-8"))
        rows = [(code(key), without_links(entry), cell(entry.get("description", "")))
                for key, entry in schema.get("properties", {}).items()]  # fmt: skip
        parts += [f"## {file.name.partition('.')[0]}\n", cell(schema.get("description", "")) + "\n"]
        parts.append(table(("key", "type", "meaning"), rows))
    return "\n".join(parts)


def without_links(entry: Mapping[str, Any]) -> str:
    """Return a schema's type, names of nested types as code."""
    words = type_of(entry)
    names = {part.partition("]")[0] for part in words.split("[")[1:]}
    for name in names:
        words = words.replace(f"[{name}](#{name.lower()})", code(name))
    return words


# ---- effects


def effect_page() -> str:
    """The catalogue of effects: list, then law, parameters and limits of each."""
    effects = describe_effects().effects
    rows = [(f"[{code(effect.name)}](#{effect.name})", effect.place, cell(effect.summary)) for effect in effects]
    parts = [
        "# Effects\n",
        "What `model.toml` can hold. `stiffcal effects NAME` prints the same for one effect, `-o FILE.svg` draws it.\n",
        "That the load acts on the deformed robot is part of the model itself, not an effect.\n",
        table(("name", "place", "what it is"), rows),
    ]
    for effect in effects:
        parts += effect_section(effect)
    return "\n".join(parts)


def effect_section(effect: EffectDescription) -> Iterator[str]:
    """Yield the section on one effect."""
    yield f"## {effect.name}\n"
    yield f"```text\n{effect.physics.strip()}\n```\n"
    rows = [
        (code(one.symbol), cell(one.unit), cell(one.meaning), "–" if one.typical is None else f"{one.typical:g}",
         " … ".join("∞" if end is None else f"{end:g}" for end in one.bounds))
        for one in effect.parameters
    ]  # fmt: skip
    if rows:
        yield table(("parameter", "unit", "meaning", "typical", "bounds"), rows)
    for title, names in (
        ("Needs", effect.needs),
        ("Includes", effect.includes),
        ("Excludes", effect.excludes),
        ("Looks like", effect.looks_like),
    ):
        if names:
            yield f"**{title}:** {cell(', '.join(names))}\n"
    yield f"**Fingerprint:** {cell(effect.fingerprint)}\n"
    yield f"**How to check:** {cell(effect.check)}\n"
    yield "```text\n" + "\n".join(sketch_effect(effect.name)) + "\n```\n"


# ---- faults


def fault_page() -> str:
    """Every fault code and what its faults have in common."""
    rows = [(code(fault.value), cell(fault.covers)) for fault in FaultCode]
    return "\n".join(
        [
            "# Fault codes\n",
            "The code is in brackets at the end of a fault's line, and in `error.code` with `--json`.\n",
            "Programs go by the code: the words may change.\n",
            "[Troubleshooting](../../troubleshooting.md) has causes and cures.\n",
            table(("code", "covers"), rows),
        ]
    )


def toml_pages() -> Iterator[tuple[str, Callable[[], str]]]:
    """Yield the name and the function of every TOML file's page."""
    for name in TOML_FILES:
        yield f"{name}-toml", lambda name=name: toml_page(name)  # type: ignore[misc]


PAGES: dict[str, Callable[[], str]] = {
    "commands": command_page,
    **dict(toml_pages()),
    "effects": effect_page,
    "columns": column_page,
    "documents": document_page,
    "fault-codes": fault_page,
}
"""Page to the function that writes it."""
