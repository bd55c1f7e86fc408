"""The same answer under the BLAS kernels of every processor, each in a process of its own."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests.kernels import KERNELS, environment, flags, why_skipped

pytestmark = pytest.mark.long

ROOT = Path(__file__).parents[2]
SAME = 0.01
"""By which a probability may differ between kernels."""
JUDGE = """
import json
from stiffcal.judgement.states import judge_states
from stiffcal.model.catalogue.catalogue import built_in_effects
from tests.calibration.stress.classes import draw_stress
campaign = draw_stress("broken-heavy-tails", 2, 0)
judged = judge_states(campaign.states, campaign.model, built_in_effects())
sets = judged.weighed.probabilities()
print(json.dumps({" + ".join(judged.members[i].name for i in key): p for key, p in sets.items()}))
"""


def judged(kernel: str) -> dict[str, float]:
    """Return the probability of each set under a kernel."""
    words = [sys.executable, "-P", "-c", JUDGE]
    env = environment(kernel) | {"PYTHONPATH": str(ROOT)}
    ended = subprocess.run(words, cwd=ROOT, env=env, capture_output=True, text=True, check=True)
    found: dict[str, float] = json.loads(ended.stdout)
    return found


def test_every_kernel_gives_the_same_probabilities() -> None:
    """Of a campaign of which several sets are as probable as each other."""
    able = [kernel for kernel in KERNELS if not why_skipped(kernel, (), flags())]
    if len(able) < 2:
        pytest.skip("this processor takes one kernel alone")
    one, *others = (judged(kernel) for kernel in able)
    assert 0.05 < max(one.values()) < 0.95
    for other in others:
        for name in one.keys() | other.keys():
            assert one.get(name, 0.0) == pytest.approx(other.get(name, 0.0), abs=SAME), name
