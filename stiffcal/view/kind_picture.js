(function (S) {
  const SHAPES = { "^": 1, s: 2, v: 3, o: 0, x: 6 };
  /** Letters of the name of a row that are written. */
  const MOST_LETTERS = 48;
  const colourOf = (colour) =>
    typeof colour === "number" ? S.theme.series[colour % S.theme.series.length] : colour === "quiet" ? S.theme.quiet : S.theme.ink;
  const shapeOf = (s) => SHAPES[s.marker] ?? Number(s.marker);

  /** How each kind of series is drawn; marks return their points that are of states. */
  const DRAW = {
    Span(g, s, box, { toX }) {
      g.fillStyle = S.theme.band;
      g.fillRect(toX(s.low), box.y, toX(s.high) - toX(s.low), box.h);
    },
    Band(g, s, box, { toX, toY }) {
      g.beginPath();
      s.x.forEach((x, k) => (k ? g.lineTo(toX(x), toY(s.high[k])) : g.moveTo(toX(x), toY(s.high[k]))));
      for (let k = s.x.length - 1; k >= 0; k--) g.lineTo(toX(s.x[k]), toY(s.low[k]));
      g.fillStyle = S.theme.band;
      g.fill();
    },
    Line(g, s, box, { toX, toY }) {
      let pen = false;
      g.beginPath();
      s.x.forEach((x, k) => {
        const known = Number.isFinite(x + s.y[k]);
        if (known) {
          if (pen) g.lineTo(toX(x), toY(s.y[k]));
          else g.moveTo(toX(x), toY(s.y[k]));
        }
        pen = known;
      });
      g.strokeStyle = colourOf(s.colour);
      g.lineWidth = 1.5 * s.width;
      g.setLineDash(s.is_dashed ? [6, 4] : []);
      g.stroke();
      g.setLineDash([]);
      g.lineWidth = 1;
    },
    Marks(g, s, box, { toX, toY }) {
      const known = [...s.x.keys()].filter((k) => Number.isFinite(s.x[k] + s.y[k]));
      g.beginPath();
      for (const k of known) S.marker(g, shapeOf(s), toX(s.x[k]), toY(s.y[k]), Math.max(1.5, 0.8 * s.size));
      g.globalAlpha = Math.max(0.5, s.opacity);
      g.fillStyle = colourOf(s.colour);
      g.fill();
      g.globalAlpha = 1;
      if (s.spread) {
        g.beginPath();
        for (const k of known) {
          g.moveTo(toX(s.x[k]), toY(s.y[k] - s.spread[k]));
          g.lineTo(toX(s.x[k]), toY(s.y[k] + s.spread[k]));
        }
        g.strokeStyle = colourOf(s.colour);
        g.stroke();
      }
      if (!s.run && !s.rows) return [];
      const members = S.statesOfPoints(s);
      return known.filter((k) => members[k].length).map((k) => ({ px: toX(s.x[k]), py: toY(s.y[k]), members: members[k] }));
    },
  };

  const markOf = (g, s) => (x, y) => {
    g.fillStyle = s.kind_ === "Band" || s.kind_ === "Span" ? S.theme.band : colourOf(s.colour);
    if (s.kind_ === "Marks") {
      g.beginPath();
      S.marker(g, shapeOf(s), x + 6, y, 4);
      g.fill();
    } else g.fillRect(x, y - 2, 12, s.kind_ === "Line" ? 3 : 8);
  };

  /** Limits of an axis that begins at zero or below, with room above, where a panel asks for that. */
  function fromZero({ head_room: room }, [low, high]) {
    if (room === null || room === undefined) return [low, high];
    const least = Math.min(low, 0);
    return [least, high + room * (high - least)];
  }

  /** Values along y that a series needs room for. */
  function heights(s) {
    if (!s.y) return [...s.low, ...s.high];
    return s.spread ? [...s.y].flatMap((y, k) => [y - s.spread[k], y + s.spread[k]]) : [...s.y];
  }

  /** Draw one pair of axes of a picture; returns the points that are of states. */
  S.drawKindPanel = function (canvas, panel) {
    const { g, width, height } = S.begin(canvas),
      { series } = panel,
      curves = series.filter((s) => s.x);
    const xs = curves.flatMap((s) => [...s.x]),
      ys = curves.flatMap(heights);
    if (!xs.length) {
      g.fillStyle = S.theme.quiet;
      g.fillText(S.visible(panel.empty), 20, 40);
      return [];
    }
    const isFirst = (entry, k) => entry.label && series.findIndex((other) => other.label === entry.label) === k;
    const entries = series.filter(isFirst).map((s) => ({ word: s.label, mark: markOf(g, s) }));
    const top = 14 + 16 * (entries.length ? S.keys(g, { x: 74, w: width - 92 }, entries) : 0),
      names = panel.y_names ?? [],
      // names of rows have the room that the longest one needs, half of the picture at most
      left = Math.min(width / 2, Math.max(74, ...names.map((name) => 12 + g.measureText(S.visible(name)).width))),
      box = { x: left, y: top, w: width - left - 18, h: height - 48 - top };
    const axes = S.axes(g, box, {
      x: panel.x_limits || S.span(xs),
      y: panel.y_limits || fromZero(panel, S.span(ys.length ? ys : [0, 1])),
      xLabel: S.visible(panel.x_label),
      yLabel: S.visible(panel.y_label),
      xNames: panel.x_names,
      yNames: names,
      yLetters: MOST_LETTERS,
    });
    g.save();
    g.beginPath();
    g.rect(box.x, box.y, box.w, box.h);
    g.clip();
    const points = [...series].sort((a, b) => a.layer - b.layer).flatMap((s) => DRAW[s.kind_](g, s, box, axes) || []);
    // what is selected elsewhere
    g.beginPath();
    if (S.nSelected)
      for (const point of points)
        if (S.isChosenPoint(point)) {
          g.moveTo(point.px + 5, point.py);
          g.arc(point.px, point.py, 5, 0, 6.2832);
        }
    g.strokeStyle = S.theme.warm;
    g.lineWidth = 1.5;
    g.stroke();
    g.lineWidth = 1;
    g.restore();
    return points;
  };
  S.isChosenPoint = (point) => point.members.some((i) => S.selected[i]);
})(stiffcal);
