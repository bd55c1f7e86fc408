"""Which kernels are tried: those that processor and library have, each once; what is left out says why."""

from __future__ import annotations

import subprocess
from typing import Any

import pytest

from tests import kernels


@pytest.fixture
def runs(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Keep what would be run, with the kernels asked for; no test is started."""
    asked: list[str] = []

    def run(words: list[str], env: dict[str, str], **_: Any) -> subprocess.CompletedProcess[str]:
        asked.append(env["OPENBLAS_CORETYPE"])
        return subprocess.CompletedProcess(words, 1 if env["OPENBLAS_CORETYPE"] == "Bad" else 0)

    monkeypatch.delenv("OPENBLAS_CORETYPE", raising=False)
    monkeypatch.setattr(subprocess, "run", run)
    monkeypatch.setattr(kernels, "flags", lambda: {"avx2", "fma"})
    monkeypatch.setattr(kernels, "computed", lambda kernel: f"digest of {kernel}")
    return asked


def test_kernels_that_cannot_be_tried_are_skipped_with_a_reason(
    runs: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(kernels, "taken", lambda kernel: {"Haswell"} if kernel == "Zen" else {kernel})
    assert kernels.main([]) == 0
    assert runs == ["Haswell"]
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("Haswell: passed in ")
    assert lines[1] == "SkylakeX: skipped, this processor has no avx512bw, avx512dq, avx512f, avx512vl"
    assert lines[2] == "Zen: skipped, the libraries take Haswell in their place, which have been tried"


def test_a_failure_under_one_kernel_is_a_failure(runs: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kernels, "taken", lambda kernel: {kernel})
    assert kernels.main(["Bad", "Haswell"]) == 1
    assert runs == ["Bad", "Haswell"]


@pytest.mark.parametrize(("own", "left"), [({"Haswell"}, ["SkylakeX"]), ({"Other"}, ["Haswell", "SkylakeX"])])
def test_the_processors_own_kernels_may_be_left_out(
    own: set[str], left: list[str], runs: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Under its own kernels a processor runs all tests; one that passes for Haswell is the same again."""
    monkeypatch.setattr(kernels, "flags", lambda: None)
    monkeypatch.setattr(
        kernels, "taken", lambda kernel: {"Haswell"} if kernel == "Zen" else {kernel} if kernel else own
    )
    assert kernels.main(["--others"]) == 0
    assert runs == left
    assert ("Haswell: left out, the tests run under these kernels anyway" in capsys.readouterr().out) == (
        "Haswell" not in left
    )
    assert kernels.main([]) == 0
    assert runs == [*left, "Haswell", "SkylakeX"]


def test_kernels_with_the_same_results_are_tried_once(
    runs: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(kernels, "flags", lambda: None)
    monkeypatch.setattr(kernels, "taken", lambda kernel: {kernel})
    monkeypatch.setattr(kernels, "computed", lambda kernel: "the same" if kernel != "SkylakeX" else "others")
    assert kernels.main([]) == 0
    assert runs == ["Haswell", "SkylakeX"]
    assert "Zen: left out, its results are those of Haswell to the last bit" in capsys.readouterr().out


def test_results_that_cannot_be_computed_are_not_equal(runs: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kernels, "flags", lambda: None)
    monkeypatch.setattr(kernels, "taken", lambda kernel: {kernel})
    monkeypatch.setattr(kernels, "computed", lambda kernel: "")
    assert kernels.main(["--others", "Haswell", "Zen"]) == 0
    assert runs == ["Haswell", "Zen"]


def test_the_libraries_say_which_kernels_they_take_and_compute_by_them() -> None:
    has = kernels.flags()
    if has is None or not kernels.INSTRUCTIONS["Haswell"] <= has:
        pytest.skip("this processor cannot run Haswell's kernels")
    assert kernels.taken("Haswell") == {"Haswell"}
    assert kernels.computed("Haswell") == kernels.computed("Haswell") != ""
    if has >= kernels.INSTRUCTIONS["SkylakeX"]:
        assert kernels.computed("Haswell") != kernels.computed("SkylakeX")
