(async function (S) {
  const say = (text) => { document.getElementById("status").textContent = S.visible(text); };
  const bar = document.getElementById("bar");

  /** Buttons from the present model to the one with all that is missing, and back. */
  function steps() {
    const { data } = S, present = data.models.find((model) => model.present), all = data.models.find((model) => model.kind === "all" && S.isDrawable(model));
    if (!present || !all || !S.isDrawable(present)) return [];
    const button = (model, text) => {
      const made = S.button({ className: "step", onclick: () => S.set({ model: model.id, off: [] }) }, `${text}: ${S.error(model.heldout_rms)}`);
      S.onChange(() => made.setAttribute("aria-pressed", String(S.state.model === model.id && !S.state.off.length)));
      return made;
    };
    return [S.make("span", { className: "steps", role: "group", "aria-label": "Error before and after adding what is missing" },
      button(present, "Present model"), "→", button(all, `With ${all.effect}`)), S.make("span", {}, `noise ${S.error(data.noise)}`)];
  }

  function controls(drawable) {
    const { data } = S;
    const model = S.choice("Model shown in all panels", drawable.map((entry) => [entry.id, entry.label]), (value) => S.set({ model: value, off: [] }));
    const clear = S.button({ onclick: () => S.select([]) }, "Clear the selection");
    const count = S.make("span", { id: "count", role: "status" });
    bar.append(...steps(), model.element, clear, count);
    S.onChange(() => {
      model.select.value = S.state.model;
      count.textContent = `${S.count(S.nSelected)} of ${S.count(S.n)} drawn states selected` + (data.n_states > S.n ? `; shown ${S.count(S.n)} of ${S.count(data.n_states)}; errors are of all` : "");
    });
  }

  /** Build the panels of a part of the data. @param {number} part */
  function build(part) {
    const data = S.use(part), drawable = data.models.filter(S.isDrawable);
    S.reset(S.part);
    document.getElementById("panels").replaceChildren();
    bar.replaceChildren();
    if (S.parts.length > 1) {
      const readings = S.choice("Readings", S.parts.map((entry, k) => [String(k), S.partName(entry)]), (value) => { history.replaceState(null, "", `#part=${value}`); build(Number(value)); S.redraw(); bar.querySelector("select").focus(); });
      readings.select.value = String(S.part);
      bar.append(readings.element);
    }
    S.state.model = (data.models.find((entry) => entry.present) || data.models[0] || { id: "" }).id;
    if (S.n && drawable.length) {
      S.readHash();
      controls(drawable);
      if (!S.scalar && data.runs.some((run) => run.chain.length)) S.robotPanel();
      S.againstPanel();
      S.ladderPanel();
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
  const partOfHash = () => Number(new URLSearchParams(location.hash.slice(1)).get("part")) || 0;

  try {
    if (typeof DecompressionStream === "undefined") throw new Error("this browser cannot unpack the data; a version from 2023 or later can");
    await S.load();
    S.readTheme();
    const data = S.parts[0];
    document.title = S.visible(`${data.campaign}: stiffcal view`);
    document.getElementById("title").textContent = S.visible(`${data.robot}, campaign ${data.campaign}`);
    document.getElementById("verdict").textContent = S.visible(data.verdict);
    build(partOfHash());
    addEventListener("hashchange", () => { if (partOfHash() !== S.part) build(partOfHash()); else if (S.n) S.readHash(); S.redraw(); });
    addEventListener("resize", S.redraw);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { S.readTheme(); S.redraw(); });
    S.redraw();
  } catch (error) {
    say(`The page cannot be shown: ${error.message}`);
    document.body.dataset.failed = "true";
    throw error;
  }
})(stiffcal);
