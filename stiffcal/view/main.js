(async function (S) {
  const say = (text) => { document.getElementById("status").textContent = S.visible(text); };
  try {
    if (typeof DecompressionStream === "undefined") throw new Error("this browser cannot unpack the data; a version from 2023 or later can");
    const data = await S.load();
    S.readTheme();
    document.title = S.visible(`${data.campaign}: stiffcal view`);
    document.getElementById("title").textContent = S.visible(`${data.robot}, campaign ${data.campaign}`);
    document.getElementById("verdict").textContent = S.visible(data.verdict);
    const drawable = data.models.filter(S.isDrawable);
    S.state.model = (data.models.find((entry) => entry.present) || data.models[0] || { id: "" }).id;
    if (S.n && drawable.length) {
      S.readHash();
      const model = S.choice("Model shown in all panels", drawable.map((entry) => [entry.id, entry.label]), (value) => S.set({ model: value, off: [] }));
      const clear = S.make("button", { type: "button", onclick: () => S.select([]) }, "Clear the selection");
      const count = S.make("span", { id: "count", role: "status" });
      document.getElementById("bar").append(model.element, clear, count);
      S.onChange(() => {
        model.select.value = S.state.model;
        count.textContent = `${S.count(S.nSelected)} of ${S.count(S.n)} drawn states selected` + (data.n_states > S.n ? `; shown ${S.count(S.n)} of ${S.count(data.n_states)}; errors are of all` : "");
      });
      if (!S.scalar && data.runs.some((run) => run.chain.length)) S.robotPanel();
      S.againstPanel();
      S.ladderPanel();
      S.effectsPanel();
      S.matrixPanel();
      S.compliancePanel();
      S.readingPanel();
      addEventListener("hashchange", () => { S.readHash(); S.redraw(); });
    } else if (data.models.length) {
      S.ladderPanel();
    }
    S.kindPanels();
    addEventListener("resize", S.redraw);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { S.readTheme(); S.redraw(); });
    S.onChange(() => {
      if (document.body.dataset.ready) return;
      document.body.dataset.ready = String(Math.round(performance.now()));
      say("");
    });
    S.redraw();
  } catch (error) {
    say(`The page cannot be shown: ${error.message}`);
    document.body.dataset.failed = "true";
    throw error;
  }
})(stiffcal);
