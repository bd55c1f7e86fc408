"""Allowing what a campaign folder wants to run, and taking that back."""

from __future__ import annotations

import os
import re
from contextlib import suppress
from pathlib import Path

from stiffcal.campaign.loading import load_manifest
from stiffcal.errors import InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.results.trust_results import TrustResult
from stiffcal.stages.campaign_code import TrustOverview, read_campaign, trusted_items
from stiffcal.trust.content import SHA256
from stiffcal.trust.places import normal_place
from stiffcal.trust.record import hashes_of_environment, open_record


def allow_shown(showing: TrustOverview) -> TrustResult:
    """Remember that the user allows what was shown, by its hash: the same content elsewhere is allowed too.

    Raises
    ------
    InputError : it cannot be remembered.
    """
    place = os.path.realpath(showing.folder)
    record = open_record()
    if showing.plugins.files:
        record.allow_plugin(showing.plugins.digest, place)
    for digest in showing.queries:
        record.allow_text(digest, place)
    entries = [entry for entry in record.entries() if entry.key in showing.hashes]
    return showing.result("allowed", entries)


def allow_folder(folder: Path) -> TrustResult:
    """Remember that whatever code stands in a campaign folder may run, while the user works on it there.

    Raises
    ------
    InputError : there is no campaign, or it cannot be remembered.
    """
    load_manifest(Path(folder))
    record, place = open_record(), os.path.realpath(folder)
    record.allow_folder(Path(folder))
    entries = [entry for entry in record.entries() if (entry.kind, entry.key) == ("folder", place)]
    return TrustResult(warnings=[], action="allowed", entries=trusted_items(entries))


def allow_place(uri: str) -> TrustResult:
    """Remember that stores in a place, and below it, count like the user's own.

    Raises
    ------
    InputError : it is empty or the root of all places, or it cannot be remembered.
    """
    _check_named("--store", uri)
    place = normal_place(uri)
    if place == os.path.dirname(place) or re.fullmatch(r"[a-z0-9+.-]+://", place):  # noqa: PTH120 - no path, a place
        raise InputError.at(
            FaultCode.OPTION_INVALID,
            "command line",
            "--store",
            f"{uri} contains everything",
            "name the folder of the stores",
        )
    record = open_record()
    record.allow_place(place)
    entries = [entry for entry in record.entries() if (entry.kind, entry.key) == ("place", place)]
    return TrustResult(warnings=[], action="allowed", entries=trusted_items(entries))


def list_trust() -> TrustResult:
    """Return everything that the user trusts; of the generations of stores only how many there are.

    Raises
    ------
    InputError : `STIFFCAL_TRUST` holds something else than hashes.
    """
    record = open_record()
    entries = record.entries()
    allowed = [entry for entry in entries if entry.kind != "generation"]
    return TrustResult(
        warnings=[],
        action="listed",
        entries=trusted_items(allowed),
        record=str(record.file) if record.file is not None else None,
        generations=len(entries) - len(allowed),
        environment=sorted(hashes_of_environment()),
    )


def _check_named(option: str, name: str) -> None:
    """Refuse an empty name, as of a variable that is not set: it would be the current folder, whatever that is."""
    if not name.strip():
        raise InputError.at(
            FaultCode.OPTION_INVALID, "command line", option, "is empty", 'name it in full, the current folder as "."'
        )


def revoke_trust(name: str) -> TrustResult:
    """Take back what was allowed: by its hash, by the folder where it was allowed, or a place.

    Raises
    ------
    InputError : nothing of this name is trusted, or the record cannot be written.
    """
    _check_named("--revoke", name)
    names = {os.path.realpath(name), normal_place(name)}
    if SHA256.fullmatch(name.lower()):
        names.add(name.lower())
    if Path(name).is_dir():
        with suppress(InputError):  # what was allowed of it before is found by the folder
            names |= set(read_campaign(Path(name)).hashes)
    revoked = open_record().revoke(*names)
    in_environment = sorted(names & hashes_of_environment())
    if not revoked and not in_environment:
        raise InputError.at(
            FaultCode.OPTION_INVALID, "command line", "--revoke", f"{name} is not trusted", "see stiffcal trust --list"
        )
    warnings = [f"STIFFCAL_TRUST still contains {digest}" for digest in in_environment]
    return TrustResult(warnings=warnings, action="revoked", entries=trusted_items(revoked))
