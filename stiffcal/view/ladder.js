(function (S) {
  const ROW = 26,
    TOP = 34,
    MOST = 5;
  const VERDICT = { alike: ", cannot be distinguished", undecided: ", undecided", possible: ", possible", rejected: ", rejected" };

  S.ladderPanel = function () {
    const { data } = S;
    // where no model has residuals of states, all can be compared by their errors and parameters
    const none = !data.models.some(S.isDrawable),
      selectable = (model) => Boolean(model) && (none || S.isDrawable(model));
    let folded = true;
    const standing = new Map(data.candidates.map((entry) => [entry.name, entry.standing]));
    /** What the diagnosis says of a refit with a candidate; of many rejected ones the page offers only some. */
    const standingOf = (model) => standing.get(model.effect) ?? "rejected";
    /** Candidates that are only possible are shown as far as they leave least; rejected ones, fits of other readings and the rest on demand. */
    const possible = data.models.filter((model) => model.kind === "with" && standingOf(model) === "possible");
    const leading = new Set([...possible].sort((a, b) => S.main(a.heldout_rms) - S.main(b.heldout_rms)).slice(0, MOST));
    // a fit of other readings is no step on the way to the present one; while logs come there is one for each run
    const isOnDemand = (model) =>
      model.kind === "fit"
        ? !selectable(model)
        : model.kind === "with" && (standingOf(model) === "rejected" || (possible.includes(model) && !leading.has(model)));
    const isFolded = (model) => model.id !== S.state.model && isOnDemand(model);
    const verdictOn = (model) => (model.kind === "with" ? (VERDICT[standingOf(model)] ?? "") : "");
    const nameOf = (model) =>
      model.kind === "fit" || model.is_forecast
        ? model.label
        : `${model.kind === "all" ? "all missing: " : "with "}${model.effect}${verdictOn(model)}`;

    function rowOf(model) {
      const heldout = S.main(model.heldout_rms),
        inside = S.main(model.fit_rms);
      return {
        id: model.id,
        name: nameOf(model),
        short: model.kind === "fit" ? model.short : undefined,
        value: heldout ?? inside,
        second: inside,
        text: heldout === null ? `${S.error(model.fit_rms)} (fit)` : S.error(model.heldout_rms),
        grey: !selectable(model),
        chosen: model.id === S.state.model,
      };
    }
    const rows = () => [
      { name: "no model", value: S.main(data.zero), text: S.error(data.zero), grey: true },
      ...data.models.filter((model) => model.kind !== "without" && !(folded && isFolded(model))).map(rowOf),
    ];
    /** The scale, linear from zero, ends at the worst model; without any model the error may be much larger, and its bar is cut off. */
    const mostOf = (shown) =>
      Math.max(...shown.filter((row) => row.id).map((row) => Math.max(row.value || 0, row.second || 0)), S.main(data.noise) || 0);

    const height = () => TOP + 10 + ROW * rows().length;
    const unfold = S.check("all models", false, (on) => {
      folded = !on;
      S.redraw();
    });
    unfold.element.hidden = !data.models.some(isFolded);
    const panel = S.panel({
      id: "ladder",
      title: "2 History of fits",
      height: height(),
      about:
        `Error ${S.leftOut()} (bars) and of the fit (frames), all states. Choose a model to show it in all ` +
        `panels.${data.models.every(selectable) ? "" : " Grey: the store does not hold its predictions."}`,
      how: "A click, or up and down arrows: show a model in all panels. The table below has a button for each.",
      controls: [unfold],
      draw,
      table: list,
      key,
      depends: () => [S.shownKey(), folded, data.models.length].join("/"),
    });
    let find = () => -1;
    const choose = (id) => {
      if (selectable(S.modelById.get(id))) S.set({ model: id, off: [] });
    };
    panel.canvas.addEventListener("click", (event) => {
      const row = rows()[find(event.offsetY)];
      if (row && row.id) choose(row.id);
    });
    function key(event) {
      const ids = rows()
          .filter((row) => row.id && !row.grey)
          .map((row) => row.id),
        k = ids.indexOf(S.state.model);
      if (event.key === "ArrowDown" && k + 1 < ids.length) choose(ids[k + 1]);
      else if (event.key === "ArrowUp" && k > 0) choose(ids[k - 1]);
      else return false;
      return true;
    }
    const numbers = S.make("p", { id: "ladder-numbers", className: "numbers", "aria-live": "polite" });
    const values = S.parameterTable();
    panel.section.insertBefore(numbers, panel.details);
    panel.section.insertBefore(values.element, panel.details);

    function draw(canvas) {
      canvas.style.height = `${height()}px`;
      const { g, width } = S.begin(canvas),
        shown = rows();
      find = S.bars(g, width, shown, {
        top: TOP,
        rowHeight: ROW,
        most: mostOf(shown),
        line: S.main(data.noise) || 0,
        lineLabel: `noise ${S.size(S.main(data.noise))}`,
      });
      const model = S.modelById.get(S.state.model);
      if (!model) return data.refits_missing;
      const ofFit = model.fit_rms ? `, ${S.error(model.fit_rms)} of the fit` : "";
      const noise = `${S.noiseWords()}${S.ofRods(model.heldout_rms ?? model.fit_rms)}`,
        words = `${model.label}: ${S.error(model.heldout_rms)} rms ${S.leftOut()}${ofFit}; ${noise}. ${model.remark}`;
      numbers.textContent = S.unbroken(S.visible(words.trim()));
      numbers.dataset.heldout = String(S.main(model.heldout_rms) ?? "");
      numbers.dataset.fit = String(S.main(model.fit_rms) ?? "");
      values.show(model);
      const other = S.whyOther(data);
      // without a diagnosis the line below the title says why; on a live page the bar says of which model it is
      const missing = data.refits_missing && data.is_diagnosed && !S.isLive() ? `Candidates of the diagnosis: ${data.refits_missing}.` : "";
      return S.visible(`${missing}${other} ${data.excluded_sizes}`.trim());
    }

    function list() {
      const unit = S.si(),
        turns = S.data.rotation;
      const ends = [
        { label: "no model", heldout_rms: data.zero, fit_rms: null },
        { label: "noise", heldout_rms: data.noise, fit_rms: data.noise },
      ];
      const show = (model) =>
        S.button({ onclick: () => S.set({ model: model.id, off: [] }), "aria-label": S.visible(`Show ${model.label}`) }, "show");
      const cells = (rms) => [S.main(rms) ?? NaN, ...(turns ? [rms?.rotation ?? NaN] : [])];
      return {
        head: [
          "model",
          `rms ${S.leftOut()} [${unit}]`,
          ...(turns ? [`rms ${S.leftOut()} [rad]`] : []),
          `fit rms [${unit}]`,
          ...(turns ? ["fit rms [rad]"] : []),
          "show",
        ],
        rows: [ends[0], ...data.models, ends[1]].map((model) => [
          model.label,
          ...cells(model.heldout_rms),
          ...cells(model.fit_rms),
          !model.id ? "–" : selectable(model) ? show(model) : "not stored",
        ]),
      };
    }
  };
})(stiffcal);
