"""The reader that the documentation shows: installed as a package, it reads its logs and refuses a spoilt one."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from docs.page_blocks import blocks_of
from tests.laboratory.documentation import ROOT

PAGE = "how-to/own-reader.md"
SCRIPT = """
import sys
from pathlib import Path
from stiffcal.errors import InputError
from stiffcal.readers import WantedColumns, find_reader
log = Path(sys.argv[1])
reader = find_reader(log)
try:
    batches = list(reader.read_batches(log, {}, WantedColumns(("t", "Fx")), "log"))
except InputError as error:
    print(error.code.value)
else:
    print(reader.name, *(float(value) for batch in batches for value in batch.numbers["Fx"]))
"""


@pytest.mark.parametrize(
    ("rows", "expected"),
    [
        ('{"rows": [{"t": 0.0, "Fx": 1.5}, {"t": 0.1, "Fx": -2.0}]}', "jsonrows 1.5 -2.0"),
        ('{"rows": [{"t": 0.0, "Fx": 1.5}, {"t": 0.1}]}', "cell-empty"),
        ('{"rows": [{"t": 0.0, "Fx": NaN}]}', "number-invalid"),
        ('{"rows": [{"t": 0.0, "Fx"', "syntax-invalid"),
    ],
    ids=["whole", "no number", "not finite", "cut off"],
)
def test_the_reader_of_the_page_reads_what_it_shows(tmp_path: Path, rows: str, expected: str) -> None:
    (module,) = (block.text for block in blocks_of(PAGE) if block.language == "python")
    (tmp_path / "lab_readers.py").write_text(module, encoding="utf-8")
    metadata = tmp_path / "lab_readers-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: lab-readers\nVersion: 1.0\n")
    (metadata / "entry_points.txt").write_text("[stiffcal.readers]\njsonrows = lab_readers:READER\n")
    log = tmp_path / "a.jrows"
    log.write_text(rows)
    path = os.pathsep.join((str(tmp_path), str(ROOT)))
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, str(log)],
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.strip() == expected
