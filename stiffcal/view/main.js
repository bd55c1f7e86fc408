(async function (S) {
  const say = (text) => {
    document.getElementById("status").textContent = S.visible(text);
  };
  const bar = document.getElementById("bar"),
    readingsOf = document.getElementById("readings"),
    chosen = document.getElementById("chosen");

  /** What a choice needs next to its text, in pixels. */
  const ARROW = 32;
  function controls() {
    const { data } = S;
    const model = S.choice("", [], (value) => S.set({ model: value, off: [] }));
    model.select.setAttribute("aria-label", "Model shown in all panels");
    const clear = S.button({ onclick: () => S.select([]) }, "Clear the selection");
    const count = S.make("span", { id: "count", role: "status" });
    bar.append(model.element);
    const pen = S.make("canvas").getContext("2d");
    let listed = "";
    chosen.append(count, " ", clear);
    S.onChange(() => {
      const shown = data.models.filter(S.isDrawable);
      const { font, maxWidth } = getComputedStyle(model.select),
        room = parseFloat(maxWidth) - ARROW;
      pen.font = font;
      const texts = shown.map((entry) => S.fitting(pen, [entry.label, entry.short].map(S.visible), room));
      const key = JSON.stringify(shown.map((entry, k) => [entry.id, texts[k]])),
        option = (entry, k) => S.make("option", { value: entry.id, title: S.visible(entry.label) }, texts[k]);
      if (key !== listed) model.select.replaceChildren(...shown.map(option));
      listed = key;
      model.select.value = S.state.model;
      clear.hidden = !S.nSelected;
      count.textContent = [
        ...(S.nSelected ? [`${S.count(S.nSelected)} of ${S.count(S.n)} drawn states selected`] : []),
        ...(data.n_states > S.n ? [`shown ${S.count(S.n)} of ${S.count(data.n_states)}; errors are of all`] : []),
      ].join("; ");
    });
  }

  /** Build the panels of a part of the data. @param {number} part */
  function build(part) {
    const data = S.use(part),
      drawable = data.models.filter(S.isDrawable);
    S.reset(S.part);
    document.getElementById("panels").replaceChildren();
    bar.replaceChildren();
    readingsOf.replaceChildren();
    chosen.replaceChildren();
    if (S.parts.length > 1) {
      const readings = S.choice(
        "Readings",
        S.parts.map((entry, k) => [String(k), S.partName(entry)]),
        (value) => {
          S.setAddress(`#part=${value}`);
          build(Number(value));
          S.redraw();
          readingsOf.querySelector("select").focus();
        },
      );
      readings.select.value = String(S.part);
      readingsOf.append(readings.element);
    }
    S.state.model = (data.models.find((entry) => entry.present) || data.models[0] || { id: "" }).id;
    S.ghost = S.hollow = null;
    S.startTryout();
    if (S.n && drawable.length) {
      S.readHash();
      controls();
      S.againstPanel();
      S.ladderPanel();
      if (!S.scalar && data.runs.some((run) => run.chain.length)) S.robotPanel();
      S.effectsPanel();
      S.matrixPanel();
      S.compliancePanel();
      S.readingPanel();
    } else if (data.models.length) {
      S.ladderPanel();
    }
    S.kindPanels();
    S.onChange(() => {
      if (document.body.dataset.ready) return;
      document.body.dataset.ready = String(Math.round(performance.now()));
      say("");
    });
  }
  /** Where each state of the data stands in other data of the same campaign, by run and row; −1 where it is not there. */
  function statesIn(other) {
    const name = (data, i) => JSON.stringify([data.runs[data.states.run[i]].name, data.states.row[i]]);
    const places = new Map(Array.from(other.states.run, (_, i) => [name(other, i), i]));
    return Array.from({ length: S.n }, (_, i) => places.get(name(S.data, i)) ?? -1);
  }
  /** Three numbers of each state, of the states that other data hold. */
  function inOrder(values, places) {
    const at = (k) => places[(k / 3) | 0];
    return values && Float64Array.from({ length: 3 * places.length }, (_, k) => (at(k) < 0 ? NaN : values[3 * at(k) + (k % 3)]));
  }

  /** Axes that were chosen and that what is shown has not (where rows are left out): they come back when it has them. */
  let lost = null;
  const axesOf = ({ x, y }) => ({ x, y });
  const heightOf = (element) => element.getBoundingClientRect().height;
  /** The panel that most of the window shows; the function that is returned scrolls to where it stands then. @returns {() => void} */
  function inView() {
    const sheet = document.getElementById("page"),
      window = sheet.getBoundingClientRect();
    if (!sheet.scrollTop) return () => {};
    const shown = [...document.querySelectorAll("#panels > section")].map((panel) => {
      const { top, bottom, width } = panel.getBoundingClientRect();
      return { id: panel.id, top, area: width * (Math.min(bottom, window.bottom) - Math.max(top, window.top)) };
    });
    const { id, top } = shown.reduce((most, one) => (one.area > most.area ? one : most), { id: "", top: 0, area: 0 });
    return () => {
      const now = document.getElementById(id);
      if (now) sheet.scrollTop += now.getBoundingClientRect().top - top;
    };
  }
  /** Show new data of the same campaign: what was shown stays as a ghost, and points move. @param {any} data */
  S.showContent = function (data) {
    const before = { ...S.state },
      old = S.data,
      earlier = S.ghost,
      shown = S.asGhost();
    const panels = document.getElementById("panels"),
      anchor = inView();
    const open = [...panels.querySelectorAll("details[open]")].map((entry) => entry.closest("section").id + entry.className);
    // a shorter verdict leaves its room: what stands below stays where it was
    summary.style.minHeight = `${heightOf(summary)}px`;
    S.take(data);
    build(before.part);
    const present = S.data.models.find((entry) => entry.present);
    const isLost = lost && lost.shown.x === before.x && lost.shown.y === before.y,
      wanted = isLost ? lost.wanted : axesOf(before);
    Object.assign(S.state, before, wanted, { model: present ? present.id : before.model, off: [], mode: "part" });
    S.repair();
    const axes = axesOf(S.state);
    lost = axes.x === wanted.x && axes.y === wanted.y ? null : { wanted, shown: axes };
    for (const entry of panels.querySelectorAll("details")) entry.open = open.includes(entry.closest("section").id + entry.className);
    showVerdict(data);
    // a diagnosis shows the same model again: its points stay, and so does where they were before it
    const isSame = Boolean(present && earlier && present.id === before.model),
      ghost = isSame ? earlier : shown;
    if (ghost && S.n) {
      const places = statesIn(old),
        placed = { ...ghost, move: inOrder(ghost.move, places), turn: inOrder(ghost.turn, places) };
      if (isSame) S.ghost = placed;
      else S.moveFrom(placed);
    }
    // drawn before the next picture, those outside the window too: no panel changes its height later
    S.drawNow();
    anchor();
  };
  /** A live page has a button for what the verdict of a page by itself names a command for. */
  function showVerdict(data) {
    const open = data.live && !data.is_diagnosed;
    const verdict = `${data.verdict} ${data.in_model} ${S.whyOther(data)}`;
    const words = open ? "Not diagnosed yet: Diagnose, above, finds what is missing." : verdict;
    document.getElementById("verdict").textContent = S.unbroken(S.visible(words.trim()));
  }
  const summary = document.getElementById("summary"),
    whole = S.button({ className: "more", "aria-expanded": "false", "aria-controls": "summary" }, "all of it");
  whole.onclick = () => {
    const isOpen = summary.classList.toggle("open");
    whole.setAttribute("aria-expanded", String(isOpen));
    whole.textContent = isOpen ? "less" : "all of it";
  };
  summary.after(whole);
  new ResizeObserver(() => {
    whole.hidden = !summary.classList.contains("open") && summary.scrollHeight <= summary.clientHeight + 4;
  }).observe(summary);
  const partOfHash = () => Number(new URLSearchParams(location.hash.slice(1)).get("part")) || 0;

  try {
    if (typeof DecompressionStream === "undefined") throw new Error("this browser cannot unpack the data; a version from 2023 or later can");
    S.take(await S.unpacked(document.getElementById("data").textContent));
    S.readTheme();
    const data = S.parts[0];
    document.title = S.visible(`${data.campaign}: stiffcal view`);
    document.getElementById("title").textContent = S.visible(`${data.robot}, campaign ${data.campaign}`);
    build(partOfHash());
    showVerdict(data);
    addEventListener("hashchange", () => {
      if (partOfHash() !== S.part) build(partOfHash());
      else if (S.n) S.readHash();
      S.redraw();
    });
    addEventListener("resize", () => {
      summary.style.minHeight = "";
      S.redraw();
    });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
      S.readTheme();
      S.redraw();
    });
    S.redraw();
    S.startLive?.();
  } catch (error) {
    say(`The page cannot be shown: ${error.message}`);
    document.body.dataset.failed = "true";
    throw error;
  }
})(stiffcal);
