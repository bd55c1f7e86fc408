(function (S) {
  /** A text made of pieces, as other kinds of experiment write them. @param {any[]} pieces */
  function words(pieces) {
    return pieces.map((piece) => {
      if (typeof piece === "string") return piece;
      switch (piece.kind_) {
        case "Digits": return S.digits(piece.value);
        case "Interval": return `${S.digits(piece.value)} (${S.digits(piece.low)} to ${S.digits(piece.high)})`;
        case "Names": return piece.names.join(", ");
        default: return (piece.joints || []).join(", ");
      }
    }).join("");
  }
  const colourOf = (colour) => (typeof colour === "number" ? S.theme.series[colour % S.theme.series.length] : colour === "quiet" ? S.theme.quiet : S.theme.ink);
  const SHAPES = { "^": 1, v: 3, o: 0, x: 6 };

  /** Draw one pair of axes of a picture. */
  function drawPanel(canvas, panel) {
    const { g, width, height } = S.begin(canvas);
    const series = panel.series, curves = series.filter((s) => s.x), xs = curves.flatMap((s) => [...s.x]), ys = curves.flatMap((s) => (s.y ? [...s.y] : [...s.low, ...s.high]));
    const box = { x: 74, y: 30, w: width - 92, h: height - 78 };
    if (!xs.length) { g.fillStyle = S.theme.quiet; g.fillText(S.visible(panel.empty), 20, 40); return; }
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
        if (s.spread) { g.beginPath(); s.x.forEach((x, k) => { g.moveTo(toX(x), toY(s.y[k] - s.spread[k])); g.lineTo(toX(x), toY(s.y[k] + s.spread[k])); }); g.strokeStyle = colourOf(s.colour); g.stroke(); }
      }
    }
    g.restore();
    g.textAlign = "left"; g.textBaseline = "middle"; g.fillStyle = S.theme.ink;
    let x = box.x;
    const first = (entry, k) => entry.label && series.findIndex((other) => other.label === entry.label) === k;
    for (const s of series.filter(first)) {
      g.fillStyle = s.kind_ === "Band" || s.kind_ === "Span" ? S.theme.band : colourOf(s.colour);
      if (s.kind_ === "Marks") { g.beginPath(); S.marker(g, SHAPES[s.marker] ?? Number(s.marker), x + 6, 14, 4); g.fill(); } else g.fillRect(x, 12, 12, s.kind_ === "Line" ? 3 : 8);
      g.fillStyle = S.theme.ink; g.fillText(S.visible(s.label), x + 16, 14); x += 30 + g.measureText(S.visible(s.label)).width;
    }
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
          S.fill(table, block.columns.map((column) => (column.unit ? `${column.title} [${column.unit}]` : column.title || "remark")), block.rows.map((row) => row.map(words)), block.caption);
          section.append(S.make("div", { className: "scroll", tabIndex: 0, role: "region", "aria-label": S.visible(`${block.caption || page.title}, table ${++tables}`) }, table));
        } else for (const panel of block.panels) {
          number++;
          S.panel({
            id: `kind${number}`, title: `${panel.title ? `${panel.title}, ` : ""}${panel.y_label}${panel.x_label ? ` over ${panel.x_label}` : ""}`, about: words(block.caption || []), height: 340,
            draw: (canvas) => { drawPanel(canvas, panel); return panel.x_label ? `${panel.y_label} against ${panel.x_label}` : panel.y_label; },
            table: () => ({ head: ["series", panel.x_label || "place", panel.y_label], rows: panel.series.flatMap((s, k) => (s.x && s.y ? [...s.x.keys()].map((i) => [s.label || String(k + 1), panel.x_names?.[s.x[i]] ?? s.x[i], s.y[i]]) : [])) }),
          });
        }
      }
    }
  };
})(stiffcal);
