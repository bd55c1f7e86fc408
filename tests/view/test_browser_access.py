"""The page in a real browser: for every kind of readings, for everyone, and inert to hostile names."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stiffcal.commands.view import view_campaign
from stiffcal.presentation.pictures import Picture
from stiffcal.view.page import build_page
from tests.laboratory.browser import axe_findings, colours_of, opened, settled

pytestmark = pytest.mark.browser

HOSTILE = "</script><img src=x onerror=alert(1)>'\"\u202eevil"


def test_nothing_moves_by_itself_where_motion_is_to_be_reduced(page: Any) -> None:
    play = page.get_by_role("button", name="Play run")
    play.click()
    playing = page.get_by_role("button", name="Stop")
    assert playing.get_attribute("aria-pressed") == "true"
    page.emulate_media(reduced_motion="reduce")
    # stopped at once and out of sight; one state after another is still gone to by hand
    play = page.locator("button", has_text="Play run")
    play.wait_for(state="hidden")
    assert play.get_attribute("aria-pressed") == "false"
    before = page.evaluate("stiffcal.state.at")
    page.locator("#robot").get_by_role("button", name="Next state").click()
    assert page.evaluate("stiffcal.state.at") != before


def test_hostile_names_are_texts(browser: Any, content: Any, tmp_path: Path) -> None:
    runs = [replace(run, name=HOSTILE + run.name, files=[HOSTILE]) for run in content[0].runs]
    variables = [replace(v, levels=[HOSTILE + w for w in v.levels]) if v.levels else v for v in content[0].variables]
    hostile = replace(content[0], campaign=HOSTILE, robot=HOSTILE, runs=runs, variables=variables, joints=[HOSTILE] * 6)
    file = tmp_path / "view.html"
    file.write_text(build_page(hostile), encoding="utf-8")
    page, complaints = opened(browser, file)
    assert complaints == []
    assert page.locator("img").count() == 0
    assert HOSTILE.replace("\u202e", "\\u202e") in page.locator("#title").inner_text()
    assert "\u202e" not in page.locator("body").inner_text()


def test_a_friction_page_is_linked_and_axe_finds_nothing(browser: Any, friction_content: Any, tmp_path: Path) -> None:
    file = tmp_path / "view.html"
    file.write_text(build_page(friction_content), encoding="utf-8")
    page, complaints = opened(browser, file, bypass_csp=True)
    for panel in ("against", "ladder", "effects", "poses", "compliance", "kind1"):
        assert colours_of(page, panel) > 5, panel
    canvas = page.locator("#compliance-canvas")
    canvas.focus()
    page.keyboard.press("ArrowRight")
    page.keyboard.press("Enter")
    settled(page)
    # all bins of one speed
    chosen = page.evaluate("Array.from(stiffcal.selected.keys()).filter((i) => stiffcal.selected[i])")
    speeds = page.evaluate("(i) => i.map((k) => stiffcal.variableByName.get('speed').values[k])", chosen)
    assert len(chosen) > 3
    assert np.ptp(speeds) < 0.02
    assert axe_findings(page) == []
    assert complaints == []
    page.context.close()


def test_pictures_of_many_joints_are_shown_one_joint_at_a_time(
    browser: Any, friction_content: Any, tmp_path: Path
) -> None:
    page_of_kind = friction_content.pages[0]
    blocks = []
    for block in page_of_kind.blocks:
        if isinstance(block, Picture):
            panels = [replace(panel, joint=f"A{joint}") for joint in range(1, 20) for panel in block.panels]
            blocks.append(replace(block, panels=tuple(panels)))
        else:
            blocks.append(block)
    content = replace(friction_content, pages=[replace(page_of_kind, blocks=tuple(blocks))])
    file = tmp_path / "view.html"
    file.write_text(build_page(content), encoding="utf-8")
    page, complaints = opened(browser, file, bypass_csp=True)
    tabs = page.locator(".panel:not([hidden]) > .tabs").first
    assert tabs.get_by_role("button").all_inner_texts() == [f"A{joint}" for joint in range(1, 20)]
    pictures = page.locator("section[id^=kind]")
    shown = "Array.from(document.querySelectorAll('section[id^=kind]')).map((one) => !one.hidden)"
    each = pictures.count() // 19
    assert page.evaluate(shown) == [True] * each + [False] * 18 * each
    tabs.get_by_role("button", name="A19").click()
    settled(page)
    assert page.evaluate(shown) == [False] * 18 * each + [True] * each
    # whoever uses the keyboard stays where the buttons were
    assert page.evaluate("document.activeElement.innerText") == "A19"
    assert page.evaluate("document.activeElement.closest('section').id") == f"kind{18 * each + 1}"
    assert colours_of(page, f"kind{19 * each}") > 5
    assert axe_findings(page) == []
    assert complaints == []
    page.context.close()


def test_a_clamped_page_selects_the_states_of_a_sweep_and_axe_finds_nothing(browser: Any, tmp_path: Path) -> None:
    folder = tmp_path / "05"
    shutil.copytree(Path(__file__).parents[2] / "campaigns" / "joints" / "05", folder)
    view_campaign(folder)
    page, complaints = opened(browser, folder / "view.html", bypass_csp=True, color_scheme="dark")
    # one point of the torque-angle curve: states of that run, at that torque, of that direction
    page.locator("#kind1-canvas").focus()
    for _ in range(12):
        page.keyboard.press("ArrowRight")
    page.keyboard.press("Enter")
    settled(page)
    chosen = page.evaluate("Array.from(stiffcal.selected.keys()).filter((i) => stiffcal.selected[i])")
    runs = np.array(page.evaluate("Array.from(stiffcal.data.states.run)"))
    torques = np.array(page.evaluate("Array.from(stiffcal.variableByName.get('torque1').values)"))
    assert 1 <= len(chosen) < 0.1 * np.sum(runs == runs[chosen[0]])
    assert len(set(runs[chosen])) == 1
    assert np.ptp(torques[chosen]) < 0.05 * np.ptp(torques)
    assert "points are of selected states" in page.locator("#kind1-note").inner_text()
    assert axe_findings(page) == []
    assert complaints == []
    page.context.close()


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [390, 1280])
def test_axe_finds_nothing(browser: Any, file: Path, scheme: str, width: int) -> None:
    # our policy lets no other script in; here the tester's is let in
    page, _ = opened(browser, file, color_scheme=scheme, viewport={"width": width, "height": 900}, bypass_csp=True)
    assert axe_findings(page) == []
    # nothing is wider than the window
    assert page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
    page.context.close()


def test_a_page_that_cannot_unpack_says_so(browser: Any, file: Path) -> None:
    context = browser.new_context(offline=True)
    context.add_init_script("delete window.DecompressionStream")
    page = context.new_page()
    page.goto(file.as_uri())
    page.wait_for_selector("body[data-failed]")
    assert "cannot be shown" in page.locator("#status").inner_text()
