(function (S) {
  /** A text made of pieces, as other kinds of experiment write them. @param {any[]} pieces @param {number} [scale] of its numbers */
  function words(pieces, scale = 1) {
    return pieces.map((piece) => {
      if (typeof piece === "string") return piece;
      switch (piece.kind_) {
        case "Digits": return S.digits(piece.value === null ? null : scale * piece.value);
        case "Interval": return `${S.digits(scale * piece.value)} (${S.digits(scale * piece.low)} to ${S.digits(scale * piece.high)})`;
        case "Names": return piece.names.join(", ");
        default: return (piece.joints || []).join(", ");
      }
    }).join("");
  }
  const colourOf = (colour) => (typeof colour === "number" ? S.theme.series[colour % S.theme.series.length] : colour === "quiet" ? S.theme.quiet : S.theme.ink);
  const SHAPES = { "^": 1, v: 3, o: 0, x: 6 };

  /** States that the points of a series are of: a row of the fit each, their whole run, or those of a clamped sweep that are nearest in torque. */
  function membersOf(s) {
    if (s.of_) return s.of_;
    const { data } = S, fitted = data.fitted_rows;
    if (s.rows && fitted) return (s.of_ = [...s.rows].map((row) => (fitted[row] >= 0 ? [fitted[row]] : [])));
    const members = S.members[data.runs.findIndex((entry) => entry.name === s.run)] || [], torque = S.variableByName.get("moved_torque") || S.variableByName.get("torque1");
    if (!s.sweep || !torque) return (s.of_ = [...s.x].map(() => members));
    s.of_ = [...s.x].map(() => []);
    const order = [...s.y.keys()].sort((a, b) => s.y[a] - s.y[b]), branch = S.variableByName.get("branch");
    const reach = 2 * S.median(order.slice(1).map((k, n) => s.y[k] - s.y[order[n]]));
    for (const i of members) {
      const t = torque.values[i], way = branch && branch.values[i] < 2 ? ((branch.values[i] === 0) === (t > 0) ? "up" : "down") : "both";
      if (s.sweep !== "both" && way !== "both" && way !== s.sweep) continue;
      let low = 0, high = order.length - 1;
      while (high - low > 1) { const middle = (low + high) >> 1; if (s.y[order[middle]] < t) low = middle; else high = middle; }
      const near = Math.abs(s.y[order[low]] - t) < Math.abs(s.y[order[high]] - t) ? order[low] : order[high];
      if (Math.abs(s.y[near] - t) <= reach) s.of_[near].push(i);
    }
    return s.of_;
  }

  const isChosen = (point) => point.members.some((i) => S.selected[i]);

  /** Draw one pair of axes of a picture; returns the points that are of states. */
  function drawPanel(canvas, panel) {
    const { g, width, height } = S.begin(canvas), points = [];
    const series = panel.series, curves = series.filter((s) => s.x), xs = curves.flatMap((s) => [...s.x]), ys = curves.flatMap((s) => (!s.y ? [...s.low, ...s.high] : s.spread ? [...s.y.map((y, k) => y - s.spread[k]), ...s.y.map((y, k) => y + s.spread[k])] : [...s.y]));
    if (!xs.length) { g.fillStyle = S.theme.quiet; g.fillText(S.visible(panel.empty), 20, 40); return points; }
    const first = (entry, k) => entry.label && series.findIndex((other) => other.label === entry.label) === k;
    const entries = series.filter(first).map((s) => ({ word: s.label, mark: (x, y) => {
      g.fillStyle = s.kind_ === "Band" || s.kind_ === "Span" ? S.theme.band : colourOf(s.colour);
      if (s.kind_ === "Marks") { g.beginPath(); S.marker(g, SHAPES[s.marker] ?? Number(s.marker), x + 6, y, 4); g.fill(); } else g.fillRect(x, y - 2, 12, s.kind_ === "Line" ? 3 : 8);
    } }));
    const top = 14 + 16 * (entries.length ? S.keys(g, { x: 74, w: width - 92 }, entries) : 0), box = { x: 74, y: top, w: width - 92, h: height - 48 - top };
    const { toX, toY } = S.axes(g, box, { x: panel.x_limits || S.span(xs), y: panel.y_limits || S.span(ys.length ? ys : [0, 1]), xLabel: S.visible(panel.x_label), yLabel: S.visible(panel.y_label), xNames: panel.x_names });
    g.save(); g.beginPath(); g.rect(box.x, box.y, box.w, box.h); g.clip();
    for (const s of [...series].sort((a, b) => a.layer - b.layer)) {
      if (s.kind_ === "Span") { g.fillStyle = S.theme.band; g.fillRect(toX(s.low), box.y, toX(s.high) - toX(s.low), box.h); continue; }
      g.beginPath();
      if (s.kind_ === "Band") {
        s.x.forEach((x, k) => (k ? g.lineTo(toX(x), toY(s.high[k])) : g.moveTo(toX(x), toY(s.high[k]))));
        for (let k = s.x.length - 1; k >= 0; k--) g.lineTo(toX(s.x[k]), toY(s.low[k]));
        g.fillStyle = S.theme.band; g.fill();
      } else if (s.kind_ === "Line") {
        let pen = false;
        s.x.forEach((x, k) => { const ok = Number.isFinite(x + s.y[k]); if (ok) { if (pen) g.lineTo(toX(x), toY(s.y[k])); else g.moveTo(toX(x), toY(s.y[k])); } pen = ok; });
        g.strokeStyle = colourOf(s.colour); g.lineWidth = 1.5 * s.width; g.setLineDash(s.is_dashed ? [6, 4] : []); g.stroke(); g.setLineDash([]); g.lineWidth = 1;
      } else {
        const shape = SHAPES[s.marker] ?? Number(s.marker);
        s.x.forEach((x, k) => { if (Number.isFinite(x + s.y[k])) S.marker(g, shape, toX(x), toY(s.y[k]), Math.max(1.5, 0.8 * s.size)); });
        g.globalAlpha = Math.max(0.5, s.opacity); g.fillStyle = colourOf(s.colour); g.fill(); g.globalAlpha = 1;
        if (s.run || s.rows) membersOf(s).forEach((members, k) => { if (members.length && Number.isFinite(s.x[k] + s.y[k])) points.push({ px: toX(s.x[k]), py: toY(s.y[k]), members }); });
        if (s.spread) { g.beginPath(); s.x.forEach((x, k) => { g.moveTo(toX(x), toY(s.y[k] - s.spread[k])); g.lineTo(toX(x), toY(s.y[k] + s.spread[k])); }); g.strokeStyle = colourOf(s.colour); g.stroke(); }
      }
    }
    // what is selected elsewhere
    g.beginPath();
    if (S.nSelected) for (const point of points) if (isChosen(point)) { g.moveTo(point.px + 5, point.py); g.arc(point.px, point.py, 5, 0, 6.2832); }
    g.strokeStyle = S.theme.warm; g.lineWidth = 1.5; g.stroke(); g.lineWidth = 1;
    g.restore();
    return points;
  }

  /** A picture of a kind: a rectangle, a click or keys select the states of its points. */
  function kindPanel(panel, number, caption) {
    let points = [], brush = null, at = -1;
    const chosen = (near, event) => S.select([...new Set(near.flatMap((point) => point.members))].sort((a, b) => a - b), event.shiftKey);
    const linked = panel.series.some((s) => s.run || s.rows), sweeps = panel.series.some((s) => s.sweep);
    const step = (by) => { if (points.length) at = (at + by + points.length + (by < 0 && at < 0)) % points.length; S.redraw(); };
    const made = S.panel({
      id: `kind${number}`, title: `${panel.title ? `${panel.title}, ` : ""}${panel.y_label}${panel.x_label ? ` over ${panel.x_label}` : ""}`, about: caption, height: 340,
      how: linked ? `Drag a rectangle, or click on a point: select the states of these points in all panels; with Shift they are added. Left and right arrows: go from point to point; Enter selects; Escape clears the selection. ${sweeps ? "A point of a clamped run is an average over cycles; of it are the states of its sweep that are nearest in torque." : ""}` : "",
      draw: (canvas) => {
        points = drawPanel(canvas, panel);
        const g = canvas.getContext("2d");
        brush?.draw(g);
        if (at >= 0 && points[at]) { g.strokeStyle = S.theme.ink; g.strokeRect(points[at].px - 7, points[at].py - 7, 14, 14); }
        return S.nSelected && points.length ? `${points.filter(isChosen).length} of ${points.length} points are of selected states.` : "";
      },
      depends: () => `${S.version}/${at}/${brush?.key() ?? ""}`,
      key: linked ? S.onKeys({ ArrowRight: () => step(1), ArrowLeft: () => step(-1) }, () => points[at]?.members) : undefined,
      table: () => ({
        head: ["series", panel.x_label || "place", panel.y_label, "low", "high"],
        rows: panel.series.flatMap((s, k) => (s.x ? [...s.x.keys()].map((i) => {
          const half = s.spread ? s.spread[i] : NaN, y = s.y ? s.y[i] : NaN;
          return [s.label || `${s.kind_.toLowerCase()} ${k + 1}`, panel.x_names?.[Math.round(s.x[i])] ?? s.x[i], y, s.low ? s.low[i] : y - half, s.high ? s.high[i] : y + half];
        }) : [[s.label || s.kind_.toLowerCase(), "", NaN, s.low, s.high]])),
      }),
    });
    if (!linked) return;
    brush = S.brush(made.canvas, () => ({ px: points.map((point) => point.px), py: points.map((point) => point.py) }), (near, event) => chosen(near.map((k) => points[k]), event));
  }

  /** Pages of clamped, friction and other kinds of experiment: pictures, tables, sentences. */
  S.kindPanels = function () {
    let number = 0, tables = 0;
    for (const page of S.data.pages) {
      const section = S.make("section", { className: "panel kind", "aria-label": S.visible(page.title) }, S.make("h2", {}, page.title));
      S.place(section);
      if (!page.blocks.length) section.append(S.make("p", {}, page.why_empty));
      for (const block of page.blocks) {
        if (block.kind_ === "Subheading") section.append(S.make("h3", {}, block.text));
        else if (block.kind_ === "Sentence") section.append(S.make("p", { className: block.level }, (block.level === "warning" ? "Warning: " : "") + words(block.words)));
        else if (block.kind_ === "Listing") section.append(S.make("ul", {}, ...block.sentences.map((sentence) => S.make("li", {}, words(sentence.words)))));
        else if (block.kind_ === "Table") {
          const table = S.make("table");
          // pictures and tables have one unit for angles
          const scales = block.columns.map((column) => (column.unit === "rad" ? 1e3 : 1)), unit = (column) => (column.unit === "rad" ? "mrad" : column.unit);
          S.fill(table, block.columns.map((column) => (column.unit ? `${column.title} [${unit(column)}]` : column.title || "remark")), block.rows.map((row) => row.map((cell, k) => words(cell, scales[k]))), block.caption);
          section.append(S.make("div", { className: "scroll", tabIndex: 0, role: "region", "aria-label": S.visible(`${block.caption || page.title}, table ${++tables}`) }, table));
        } else block.panels.forEach((panel, k) => { if (panel.series.length) kindPanel(panel, ++number, k ? "" : words(block.caption || [])); });
      }
    }
  };
})(stiffcal);
