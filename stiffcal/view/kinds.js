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

  /** States that a series' point is of: a row of the fit, or a run; none where it is of neither. */
  function membersOf(s, k) {
    if (s.rows && S.data.fitted_rows) { const i = S.data.fitted_rows[s.rows[k]]; return i >= 0 ? [i] : []; }
    const run = s.run ? S.data.runs.findIndex((entry) => entry.name === s.run) : -1;
    return run >= 0 ? S.members[run] : [];
  }

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
        if (s.run || s.rows) s.x.forEach((x, k) => { if (Number.isFinite(x + s.y[k])) points.push({ px: toX(x), py: toY(s.y[k]), members: () => membersOf(s, k), run: s.run }); });
        if (s.spread) { g.beginPath(); s.x.forEach((x, k) => { g.moveTo(toX(x), toY(s.y[k] - s.spread[k])); g.lineTo(toX(x), toY(s.y[k] + s.spread[k])); }); g.strokeStyle = colourOf(s.colour); g.stroke(); }
      }
    }
    // what is selected elsewhere
    g.beginPath();
    const runs = new Map();
    const isChosen = (point) => {
      if (!point.run) return point.members().some((i) => S.selected[i]);
      if (!runs.has(point.run)) runs.set(point.run, point.members().some((i) => S.selected[i]));
      return runs.get(point.run);
    };
    if (S.nSelected) for (const point of points) if (isChosen(point)) { g.moveTo(point.px + 5, point.py); g.arc(point.px, point.py, 5, 0, 6.2832); }
    g.strokeStyle = S.theme.warm; g.lineWidth = 1.5; g.stroke(); g.lineWidth = 1;
    g.restore();
    return points;
  }

  /** A picture of a kind: a rectangle, a click or keys select the states of its points. */
  function kindPanel(panel, number, caption) {
    let points = [], drag = null, at = -1;
    const chosen = (near, event) => S.select([...new Set(near.flatMap((point) => point.members()))].sort((a, b) => a - b), event.shiftKey);
    const linked = panel.series.some((s) => s.run || s.rows);
    const made = S.panel({
      id: `kind${number}`, title: `${panel.title ? `${panel.title}, ` : ""}${panel.y_label}${panel.x_label ? ` over ${panel.x_label}` : ""}`, about: caption, height: 340,
      how: linked ? "Drag a rectangle, or click on a point: select the states of these points in all panels; with Shift they are added. Left and right arrows: go from point to point; Enter selects; Escape clears the selection. Points of clamped runs are averages over cycles and stand for their whole run." : "",
      draw: (canvas) => {
        points = drawPanel(canvas, panel);
        const g = canvas.getContext("2d");
        if (drag) { g.strokeStyle = S.theme.accent; g.setLineDash([4, 3]); g.strokeRect(drag.from[0], drag.from[1], drag.to[0] - drag.from[0], drag.to[1] - drag.from[1]); g.setLineDash([]); }
        if (at >= 0 && points[at]) { g.strokeStyle = S.theme.ink; g.strokeRect(points[at].px - 7, points[at].py - 7, 14, 14); }
        return S.nSelected && points.length ? `${points.filter((point) => point.members().some((i) => S.selected[i])).length} of ${points.length} points are of selected states.` : "";
      },
      depends: () => `${S.version}/${at}/${drag ? drag.to.join() : ""}`, key: linked ? key : undefined,
      table: () => ({ head: ["series", panel.x_label || "place", panel.y_label], rows: panel.series.flatMap((s, k) => (s.x && s.y ? [...s.x.keys()].map((i) => [s.label || String(k + 1), panel.x_names?.[s.x[i]] ?? s.x[i], s.y[i]]) : [])) }),
    });
    function key(event) {
      if (event.key === "ArrowRight" || event.key === "ArrowLeft") {
        const n = points.length;
        if (n) at = event.key === "ArrowRight" ? (at + 1) % n : (at + n - 1 + (at < 0)) % n;
        S.redraw();
      } else if ((event.key === "Enter" || event.key === " ") && points[at]) chosen([points[at]], event);
      else if (event.key === "Escape") S.select([]);
      else return false;
      return true;
    }
    if (!linked) return;
    const where = (event) => { const rect = made.canvas.getBoundingClientRect(); return [event.clientX - rect.left, event.clientY - rect.top]; };
    made.canvas.addEventListener("pointerdown", (event) => { drag = { from: where(event), to: where(event) }; made.canvas.setPointerCapture(event.pointerId); });
    made.canvas.addEventListener("pointermove", (event) => { if (drag) { drag.to = where(event); S.redraw(); } });
    made.canvas.addEventListener("pointercancel", () => { drag = null; S.redraw(); });
    made.canvas.addEventListener("pointerup", (event) => {
      if (!drag) return;
      const [[x0, x1], [y0, y1]] = [0, 1].map((k) => [drag.from[k], drag.to[k]].sort((a, b) => a - b));
      drag = null;
      const far = (point) => Math.hypot(point.px - x0, point.py - y0), click = x1 - x0 < 4 && y1 - y0 < 4;
      const nearest = points.reduce((best, point) => (far(point) < (best ? far(best) : 12) ? point : best), null);
      chosen(click ? (nearest ? [nearest] : []) : points.filter((point) => point.px >= x0 && point.px <= x1 && point.py >= y0 && point.py <= y1), event);
    });
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
