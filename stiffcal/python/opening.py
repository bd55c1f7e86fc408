"""`stiffcal.open`: a campaign folder as an object, with what of its code may run and where its results lie."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from stiffcal.errors import InputError, Progress, no_progress
from stiffcal.fault_codes import FaultCode
from stiffcal.python.session import CampaignSession, logger
from stiffcal.stages.steps import RunContext


def open_campaign(
    folder: str | Path,
    store: str | Path | None = None,
    update: bool = True,
    trust: bool | str | Iterable[str] = (),
    progress: Progress | None = None,
) -> CampaignSession:
    """Open a campaign folder.

    Parameters
    ----------
    folder : with campaign.toml.
    store : where results lie: a folder or an address; None: the folder's own store.
    update : False: refuse where an earlier step is missing or stale, instead of running it.
    trust : SHA-256 of code and queries that may run, as ``stiffcal trust --hash`` prints; True: whatever the folder
        wants to run as it is now, with your rights. It counts as long as this process runs.
    progress : called with what is being done and the share of it, 0 to 1 or None.

    Returns
    -------
    CampaignSession

    Raises
    ------
    InputError : there is no campaign in the folder, or a file of it is wrong.
    """
    from stiffcal.campaign.loading import load_campaign

    place = Path(folder)
    load_campaign(place, check_files=False)
    _allow(place, trust)
    context = RunContext(
        store=None if store is None else str(store),
        update=update,
        progress=progress or no_progress,
        notify=logger.info,
    )
    return CampaignSession(place, context)


def _allow(folder: Path, trust: bool | str | Iterable[str]) -> None:
    """Allow what may run, as long as this process does."""
    from stiffcal.stages.campaign_code import read_campaign
    from stiffcal.trust.content import SHA256
    from stiffcal.trust.record import allow_in_process

    if isinstance(trust, bool):
        allow_in_process(*(read_campaign(folder).hashes if trust else ()))
        return
    digests = [trust.lower()] if isinstance(trust, str) else [digest.lower() for digest in trust]
    for digest in digests:
        if SHA256.fullmatch(digest) is None:
            reason, mend = (
                f"{digest!r} is not a SHA-256",
                ("give the hash that stiffcal trust --hash DIR prints, or True"),
            )
            raise InputError.at(FaultCode.OPTION_INVALID, "open", "trust", reason, mend)
    allow_in_process(*digests)
