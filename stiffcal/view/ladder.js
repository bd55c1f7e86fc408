(function (S) {
  const ROW = 26;

  /** The fit to compare with: the first one of these states, so that all steps count; of a refit the present fit. */
  function before(model) {
    const fits = S.data.models.filter((entry) => entry.kind === "fit");
    if (model.kind !== "fit") return fits.find((entry) => entry.present);
    const first = fits.findIndex(S.isDrawable), chosen = fits.indexOf(model);
    return fits[first >= 0 && chosen > first ? first : chosen - 1];
  }

  S.ladderPanel = function () {
    const { data } = S;
    // where no model has residuals of states, all can be compared by their errors and parameters
    const none = !data.models.some(S.isDrawable), selectable = (model) => Boolean(model) && (none || S.isDrawable(model));
    const rows = () => [
      { name: "no model", value: S.main(data.zero), text: S.error(data.zero), grey: true },
      ...data.models.filter((model) => model.kind !== "without").map((model) => ({
        id: model.id, name: model.kind === "fit" ? model.label : `with ${model.effect}`, value: S.main(model.heldout_rms) ?? S.main(model.fit_rms),
        second: S.main(model.fit_rms), text: S.error(S.main(model.heldout_rms) !== null ? model.heldout_rms : model.fit_rms) + (S.main(model.heldout_rms) !== null ? "" : " (fit)"),
        grey: !selectable(model), chosen: model.id === S.state.model,
      })),
    ];
    const height = 44 + ROW * rows().length;
    const panel = S.panel({
      id: "ladder", title: "3 Ladder of models", height,
      about: `Error ${S.leftOut()} (bars) and of the fit (frames), all states; logarithmic. A click, or up and down arrows, shows a model in all panels. Grey: the store does not hold its predictions.`,
      draw, table: list, key, depends: S.shownKey,
    });
    let find = () => -1;
    const choose = (id) => { if (selectable(S.modelById.get(id))) S.set({ model: id, off: [] }); };
    panel.canvas.addEventListener("click", (event) => {
      const row = rows()[find(event.clientY - panel.canvas.getBoundingClientRect().top)];
      if (row && row.id) choose(row.id);
    });
    function key(event) {
      const ids = rows().filter((row) => row.id && !row.grey).map((row) => row.id), k = ids.indexOf(S.state.model);
      if (event.key === "ArrowDown" && k + 1 < ids.length) choose(ids[k + 1]);
      else if (event.key === "ArrowUp" && k > 0) choose(ids[k - 1]);
      else return false;
      return true;
    }
    const numbers = S.make("p", { id: "ladder-numbers", className: "numbers", "aria-live": "polite" });
    const values = S.make("table", { id: "values" });
    panel.section.insertBefore(numbers, panel.details);
    panel.section.insertBefore(S.make("div", { className: "scroll", tabIndex: 0, role: "region", "aria-label": "Parameters before and after" }, values), panel.details);

    let listed = "";
    function draw(canvas) {
      const { g, width } = S.begin(canvas);
      find = S.bars(g, width, rows(), { top: 34, rowHeight: ROW, log: true, line: S.main(data.noise) || 0, lineLabel: `noise ${S.size(S.main(data.noise))}` });
      const model = S.modelById.get(S.state.model);
      if (!model) return data.refits_missing;
      numbers.textContent = S.visible(`${model.label}: ${S.error(model.heldout_rms)} rms ${S.leftOut()}${model.fit_rms ? `, ${S.error(model.fit_rms)} of the fit` : ""}; noise ${S.error(data.noise)}.`);
      numbers.dataset.heldout = String(S.main(model.heldout_rms) ?? "");
      numbers.dataset.fit = String(S.main(model.fit_rms) ?? "");
      if (listed !== model.id) { listed = model.id; compare(model, before(model)); }
      return data.refits_missing ? `Candidates of the diagnosis: ${data.refits_missing}` : "";
    }

    function compare(model, earlier) {
      const old = new Map((earlier ? earlier.values : []).map((entry) => [entry.name, entry]));
      if (!model.values.length) {
        S.fill(values, ["parameter"], [], `The store holds no values of this model${model.kind === "without" ? ": refits without an effect are stored by their residuals" : ""}.`);
        return;
      }
      const names = [...new Set([...old.keys(), ...model.values.map((entry) => entry.name)])];
      const now = new Map(model.values.map((entry) => [entry.name, entry]));
      const words = (entry) => {
        if (!entry) return "not in the model";
        if (entry.value === null) return "not identified";
        const low = entry.low !== null ? entry.value - entry.low : NaN, high = entry.high !== null ? entry.high - entry.value : NaN;
        const half = Number.isFinite(low + high) ? Math.max(low, high) : NaN;
        return S.withHalf(entry.value, half);
      };
      const rows = names.map((name) => {
        const a = old.get(name), b = now.get(name);
        const change = a && b && a.value && b.value !== null ? S.percent(b.value / a.value - 1) : "–";
        return earlier ? [name, words(a), words(b), change, (b || a).unit] : [name, words(b), b.unit];
      });
      const short = (entry) => (entry.kind === "fit" ? `fit ${entry.id.slice(3)}` : entry.label);
      const head = earlier ? ["parameter", `before: ${short(earlier)}`, `after: ${short(model)}`, "change", "unit"] : ["parameter", short(model), "unit"];
      S.fill(values, head, rows,
        `Stiffness and other parameters; ± is 95 %.${model.kind === "with" ? " Candidates are linear refits; intervals come with stiffcal add and identify." : ""}`);
    }

    function list() {
      const unit = S.si();
      return {
        head: ["model", `held-out rms [${unit}]`, ...(S.data.rotation ? ["held-out rms [rad]"] : []), `fit rms [${unit}]`, ...(S.data.rotation ? ["fit rms [rad]"] : []), "show"],
        rows: data.models.map((model) => [model.label, ...[model.heldout_rms, model.fit_rms].flatMap((rms) => [S.main(rms) ?? NaN, ...(S.data.rotation ? [rms?.rotation ?? NaN] : [])]),
          selectable(model) ? S.make("button", { type: "button", onclick: () => S.set({ model: model.id, off: [] }), "aria-label": S.visible(`Show ${model.label}`) }, "show") : "not stored"]),
      };
    }
  };
})(stiffcal);
