"""The manifest's type as a file is checked against it: with the options of log formats and kinds of experiment.

`stiffcal.campaign.manifest.manifest` defines what every manifest may hold. Which tables of options a source or a run
may hold besides, readers and experiments declare; the type is made from both, so that a new one needs no edit here and
the JSON Schema follows.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import lru_cache
from typing import Annotated, Any, cast

from pydantic import Field, create_model

from stiffcal.campaign.found.experiment_kinds import experiment_kind, kind_names
from stiffcal.campaign.found.file_formats import format_names, log_format
from stiffcal.campaign.manifest.manifest import Manifest, Run
from stiffcal.campaign.manifest.source import Source, SourceFiles
from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.campaign.toml.toml_reading import validate
from stiffcal.campaign.toml.typed import TomlTable
from stiffcal.errors import InputError

_Options = tuple[tuple[str, type[TomlTable]], ...]
"""Tables of options by name."""


def manifest_type(document: Mapping[str, object] | None = None) -> type[Manifest]:
    """Return the type that a manifest is checked against.

    Parameters
    ----------
    document : the manifest; formats and kinds whose options it does not hold are not imported. None: all are.

    Examples
    --------
    >>> manifest = {"schema": "stiffcal/campaign/1", "sources": {"ft": {"csv": {"decimal": ","}}}}
    >>> manifest_type(manifest).model_validate(manifest).sources["ft"].options_of("csv")
    {'decimal': ','}
    """
    if document is None:
        return _manifest_type(_options(format_names(), _format_options), _options(kind_names(), _kind_options))
    sources, runs = document.get("sources"), document.get("runs")
    in_sources = _keys_of(sources.values() if isinstance(sources, Mapping) else ())
    in_runs = _keys_of(runs if isinstance(runs, list) else ())
    formats = [name for name in format_names() if name in in_sources]
    kinds = [name for name in kind_names() if name in in_runs]
    return _manifest_type(_options(formats, _format_options), _options(kinds, _kind_options))


def validate_manifest(document: dict[str, Any]) -> Manifest:
    """Check a manifest.

    Raises
    ------
    InputError
        With one fault per wrong key.
    """
    try:
        return validate(document, MANIFEST_FILE, manifest_type(document))
    except InputError:  # once more with all keys that may be written: the faults list them
        return validate(document, MANIFEST_FILE, manifest_type())


def source_type() -> type[Source]:
    """Return the type of a source, with the options of all log formats."""
    return _source_type(_options(format_names(), _format_options))


def _keys_of(tables: Iterable[object]) -> set[str]:
    return {key for table in tables if isinstance(table, Mapping) for key in table}


def _options(names: Iterable[str], options_of: Callable[[str], type[TomlTable] | None]) -> _Options:
    tables = ((name, options_of(name)) for name in names)
    return tuple((name, table) for name, table in tables if table is not None)


def _format_options(name: str) -> type[TomlTable] | None:
    named_format = log_format(name)
    return named_format.options if named_format is not None else None


def _kind_options(name: str) -> type[TomlTable] | None:
    kind = experiment_kind(name)
    return kind.options if kind is not None else None


def _fields(options: _Options) -> dict[str, Any]:
    return {name: (table | None, None) for name, table in options}


@lru_cache(maxsize=32)
def _source_type(options: _Options) -> type[Source]:
    # The options lie between the two, so that keys and faults come in the order in which people write them.
    bases: Any = (Source, create_model("SourceOptions", __base__=SourceFiles, **_fields(options)))
    return cast(type[Source], create_model("Source", __base__=bases, __doc__=Source.__doc__))


@lru_cache(maxsize=32)
def _manifest_type(formats: _Options, kinds: _Options) -> type[Manifest]:
    run: Any = create_model("Run", __base__=Run, __doc__=Run.__doc__, **_fields(kinds)) if kinds else Run
    fields: dict[str, Any] = {
        "sources": (dict[str, _source_type(formats)], Field(default_factory=dict)),  # type: ignore[misc]
        "runs": (Annotated[tuple[run, ...], Field(strict=False)], ()),
    }
    made = create_model("Manifest", __base__=Manifest, __doc__=Manifest.__doc__, **fields)
    made.run_type = run
    return made
