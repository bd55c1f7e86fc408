"""`tests/batch_many.py` in small; by hand it runs with two hundred campaigns (``make batch-many``)."""

from __future__ import annotations

import sys

import pytest

from tests import batch_many


@pytest.mark.long
@pytest.mark.skipif(sys.platform != "linux", reason="it looks at processes where Linux shows them")
def test_ten_campaigns_are_killed_and_resumed(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(batch_many, "LONGEST_S", 600.0)
    assert batch_many.main(campaigns=10, idle_timeout=5.0, n_broken=2), capsys.readouterr().out
