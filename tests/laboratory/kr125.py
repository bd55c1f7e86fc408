"""Parts of campaigns/kr125, simulated: some of its clamped runs, with a change of what is simulated or modelled."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np

from stiffcal.campaign.loading import load_campaign
from stiffcal.simulation.settings import load_settings
from stiffcal.simulation.simulate import simulate_campaign

SOURCE = Path(__file__).parents[2] / "campaigns" / "kr125"
DEGREE = np.pi / 180.0
TABLE_2 = {
    1: (0.10, 28.7, -10.9, 1.30),
    2: (0.15, -42.5, -5.30, 6.35),
    3: (0.10, -8.72, -3.14, 1.47),
    4: (0.16, 0.304, 0.00706, 0.0225),
    5: (0.14, 8.04, -0.921, 0.285),
    6: (0.10, 19.9, 0.598, 0.331),
}
Change = Callable[[str], str]


def same(text: str) -> str:
    return text


def without_friction(text: str) -> str:
    """Take the friction sweeps' source out: these tests are of clamped runs."""
    return re.sub(
        r"\[(sources|sensors)\.drives\].*?(?=\n\[\[|\n\[frames|\n\[s\w+\.(?!drives)|\n# )", "", text, flags=re.S
    )


def some_runs(text: str, keep: tuple[str, ...]) -> str:
    head, *runs = re.split(r"(?=^\[\[runs\]\])", text, flags=re.M)
    return head + "".join(run for run in runs if re.search(r'id = "([^"]+)"', run)[1] in keep)  # type: ignore[index]


def source_folder(
    folder: Path, runs: tuple[str, ...], *, manifest: Change = same, settings: Change = same, model: Change = same
) -> Path:
    """Write kr125 with some of its runs, changed, to be simulated from."""
    folder.mkdir(parents=True)
    shutil.copyfile(SOURCE / "robot.toml", folder / "robot.toml")
    read = {
        name: (SOURCE / name).read_text(encoding="utf-8") for name in ("campaign.toml", "simulate.toml", "model.toml")
    }
    (folder / "campaign.toml").write_text(manifest(some_runs(without_friction(read["campaign.toml"]), runs)))
    (folder / "simulate.toml").write_text(settings(some_runs(without_friction(read["simulate.toml"]), runs)))
    kept = read["model.toml"].split('[[effects]]\ntype = "joint-friction"')[0]
    (folder / "model.toml").write_text(model(kept))
    return folder


def simulated(tmp_path: Path, runs: tuple[str, ...], **changes: Change) -> Path:
    source = source_folder(tmp_path / "source", runs, **changes)
    out = tmp_path / "out"
    simulate_campaign(load_campaign(source, check_files=False), load_settings(source), out)
    return out
