(function (S) {
  const MOST_LEVELS = 8;

  S.againstPanel = function () {
    const { data } = S;
    const names = data.variables.map((variable) => [variable.name, variable.unit ? `${variable.label} [${variable.unit}]` : variable.label]);
    const ys = S.scalar ? [["x", "moved motor's angle"]] : [...S.components.map((name, k) => [name, k < 3 ? `along ${name}` : `about ${name.slice(1)}`]), ["length", "length"],
      ...data.effects.map((effect) => [`along ${effect.name}`, `along ${effect.name}`])];
    const x = S.choice("Across", names, (value) => S.set({ x: value }));
    const y = S.choice("Up: residual", ys, (value) => S.set({ y: value }));
    const colour = S.choice("Colour", [["none", "none"], ...names], (value) => S.set({ colour: value }));
    const kind = S.choice("Residual in", [["heldout", "held-out poses"], ["fit", "the fit"]], (value) => S.set({ kind: value }));
    let axes = null, drag = null, listed = "";
    const proposals = S.make("ol", { className: "proposals" });
    const panel = S.panel({
      id: "against", title: "2 Residual against any variable", height: 420,
      about: "Drag a rectangle to select states in all panels; with Shift they are added; Escape clears the selection; left and right arrows step through the states. The band is the noise, ± 2σ.",
      controls: [x, y, colour, kind], draw, table, key,
      depends: () => S.everything() + (drag ? drag.to.join() : ""),
    });
    const heading = S.make("h3", {}, "Variables ranked by the share of the residual that they explain (all states)");
    panel.section.insertBefore(heading, panel.details);
    panel.section.insertBefore(proposals, panel.details);

    const where = (event) => {
      const rect = panel.canvas.getBoundingClientRect();
      return [event.clientX - rect.left, event.clientY - rect.top];
    };
    panel.canvas.addEventListener("pointerdown", (event) => { drag = { from: where(event), to: where(event) }; panel.canvas.setPointerCapture(event.pointerId); });
    panel.canvas.addEventListener("pointermove", (event) => { if (drag) { drag.to = where(event); S.redraw(); } });
    panel.canvas.addEventListener("pointerup", (event) => {
      if (!drag || !axes) return;
      const [x0, x1] = [drag.from[0], drag.to[0]].sort((a, b) => a - b), [y0, y1] = [drag.from[1], drag.to[1]].sort((a, b) => a - b);
      drag = null;
      S.redraw();
      const chosen = [], click = x1 - x0 < 4 && y1 - y0 < 4;
      let nearest = -1, best = 12;
      for (let i = 0; i < S.n; i++) {
        const px = axes.px[i], py = axes.py[i];
        if (!Number.isFinite(px + py)) continue;
        if (px >= x0 && px <= x1 && py >= y0 && py <= y1) chosen.push(i);
        const far = Math.hypot(px - x0, py - y0);
        if (far < best) { best = far; nearest = i; }
      }
      if (!click) S.select(chosen, event.shiftKey);
      else if (nearest >= 0) { S.goTo(nearest); S.select([nearest], event.shiftKey); } else S.select([]);
    });

    function key(event) {
      if (event.key === "ArrowRight") S.goTo(S.state.at + 1);
      else if (event.key === "ArrowLeft") S.goTo(S.state.at - 1);
      else if (event.key === "Escape") S.select([]);
      else if (event.key === " " || event.key === "Enter") S.select([S.state.at], event.shiftKey);
      else return false;
      return true;
    }

    /** Number of the colour of each state, and the legend. */
    function colours() {
      const variable = S.variableByName.get(S.state.colour), groups = new Int8Array(S.n);
      if (!variable) return { groups, legend: [], scale: false };
      const { values, levels } = variable;
      if (levels.length && levels.length <= MOST_LEVELS) {
        for (let i = 0; i < S.n; i++) groups[i] = Number.isFinite(values[i]) ? values[i] : -1;
        return { groups, legend: levels, scale: false };
      }
      const [low, high] = S.span(values, 0), count = S.theme.scale.length;
      for (let i = 0; i < S.n; i++) groups[i] = Number.isFinite(values[i]) ? Math.min(count - 1, Math.floor(((values[i] - low) / (high - low || 1)) * count)) : -1;
      const end = (v) => (levels.length ? levels[Math.round(v)] : `${S.digits(v)} ${variable.unit}`);
      return { groups, legend: [end(low), end(high)], scale: true };
    }

    function draw(canvas) {
      for (const [entry, value] of [[x, S.state.x], [y, S.state.y], [colour, S.state.colour], [kind, S.residual().heldout ? "heldout" : "fit"]]) entry.select.value = value;
      const { g, width, height } = S.begin(canvas), { theme } = S, across = S.variableByName.get(S.state.x), up = S.residualOf(S.state.y);
      const used = data.states.used, shown = Float64Array.from(up.values, (value, i) => (used[i] ? value : NaN));
      const box = { x: 74, y: 26, w: width - 92, h: height - 70 };
      const yEnds = S.span(shown), xs = across.values;
      const noise = S.state.y === "length" ? S.main(data.noise) / 2 : up.unit === "µm" || S.scalar ? S.sigma() : data.noise && data.noise.rotation / Math.sqrt(3);
      const sigma = noise > 0 ? 2e6 * noise : 0;
      if (sigma && S.state.y !== "length") { yEnds[0] = Math.min(yEnds[0], -1.2 * sigma); yEnds[1] = Math.max(yEnds[1], 1.2 * sigma); }
      const ends = across.levels.length ? [-0.5, across.levels.length - 0.5] : S.span(xs);
      const { toX, toY } = S.axes(g, box, { x: ends, y: yEnds, xLabel: across.unit ? `${across.label} [${across.unit}]` : across.label, yLabel: `${up.label} [${up.unit}]`, xNames: across.levels });
      if (sigma) {
        const low = S.state.y === "length" ? 0 : -sigma;
        g.fillStyle = theme.band;
        g.fillRect(box.x, toY(sigma), box.w, toY(low) - toY(sigma));
      }
      const px = new Float64Array(S.n), py = new Float64Array(S.n), { groups, legend, scale } = colours();
      const jitter = across.levels.length ? 0.3 : 0;
      for (let i = 0; i < S.n; i++) {
        px[i] = toX(xs[i] + jitter * (((i * 0.618034) % 1) - 0.5));
        py[i] = toY(shown[i]);
      }
      axes = { px, py };
      const palette = scale ? theme.scale : theme.series;
      const r = S.n > 2500 ? 1.8 : 2.8;
      for (let group = -1; group < palette.length; group++) {
        g.beginPath();
        let count = 0;
        for (let i = 0; i < S.n; i++) {
          if (groups[i] !== group || !Number.isFinite(px[i] + py[i])) continue;
          S.marker(g, scale || group < 0 ? 0 : group, px[i], py[i], r);
          count++;
        }
        if (count) { g.fillStyle = group < 0 ? theme.line : palette[group]; g.fill(); }
      }
      g.beginPath();
      for (let i = 0; i < S.n; i++) if (S.selected[i] && Number.isFinite(px[i] + py[i])) { g.moveTo(px[i] + 5, py[i]); g.arc(px[i], py[i], 5, 0, 6.2832); }
      g.strokeStyle = theme.warm; g.lineWidth = 1.5; g.stroke();
      const at = S.state.at;
      if (Number.isFinite(px[at] + py[at])) { g.beginPath(); g.rect(px[at] - 7, py[at] - 7, 14, 14); g.strokeStyle = theme.ink; g.stroke(); }
      if (drag) { g.strokeStyle = theme.accent; g.setLineDash([4, 3]); g.strokeRect(drag.from[0], drag.from[1], drag.to[0] - drag.from[0], drag.to[1] - drag.from[1]); g.setLineDash([]); }
      g.textAlign = "left"; g.textBaseline = "middle";
      let right = box.x;
      if (scale) {
        g.fillStyle = theme.ink; g.fillText(S.visible(legend[0]), right, 12);
        right += g.measureText(S.visible(legend[0])).width + 6;
        palette.forEach((c) => { g.fillStyle = c; g.fillRect(right, 6, 10, 12); right += 10; });
        g.fillStyle = theme.ink; g.fillText(S.visible(legend[1]), right + 6, 12);
      } else legend.forEach((word, k) => {
        g.beginPath(); S.marker(g, k, right + 6, 12, 4); g.fillStyle = palette[k]; g.fill();
        g.fillStyle = theme.ink; g.fillText(S.visible(word), right + 14, 12);
        right += 26 + g.measureText(S.visible(word)).width;
      });
      propose();
      const sentence = S.data.n_states > S.n ? ` Shown ${S.count(S.n)} of ${S.count(S.data.n_states)} states.` : "";
      return `${up.label} against ${across.label}, ${S.residual().model.label}. ${S.nSelected} states selected.${sentence}`;
    }

    function propose() {
      const model = S.residual().model, key = `${model.id}`;
      if (key === listed) return;
      listed = key;
      const names = (share) => S.variableByName.get(share.variable);
      const rows = model.shares.filter(names).slice(0, 8).map((share) => S.make("li", {}, S.make("button", {
        type: "button", onclick: () => S.set({ x: share.variable, y: share.component }),
      }, `${S.scalar ? "" : `${share.component} `}against ${names(share).label}: ${S.percent(share.share)}`)));
      proposals.replaceChildren(...(rows.length ? rows : [S.make("li", {}, "No variable explains more than 2 % of the residual.")]));
    }

    function table() {
      const across = S.variableByName.get(S.state.x), up = S.residualOf(S.state.y), rows = [];
      for (let i = 0; i < S.n; i++) {
        if (S.nSelected && !S.selected[i]) continue;
        const level = across.levels.length ? across.levels[across.values[i]] : across.values[i];
        rows.push([data.runs[data.states.run[i]].name, data.states.row[i], level, up.values[i], data.states.used[i] ? "used" : data.states.why[i] || "reference"]);
      }
      return { head: ["run", "row", across.label, `${up.label} [${up.unit}]`, "state"], rows };
    }
  };
})(stiffcal);
