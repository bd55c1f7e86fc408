"""The manifest's type as a file is checked against it: with the options of the log formats that there are.

`stiffcal.campaign.manifest` says what every manifest may hold. Which tables of options a source may hold besides, the
readers declare; the type is made from both, so that a new reader needs no edit here and the JSON Schema follows.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Any, cast

from pydantic import Field, create_model

from stiffcal.campaign.file_formats import format_names, log_format
from stiffcal.campaign.manifest import Manifest, Source, SourceFiles
from stiffcal.campaign.typed import Table

_Options = tuple[tuple[str, type[Table] | None], ...]


def manifest_type(document: Mapping[str, object] | None = None) -> type[Manifest]:
    """Return the type that a manifest is checked against.

    Parameters
    ----------
    document : the manifest; formats whose options it does not hold are not imported. None: all are.

    Examples
    --------
    >>> manifest = {"schema": "stiffcal/campaign/1", "sources": {"ft": {"csv": {"decimal": ","}}}}
    >>> manifest_type(manifest).model_validate(manifest).sources["ft"].options_of("csv")
    {'decimal': ','}
    """
    return _manifest_type(_options(None if document is None else _keys_of_sources(document)))


def source_type() -> type[Source]:
    """Return the type of a source, with the options of all log formats."""
    return _source_type(_options(None))


def _keys_of_sources(document: Mapping[str, object]) -> set[str]:
    sources = document.get("sources")
    tables = sources.values() if isinstance(sources, Mapping) else ()
    return {key for table in tables if isinstance(table, Mapping) for key in table}


def _options(wanted: set[str] | None) -> _Options:
    return tuple((name, _options_of(name) if wanted is None or name in wanted else None) for name in format_names())


def _options_of(name: str) -> type[Table] | None:
    found = log_format(name)
    return found.options if found is not None else None


@lru_cache(maxsize=32)
def _source_type(options: _Options) -> type[Source]:
    # A format that is not asked for is there by name alone: what may be written is listed where a key is wrong.
    fields: dict[str, Any] = {name: (None if table is None else table | None, None) for name, table in options}
    # The options lie between the two, so that keys and faults come in the order in which people write them.
    bases: Any = (Source, create_model("SourceOptions", __base__=SourceFiles, **fields))
    return cast(type[Source], create_model("Source", __base__=bases, __doc__=Source.__doc__))


@lru_cache(maxsize=32)
def _manifest_type(options: _Options) -> type[Manifest]:
    sources: Any = dict[str, _source_type(options)]  # type: ignore[misc]  # made at run time
    return create_model(
        "Manifest", __base__=Manifest, __doc__=Manifest.__doc__, sources=(sources, Field(default_factory=dict))
    )
