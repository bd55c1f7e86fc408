(function (S) {
  /**
   * The fit to compare with: the first one of these states, so that all steps count; of the first fit, where an effect came
   * back to it, the one without that effect; of a refit the present fit.
   */
  function before(model) {
    const fits = S.data.models.filter((entry) => entry.kind === "fit");
    if (model.kind !== "fit") return fits.find((entry) => entry.present);
    const first = fits.findIndex(S.isDrawable),
      chosen = fits.indexOf(model);
    const earlier = fits[first >= 0 && chosen > first ? first : chosen - 1];
    return earlier ?? (model.present && S.data.change ? S.modelById.get(S.data.change.before) : undefined);
  }

  // "fit 1" keeps its number in a narrow column
  const onOneLine = (name) => name.replace(/^fit (?=\d)/, "fit\u00a0");
  const words = (entry) => (entry ? entry.text : "not in the model");
  function change(a, b) {
    if (!a || !b || !a.value || b.value === null) return "–";
    const percent = 100 * (b.value / a.value - 1);
    return `${percent > 0 ? "+" : ""}${S.digits(percent)} %`;
  }

  /** Names of the parameters that stand on this part of the page: what only readings of another kind show stands on theirs. */
  function namesOf(...models) {
    const effects = (part) => part.effects.map((effect) => effect.name.replace(" ", "."));
    const elsewhere = new Set(S.parts.filter((part) => part !== S.data).flatMap(effects)),
      own = new Set(effects(S.data));
    const isShown = (name) => {
      const effect = name.split(".").slice(0, 2).join(".");
      return own.has(effect) || !elsewhere.has(effect);
    };
    return [...new Set(models.flatMap((model) => (model ? model.values.map((entry) => entry.name) : [])))].filter(isShown);
  }

  /** The table of parameters before and after. @returns {{element: HTMLElement, show: (model: any) => void}} */
  S.parameterTable = function () {
    const table = S.make("table", { id: "values" });
    let listed = "";

    function fill(model, earlier) {
      if (!model.values.length) {
        const why = model.kind === "without" ? ": refits without an effect are stored by their residuals" : "";
        const none = model.is_forecast ? "A forecast is of the residual alone: it holds no values." : `The store holds no values of this model${why}.`;
        S.fill(table, [], [], none);
        return;
      }
      const byName = (of) => new Map(of ? of.values.map((entry) => [entry.name, entry]) : []),
        old = byName(earlier),
        now = byName(model);
      const rows = namesOf(earlier, model).map((name) => {
        const a = old.get(name),
          b = now.get(name),
          { unit } = b || a,
          named = unit ? `${name} [${unit}]` : name;
        return earlier ? [named, words(a), words(b), change(a, b)] : [named, words(b)];
      });
      const head = earlier
        ? ["parameter", `before: ${onOneLine(earlier.short)}`, `after: ${onOneLine(model.short)}`, "change"]
        : ["parameter", model.short];
      const linear =
        " A candidate is a linear refit about the present fit: ± holds for the chosen shape; what is chosen among a few values has " +
        "none, and makes the others' ± too narrow.";
      S.fill(table, head, rows, `Stiffness and other parameters; ± is 95 %.${model.kind === "with" ? linear : ""}`);
    }

    function show(model) {
      if (listed === model.id) return;
      listed = model.id;
      // of a first fit the table shows what follows: all that is missing added
      const earlier = before(model),
        all = S.data.models.find((entry) => entry.kind === "all" && entry.values.length);
      if (!earlier && all && model.present) fill(all, model);
      else fill(model, earlier);
    }
    return { element: S.make("div", { className: "scroll tall", tabIndex: 0, role: "region", "aria-label": "Parameters before and after" }, table), show };
  };
})(stiffcal);
