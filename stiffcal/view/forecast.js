(function (S) {
  // of what two candidates do alike, least squares determines no share: a little of the diagonal is added
  const OF_ALIKE = 1e-6;

  /** Solve symmetric positive equations, by Gauss. @param {number[][]} a (k × k) @param {number[]} b */
  function solved(a, b) {
    const k = b.length,
      m = a.map((row, i) => [...row.map((value, j) => (i === j ? value * (1 + OF_ALIKE) : value)), b[i]]);
    for (let i = 0; i < k; i++) {
      for (let j = i + 1; j < k; j++) {
        const by = m[j][i] / m[i][i];
        for (let c = i; c <= k; c++) m[j][c] -= by * m[i][c];
      }
    }
    const x = new Array(k).fill(0);
    for (let i = k - 1; i >= 0; i--) x[i] = (m[i][k] - x.reduce((sum, value, j) => sum + (j > i ? m[i][j] * value : 0), 0)) / m[i][i];
    return x;
  }

  /**
   * What several candidates together leave, from their stored refits: each takes something out of the present residual, and
   * least squares says how much of each the residual holds: an estimate, where refits were judged in held-out data.
   * @param {any} present model @param {any[]} refits one of each candidate @returns {any} a model
   */
  S.forecastOf = function (present, refits) {
    const { data } = S,
      { used } = data.states,
      pick = (model) => model.residual_heldout,
      sigma = [S.main(data.noise) || 1, data.noise?.rotation || 1];
    const before = pick(present),
      parts = [0, ...(data.rotation ? [1] : [])];
    const taken = refits.map((model) => parts.map((part) => before[part].map((value, i) => value - pick(model)[part][i])));
    const inner = (a, b) =>
      parts.reduce((sum, part) => {
        let own = 0;
        for (let i = 0; i < a[part].length; i++) {
          const value = a[part][i] * b[part][i];
          if (used[(i / 3) | 0] && Number.isFinite(value)) own += value;
        }
        return sum + own / sigma[part] ** 2;
      }, 0);
    const share = solved(
      taken.map((a) => taken.map((b) => inner(a, b))),
      taken.map((a) => inner(a, before)),
    );
    const residual = parts.map((part) => before[part].map((value, i) => value - share.reduce((sum, by, k) => sum + by * taken[k][part][i], 0)));
    const names = refits.map((model) => model.effect);
    return {
      id: `forecast ${names.join(", ")}`,
      kind: "with",
      is_forecast: true,
      label: `forecast: with ${names.join(" and ")}`,
      short: "forecast",
      effect: names.join(", "),
      heldout_rms: { [data.measure]: S.rms(residual[0]), rotation: data.rotation ? S.rms(residual[1]) : null },
      fit_rms: null,
      remark: "",
      values: [],
      shares: [],
      residual_fit: null,
      residual_heldout: [residual[0], residual[1] ?? null],
    };
  };

  /** Whether two lists hold the same. @param {string[]} a @param {string[]} b */
  const same = (a, b) => a.length === b.length && a.every((name) => b.includes(name));
  /** The stored refit of the present model with just these candidates. @param {string[]} names */
  S.storedRefit = function (names) {
    return S.data.models.find(
      (entry) => S.isDrawable(entry) && (entry.kind === "with" || entry.kind === "all") && same(entry.effect.split(", "), names),
    );
  };
  /** The fit of the present model, else the first model. */
  S.presentModel = () => S.data.models.find((entry) => entry.present) || S.data.models[0];
  S.canForecast = (names) => Boolean(S.presentModel().residual_heldout) && names.every((name) => S.storedRefit([name]));
  /** What candidates leave together by their stored refits; it joins the models of the page. @param {string[]} names */
  S.forecast = function (names) {
    if (!S.canForecast(names)) return null;
    const made = S.forecastOf(
      S.presentModel(),
      names.map((name) => S.storedRefit([name])),
    );
    S.data.models.push(made);
    S.modelById.set(made.id, made);
    return made;
  };
})(stiffcal);
