"""The page in a real browser: from a file, with the network off; every panel drawn, linked, inert to hostile names."""

from __future__ import annotations

import re
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stiffcal.commands.diagnose import diagnose_campaign
from stiffcal.commands.view import view_campaign
from stiffcal.view.page import build_page
from stiffcal.wording import significant
from tests.laboratory.browser import becomes, colours_of, opened, settled
from tests.laboratory.diagnosed_folders import WITHOUT_6, diagnosed_copy
from tests.laboratory.few_effects import few_effects
from tests.laboratory.small_campaign import write_small_campaign
from tests.laboratory.view_of_many_states import with_many_states

pytestmark = pytest.mark.browser

PANELS = ("robot", "against", "ladder", "effects", "poses", "compliance")


def test_every_panel_is_drawn(page: Any) -> None:
    for panel in PANELS:
        assert colours_of(page, panel) > 8, panel
    assert page.locator("#reading-table tbody tr").count() > 6


def test_a_model_of_the_ladder_shows_the_numbers_of_history(page: Any, content: Any) -> None:
    fits = content[1].fits
    page.evaluate("(id) => stiffcal.set({ model: id })", f"fit{fits[0].id}")
    settled(page)
    numbers = page.locator("#ladder-numbers")
    assert float(numbers.get_attribute("data-heldout")) == pytest.approx(fits[0].heldout_rms.translation, rel=1e-12)
    assert float(numbers.get_attribute("data-fit")) == pytest.approx(fits[0].fit_rms.translation, rel=1e-12)
    first = page.evaluate("Array.from(stiffcal.residual().move)")
    # a click on the row of the first candidate switches all panels
    page.get_by_label("all models").check()
    settled(page)
    order = ["no model", *(model.id for model in content[0].models if model.kind != "without")]
    chosen = next(model.id for model in content[0].models if model.kind == "with")
    box = page.locator("#ladder-canvas").bounding_box()
    page.locator("#ladder-canvas").click(position={"x": box["width"] / 2, "y": 34 + 26 * (order.index(chosen) + 0.5)})
    settled(page)
    assert page.evaluate("stiffcal.state.model") == chosen
    assert page.evaluate("Array.from(stiffcal.residual().move)") != first
    stated = next(model for model in content[0].models if model.id == chosen).heldout_rms
    assert float(numbers.get_attribute("data-heldout")) == pytest.approx(stated.translation, rel=1e-12)


def test_a_candidate_that_the_page_does_not_offer_is_folded_as_a_rejected_one(
    content: Any, browser: Any, tmp_path: Path
) -> None:
    """Of many rejected ones the page offers some; the others filled the ladder."""
    path = tmp_path / "view.html"
    path.write_text(build_page(replace(content[0], candidates=[])), encoding="utf-8")
    page, complaints = opened(browser, path)
    shown = [model for model in content[0].models if model.kind in ("fit", "all")]
    assert len(shown) + 3 < len(content[0].models)
    rows = (float(page.evaluate("parseFloat(document.getElementById('ladder-canvas').style.height)")) - 44) / 26
    assert rows == 1 + len(shown)
    assert complaints == []
    page.context.close()


def test_a_saved_picture_states_what_it_shows_of_which_model_and_when(page: Any) -> None:
    name = ("of a long name " * 6).strip()
    with page.expect_download() as saving:
        page.evaluate("(name) => { stiffcal.data.robot = name; }", name)
        page.locator("#robot").get_by_role("button", name="SVG").click()
    words = " ".join(re.findall(r"<text[^>]*>([^<]*)</text>", Path(saving.value.path()).read_text("utf-8")))
    campaign, model, day = page.evaluate(
        "[stiffcal.data.campaign, stiffcal.modelById.get(stiffcal.state.model).label, new Date().toISOString()]"
    )
    assert f"Robot {name}, campaign {campaign}; {model}; {day[:10]}" in words


def test_brushing_selects_in_all_panels_and_stands_in_the_address(page: Any, browser: Any) -> None:
    before = {panel: page.locator(f"#{panel}-canvas").screenshot() for panel in ("against", "compliance")}
    canvas = page.locator("#against-canvas")
    canvas.scroll_into_view_if_needed()
    box = canvas.bounding_box()
    page.mouse.move(box["x"] + 0.3 * box["width"], box["y"] + 40)
    page.keyboard.down("Shift")
    page.mouse.down()
    page.mouse.move(box["x"] + 0.9 * box["width"], box["y"] + 0.8 * box["height"], steps=3)
    page.mouse.up()
    page.keyboard.up("Shift")
    settled(page)
    chosen = page.evaluate("Array.from(stiffcal.selected.keys()).filter((i) => stiffcal.selected[i])")
    assert 0 < len(chosen) < page.evaluate("stiffcal.n")
    for panel, picture in before.items():
        assert page.locator(f"#{panel}-canvas").screenshot() != picture, panel
    rows = page.evaluate("(i) => i.map((k) => stiffcal.data.states.row[k])", chosen)
    lines = page.locator("#exclude").inner_text()
    assert all(str(int(row)) in lines for row in rows[:5])
    page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    page.get_by_role("button", name="Copy the lines").click()
    copied = tomllib.loads(page.evaluate("navigator.clipboard.readText()"))["exclude"]
    assert all(int(row) in {int(one) for entry in copied for one in entry["rows"]} for row in rows)
    again = page.context.new_page()
    again.goto(page.url)
    again.wait_for_selector("body[data-ready]")
    assert again.evaluate("Array.from(stiffcal.selected.keys()).filter((i) => stiffcal.selected[i])") == chosen


def test_numbers_are_those_of_python(page: Any, content: Any) -> None:
    states, effect = content[0].states, content[0].effects[0]
    model = next(entry for entry in content[0].models if entry.present)
    page.evaluate("(name) => stiffcal.set({ off: [name], mode: 'part', kind: 'heldout' })", effect.name)
    shown = np.array(page.evaluate("Array.from(stiffcal.residual().move)")).reshape(-1, 3)
    expected = (model.residual_heldout + effect.part)[:, :3]
    used = states.used
    assert np.nanmax(np.abs(shown - expected)[used]) < 0.02 * content[0].noise.translation
    rms = float(np.sqrt(np.nanmean(np.sum(expected[used] ** 2, axis=1))))
    assert page.evaluate("stiffcal.rms(stiffcal.residual().move)") == pytest.approx(rms, rel=1e-3)


def test_matrix_and_apparent_compliance_are_those_of_numpy(page: Any, content: Any) -> None:
    made, states = content[0], content[0].states
    model = next(entry for entry in made.models if entry.present)
    residual, part = model.residual_heldout[:, :3], made.effects[0].part[:, :3]
    direction = next(variable for variable in made.variables if variable.name == made.direction)

    def row(panel: str, number: int) -> list[float]:
        page.locator(f"#{panel} details.data summary").click()
        cells_of_row = page.locator(f"#{panel} table.behind tbody tr").nth(number).locator("td")
        cells_of_row.first.wait_for()
        cells = cells_of_row.all_inner_texts()
        return [float(cell.replace("−", "-")) for cell in cells]

    of_run = (states.run == 1) & states.used
    expected = [
        1e3 * np.sqrt(np.mean(np.sum(residual[of_run & (direction.values == k)] ** 2, axis=1)))
        for k in range(len(direction.levels))
    ]
    assert row("poses", 1) == pytest.approx(expected, rel=0.01)  # rounding, and three digits
    p, r = (values[of_run] - values[of_run].mean(axis=0) for values in (part, residual))
    half = 1.96 * made.noise.translation / np.sqrt(3.0 * np.sum(p**2))
    assert row("compliance", 1)[1:] == pytest.approx([1.0 + np.sum(p * r) / np.sum(p**2), half], rel=0.01)


def test_readings_of_two_kinds_have_pages_of_their_own(
    browser: Any, content: Any, friction_content: Any, tmp_path: Path
) -> None:
    file = tmp_path / "view.html"
    file.write_text(build_page(replace(content[0], others=[friction_content])), encoding="utf-8")
    page, complaints = opened(browser, file)
    assert not page.locator("#kind1").count()
    page.get_by_label("Readings").select_option("1")
    settled(page)
    present = next(model for model in friction_content.models if model.present)
    assert page.evaluate("stiffcal.main(stiffcal.data.noise)") == friction_content.noise.torque
    lines = page.locator("#exclude").inner_text()
    first, last = (page.evaluate(f"stiffcal.data.states.{end}_row[stiffcal.state.at]") for end in ("first", "last"))
    assert lines.startswith("# a pass is left out as a whole\n[[exclude]]")
    assert f'rows = ["{first}-{last}"]' in lines
    for panel in ("against", "ladder", "effects", "poses", "compliance", "kind1"):
        assert colours_of(page, panel) > 5, panel
    # numbers of the second kind are rounded by its own noise
    shown = np.array(page.evaluate("Array.from(stiffcal.residual().move)")).reshape(-1, 3)[:, 0]
    assert np.nanmax(np.abs(shown - present.residual_heldout[:, 0])) <= 0.01 * friction_content.noise.torque
    # a selection in one picture is one in the others: a reading of the kind's own picture, and back
    before = page.locator("#kind1-canvas").screenshot()
    page.evaluate("stiffcal.select(stiffcal.members[0])")
    settled(page)
    assert page.locator("#kind1-canvas").screenshot() != before
    page.locator("#kind1-canvas").focus()
    page.keyboard.press("ArrowRight")
    page.keyboard.press("Enter")
    settled(page)
    assert page.evaluate("stiffcal.nSelected") == 1
    again = page.context.new_page()
    again.goto(page.url)
    again.wait_for_selector("body[data-ready]")
    assert again.evaluate("stiffcal.data.measure") == "torque"
    assert again.evaluate("stiffcal.nSelected") == 1
    assert complaints == []
    page.context.close()


def test_a_step_with_all_that_is_missing(browser: Any, tmp_path: Path) -> None:
    folder = diagnosed_copy(WITHOUT_6, tmp_path / "small")
    diagnosis = diagnose_campaign(folder)
    assert diagnosis.heldout_rms_with_missing is not None
    view_campaign(folder)
    page, complaints = opened(browser, folder / "view.html")
    # the picture that is drawn first is what the diagnosis read of the missing effect
    assert page.evaluate("[stiffcal.state.x, stiffcal.state.y]") == ["torque6", "r.e1"]
    size = """(() => { const known = stiffcal.quantity("r.e1").values.filter(Number.isFinite);
        return Math.hypot(...known) / Math.sqrt(known.length); })()"""
    before = page.evaluate(size)
    page.locator("#candidates input[data-effect='joint-compliance j6']").check()
    settled(page)
    assert page.locator("#error").inner_text() == page.evaluate(
        "S => stiffcal.error(stiffcal.residual().model.heldout_rms)"
    )
    numbers = page.locator("#ladder-numbers")
    stated = diagnosis.heldout_rms_with_missing.translation
    assert float(numbers.get_attribute("data-heldout")) == pytest.approx(stated, rel=1e-12)
    assert page.evaluate("stiffcal.rms(stiffcal.residual().move)") == pytest.approx(stated, rel=0.02)
    assert page.evaluate(size) < 0.5 * before
    cells = page.locator("#values tbody tr", has_text="joint-compliance.j6.c").locator("td").all_inner_texts()
    assert cells[0] == "not in the model"
    assert "±" in cells[1]
    assert complaints == []
    page.context.close()


def test_an_effect_that_was_added_is_shown_before_and_after_on_one_scale(browser: Any, tmp_path: Path) -> None:
    folder = diagnosed_copy(WITHOUT_6, tmp_path / "small")
    model = folder / "model.toml"
    model.write_text(model.read_text("utf-8").replace("4, 5]", "4, 5, 6]"), encoding="utf-8")
    view_campaign(folder)
    page, complaints = opened(browser, folder / "view.html")
    assert page.evaluate("[stiffcal.state.x, stiffcal.state.y, stiffcal.state.sideBySide]") == ["torque6", "r.e1", 1]
    titles = page.locator("#against-note").inner_text()
    assert "fit 1" in titles
    assert "fit 2" in titles
    scale = "JSON.stringify(['x', 'y'].map((a) => stiffcal.locked(`${a} torque6 r.e1`, [0, 0])))"
    both = page.evaluate(scale)
    shades = {}
    for name, shown in (("before", "fit1"), ("after", "fit2")):
        page.get_by_role("button", name=name, exact=True).click()
        settled(page)
        assert page.evaluate("[stiffcal.state.model, stiffcal.state.sideBySide]") == [shown, 0]
        assert page.evaluate(scale) == both
        shades[name] = page.locator("#poses-note").inner_text()
    # colours too: the largest of the scale is the earlier model's in both
    assert shades["before"] == shades["after"]
    page.get_by_role("button", name="side by side").click()
    settled(page)
    assert page.evaluate("stiffcal.state.sideBySide") == 1
    assert complaints == []
    page.context.close()


def test_candidates_are_forecast_together_without_a_server(browser: Any, tmp_path: Path) -> None:
    folder = write_small_campaign(tmp_path / "small", poses=4)
    model = folder / "model.toml"
    whole = model.read_text("utf-8")
    model.write_text(whole.replace("1, 2, 3, 4, 5, 6]", "2, 3, 4, 5]"), encoding="utf-8")
    with few_effects():
        diagnose_campaign(folder)
        view_campaign(folder)
    page, complaints = opened(browser, folder / "view.html")
    names = page.evaluate("stiffcal.data.candidates.map((one) => one.name)")
    assert {"joint-compliance j1", "joint-compliance j6"} <= set(names)
    # the fit with both is what the forecast stands for; either refit alone leaves more than what is forecast of both
    everything = page.evaluate("stiffcal.data.models.find((one) => one.kind === 'all')")
    made = page.evaluate(
        """() => { const by = (name) => stiffcal.data.models.find((one) => one.kind === "with" && one.effect === name);
        const refits = ["joint-compliance j1", "joint-compliance j6"].map(by);
        const present = stiffcal.data.models.find((one) => one.present);
        return stiffcal.forecastOf(present, refits).heldout_rms.translation; }"""
    )
    assert sorted(everything["effect"].split(", ")) == ["joint-compliance j1", "joint-compliance j6"]
    single = next(one for one in page.evaluate("stiffcal.data.models") if one["effect"] == "joint-compliance j1")
    together = everything["heldout_rms"]["translation"]
    assert together < made < 0.8 * single["heldout_rms"]["translation"]
    assert made == pytest.approx(together, rel=0.3)
    # any two that have refits: ticked one after the other, a rung more
    rungs = page.evaluate("stiffcal.data.models.length")
    other = page.evaluate("stiffcal.data.models.filter((one) => one.kind === 'with').map((one) => one.effect)")
    ticked = [next(name for name in other if not name.startswith("joint-compliance")), "joint-compliance j6"]
    page.locator(".row button.more").first.click()
    for name in ticked:
        page.locator(f"#candidates input[data-effect='{name}']").check()
        settled(page)
    assert page.evaluate("stiffcal.data.models.length") == rungs + 1
    shown = page.evaluate("stiffcal.residual().model")
    assert shown["is_forecast"]
    assert sorted(shown["effect"].split(", ")) == sorted(ticked)
    # it is a rung that is shown, whatever the diagnosis says of each
    assert "undefined" not in page.locator("#ladder").inner_text()
    high = page.evaluate("document.getElementById('ladder-canvas').offsetHeight")
    page.evaluate("stiffcal.set({ model: stiffcal.presentModel().id })")
    settled(page)
    assert page.evaluate("document.getElementById('ladder-canvas').offsetHeight") < high
    assert complaints == []
    page.context.close()


def test_any_quantity_is_drawn_against_any_other(page: Any) -> None:
    page.evaluate("stiffcal.set({ x: 'component', y: 'r.all', colour: 'r.length' })")
    settled(page)
    assert colours_of(page, "against") > 8
    n = page.evaluate("stiffcal.n")
    page.locator("#against details.data summary").click()
    page.locator("#against table.behind td").first.wait_for()
    assert f"of {3 * n} rows" in page.locator("#against table.behind caption").inner_text()
    # a click on a point selects its state, whose three components then stand in the table
    page.locator("#against-canvas").focus()
    page.keyboard.press("Enter")
    settled(page)
    assert page.locator("#against table.behind tbody tr").count() == 3


def test_what_an_angle_explains_is_a_weighted_parabola(page: Any) -> None:
    # a joint that appears softer by 0.3 sin 2q over another joint's angle q, which no effect of the catalogue does
    rng = np.random.default_rng(1)
    angle, weight = rng.uniform(-80.0, 80.0, 12), rng.uniform(1.0, 4.0, 12)
    value = 1.0 + 0.3 * np.sin(np.radians(2.0 * angle)) + 0.02 * rng.standard_normal(12)
    left = value - np.polyval(np.polyfit(angle, value, 2, w=np.sqrt(weight)), angle)
    spread = value - np.average(value, weights=weight)
    expected = 1.0 - (weight @ left**2 / (12 - 3)) / (weight @ spread**2 / (12 - 1))
    given = [angle.tolist(), value.tolist(), weight.tolist()]
    assert page.evaluate("(given) => stiffcal.parabolaShare(...given)", given) == pytest.approx(expected, rel=1e-9)
    assert expected > 0.3
    # two angles of three poses each determine no parabola
    assert page.evaluate("stiffcal.parabolaShare([1, 1, 1, 2, 2, 2], [0, 1, 0, 1, 0, 1], [1, 1, 1, 1, 1, 1])") < 0.01


def test_a_share_is_measured_by_what_chance_explains(page: Any) -> None:
    # of random values over 12 poses, the best of two angles: the level is that of numpy's shuffles
    rng = np.random.default_rng(4)
    angles, values = rng.uniform(-80.0, 80.0, (2, 12)), 1.0 + 0.1 * rng.standard_normal(12)

    def share(angle: Any, value: Any) -> float:
        left = value - np.polyval(np.polyfit(angle, value, 2), angle)
        return float(max(0.0, 1.0 - (left @ left / 9) / np.var(value, ddof=1)))

    best = [max(share(angle, rng.permutation(values)) for angle in angles) for _ in range(2000)]
    script = """([angles, y]) => stiffcal.shareByChance((order) => Math.max(...angles.map((angle) =>
        stiffcal.parabolaShare(order.map((k) => angle[k]), y, y.map(() => 1)))), 12, 199)"""
    given = [angles.tolist(), values.tolist()]
    low, high = np.quantile(best, [0.9, 0.985])  # 199 shuffles: 0.95 ± 2 · 0.015
    assert low <= page.evaluate(script, given) <= high


def test_a_long_verdict_and_many_effects_leave_the_picture_in_a_small_window(
    browser: Any, content: Any, tmp_path: Path
) -> None:
    models = [replace(model, label=f"{model.label} + an effect of a long name" * 4) for model in content[0].models]
    long = replace(content[0], verdict="Torque over angle of joint 2: nothing is missing. " * 30, models=models)
    path = tmp_path / "view.html"
    path.write_text(build_page(long), encoding="utf-8")
    page, complaints = opened(browser, path, viewport={"width": 800, "height": 600})
    canvas = page.locator("#against-canvas")
    assert canvas.bounding_box()["y"] + 100 < 600
    # a place of an effect is shown whole, or not at all
    cut = """() => { const line = document.getElementById("in-model").getBoundingClientRect();
        return [...document.querySelectorAll("#in-model .check")].map((one) => one.getBoundingClientRect())
            .filter((box) => box.top < line.bottom - 1 && box.bottom > line.bottom + 1).length; }"""
    assert page.evaluate(cut) == 0
    # nor is the name of a model cut off: there is a shorter one
    names = page.evaluate("Array.from(document.querySelectorAll('#bar option'), (option) => option.text)")
    assert names == [model.short for model in models if model.residual_heldout is not None]
    page.get_by_role("button", name="all of it").click()
    assert becomes(page, "document.getElementById('against-canvas').getBoundingClientRect().top > 600")
    page.get_by_role("button", name="less").click()
    assert canvas.bounding_box()["y"] + 100 < 600
    assert complaints == []
    page.context.close()


def test_why_there_is_no_diagnosis_is_said_once(browser: Any, content: Any, tmp_path: Path) -> None:
    reason = "the last diagnosis is stale: run stiffcal diagnose"
    without = replace(content[0], verdict=reason, refits_missing=reason, is_diagnosed=False, candidates=())
    path = tmp_path / "view.html"
    path.write_text(build_page(without), encoding="utf-8")
    page, complaints = opened(browser, path)
    assert page.locator("body").inner_text().count(reason) == 1
    assert complaints == []
    page.context.close()


@pytest.mark.parametrize("value", [0.2, 0.9, 0.999, 3.0])
def test_the_line_of_the_noise_crosses_no_figure_of_the_ladder(page: Any, value: float) -> None:
    drawn = page.evaluate(
        """(value) => {
          const texts = [], at = [], width = (text) => 7 * text.length;
          const g = new Proxy({ measureText: (text) => ({ width: width(text) }), moveTo: (x) => at.push(x),
            fillText: (text, x) => texts.push([text, x, x + width(text)]),
          }, { get: (own, key) => own[key] ?? (() => {}) });
          stiffcal.bars(g, 400, [{ name: "fit", value, second: 0.9 * value, text: "0.0280 mm" }],
            { top: 0, rowHeight: 26, line: 1, most: 4, lineLabel: "noise" });
          return [texts.find(([text]) => text === "0.0280 mm"), at.at(-1)];
        }""",
        value,
    )
    (_, start, end), line = drawn
    assert not start <= line <= end
    assert end <= 400


def test_an_effect_in_the_bar_has_its_first_place_on_its_line(page: Any) -> None:
    tops = page.evaluate(
        """Array.from(document.querySelectorAll("#in-model .effect"), (effect) => {
            const words = document.createRange();
            words.selectNode(document.createTreeWalker(effect, NodeFilter.SHOW_TEXT).nextNode());
            const [name, first] = [words, effect.querySelector("input")].map((part) => part.getBoundingClientRect());
            return [effect.querySelector("input").closest(".group") !== null, Math.abs(name.y - first.y) < 12];
        })"""
    )
    assert tops
    assert all(all(pair) for pair in tops)


def test_points_of_one_level_are_spread_alike_now_before_and_as_forecast(page: Any) -> None:
    now, before, forecast = page.evaluate(
        """(() => {
        const drawn = [], real = document.createElement("canvas").getContext("2d");
        const noted = { arc: (x, y, r) => drawn.push([r, x]) };
        const g = new Proxy(real, {
            get: (on, key) => noted[key] ?? (typeof on[key] === "function" ? on[key].bind(on) : on[key]),
            set: (on, key, value) => Reflect.set(on, key, value),
        });
        const one = { label: "a", unit: "", sigma: 0 };
        const points = { across: { ...one, levels: ["p", "q"] }, up: { ...one, levels: [] }, count: stiffcal.n,
            stateOf: (p) => p, x: Array(stiffcal.n).fill(1), y: Array(stiffcal.n).fill(0.5) };
        const colours = { numbers: Array(stiffcal.n).fill(0), palette: ["#000"], scale: false };
        const { px } = stiffcal.drawPoints(g, { x: 50, y: 10, w: 300, h: 200 }, {
            points, colours, ends: { x: [-0.5, 1.5], y: [0, 1] }, ghost: points, hollow: points, moved: 1 });
        return [[...px], ...[1.6, 3].map((radius) => drawn.filter(([r]) => r === radius).map(([, x]) => x))];
    })()"""
    )
    assert before == now
    assert forecast == now


def test_numbers_are_written_as_in_terminal_and_report(page: Any) -> None:
    draw = np.random.default_rng(0)
    # halves, which Python rounds to even, and the edges of powers of ten
    numbers = [1.125, 0.125, 1.135, 2.5, 9995.0, 9985.0, 99.95, 999.6, 10000.0, 9.9999e-5, 5e-324, -1.7e308, 0.0]
    numbers += (draw.choice([-1.0, 1.0], 2000) * 10.0 ** draw.uniform(-12.0, 12.0, 2000)).tolist()
    assert page.evaluate("(all) => all.map(stiffcal.digits)", numbers) == [significant(number) for number in numbers]
    # an axis has two marks at least
    assert page.evaluate("stiffcal.ticks(-0.19, 0.19, 3.6)") == pytest.approx([-0.1, 0.0, 0.1])
    # a share that is next to nothing; rows are counted, not rounded
    assert page.evaluate("[stiffcal.percent(-6e-6), stiffcal.percent(0), stiffcal.percent(0.041)]") == [
        "< 0.1 %",
        "0 %",
        "4.10 %",
    ]
    # a model of a tool and rods
    rods = "(stiffcal.data.noise = { ...stiffcal.data.noise, length: 5e-7 }, stiffcal.ofRods({ length: 8.6e-6 }))"
    assert page.evaluate(rods) == "; at the rods 0.00860 mm, noise 0.000500 mm"
    assert page.evaluate("stiffcal.ofRods({ translation: 1e-5 })") == ""
    broken = "0.126 mm in 12 poses, 2 N·m, 99.5 to 100 %), 3 noisy rows"
    unbroken = "0.126\u00a0mm in 12 poses, 2\u00a0N·m, 99.5 to 100\u00a0%), 3 noisy rows"
    assert page.evaluate("(text) => stiffcal.unbroken(text)", broken) == unbroken
    filled = """() => { const table = document.createElement("table");
        stiffcal.fill(table, ["row", "rms"], [[12345, 0.25]], "");
        return Array.from(table.tBodies[0].rows[0].cells, (cell) => cell.textContent); }"""
    assert page.evaluate(filled) == ["12345", "0.250"]


@pytest.mark.parametrize(
    "change",
    ["stiffcal.set({ turn: stiffcal.state.turn + 0.02 })", "stiffcal.goTo(stiffcal.state.at + 1)"],
    ids=["orbit", "step"],
)
def test_frames_of_1200_states_are_quick_in_software(browser: Any, content: Any, tmp_path: Path, change: str) -> None:
    file = tmp_path / "view.html"
    file.write_text(build_page(with_many_states(content[0], 1200, 1200)), encoding="utf-8")
    page, complaints = opened(browser, file)
    assert int(page.evaluate("document.body.dataset.ready")) > 0
    script, rate = page.evaluate(
        f"""async () => {{ let script = Infinity, rate = 0;
        for (let window = 0; window < 40 && !(script <= 4 && rate >= 15); window++) {{
          const began = performance.now();
          for (let k = 0; k < 8; k++) {{
            {change};
            await new Promise((done) => requestAnimationFrame(() => setTimeout(done, 0)));
            script = Math.min(script, stiffcal.lastFrame);
          }}
          rate = Math.max(rate, 8000 / (performance.now() - began));
        }}
        return [script, rate]; }}"""
    )
    assert complaints == []
    # the best of several: what else runs on the machine makes frames longer, never shorter
    assert script <= 4.0
    assert rate >= 15.0
    page.context.close()


def test_a_page_of_20_000_states(browser: Any, content: Any, tmp_path: Path) -> None:
    file = tmp_path / "view.html"
    file.write_text(build_page(with_many_states(content[0], 5000, 20_000)), encoding="utf-8")
    assert file.stat().st_size <= 5_000_000
    ready = []
    for _ in range(3):
        page, complaints = opened(browser, file)
        ready.append(int(page.evaluate("document.body.dataset.ready")))
        assert complaints == []
        assert "shown 5 000 of 20 000" in page.locator("#count").inner_text().replace("\u202f", " ")
        page.context.close()
    assert min(ready) <= 3000


def test_the_first_picture_is_whole_in_a_small_window(page: Any) -> None:
    """With its axis, and not stretched; what the band is stands next to the categories, not among the points."""
    canvas = "document.getElementById('against-canvas')"
    drawn = f"{canvas}.height === Math.round({canvas}.clientHeight * devicePixelRatio)"
    for width, height in ((1400, 900), (800, 600)):
        page.set_viewport_size({"width": width, "height": height})
        whole = f"innerHeight === {height} && {canvas}.getBoundingClientRect().bottom <= innerHeight"
        assert becomes(page, f"{whole} && {drawn}"), (width, height)
    # what is above it grows: the picture takes less room, and is drawn anew
    high = page.evaluate(f"{canvas}.clientHeight")
    page.evaluate("document.getElementById('tryout').style.minHeight = '240px'")
    assert becomes(page, f"{canvas}.clientHeight < {high} && {drawn}")
    assert page.locator("#against .legend .band").is_visible()
