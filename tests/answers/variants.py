"""Campaigns that no bundled one stands for, written from the simulators of the tests or from a bundled one."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping
from pathlib import Path

import tomlkit
from tomlkit.items import AoT

Writer = Callable[[Path, Path], object]
"""Writes a campaign: the folder of the bundled campaigns, and the new folder, which is not there yet."""


def _track_absolute(_: Path, place: Path) -> None:
    from tests.laboratory.track_simulator import Track, write_absolute

    write_absolute(place, Track.drawn(3), 3, 60)


def _track_loads(_: Path, place: Path) -> None:
    from tests.laboratory.track_simulator import Track, write_loads

    write_loads(place, Track.drawn(4), 4, 20)
    (place / "model.toml").write_text(
        'schema = "stiffcal/model/1"\n[[effects]]\ntype = "joint-compliance"\njoints = "all"\n', "utf-8"
    )


def _inclined_base(_: Path, place: Path) -> None:
    from tests.laboratory.track_simulator import Track, write_absolute

    write_absolute(place, Track.arm(5, 0.6), 5, 60)


def _uncertain_payload(bundled: Path, place: Path) -> None:
    shutil.copytree(bundled / "absolute" / "02", place)
    manifest = tomlkit.parse((place / "campaign.toml").read_text("utf-8"))
    frames = manifest["frames"]
    if not isinstance(frames, Mapping):
        raise TypeError("frames is no table")
    frames["payload"]["sigma_m"] = 0.005
    (place / "campaign.toml").write_text(tomlkit.dumps(manifest), "utf-8")


def reversed_model(name: str) -> Writer:
    """Return what copies a bundled campaign with the entries of its model in reverse order."""

    def write(bundled: Path, place: Path) -> None:
        shutil.copytree(bundled / name, place)
        model = tomlkit.parse((place / "model.toml").read_text("utf-8"))
        entries = model["effects"]
        if not isinstance(entries, AoT):
            raise TypeError(f"{name}: effects is no array of tables")
        turned = tomlkit.aot()
        for entry in reversed(list(entries)):
            turned.append(entry)
        model["effects"] = turned
        (place / "model.toml").write_text(tomlkit.dumps(model), "utf-8")

    return write


VARIANTS: Mapping[str, Writer] = {
    "variants/track-absolute": _track_absolute,
    "variants/track-loads": _track_loads,
    "variants/inclined-base": _inclined_base,
    "variants/uncertain-payload": _uncertain_payload,
    "variants/reversed-absolute": reversed_model("absolute/02"),
    "variants/reversed-mixed": reversed_model("mixed"),
    "variants/reversed-bodies": reversed_model("kr125-bodies"),
}
"""Prismatic axes and seven joints; an inclined first axis; a payload whose place has `sigma_m`; models in reverse."""

SUBSET = (
    "demo",
    "hidden/03",
    "hidden/06",
    "joints/01",
    "joints/07",
    "absolute/02",
    "absolute/04",
    "absolute-and-loads",
    "mixed",
    "sda5f/left",
    "max100",
    *VARIANTS,
)
"""One campaign of each kind, for every step of a change that should alter nothing."""
