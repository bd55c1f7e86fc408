"""A plugin that a campaign's model needs, and that does what a test of `batch` wants when it is loaded."""

from __future__ import annotations

from pathlib import Path

from stiffcal.trust.record import open_record

PLUGIN = """
import os, signal, time
from stiffcal.effects_api import Law
class Own(Law):
    name = "own"
    place_kind = "joints"
    summary = fingerprint = how_to_check = "of no consequence"
    def terms(self, place, chain, loads, shape):
        return ()
from pathlib import Path
HERE = Path(__file__).parent
print("a plugin's own words, which are no outcome")
(HERE / "threads").write_text(os.environ["OPENBLAS_NUM_THREADS"])
with (HERE / "pids").open("a") as file:
    file.write(f"{os.getpid()}\\n")
"""
KILLED = "os.kill(os.getpid(), signal.SIGKILL)\n"
WAITS = "time.sleep(600)\n"
COMPUTES = "while True:\n    pass\n"
STANDS = "os.kill(os.getpid(), signal.SIGSTOP)\n"
LEAVES_A_PROCESS = "if os.fork() == 0:\n    time.sleep(600)\nos._exit(0)\n"


def with_plugin(folder: Path, *lines: str) -> Path:
    """Give a campaign a plugin that its user trusts and its model needs."""
    manifest = folder / "campaign.toml"
    manifest.write_text('plugins = ["own.py"]\n' + manifest.read_text(encoding="utf-8"), encoding="utf-8")
    (folder / "own.py").write_text(PLUGIN + "".join(lines), encoding="utf-8")
    with (folder / "model.toml").open("a", encoding="utf-8") as model:
        model.write('\n[[effects]]\ntype = "own"\njoints = [1]\n')
    open_record().allow_folder(folder)
    return folder
