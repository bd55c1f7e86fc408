"""Secrets of the environment stand in no message, log, JSON error or summary of a batch."""

from __future__ import annotations

import json
import os
import re
import stat
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import stiffcal.commands.history
from stiffcal.cli.app import main
from stiffcal.errors import Fault, InputError
from stiffcal.fault_codes import FaultCode
from stiffcal.masking import is_secret_name, mask, masked
from stiffcal.results.batch_results import BatchTask
from tests.laboratory.small_campaign import write_small_campaign

SECRET = "k7 =geheim'&%öl"
ESCAPED = r"k7 =geheim\'&%öl"
PERCENT = "k7%20%3Dgeheim%27%26%25%C3%B6l"


@pytest.fixture
def secret(monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", SECRET)
    return SECRET


@pytest.mark.parametrize("spelling", [SECRET, ESCAPED, PERCENT, SECRET.replace(" ", "\n"), f"x{SECRET}x"])
def test_a_secret_is_masked_however_it_is_spelled(secret: str, spelling: str) -> None:
    fault = Fault(FaultCode.DATABASE_ADDRESS, spelling, f"place {spelling}", f"reason {spelling}", f"mend {spelling}")
    assert "geheim" not in str(fault) + json.dumps(fault.as_document()) + mask(f"a {spelling} b")
    assert "geheim" not in str(InputError(fault))


def test_a_secret_that_would_be_cut_leaves_no_half(secret: str) -> None:
    for start in range(290, 302):
        assert "geh" not in str(Fault(FaultCode.DATABASE_ADDRESS, "", "", "x" * start + SECRET + "y" * 400, ""))


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("PGPASSWORD", True), ("AWS_SECRET_ACCESS_KEY", True), ("AWS_ACCESS_KEY_ID", True),
        ("AWS_SESSION_TOKEN", True), ("GITHUB_TOKEN", True), ("LAB_API_KEY", True), ("db_pass", True),
        ("GH_PAT", True), ("CI_JOB_JWT_TOKEN", True), ("SSH_PRIVATE_KEY", True),
        ("PWD", False), ("OLDPWD", False), ("PATH", False), ("AWS_REGION", False), ("AWS_ENDPOINT_URL", False),
        ("PGPASSFILE", False), ("SSH_AUTH_SOCK", False), ("DESKTOP_SESSION", False), ("KEYBOARD", False),
        ("GIT_ASKPASS", False), ("GOOGLE_CREDENTIALS_FILE", False), ("COMPASS", False), ("PASSENGER", False),
    ],
)  # fmt: skip
def test_which_variables_hold_secrets(name: str, expected: bool) -> None:
    assert is_secret_name(name) is expected


def test_short_values_mask_no_ordinary_words(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LAB_TOKEN", "tool")
    monkeypatch.setenv("LAB_PASSWORD", "12")
    assert mask("the tool of joint 12") == "the tool of joint 12"


def test_passwords_inside_other_variables(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LAB", "postgresql://me:pass%20wort@db/ft")
    monkeypatch.setenv("OTHER", "host=db password='other wort' user=me")
    assert "wort" not in mask("FATAL: role me, pass wort, pass%20wort, other wort")


@pytest.mark.parametrize(
    "text",
    [
        "s3://key:geheim@bucket/x", "postgresql://me:ge@heim@db", "x password=geheim host", "PASSWORD = 'ge heim'",
        '{"password": "geheim"}', "Authorization: Bearer geheim1234567", "https://h/x?a=1&X-Amz-Signature=geheim&b=2",
        "aws_secret_access_key=geheim", "sslpassword=geheim", "-----BEGIN RSA PRIVATE KEY-----\ngeheim\n",
    ],
)  # fmt: skip
def test_what_is_a_secret_by_its_form_is_masked_without_any_variable(text: str) -> None:
    assert "heim" not in mask(text)


@pytest.mark.parametrize(
    "text",
    [
        "postgres.password: no such option", "the key of a table", "token: 7 columns", "http://localhost:8080/a@b",
        "export LAB_DB=postgresql://USER@HOST/DATABASE", "column Fx = 5 N", "C:/data/a@b",
    ],
)  # fmt: skip
def test_ordinary_lines_stay_as_they_are(text: str) -> None:
    assert mask(text) == text


def test_numbers_and_keys_of_a_document_stay(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LAB_TOKEN", "123456")
    assert masked({"123456": 123456, "words": ["a 123456"]}) == {"123456": 123456, "words": ["a …"]}


def _broken(*_: object, **__: object) -> None:
    raise RuntimeError(f"nobody thought of {os.environ['AWS_SECRET_ACCESS_KEY']}")


@pytest.mark.parametrize("further", [[], ["--json"], ["--debug"]])
def test_the_log_of_an_internal_fault_holds_no_secret_and_only_its_user_reads_it(
    secret: str, further: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(stiffcal.commands.history, "read_history", _broken)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "logs"))
    (tmp_path / "logs").mkdir()
    with pytest.raises(SystemExit) as end:
        main(["history", str(tmp_path), "--store", f"s3://me:{SECRET}@bucket/x", *further])
    assert end.value.code == 3
    shown = capsys.readouterr()
    assert "nobody thought of" in shown.out + shown.err
    assert "geheim" not in shown.out + shown.err
    logs = list((tmp_path / "logs").iterdir())
    assert len(logs) == (0 if "--debug" in further else 1)
    for log in logs:
        assert "geheim" not in log.read_text()
        assert "Traceback" in log.read_text()
        if os.name == "posix":
            assert stat.S_IMODE(log.stat().st_mode) == 0o600


def test_the_log_follows_no_link_that_somebody_has_put_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    victim = tmp_path / "victim"
    victim.write_text("mine")
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", SECRET)
    monkeypatch.setattr(stiffcal.commands.history, "read_history", _broken)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setattr("time.strftime", lambda _: "20260101-000000")
    (tmp_path / f"stiffcal-fault-20260101-000000-{os.getpid()}.log").symlink_to(victim)
    with pytest.raises(SystemExit):
        main(["history", str(tmp_path)])
    assert victim.read_text() == "mine"
    capsys.readouterr()


def test_a_usage_error_shows_no_secret(secret: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        main([SECRET])
    assert end.value.code == 2
    assert "geheim" not in capsys.readouterr().err


def test_a_batch_shows_no_secret_in_any_of_its_outputs(
    secret: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = write_small_campaign(tmp_path / "cell")

    def lose(tasks: list[BatchTask], jobs: int, finished: Any) -> None:
        from stiffcal.batch.processes import Heard, WorkerLostError, outcome_of_lost_worker

        for task in tasks:
            outcome = outcome_of_lost_worker(task, WorkerLostError(f"its process ended: {SECRET}", Heard()))
            finished(replace(outcome, warnings=[f"w {SECRET}"]))

    monkeypatch.setattr("stiffcal.batch.processes.run_on_this_machine", lose)
    junit, markdown = tmp_path / "junit.xml", tmp_path / "summary.md"
    for further in ([], ["--json"]):
        with pytest.raises(SystemExit):
            main(["batch", str(folder), "--junit", str(junit), "--markdown", str(markdown), *further])
        shown = capsys.readouterr()
        everything = shown.out + shown.err + junit.read_text() + markdown.read_text()
        assert re.search(r"its process ended: …", everything)
        assert "geheim" not in everything


@pytest.mark.parametrize(
    "piece", ["a", "password=", "://a:", "Bearer ", '"password": "', "-----BEGIN A PRIVATE KEY-----", "x@", "secret_"]
)
def test_a_very_long_text_of_a_stranger_costs_no_time(piece: str) -> None:
    begun = time.process_time()
    fault = Fault(FaultCode.DATABASE_ADDRESS, piece * 200_000, "", piece * 200_000, "")
    mask(piece * 2_000)
    assert len(fault.reason) < 700
    assert time.process_time() - begun < 2.0
