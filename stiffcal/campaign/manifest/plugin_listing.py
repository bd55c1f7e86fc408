"""Naming a plugin in campaign.toml; the user's comments stay."""

from __future__ import annotations

from pathlib import Path

import tomlkit
from tomlkit.items import Array

from stiffcal.campaign.manifest.manifest_type import validate_manifest
from stiffcal.campaign.toml.naming import MANIFEST_FILE
from stiffcal.campaign.toml.reach import check_own
from stiffcal.campaign.toml.toml_reading import parse_for_editing, read_toml, toml_text
from stiffcal.files import replacing


def list_plugin(folder: Path, name: str) -> None:
    """Add a file to the ``plugins`` of a campaign's manifest.

    Parameters
    ----------
    folder : the campaign folder.
    name : of the file, in this folder.

    Raises
    ------
    InputError : the manifest is faulty.
    """
    path = folder / MANIFEST_FILE
    check_own(folder, MANIFEST_FILE)
    document = parse_for_editing(toml_text(path, MANIFEST_FILE), MANIFEST_FILE, validate_manifest)
    plugins = document.get("plugins")
    if isinstance(plugins, Array):
        plugins.append(name)
    else:
        listed = tomlkit.array()
        listed.append(name)
        document["plugins"] = listed
    with replacing(path) as temporary:
        temporary.write_text(tomlkit.dumps(document), encoding="utf-8", newline="\n")
        validate_manifest(read_toml(temporary, MANIFEST_FILE))
