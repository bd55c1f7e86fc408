"""What a file may ask for has a limit, named in the message and raised by the environment."""

from __future__ import annotations

import re

import pytest

from stiffcal import limits
from stiffcal.errors import InputError


class TestTheTableOfLimits:
    def test_every_limit_stands_in_it_with_its_default(self) -> None:
        rows = dict(re.findall(r"^``(STIFFCAL_MAX_\w+)``\s+(.*?)\s{2,}", limits.__doc__ or "", re.MULTILINE))
        assert rows == {limit.variable: limits.shown_amount(limit.default, limit.in_bytes) for limit in limits.ALL}

    @pytest.mark.parametrize("limit", limits.ALL, ids=lambda limit: limit.variable)
    def test_the_environment_raises_it_and_the_message_says_how(
        self, limit: limits.Limit, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        with pytest.raises(InputError, match=limit.variable):
            limit.check(limit.default + 1, "ft.csv")
        monkeypatch.setenv(limit.variable, str(limit.default + 1))
        limit.check(limit.default + 1, "ft.csv")

    @pytest.mark.parametrize(
        ("text", "amount"), [("3 GiB", 3 << 30), ("1.5KiB", 1536), ("2 tb", 2 * 10**12), ("7", 7), (" ", limits.TIB)]
    )
    def test_amounts_with_a_unit(self, text: str, amount: int, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setenv("STIFFCAL_MAX_UNPACKED", text)
        assert limits.UNPACKED.most == amount

    @pytest.mark.parametrize("text", ["much", "-1", "1e9", "5 GiB ROWS", "٣", "9" * 30, "inf"])
    def test_what_is_no_amount_is_one_line(self, text: str, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setenv("STIFFCAL_MAX_UNPACKED", text)
        with pytest.raises(InputError, match='STIFFCAL_MAX_UNPACKED: .* is no amount; .*="4 TiB"'):
            limits.UNPACKED.check(1, "ft.csv.gz")
