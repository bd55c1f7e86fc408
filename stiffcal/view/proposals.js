(function (S) {
  const MOST = 8,
    CONSTANT = 0.02;
  const range = (values) => Math.max(...values) - Math.min(...values);

  /** Whether a variable is constant in each run: it then explains what differs between few runs. */
  function isPerRun({ name, values }, runs) {
    const known = (of) => of.filter(Number.isFinite),
      most = CONSTANT * range(known([...values]));
    return name !== "run" && runs.length > 2 && runs.every((members) => !(range(known(members.map((i) => values[i]))) > most));
  }

  /** The list of what explains the residual; a click draws it. @returns {{list: HTMLElement, show: () => void}} */
  S.proposals = function () {
    const { data } = S,
      list = S.make("ol", { className: "proposals" });
    const variable = (share) => S.variableByName.get(share.variable);
    const evidenceOf = (component) => data.evidence[/^e\d+$/.test(component) ? Number(component.slice(1)) - 1 : -1];
    const along = (share) => (evidenceOf(share.component) ? `along ${evidenceOf(share.component).name} ` : S.scalar ? "" : `${share.component} `);
    const words = (share) => `${along(share)}against ${variable(share).label}`;
    const button = (share, text) => S.make("li", {}, S.button({ onclick: () => S.set({ x: share.variable, y: `r.${share.component}` }) }, S.unbroken(text)));
    // what the diagnosis reads of each effect stands first, whatever share a curve over its variable explains
    const first = data.evidence.map((one, k) => ({ component: `e${k + 1}`, variable: one.variable, standing: one.standing })).filter(variable);
    const isFirst = (share) => first.some((one) => one.component === share.component && one.variable === share.variable);
    const runs = S.members.filter((members) => members.length > 1);
    const remark = (share) => (isPerRun(variable(share), runs) ? `, constant in each of ${runs.length} runs` : "");
    let listed = null;
    function show() {
      const { model } = S.residual();
      if (model.id === listed) return;
      listed = model.id;
      const shares = model.shares.filter((share) => variable(share) && !isFirst(share)).slice(0, MOST);
      const rows = [
        ...first.map((share) => button(share, `${share.standing}: ${words(share)}`)),
        ...shares.map((share) => button(share, `${words(share)}: ${S.percent(share.share)}${remark(share)}`)),
      ];
      list.replaceChildren(...(rows.length ? rows : [S.make("li", {}, "No variable explains more than 2 % of the residual.")]));
    }
    return { list, show };
  };
})(stiffcal);
