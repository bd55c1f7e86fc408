"""What drawing and setting pages leaves in memory: nothing that grows with the number of reports."""

from __future__ import annotations

import json
import subprocess
import sys
import weakref
from pathlib import Path

import pytest
from matplotlib.figure import Figure

from stiffcal.errors import no_progress
from stiffcal.report.drawing import draw_pictures

# In a process of its own: what other tests have given back would be taken first.
REPORTS_OF_MANY_LINES = """
import json, sys
from pathlib import Path
import numpy as np
from stiffcal.report.typesetting import set_pages

def set_report(folder, seed):
    ends = np.random.default_rng(seed).uniform(0.0, 400.0, (4, 4000, 4))
    folder.mkdir()
    for number, picture in enumerate(ends):
        lines = "".join('<path d="M {:.2f} {:.2f} L {:.2f} {:.2f}" stroke="#000"/>'.format(*row) for row in picture)
        svg = f'<svg xmlns="http://www.w3.org/2000/svg" width="400" height="400">{lines}</svg>'
        (folder / f"{number}.svg").write_text(svg, encoding="utf-8")
    head = dict.fromkeys(("title", "kind", "campaign", "maker", "logo"), "") | {"date": "", "has_contents": False}
    blocks = [{"kind": "picture", "file": f"{k}.svg", "number": k, "caption": ""} for k in range(len(ends))]
    assert set_pages({**head, "sections": [{"title": "", "blocks": blocks}]}, folder, "").startswith(b"%PDF")

held = []
for seed in range(6):
    set_report(Path(sys.argv[1]) / str(seed), seed)
    held.append(4096 * int(Path("/proc/self/statm").read_text().split()[1]))
print(json.dumps(held))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="it looks at memory where Linux shows it")
def test_reports_leave_no_pages_in_memory(tmp_path: Path) -> None:
    command = [sys.executable, "-P", "-c", REPORTS_OF_MANY_LINES, str(tmp_path)]
    held = json.loads(subprocess.run(command, stdout=subprocess.PIPE, check=True).stdout)
    # 11 MB a report were kept
    assert held[-1] - held[1] < 15e6


def test_pictures_that_are_drawn_are_given_back(tmp_path: Path) -> None:
    """Their parts refer to each other, and would stand among objects that are hardly ever looked at."""
    drawn: list[weakref.ref[Figure]] = []

    def draw() -> Figure:
        figure = Figure()
        figure.add_subplot().plot([0.0, 1.0])
        drawn.append(weakref.ref(figure))
        return figure

    draw_pictures([("a picture", draw, tmp_path / f"{number}.svg") for number in range(2)], no_progress)
    assert [figure() for figure in drawn] == [None, None]
