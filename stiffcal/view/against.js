(function (S) {
  const MOST_LEVELS = 8;
  /** Ends of the axes by what they show. */
  S.scales = new Map();
  const windows = new Map();

  S.againstPanel = function () {
    const { data } = S, states = data.states;
    const names = data.variables.map((variable) => [variable.name, S.withUnit(variable)]);
    const component = S.scalar ? [] : [["component", "component of the residual"]];
    const groups = [["Residual", S.residualKeys()], ["Variable", names]], coloured = [["Variable", [...names, ...component]], ["Residual", S.residualKeys().filter(([key]) => key !== "r.all")]];
    const x = S.choice("x axis", [["Variable", [...names, ...component]], ["Residual", S.residualKeys()]], (value) => S.set({ x: value }));
    const y = S.choice("y axis", groups, (value) => S.set({ y: value }));
    const colour = S.choice("Colour", [["none", "none"], ...coloured], (value) => S.set({ colour: value }));
    const kind = S.choice("Residual", [["heldout", S.leftOut()], ["fit", "of the fit"]], (value) => S.set({ kind: value }));
    let axes = { px: [], py: [] }, brush = null, listed = "";
    const proposals = S.make("ol", { className: "proposals" });
    /** Categories that are not drawn, by what gives the colours. */
    const hidden = new Set(), legendButtons = S.make("span", { className: "legend", role: "group", "aria-label": "Categories that are drawn" });
    let legendKey = "";
    function legendOf(words, palette) {
      const key = JSON.stringify([words, S.state.colour, S.themeName, [...hidden]]);
      if (key === legendKey) return;
      legendKey = key;
      const focus = [...legendButtons.children].indexOf(document.activeElement);
      legendButtons.replaceChildren(...words.map((word, k) => {
        const name = `${S.state.colour}/${k}`, mark = S.make("canvas", { width: 24, height: 24, className: "mark" }), g = mark.getContext("2d");
        g.scale(2, 2); g.beginPath(); S.marker(g, k, 6, 6, 4.5); g.fillStyle = palette[k]; g.fill();
        return S.make("button", { type: "button", "aria-pressed": String(!hidden.has(name)), title: "Show or hide", onclick: () => {
          if (!hidden.delete(name)) hidden.add(name);
          S.frame++;
          S.redraw();
        } }, mark, word);
      }));
      if (focus >= 0) legendButtons.children[focus]?.focus();
    }
    const panel = S.panel({
      id: "against", title: "2 Residual against any variable", height: 420,
      about: "Band: noise, ± 2σ. Points outside it are what the model does not explain.",
      how: "Drag a rectangle from a point, or from anywhere with Shift: select states in all panels; with Ctrl they are added. Drag from an empty place: move the picture; wheel after a click: zoom; double click: all of it. Left and right arrows: step through the states, + and −: zoom, Enter selects, Escape clears the selection.",
      controls: [x, y, colour, kind, S.button({ onclick: () => { S.scales.clear(); windows.clear(); S.ghost = null; S.frame++; S.redraw(); } }, "Rescale"), legendButtons], draw, table,
      key: S.onKeys({
        ArrowRight: () => S.goTo(S.state.at + 1), ArrowLeft: () => S.goTo(S.state.at - 1),
        "+": () => zoom(1 / 1.25, axes.box.x + axes.box.w / 2, axes.box.y + axes.box.h / 2), "-": () => zoom(1.25, axes.box.x + axes.box.w / 2, axes.box.y + axes.box.h / 2),
      }, () => [S.state.at]),
      depends: () => S.everything() + (brush?.key() ?? ""),
    });
    const heading = S.make("h3", {}, "What explains the residual, by its share of the variance (all states)");
    panel.section.insertBefore(heading, panel.details);
    panel.section.insertBefore(proposals, panel.details);

    brush = S.brush(panel.canvas, () => axes, (chosen, event, click) => {
      const states = [...new Set(chosen.map((p) => axes.stateOf(p)))].sort((a, b) => a - b);
      if (click && states.length) S.goTo(states[0]);
      S.select(states, (event.ctrlKey || event.metaKey) && states.length > 0);
    }, { pan, zoom, all: () => { windows.delete(windowKey()); S.frame++; }, words: wordsOf });

    /** Which part of a picture is shown, by what its axes show; none: all of it. */
    const windowKey = () => `${S.part}/${S.state.x}/${S.state.y}`;
    function look(x, y) {
      windows.set(windowKey(), { x, y });
      S.frame++;
      S.redraw();
    }
    function pan(dx, dy) {
      const { box, ends } = axes, u = (-dx / box.w) * (ends.x[1] - ends.x[0]), v = (dy / box.h) * (ends.y[1] - ends.y[0]);
      look(ends.x.map((value) => value + u), ends.y.map((value) => value + v));
    }
    function zoom(by, px, py) {
      const { box, ends } = axes, u = ends.x[0] + ((px - box.x) / box.w) * (ends.x[1] - ends.x[0]), v = ends.y[1] - ((py - box.y) / box.h) * (ends.y[1] - ends.y[0]);
      look(ends.x.map((value) => u + by * (value - u)), ends.y.map((value) => v + by * (value - v)));
    }
    /** Run, row and values of a point. */
    function wordsOf(p) {
      const { across, up, stateOf, valueOf } = points(), i = stateOf(p);
      const value = (quantity) => (quantity.levels.length ? quantity.levels[valueOf(quantity, p)] ?? "" : `${S.digits(valueOf(quantity, p))} ${quantity.unit}`);
      return `${data.runs[states.run[i]].name}, row ${states.row[i]}: ${value(up)} at ${across.label} ${value(across)}`;
    }

    /** Number of the colour of each point, and the legend. @param {number} count @param {(q: any, p: number) => number} valueOf */
    function colours(count, valueOf) {
      const numbers = new Int8Array(count);
      if (S.state.colour === "none") return { numbers, legend: [], scale: false };
      const quantity = S.quantity(S.state.colour), { levels } = quantity;
      if (levels.length && levels.length <= MOST_LEVELS) {
        for (let p = 0; p < count; p++) { const value = valueOf(quantity, p); numbers[p] = Number.isFinite(value) ? value : -1; }
        return { numbers, legend: levels, scale: false };
      }
      const [low, high] = S.span(quantity.values, 0), shades = S.theme.scale.length;
      for (let p = 0; p < count; p++) {
        const value = valueOf(quantity, p);
        numbers[p] = Number.isFinite(value) ? Math.max(0, Math.min(shades - 1, Math.floor(((value - low) / (high - low || 1)) * shades))) : -1;
      }
      const end = (v) => (levels.length ? levels[Math.round(v)] : `${S.digits(v)} ${quantity.unit}`);
      return { numbers, legend: [`${quantity.label}: ${end(low)}`, end(high)], scale: true };
    }

    /** What is drawn: points, each of a state; three of each state where components are drawn apart. */
    function points() {
      const across = S.quantity(S.state.x), up = S.quantity(S.state.y);
      const wide = across.wide || up.wide || S.state.colour === "component", count = wide ? 3 * S.n : S.n;
      const stateOf = wide ? (p) => (p / 3) | 0 : (p) => p;
      const valueOf = (quantity, p) => (!quantity.wide ? quantity.values[stateOf(p)] : quantity.values ? quantity.values[p] : p % 3);
      return { across, up, count, stateOf, valueOf };
    }

    /** Where a residual other than the one that is shown has its points; null where the axes are of none. */
    function drawnOf(other, count, stateOf, valueOf) {
      if (!other || ![S.state.x, S.state.y].some((key) => key.startsWith("r."))) return null;
      const [x, y] = [S.state.x, S.state.y].map((key) => {
        const quantity = S.quantity(key, other);
        return Float64Array.from({ length: count }, (_, p) => (states.used[stateOf(p)] ? valueOf(quantity, p) : NaN));
      });
      return { x, y };
    }
    const joined = (...lists) => lists.flatMap((list) => (list ? [...list] : []));
    /** Scales stay, so that a fall looks as large as it is: each axis grows to the worst model that was shown. */
    function locked(axis, ends) {
      const key = `${axis}/${S.part}/${S.state[axis]}`, before = S.scales.get(key);
      const now = before ? [Math.min(before[0], ends[0]), Math.max(before[1], ends[1])] : ends;
      S.scales.set(key, now);
      return [...now];
    }

    function draw(canvas) {
      for (const [entry, value] of [[x, S.state.x], [y, S.state.y], [colour, S.state.colour], [kind, S.residual().heldout ? "heldout" : "fit"]]) entry.select.value = value;
      kind.select.options[0].disabled = !S.residual().model.residual_heldout;
      kind.select.options[1].disabled = !S.residual().model.residual_fit;
      const { g, width, height } = S.begin(canvas), { theme } = S, { across, up, count, stateOf, valueOf } = points();
      const { numbers, legend, scale } = colours(count, valueOf);
      const xs = new Float64Array(count), shown = new Float64Array(count);
      for (let p = 0; p < count; p++) {
        const used = states.used[stateOf(p)];
        xs[p] = valueOf(across, p);
        shown[p] = used ? valueOf(up, p) : NaN;
      }
      const ghost = drawnOf(S.ghost, count, stateOf, valueOf), hollow = drawnOf(S.hollow, count, stateOf, valueOf), t = S.moved();
      const palette = scale ? theme.scale : theme.series;
      legendOf(scale ? [] : legend, palette);
      if (!scale && legend.length) for (let p = 0; p < count; p++) if (hidden.has(`${S.state.colour}/${numbers[p]}`)) shown[p] = NaN;
      const top = scale ? 26 : S.drawsFile ? S.legend(g, { x: 74, w: width - 92 }, legend, palette, scale) : 12;
      const box = { x: 74, y: top, w: width - 92, h: height - 44 - top }, named = up.levels.length > 0;
      const yEnds = named ? [-0.5, up.levels.length - 0.5] : locked("y", S.span(joined(shown, ghost?.y, hollow?.y))), oneSided = S.state.y === "r.length";
      const sigma = up.sigma > 0 ? 2 * up.sigma : 0;
      if (sigma && !oneSided) { yEnds[0] = Math.min(yEnds[0], -1.2 * sigma); yEnds[1] = Math.max(yEnds[1], 1.2 * sigma); }
      const ends = across.levels.length ? [-0.5, across.levels.length - 0.5] : locked("x", S.span(joined(xs.map((value, p) => (Number.isFinite(shown[p]) ? value : NaN)), ghost?.x, hollow?.x)));
      const part = windows.get(windowKey());
      if (part && !across.levels.length) ends.splice(0, 2, ...part.x);
      if (part && !named) yEnds.splice(0, 2, ...part.y);
      const { toX, toY } = S.axes(g, box, { x: ends, y: yEnds, xLabel: S.withUnit(across), yLabel: S.withUnit(up), xNames: across.levels, yNames: up.levels });
      g.save(); g.beginPath(); g.rect(box.x, box.y, box.w, box.h); g.clip();
      if (sigma) {
        g.fillStyle = theme.band;
        g.fillRect(box.x, toY(sigma), box.w, toY(oneSided ? 0 : -sigma) - toY(sigma));
      }
      if (across.sigma > 0) {
        g.fillStyle = theme.band;
        const left = toX(Math.max(-2 * across.sigma, ends[0])), right = toX(Math.min(2 * across.sigma, ends[1]));
        g.fillRect(left, box.y, right - left, box.h);
      }
      if (ghost) {
        g.beginPath();
        for (let p = 0; p < count; p++) if (Number.isFinite(ghost.x[p] + ghost.y[p])) S.marker(g, 0, toX(ghost.x[p]), toY(ghost.y[p]), 1.6);
        g.fillStyle = theme.line; g.fill();
        for (let p = 0; p < count && t < 1; p++) {
          if (Number.isFinite(ghost.x[p])) xs[p] = ghost.x[p] + t * (xs[p] - ghost.x[p]);
          if (Number.isFinite(ghost.y[p])) shown[p] = ghost.y[p] + t * (shown[p] - ghost.y[p]);
        }
      }
      const px = new Float64Array(count), py = new Float64Array(count);
      const spread = (p) => 0.3 * (((p * 0.618034) % 1) - 0.5);
      for (let p = 0; p < count; p++) {
        px[p] = toX(across.levels.length ? xs[p] + spread(p) : xs[p]);
        py[p] = toY(named ? shown[p] + spread(p) : shown[p]);
      }
      const inBox = (p) => px[p] >= box.x - 1 && px[p] <= box.x + box.w + 1 && py[p] >= box.y - 1 && py[p] <= box.y + box.h + 1;
      if (part) for (let p = 0; p < count; p++) if (!inBox(p)) px[p] = NaN;
      axes = { px, py, stateOf, box, ends: { x: [...ends], y: [...yEnds] } };
      const r = count > 2500 ? 1.8 : 2.8;
      for (let group = -1; group < palette.length; group++) {
        g.beginPath();
        let drawn = 0;
        for (let p = 0; p < count; p++) {
          if (numbers[p] !== group || !Number.isFinite(px[p] + py[p])) continue;
          S.marker(g, scale || group < 0 ? 0 : group, px[p], py[p], r);
          drawn++;
        }
        if (drawn) { g.fillStyle = group < 0 ? theme.line : palette[group]; g.fill(); }
      }
      if (hollow) {
        g.beginPath();
        for (let p = 0; p < count; p++) if (Number.isFinite(hollow.x[p] + hollow.y[p])) { const [hx, hy] = [toX(hollow.x[p]), toY(hollow.y[p])]; g.moveTo(hx + 3, hy); g.arc(hx, hy, 3, 0, 6.2832); }
        g.strokeStyle = theme.accent; g.lineWidth = 1; g.stroke();
      }
      g.beginPath();
      for (let p = 0; p < count; p++) if (S.selected[stateOf(p)] && Number.isFinite(px[p] + py[p])) { g.moveTo(px[p] + 5, py[p]); g.arc(px[p], py[p], 5, 0, 6.2832); }
      g.strokeStyle = theme.warm; g.lineWidth = 1.5; g.stroke();
      const apart = count / S.n;
      for (let p = apart * S.state.at; p < apart * (S.state.at + 1); p++) {
        if (Number.isFinite(px[p] + py[p])) { g.beginPath(); g.rect(px[p] - 7, py[p] - 7, 14, 14); g.strokeStyle = theme.ink; g.stroke(); }
      }
      g.restore();
      brush.draw(g);
      if (scale) S.legend(g, box, legend, palette, scale);
      propose();
      const sentence = data.n_states > S.n ? ` Shown ${S.count(S.n)} of ${S.count(data.n_states)} states.` : "";
      return `${up.label} against ${across.label}, ${S.residual().model.label}. ${S.count(S.nSelected)} states selected.${sentence}`;
    }

    function propose() {
      const model = S.residual().model, key = `${model.id}`;
      if (key === listed) return;
      listed = key;
      const variable = (share) => S.variableByName.get(share.variable);
      const named = (component) => data.evidence[/^e\d+$/.test(component) ? Number(component.slice(1)) - 1 : -1]?.name;
      const button = (share, words) => S.make("li", {}, S.button({ onclick: () => S.set({ x: share.variable, y: `r.${share.component}` }) }, words));
      // what the diagnosis reads of each missing effect stands first, whatever share a curve over its variable explains
      const first = data.evidence.map((one, k) => ({ component: `e${k + 1}`, variable: one.variable })).filter(variable);
      const isFirst = (share) => first.some((one) => one.component === share.component && one.variable === share.variable);
      const words = (share) => `${S.scalar ? "" : named(share.component) ? `along ${named(share.component)} ` : `${share.component} `}against ${variable(share).label}`;
      // whatever is constant in each run explains what differs between few runs
      const range = (values) => Math.max(...values) - Math.min(...values), runs = S.members.filter((members) => members.length > 1);
      const perRun = ({ name, values }) => {
        const most = 0.02 * range(values.filter(Number.isFinite));
        return name !== "run" && runs.length > 2 && runs.every((members) => !(range(members.map((i) => values[i]).filter(Number.isFinite)) > most));
      };
      const remark = (share) => (perRun(variable(share)) ? `, constant in each of ${runs.length} runs` : "");
      const rows = [...first.map((share) => button(share, `missing: ${words(share)}`)),
        ...model.shares.filter((share) => variable(share) && !isFirst(share)).slice(0, 8).map((share) => button(share, `${words(share)}: ${S.percent(share.share)}${remark(share)}`))];
      proposals.replaceChildren(...(rows.length ? rows : [S.make("li", {}, "No variable explains more than 2 % of the residual.")]));
    }

    function table() {
      const { across, up, count, stateOf, valueOf } = points(), rows = [];
      const cell = (quantity, p) => (quantity.levels.length ? quantity.levels[valueOf(quantity, p)] ?? "" : valueOf(quantity, p));
      for (let p = 0; p < count; p++) {
        const i = stateOf(p);
        if (S.nSelected && !S.selected[i]) continue;
        rows.push([data.runs[states.run[i]].name, states.row[i], cell(across, p), cell(up, p), states.used[i] ? "used" : states.why[i] || "reference"]);
      }
      return { head: ["run", "row", S.withUnit(across), S.withUnit(up), "state"], rows };
    }
  };
})(stiffcal);
