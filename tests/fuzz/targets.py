"""What is fed with spoilt inputs: each target makes input number n and feeds it; a fault is raised as `InputError`."""

from __future__ import annotations

import random
import tomllib
from collections.abc import Callable
from pathlib import Path

import numpy as np

from stiffcal.campaign.found.file_formats import format_names, log_formats
from stiffcal.errors import InputError
from stiffcal.readers import FuzzInput, Reader, WantedColumns, find_reader
from tests.fuzz.addresses import feed_address
from tests.fuzz.attacks import ATTACKS
from tests.fuzz.databases import SPOILT, allowing, odd_query, spoiling_line, spoilt_options, wanted_of_database
from tests.fuzz.inputs import MAKERS, make_bag, make_csv, packed
from tests.fuzz.mutations import NASTY_TEXTS, spoilt_bytes, spoilt_lines, spoilt_toml
from tests.fuzz.plugin_folders import feed_plugins
from tests.fuzz.stores import feed_store
from tests.fuzz.wrong_numbers import feed_numbers
from tests.laboratory.campaign_folders import DATA, MANIFEST, ROBOT

Target = Callable[[random.Random, Path], None]
"""Makes one spoilt input in a folder from a stream of chance, and feeds it."""

SIMULATE = Path(__file__).parents[2] / "campaigns" / "irb4400" / "simulate.toml"
TEXT_OPTIONS: tuple[dict[str, object], ...] = (
    {}, {}, {}, {"delimiter": ","}, {"delimiter": "tab"}, {"decimal": ","}, {"encoding": "latin-1"}, {"skip_rows": 1},
    {"skip_rows": 10**18}, {"encoding": "no-such"}, {"unit_row": True}, {"delimiter": "ab"}, {"delimiter": "\n"},
    {"encoding": "utf-16"}, {"encoding": "idna"}, {"encoding": "base64"}, {"skip_rows": "x"}, {"skip_rows": -1},
)  # fmt: skip
WANTED = (
    WantedColumns(("t", "Fx", "Fy")),
    WantedColumns(("t", "Fx", "Fy"), ("run",)),
    WantedColumns(("Fx",), (), ("t",)),
    WantedColumns(("t", "Fx"), gaps=frozenset(("Fx",))),
    WantedColumns(("Fx", "nowhere")),
    WantedColumns((), ("run",), ("t",)),
)


WANTED_OF_BAG = (
    WantedColumns(("wrench.force.x", "wrench.torque.z")),
    WantedColumns(("wrench.force.x",), ("header.frame_id",)),
    WantedColumns(("wrench.force.x", "time")),
    WantedColumns(("header.stamp", "wrench.force.x")),
    WantedColumns(("nowhere",)),
)


class BrokenPromiseError(AssertionError):
    """A reader or a file was accepted, and what it gave is not what was promised."""


def read_log(path: Path, log_format: str | None, options: dict[str, object], wanted: WantedColumns) -> None:
    """Read a log from beginning to end, and hold the reader to what it promises of the numbers."""
    reader = find_reader(path, log_format, "raw/log")
    if not all(isinstance(table, dict) for table in reader.tables(path, "raw/log")):
        raise BrokenPromiseError("a table is not chosen by options")
    header = reader.read_header(path, options, "raw/log")
    if not all(isinstance(name, str) for name in header.columns):
        raise BrokenPromiseError("a column's name is no text")
    rows = 0
    for batch in reader.read_batches(path, options, wanted, "raw/log"):
        if batch.first_row != rows + 1:
            raise BrokenPromiseError(f"row {batch.first_row} after row {rows}")
        rows += len(batch)
        for name, values in batch.numbers.items():
            gaps = name in wanted.gaps
            if values.dtype != np.float64 or np.isinf(values).any() or (not gaps and np.isnan(values).any()):
                raise BrokenPromiseError(f"column {name} is not finite")
    if rows == 0:
        raise BrokenPromiseError("accepted without a row")


def reader_target(name: str) -> Target:
    """Return the target that spoils logs of one kind, and sometimes what the manifest says of them."""
    log_format, ending, make = MAKERS[name]

    def feed(chance: random.Random, folder: Path) -> None:
        path = folder / f"log{ending}"
        path.unlink(missing_ok=True)
        make(chance, path)
        if chance.random() < 0.75:
            path.write_bytes(spoilt_bytes(chance, path.read_bytes()))
        bag = make is make_bag
        options: dict[str, object] = {"topic": "/ft"} if bag else {}
        if chance.random() < 0.15:
            options |= odd_option(chance, log_format)
        read_log(path, log_format, options, chance.choice(WANTED_OF_BAG if bag else WANTED))

    return feed


def odd_option(chance: random.Random, log_format: str) -> dict[str, object]:
    """Return one of the options that a format declares, or one that it does not know, with any value."""
    (known,) = (found.options.model_fields for found in log_formats() if found.name == log_format)
    values = (*NASTY_TEXTS, "log", "Fx", "ft", "/ft", "/tf", 5, True, ["t", "Fx", "Fy", "run"])
    return {chance.choice(tuple(known) or ("nothing",)): chance.choice(values)}


def declared_target(log_format: str, inputs: tuple[FuzzInput, ...]) -> Target:
    """Return the target that spoils what a reader itself declares to be spoilt."""

    def feed(chance: random.Random, folder: Path) -> None:
        chosen = chance.choice(inputs)
        path = folder / f"log{chosen.ending}"
        path.unlink(missing_ok=True)
        chosen.write(path)
        if chance.random() < 0.75:
            path.write_bytes(spoilt_bytes(chance, path.read_bytes()))
        options = dict(chosen.options) | (odd_option(chance, log_format) if chance.random() < 0.15 else {})
        wanted = chance.choice(
            (WantedColumns(chosen.numbers, chosen.texts), WantedColumns(chosen.numbers), WantedColumns(("nowhere",)))
        )
        read_log(path, log_format, options, wanted)

    return feed


def declared_targets() -> dict[str, Target]:
    """Return a target for each log format for which there is no maker of odd logs: it is found, and so is its input."""
    made = {log_format for log_format, _, _ in MAKERS.values()}
    readers = [reader for reader in log_formats() if isinstance(reader, Reader) and reader.name not in made]
    return {reader.name: declared_target(reader.name, reader.fuzz_inputs) for reader in readers if reader.fuzz_inputs}


def feed_csv(chance: random.Random, folder: Path) -> None:
    """Spoil cells, lines, header, encoding and options of a text log."""
    make_csv(chance, path := folder / "log.csv")
    text = path.read_text(encoding="utf-8")
    path.write_bytes(spoilt_lines(chance, text) if chance.random() < 0.7 else spoilt_bytes(chance, text.encode()))
    read_log(path, None, dict(chance.choice(TEXT_OPTIONS)), chance.choice(WANTED))


def feed_packed(chance: random.Random, folder: Path) -> None:
    """Spoil a packed text log, before it is packed or after."""
    make_csv(chance, path := folder / "log.csv")
    data = path.read_bytes()
    if chance.random() < 0.2:
        data = spoilt_lines(chance, data.decode())
    ending, data = packed(chance, data * (chance.choice((1, 1, 200)) if len(data) < 10_000 else 1))
    path = folder / f"log.csv{ending}"
    path.write_bytes(spoilt_bytes(chance, data) if chance.random() < 0.8 else data)
    read_log(path, None, dict(chance.choice(TEXT_OPTIONS[:8])), chance.choice(WANTED))


def feed_postgres(chance: random.Random, folder: Path) -> None:
    """Ask a real server: odd columns, spoilt queries, options and addresses, and a line that spoils its answers."""
    wanted = wanted_of_database(chance)
    if chance.random() < 0.7:
        options = spoilt_options(chance, folder)
        with allowing(folder, options):
            return read_log(folder, "postgres", options, wanted)
    with spoiling_line(chance, folder), allowing(folder, options := {"uri_env": SPOILT, "from": odd_query(chance)}):
        return read_log(folder, "postgres", options, wanted)


def feed_campaign(folder: Path, manifest: bytes, robot: bytes, model: bytes) -> None:
    """Load a folder of three files as every command does, up to the robot that is to be fitted."""
    from stiffcal.campaign.frames.frames import measurement_setup, resolve_frames
    from stiffcal.campaign.loading import load_campaign
    from stiffcal.model.assembled.assembly import compliant_robot
    from stiffcal.model.catalogue.catalogue import built_in_effects

    for name, data in (("campaign.toml", manifest), ("robot.toml", robot), ("model.toml", model)):
        (folder / name).write_bytes(data)
    campaign = load_campaign(folder, check_files=False)
    chain = campaign.chain
    measurement_setup(campaign.manifest, chain, resolve_frames(campaign.manifest, chain))
    compliant_robot(chain, campaign.model, built_in_effects())
    for held in (
        chain.fixed,
        chain.flange,
        chain.coupling,
        chain.offset,
        chain.link_mass,
        chain.link_com,
        chain.gravity,
    ):
        if not np.isfinite(held).all():
            raise BrokenPromiseError("the chain holds what is no number")


def toml_targets() -> dict[str, Target]:
    """Return the targets of the TOML files, each with the others as they should be."""
    full = (DATA / "everything.toml").read_text(encoding="utf-8")
    robots = (ROBOT, (DATA / "interface_robot.toml").read_text(encoding="utf-8"))
    model = (DATA / "interface_model.toml").read_text(encoding="utf-8")
    simulate = SIMULATE.read_text(encoding="utf-8")

    def spoilt(chance: random.Random, text: str) -> bytes:
        return spoilt_toml(chance, text, tomllib.loads(text))

    def feed_manifest(chance: random.Random, folder: Path) -> None:
        feed_campaign(
            folder,
            spoilt(chance, chance.choice((full, full, MANIFEST))),
            ROBOT.encode(),
            b'schema = "stiffcal/model/1"\n',
        )

    def feed_robot(chance: random.Random, folder: Path) -> None:
        feed_campaign(
            folder, MANIFEST.encode(), spoilt(chance, chance.choice(robots)), b'schema = "stiffcal/model/1"\n'
        )

    def feed_model(chance: random.Random, folder: Path) -> None:
        feed_campaign(folder, MANIFEST.encode(), ROBOT.encode(), spoilt(chance, model))

    def feed_simulate(chance: random.Random, folder: Path) -> None:
        from stiffcal.simulation.settings import load_settings

        (folder / "simulate.toml").write_bytes(spoilt(chance, simulate))
        load_settings(folder)

    return {
        "campaign.toml": feed_manifest,
        "robot.toml": feed_robot,
        "model.toml": feed_model,
        "simulate.toml": feed_simulate,
    }


def targets() -> dict[str, Target]:
    """Return every target by name: one or more for each log format, one for each TOML file."""
    readers = {name: reader_target(name) for name in MAKERS}
    others = {"csv": feed_csv, "packed csv": feed_packed, "postgres": feed_postgres, "commands": feed_numbers}
    folders = {"addresses": feed_address, "stores": feed_store, "plugins": feed_plugins}
    return declared_targets() | readers | others | toml_targets() | ATTACKS | folders


def formats_not_fed() -> tuple[str, ...]:
    """Return the log formats of the package that no target feeds."""
    fed = {log_format for log_format, _, _ in MAKERS.values()} | {"postgres", *declared_targets()}
    return tuple(name for name in format_names() if name not in fed)


def check_fault(error: InputError) -> str:
    """Return what is not clear about a refusal, "" where all is as it should be."""
    for fault in error.faults:
        line = str(fault)
        if not fault.reason.strip() or not fault.mend.strip():
            return f"no reason or no mend: {line[:200]!r}"
        if "\n" in line or "\r" in line:
            return f"more than one line: {line[:200]!r}"
        if len(line) > 2500:
            return f"a line of {len(line)} characters: {line[:200]!r}"
        if any(word in line for word in ("Traceback", "pydantic_core", "pydantic.dev", "ValidationError", " at 0x")):
            return f"words of the machine's own: {line[:200]!r}"
    return ""
