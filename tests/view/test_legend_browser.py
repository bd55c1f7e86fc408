"""The legend of the residuals in a real browser: each button hides what it names and brings it back."""

from __future__ import annotations

from typing import Any

import pytest

from tests.laboratory.browser import settled

pytestmark = pytest.mark.browser


def test_each_button_of_the_legend_hides_points_and_brings_them_back(page: Any) -> None:
    points = """() => { const c = document.getElementById("against-canvas"), g = c.getContext("2d");
        return g.getImageData(0, 0, c.width, c.height).data.reduce((sum, value) => (31 * sum + value) | 0, 0); }"""
    page.evaluate("stiffcal.set({ x: 'torque2', y: 'r.x', colour: 'branch' })")
    settled(page)
    levels = page.evaluate("stiffcal.variableByName.get('branch').levels")
    buttons = page.locator("#against .legend button")
    whole = page.evaluate(points)
    assert buttons.all_inner_texts() == levels
    for k in range(buttons.count()):
        buttons.nth(k).click()
        settled(page)
        assert page.evaluate(points) != whole
        assert buttons.nth(k).get_attribute("aria-pressed") == "false"
        buttons.nth(k).click()
        settled(page)
        assert page.evaluate(points) == whole
    # a category of which no point is drawn has no button: it would do nothing
    page.evaluate(
        """() => { const branch = stiffcal.variableByName.get("branch").values;
        stiffcal.data.states.used = stiffcal.data.states.used.map((used, i) => (branch[i] === 1 ? 0 : used));
        stiffcal.select([0]); }"""
    )
    settled(page)
    assert buttons.all_inner_texts() == [levels[0], *levels[2:]]
