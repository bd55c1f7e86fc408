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
    let folded = true;
    const standing = new Map(data.candidates.map((entry) => [entry.name, entry.standing]));
    const isRejected = (model) => model.kind === "with" && standing.get(model.effect) === "rejected";
    const VERDICT = { alike: ", cannot be distinguished", undecided: ", undecided", possible: ", possible", rejected: ", rejected" };
    const standingOf = (model) => (model.kind === "with" ? VERDICT[standing.get(model.effect)] ?? "" : "");
    /** The scale ends at the worst model; without any model the error may be much larger, and its bar is cut off. */
    const mostOf = () => Math.max(...data.models.map((model) => Math.max(S.main(model.heldout_rms) ?? 0, S.main(model.fit_rms) ?? 0)), S.main(data.noise) || 0);
    const rows = () => [
      { name: "no model", value: S.main(data.zero), text: S.error(data.zero), grey: true },
      ...data.models.filter((model) => model.kind !== "without" && !(folded && isRejected(model))).map((model) => ({
        id: model.id, name: model.kind === "fit" ? model.label : `${model.kind === "all" ? "all missing: " : "with "}${model.effect}${standingOf(model)}`, value: S.main(model.heldout_rms) ?? S.main(model.fit_rms),
        second: S.main(model.fit_rms), text: S.error(S.main(model.heldout_rms) !== null ? model.heldout_rms : model.fit_rms) + (S.main(model.heldout_rms) !== null ? "" : " (fit)"),
        grey: !selectable(model), chosen: model.id === S.state.model,
      })),
    ];
    const height = 44 + ROW * rows().length;
    const unfold = S.check("rejected candidates too", false, (on) => { folded = !on; panel.canvas.style.height = `${44 + ROW * rows().length}px`; S.frame++; S.redraw(); });
    unfold.element.hidden = !data.models.some(isRejected);
    const panel = S.panel({
      id: "ladder", title: "3 Ladder of models", height,
      about: `Error ${S.leftOut()} (bars) and of the fit (frames), all states. Choose a model to show it in all panels.${data.models.every(selectable) ? "" : " Grey: the store does not hold its predictions."}`,
      how: "A click, or up and down arrows: show a model in all panels. The table below has a button for each.",
      controls: [unfold], draw, table: list, key, depends: () => `${S.shownKey()}/${folded}`,
    });
    let find = () => -1;
    const choose = (id) => { if (selectable(S.modelById.get(id))) S.set({ model: id, off: [] }); };
    panel.canvas.addEventListener("click", (event) => {
      const row = rows()[find(event.offsetY)];
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
      find = S.bars(g, width, rows(), { top: 34, rowHeight: ROW, most: mostOf(), line: S.main(data.noise) || 0, lineLabel: `noise ${S.size(S.main(data.noise))}` });
      const model = S.modelById.get(S.state.model);
      if (!model) return data.refits_missing;
      numbers.textContent = S.visible(`${model.label}: ${S.error(model.heldout_rms)} rms ${S.leftOut()}${model.fit_rms ? `, ${S.error(model.fit_rms)} of the fit` : ""}; noise ${S.error(data.noise)}.`);
      numbers.dataset.heldout = String(S.main(model.heldout_rms) ?? "");
      numbers.dataset.fit = String(S.main(model.fit_rms) ?? "");
      if (listed !== model.id) {
        // of a first fit the table shows what follows: all that is missing added
        const earlier = before(model), all = data.models.find((entry) => entry.kind === "all" && entry.values.length);
        listed = model.id;
        if (!earlier && all && model.present) compare(all, model); else compare(model, earlier);
      }
      const present = data.models.find((entry) => entry.present), own = S.main(present?.heldout_rms), judged = S.main(data.diagnosed);
      const other = own > 0 && judged > 0 && Math.abs(judged / own - 1) > 0.02 && data.models.some((entry) => entry.kind === "with" || entry.kind === "all");
      return (data.refits_missing ? `Candidates of the diagnosis: ${data.refits_missing}.` : "") + (other ? `The diagnosis leaves out other groups of poses than the fits' errors do; the present fit has ${S.error(data.diagnosed)} there, which candidates compare with.` : "");
    }

    function compare(model, earlier) {
      const old = new Map((earlier ? earlier.values : []).map((entry) => [entry.name, entry]));
      if (!model.values.length) {
        S.fill(values, ["parameter"], [], `The store holds no values of this model${model.kind === "without" ? ": refits without an effect are stored by their residuals" : ""}.`);
        return;
      }
      // what only readings of another kind show stands on their page
      const elsewhere = new Set(S.parts.filter((part) => part !== S.data).flatMap((part) => part.effects.map((effect) => effect.name.replace(" ", "."))));
      const own = new Set(S.data.effects.map((effect) => effect.name.replace(" ", ".")));
      const isShown = (name) => { const effect = name.split(".").slice(0, 2).join("."); return own.has(effect) || !elsewhere.has(effect); };
      const names = [...new Set([...old.keys(), ...model.values.map((entry) => entry.name)])].filter(isShown);
      const now = new Map(model.values.map((entry) => [entry.name, entry]));
      // lengths and angles in the units of the page; of a stiffness that is N·m/rad and the like
      const scaleOf = (unit) => ({ m: S.units.length, rad: S.units.angle })[unit] || { factor: 1, unit };
      const words = (entry) => {
        if (!entry) return "not in the model";
        if (entry.value === null) return "not identified";
        const { factor } = scaleOf(entry.unit);
        const scaled = (end) => (end === null || !Number.isFinite(end) ? null : factor * end);
        return S.estimate(factor * entry.value, scaled(entry.low), scaled(entry.high));
      };
      const rows = names.map((name) => {
        const a = old.get(name), b = now.get(name);
        const change = a && b && a.value && b.value !== null ? `${(100 * (b.value / a.value - 1)).toFixed(1).replace(/^-0\.0$/, "0.0").replace("-", "−")} %` : "–";
        return earlier ? [name, words(a), words(b), change, scaleOf((b || a).unit).unit] : [name, words(b), scaleOf(b.unit).unit];
      });
      const short = (entry) => (entry.kind === "fit" ? `fit ${entry.id.slice(3)}` : entry.kind === "all" ? "all missing added" : entry.label);
      const head = earlier ? ["parameter", `before: ${short(earlier)}`, `after: ${short(model)}`, "change", "unit"] : ["parameter", short(model), "unit"];
      S.fill(values, head, rows,
        `Stiffness and other parameters; ± is 95 %.${model.kind === "with" ? " A candidate is a linear refit about the present fit: ± holds for the chosen shape; what is chosen among a few values has none, and makes the others' ± too narrow." : ""}`);
    }

    function list() {
      const unit = S.si();
      return {
        head: ["model", `rms ${S.leftOut()} [${unit}]`, ...(S.data.rotation ? [`rms ${S.leftOut()} [rad]`] : []), `fit rms [${unit}]`, ...(S.data.rotation ? ["fit rms [rad]"] : []), "show"],
        rows: [{ label: "no model", heldout_rms: data.zero, fit_rms: null }, ...data.models, { label: "noise", heldout_rms: data.noise, fit_rms: data.noise }].map((model) => [
          model.label, ...[model.heldout_rms, model.fit_rms].flatMap((rms) => [S.main(rms) ?? NaN, ...(S.data.rotation ? [rms?.rotation ?? NaN] : [])]),
          !model.id ? "–" : selectable(model) ? S.button({ onclick: () => S.set({ model: model.id, off: [] }), "aria-label": S.visible(`Show ${model.label}`) }, "show") : "not stored"]),
      };
    }
  };
})(stiffcal);
