"""The live page in a real browser: tick a candidate, see a forecast, then the refit; undo; rows left out; written."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from stiffcal.live.page import live_server
from stiffcal.stages.steps import RunContext
from tests.laboratory.diagnosed_folders import WITHOUT_6, diagnosed_copy
from tests.laboratory.small_campaign import write_small_campaign

pytestmark = pytest.mark.browser
EFFECT = "joint-compliance j6"
SCALE = "stiffcal.locked(`y ${stiffcal.state.x} ${stiffcal.state.y}`, [0, 0])"
TOP_OF_PICTURE = "document.querySelector('#against canvas').offsetTop - document.getElementById('against').offsetTop"
TOPS = "[...document.querySelectorAll('#panels > section')].map((panel) => panel.getBoundingClientRect().top)"
WATCH_FORECASTS = (
    """(() => {
  const show = stiffcal.showTryout, content = stiffcal.showContent;
  window.forecasts = [];
  stiffcal.showTryout = () => {
    if (stiffcal.hollow) window.forecasts.push(stiffcal.hollow.model.heldout_rms.translation);
    show();
  };
  stiffcal.showContent = (data) => {
    content(data);
    window.tops = """
    + TOPS
    + """;
  };
})()"""
)


@pytest.fixture
def live_page(browser: Any, tmp_path: Path) -> Iterator[tuple[Any, Path]]:
    """A campaign whose model lacks a joint, diagnosed, served and opened."""
    folder = diagnosed_copy(WITHOUT_6, tmp_path / "small")
    with served(browser, folder) as opened:
        yield opened, folder


@contextmanager
def served(browser: Any, folder: Path) -> Iterator[Any]:
    """Serve and open the page of a campaign, and wait until forecasts can be made."""
    server = live_server(folder, RunContext())
    thread = threading.Thread(target=server.serve)
    thread.start()
    complaints: list[str] = []
    opened = browser.new_context().new_page()
    try:
        opened.set_default_timeout(30_000)
        opened.on("console", lambda message: complaints.append(message.text))
        opened.on("pageerror", lambda error: complaints.append(str(error)))
        opened.goto(server.address)
        opened.wait_for_selector("body[data-ready], body[data-failed]")
        _until(opened, "stiffcal.parts[0].live.forecasts")
        yield opened
    finally:
        opened.context.close()
        server.stop()
        thread.join()
    # the console states each refusal of the server, which tests ask for
    assert [line for line in complaints if "409" not in line] == []


def _until(page: Any, condition: str) -> None:
    """Wait until something holds on the page, whose policy lets playwright's own waiting evaluate nothing."""
    deadline = time.monotonic() + 180.0
    while not page.evaluate(condition):
        assert time.monotonic() < deadline, condition
        page.wait_for_timeout(50)


def _waited(page: Any) -> None:
    _until(page, "stiffcal.waitsFor === '' && stiffcal.moved() === 1 && !stiffcal.pending")
    assert page.evaluate("stiffcal.fault") == ""


def test_an_effect_is_ticked_and_the_error_falls(live_page: tuple[Any, Path]) -> None:
    shown, folder = live_page
    before = shown.evaluate("Array.from(stiffcal.residual().move)")
    text = shown.locator("#error").inner_text()
    rungs = shown.evaluate("stiffcal.data.models.length")
    top = shown.evaluate(TOP_OF_PICTURE)
    shown.evaluate(WATCH_FORECASTS)
    asked: list[str] = []
    shown.on("request", lambda request: asked.append(request.url.rsplit("/", 1)[-1]))
    shown.locator(f"#candidates input[data-effect='{EFFECT}']").check()
    _waited(shown)
    # the server computes one thing at a time: first what is drawn first
    assert [name for name in asked if name in ("forecast", "content")] == ["forecast", "content"]
    assert shown.evaluate("window.tops") == shown.evaluate(TOPS)  # nothing moves once it is drawn
    refit = shown.evaluate("stiffcal.data.models.find((model) => model.present).heldout_rms.translation")
    forecasts = shown.evaluate("window.forecasts")
    assert forecasts  # it was there before the refit
    assert forecasts[0] == pytest.approx(refit, rel=0.1)
    assert shown.locator("#error").inner_text() != text
    assert shown.evaluate("Array.from(stiffcal.ghost.move)") == before
    assert "stale" in shown.locator("#candidates").get_attribute("class")
    assert shown.evaluate(TOP_OF_PICTURE) == top  # buttons that come have their room before
    # what has been added is called missing nowhere
    assert shown.evaluate("[stiffcal.data.suspects, stiffcal.data.suspected]") == [[], []]
    assert shown.evaluate("stiffcal.data.evidence.map((one) => one.standing)") == ["added"]
    assert any(model.startswith("tried") for model in shown.evaluate("stiffcal.data.models.map((model) => model.id)"))
    # what is grey can be read, and a button fits the scale to what is shown
    assert shown.evaluate("getComputedStyle(document.getElementById('candidates')).opacity") == "1"
    wide = shown.evaluate(SCALE)
    shown.get_by_role("button", name="Rescale").click()
    _waited(shown)
    narrow = shown.evaluate(SCALE)
    assert narrow[1] - narrow[0] < wide[1] - wide[0]
    # untick, and it comes back
    shown.locator("#undo").click()
    _waited(shown)
    assert shown.evaluate("Array.from(stiffcal.residual().move)") == before
    # its rung stands in place of the linear refit: of one model there is one error
    kinds = shown.evaluate("stiffcal.data.models.map((model) => model.id.startsWith('tried') ? 'tried' : model.kind)")
    assert (kinds.count("tried"), kinds.count("all"), len(kinds)) == (1, 0, rungs)
    # a diagnosis of what is shown
    shown.locator(f"#candidates input[data-effect='{EFFECT}']").check()
    _waited(shown)
    shown.locator("#diagnose").click()
    _waited(shown)
    assert "stale" not in (shown.locator("#candidates").get_attribute("class") or "")
    # the same model: where its points were stays, and the effect, no candidate any more, can be unticked
    assert shown.evaluate("Array.from(stiffcal.ghost.move)") == before
    assert shown.locator(f"#candidates input[data-effect='{EFFECT}']").count() == 0
    assert shown.locator(f"#in-model input[data-effect='{EFFECT}']").is_checked()
    shown.locator("#write").click()
    _waited(shown)
    assert "6" in (folder / "model.toml").read_text("utf-8")
    assert shown.evaluate("stiffcal.wanted.added.length") == 0
    assert shown.evaluate("stiffcal.data.effects.map((effect) => effect.name)").count(EFFECT) == 1
    # the same model of the same data was diagnosed: nothing is grey, and nothing has to be diagnosed again
    assert shown.evaluate("[stiffcal.data.is_diagnosed, stiffcal.data.diagnosis_of]") == [True, ""]
    assert shown.locator("#diagnose").is_disabled()


def test_a_campaign_that_was_never_diagnosed_is_diagnosed_on_the_page(browser: Any, tmp_path: Path) -> None:
    folder = write_small_campaign(tmp_path / "small", poses=4)
    model = folder / "model.toml"
    model.write_text(model.read_text("utf-8").replace("4, 5, 6]", "4, 5]"), encoding="utf-8")
    with served(browser, folder) as shown:
        assert shown.locator("#candidates input").count() == 0
        shown.get_by_role("button", name="Diagnose", exact=True).click()
        _waited(shown)
        candidate = shown.locator(f"#candidates input[data-effect='{EFFECT}']")
        candidate.wait_for()
        assert shown.get_by_role("button", name="Diagnose again").is_disabled()
        # what the diagnosis reads of the missing effect is shown
        assert shown.evaluate("[stiffcal.state.x, stiffcal.state.y]") == ["torque6", "r.e1"]


def test_states_are_left_out_and_taken_back(live_page: tuple[Any, Path]) -> None:
    shown, folder = live_page
    used = "Array.from(stiffcal.data.states.used).filter(Boolean).length"
    count, manifest = shown.evaluate(used), (folder / "campaign.toml").read_bytes()
    axes = shown.evaluate("[stiffcal.state.x, stiffcal.state.y]")
    shown.evaluate("stiffcal.select([3, 4, 8])")
    robot = "document.getElementById('robot').getBoundingClientRect().top"
    shown.evaluate("document.getElementById('robot').scrollIntoView()")
    looked_at = shown.evaluate(robot)
    shown.evaluate("document.getElementById('leave-out').click()")  # from where the page is
    _waited(shown)
    assert shown.evaluate(robot) == pytest.approx(looked_at, abs=1.0)
    assert shown.evaluate(used) == count - 3
    # the lines of what is out stay, whatever is selected next; nothing is taken back where nothing is out
    left = shown.locator("#exclude").inner_text()
    shown.evaluate("stiffcal.select([12])")
    shown.evaluate("stiffcal.drawNow()")
    assert left in shown.locator("#exclude").inner_text()
    assert shown.locator("#exclude").inner_text().count("[[exclude]]") == left.count("[[exclude]]") + 1
    shown.evaluate("stiffcal.select([])")
    assert (folder / "campaign.toml").read_bytes() == manifest
    shown.locator("#take-back").click()
    _waited(shown)
    assert shown.evaluate(used) == count
    assert shown.locator("#take-back").is_disabled()
    assert shown.evaluate("[stiffcal.state.x, stiffcal.state.y]") == axes


def test_a_model_that_somebody_changed_is_asked_about(live_page: tuple[Any, Path]) -> None:
    shown, folder = live_page
    file = folder / "model.toml"
    file.write_text(file.read_text("utf-8") + "# a remark\n", encoding="utf-8")
    shown.locator(f"#candidates input[data-effect='{EFFECT}']").check()
    _until(shown, "stiffcal.modelChanged")
    assert "model.toml was changed" in shown.locator("#error-hint").inner_text()
    shown.get_by_role("button", name="write the ticks into it").click()
    _waited(shown)
    text = file.read_text("utf-8")
    assert "# a remark" in text
    assert "6" in text


def test_two_pages_of_one_server_wait_for_each_other(live_page: tuple[Any, Path]) -> None:
    shown, _ = live_page
    other = shown.context.new_page()
    other.goto(shown.url)
    other.wait_for_selector("body[data-ready]")
    before = other.locator("#error").inner_text()
    shown.evaluate(f"stiffcal.want({{ added: ['{EFFECT}'] }})")
    other.evaluate("stiffcal.want({ removed: ['joint-compliance j5'] })")
    for page in (shown, other):
        _waited(page)
    texts = [page.locator("#error").inner_text() for page in (shown, other)]
    assert before not in texts
    assert len({*texts}) == 2
