"""Small campaign folders to break."""

from __future__ import annotations

from pathlib import Path

DATA = Path(__file__).parent / "data"

ROBOT = """schema = "stiffcal/robot/1"
convention = "modified-dh"
""" + "".join(f'[[joints]]\nname = "A{k}"\nd_m = 0.3\nalpha_deg = {90 * (k % 2)}\n' for k in range(1, 7))

MANIFEST = (DATA / "interface_campaign_short.toml").read_text(encoding="utf-8")


def write_campaign(folder: Path, manifest: str = MANIFEST, robot: str = ROBOT, model: str | None = None) -> Path:
    """Write a campaign folder with an (empty) table and return it."""
    (folder / "raw").mkdir(parents=True)
    (folder / "raw" / "table.csv").write_text("A1\n")
    (folder / "campaign.toml").write_text(manifest, encoding="utf-8")
    (folder / "robot.toml").write_text(robot, encoding="utf-8")
    if model is not None:
        (folder / "model.toml").write_text(model, encoding="utf-8")
    return folder


def changed(text: str, *changes: tuple[str, str]) -> str:
    """Replace pieces of a text, each of which must be there."""
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new, 1)
    return text
