"""Reference pages made from the code when the documentation is built: commands, TOML keys, effects, columns, faults.

Each function returns the Markdown of one page.
"""

from __future__ import annotations

import importlib
import inspect
import json
import re
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields
from functools import partial
from pathlib import Path
from typing import Any, cast

from docs.document_page import document_page
from docs.effect_page import effect_list, effect_page
from docs.effects_api_page import effects_api_page
from docs.markdown import cell, code, table
from docs.schema_words import read_schema, type_of
from stiffcal.campaign.found.file_formats import format_names, log_format
from stiffcal.cli import endings
from stiffcal.cli.command_tree import COMMANDS, command_named
from stiffcal.cli.common_options import CommonOptions
from stiffcal.fault_codes import FaultCode
from stiffcal.kinds.declared_tables import declared_tables
from stiffcal.model.catalogue.catalogue import built_in_effects
from stiffcal.readers import Reader
from stiffcal.store.declared_table import MEANING, UNIT

TOML_FILES = {
    "campaign": "campaign.toml",
    "robot": "robot.toml",
    "model": "model.toml",
    "simulate": "simulate.toml",
    "plan": "plan.toml",
    "thresholds": "thresholds.toml",
}


def write_pages(folder: Path) -> None:
    """Write all generated pages into `folder`; a page whose text has not changed keeps its date, one of before goes."""
    pages = {folder / f"{name}.md": make for name, make in PAGES.items()}
    for page in set(folder.rglob("*.md")) - set(pages):
        page.unlink()
    for page, make in pages.items():
        text = make().rstrip() + "\n"
        page.parent.mkdir(parents=True, exist_ok=True)
        if not page.exists() or page.read_text(encoding="utf-8") != text:
            page.write_text(text, encoding="utf-8")


# ---- commands


def command_page() -> str:
    """Every command with its arguments and options, as `--help` lists them."""
    first = [(f"[{code(name)}](#{name})", cell(summary)) for name, summary in COMMANDS.items()]
    common = [field.name for field in fields(CommonOptions)]
    parts = ["# Commands\n", "`DIR` is a campaign folder, `.` where left out.\n", table(("command", "purpose"), first)]
    parts += ["## Every command\n", EVERY_COMMAND, parameter_table("check", only=common)]
    for name in COMMANDS:
        function = getattr(importlib.import_module(f"stiffcal.cli.{name}"), name)
        parts += [f"## {name}\n", *command_description(function), parameter_table(name, without=common)]
    return "\n".join(parts)


EVERY_COMMAND = """\
These, `--json` and `--store` may stand before the command's name or after it. `--force` is the largest force of `plan`
and the load of `compensate` and `predict`: there `--overwrite` alone replaces files.

No command writes to a file that holds something it did not write: it ends with exit code 2, unless `--overwrite` is
given. stiffcal notes the SHA-256 of what it writes in the user's state folder (`outputs/`): a report, a table or a
picture that is as it wrote it is replaced without asking, one that was edited since is not. A log is appended to where
its first line is one of a log.

What a command writes where no name is given goes to `DIR`; a relative name after `-o` is one of the current folder.
"""


def command_description(function: Callable[..., int]) -> Iterator[str]:
    """Yield a command's paragraphs; its examples as code."""
    for paragraph in inspect.cleandoc(function.__doc__ or "").split("\n\n"):
        words = " ".join(paragraph.split())
        if words.startswith("Example"):
            yield "```sh\n" + words.partition(": ")[2] + "\n```\n"
        else:
            yield cell(words) + "\n"


def parameter_table(name: str, without: Sequence[str] = (), only: Sequence[str] | None = None) -> str:
    """Return the table of a command's arguments and options, or of some of them."""
    rows = []
    for parameter in command_named(name).params:
        if parameter.name in without or (only is not None and parameter.name not in only):
            continue
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


def column_page() -> str:
    """Columns of the Parquet tables in the store."""
    parts = [
        "# Columns of the store's tables\n",
        "The tables are Parquet files in `DIR/store/current/`. A missing number is NaN.\n",
        "In names, `<joint>` is a joint of the robot and `<target>` a measured target.\n",
        'Each file carries them too: `pyarrow.parquet.read_schema(FILE).field("Fx_N").metadata` has both.\n',
    ]
    for declared in sorted(declared_tables(), key=lambda declared: declared.name):
        parts += [f"## {declared.name}\n", cell(declared.meaning) + "\n"]
        rows = [
            (
                code(column.name),
                str(column.type),
                cell(column.metadata[UNIT].decode()),
                cell(column.metadata[MEANING].decode()),
                "yes" if column.nullable else "",
            )
            for column in declared.schema
        ]
        parts.append(table(("column", "Parquet type", "unit", "meaning", "may be missing"), rows))
    return "\n".join(parts)


# ---- log formats


def format_page() -> str:
    """Every log format: its files, options and what they mean."""
    parts = [
        "# Formats of logs\n",
        "The ending of a file determines its format; `format` of a source names it where it does not.\n",
        'Options stand in a table called like the format, `csv = { delimiter = ";" }`.\n',
        "[Log formats](../log-formats.md) has what to look at.\n",
    ]
    for name in format_names():
        reader = cast(Reader, log_format(name))
        packed = f", also as {', '.join(map(code, reader.packed_endings))}" if reader.packed_endings else ""
        files = ", ".join(map(code, reader.endings)) + packed if reader.in_files else "none: a database"
        words = inspect.cleandoc(sys.modules[type(reader).__module__].__doc__ or "").replace("``", "`")
        described, _ = options_in(words)
        _, meanings = options_in(
            inspect.cleandoc(sys.modules[reader.options.__module__].__doc__ or "").replace("``", "`")
        )
        schema = reader.options.model_json_schema()
        rows = [
            (code(option), type_of(without_nothing(entry)), cell(entry.get("description") or meanings.get(option, "")))
            for option, entry in schema.get("properties", {}).items()
        ]
        parts += [f"## {name}\n", *(cell(paragraph) + "\n" for paragraph in described)]
        parts.append(f"**Files:** {files or 'known by their content or by `format`'}\n")
        parts.append(table(("option", "type", "meaning"), rows) if rows else "**Options:** none.\n")
    return "\n".join(parts)


def options_in(words: str) -> tuple[list[str], dict[str, str]]:
    """Return a docstring's paragraphs without its list ``option : meaning``, and that list."""
    paragraphs: list[str] = []
    meanings: dict[str, str] = {}
    for paragraph in words.split("\n\n"):
        if re.match(r"[\w, ]+ : ", paragraph):
            for entry in re.split(r"\n(?=[\w, ]+ : )", paragraph):
                names, _, meaning = entry.partition(" : ")
                meanings |= dict.fromkeys(names.split(", "), " ".join(meaning.split()))
        elif not paragraph.startswith("Options of the manifest"):
            paragraphs.append(paragraph)
    return paragraphs, meanings


def without_nothing(entry: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return a schema without the choice of no value."""
    choices = [choice for choice in entry.get("anyOf", ()) if choice.get("type") != "null"]
    return {**entry, "anyOf": choices} if choices else entry


# ---- exit codes


def exit_code_page() -> str:
    """Exit codes, and the commands that end with 1."""
    judging = ", ".join(map(code, commands_that_judge()))
    line = "one line each with file, place, reason and remedy, and the [fault code](fault-codes.md)"
    document = '`{"error": {code, file, place, reason, mend}}`'
    meanings = (
        (endings.OK, "done"),
        (endings.NOT_HELD, f"done, and a threshold or check did not hold: {judging}"),
        (endings.WRONG_INPUT, f"the input is wrong: {line}; with `--json` {document}"),
        (endings.INTERNAL_FAULT, "an internal fault: one line that names a log file; `--debug` shows the traceback"),
        (endings.INTERRUPTED, "interrupted with Ctrl-C; what was stored before is whole"),
    )
    rows = [(code(number), meaning) for number, meaning in meanings]
    return "# Exit codes\n\n" + table(("exit code", "meaning"), rows) + "\n" + EXIT_CODE_NOTES


def commands_that_judge() -> list[str]:
    """Return the commands whose code ends with `NOT_HELD`."""
    modules = {name: importlib.import_module(f"stiffcal.cli.{name}") for name in COMMANDS}
    return [name for name, module in modules.items() if hasattr(module, "NOT_HELD")]


EXIT_CODE_NOTES = """
A closed pipe (`| head`) does not change the exit code; a write error on standard output (a full disk) gives 2; a stream
that is closed (`>&-`) counts as the null device.

Each command first runs the steps before it that are missing or out of date, and reports that in one line; `--no-update`
refuses instead. `--store` sets the folder of the store.

`--verbose` with any command writes each step with its time (UTC) to standard error, and `--log-file FILE` appends the
same lines to a file: the command line, steps that are run first, warnings, errors and the duration. Passwords in
addresses are masked. Colour is left out where the output is no terminal or `NO_COLOR` is set.
"""


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
    "effects": effect_list,
    **{f"effects/{name}": partial(effect_page, name) for name in built_in_effects()},
    "effects-api": effects_api_page,
    "formats": format_page,
    "exit-codes": exit_code_page,
    "columns": column_page,
    "documents": document_page,
    "fault-codes": fault_page,
}
"""Page to the function that writes it."""
