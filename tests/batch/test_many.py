"""`tests/batch_many.py` in small; by hand it runs with two hundred campaigns (``make batch-many``)."""

from __future__ import annotations

import sys

import pytest

from tests.batch_many import main


@pytest.mark.long
@pytest.mark.skipif(sys.platform != "linux", reason="it looks at processes where Linux shows them")
def test_twenty_campaigns_are_killed_and_resumed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(campaigns=20, idle_timeout=5.0, n_broken=4), capsys.readouterr().out
