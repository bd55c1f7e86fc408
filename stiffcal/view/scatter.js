(function (S) {
  const MOST_LEVELS = 8,
    MANY = 2500;

  /**
   * The points of a residual by the axes of the state: each of a state; three of each state where components are drawn apart.
   * @param {any} residual as `S.residual` returns it
   */
  S.pointsOf = function (residual) {
    const across = S.quantity(S.state.x, residual),
      up = S.quantity(S.state.y, residual),
      { used } = S.data.states;
    const wide = across.wide || up.wide || S.state.colour === "component",
      count = wide ? 3 * S.n : S.n;
    const stateOf = wide ? (p) => (p / 3) | 0 : (p) => p;
    const valueOf = (quantity, p) => (!quantity.wide ? quantity.values[stateOf(p)] : quantity.values ? quantity.values[p] : p % 3);
    const x = Float64Array.from({ length: count }, (_, p) => valueOf(across, p));
    const y = Float64Array.from({ length: count }, (_, p) => (used[stateOf(p)] ? valueOf(up, p) : NaN));
    return { residual, across, up, count, stateOf, valueOf, x, y };
  };

  /** Number of the colour of each point, and the legend. @param {any} points @param {any[]} others models on the same scale */
  S.coloursOf = function (points, others) {
    const numbers = new Int8Array(points.count),
      { colour } = S.state;
    if (colour === "none") return { numbers, legend: [], palette: S.theme.series, scale: false };
    const quantity = S.quantity(colour, points.residual),
      { levels } = quantity;
    if (levels.length && levels.length <= MOST_LEVELS) {
      for (let p = 0; p < points.count; p++) {
        const value = points.valueOf(quantity, p);
        numbers[p] = Number.isFinite(value) ? value : -1;
      }
      return { numbers, legend: levels, palette: S.theme.series, scale: false };
    }
    const all = colour.startsWith("r.") ? [quantity, ...others.map((other) => S.quantity(colour, other))] : [quantity];
    const [low, high] = S.locked(
        `colour ${colour}`,
        S.span(
          all.flatMap((entry) => [...entry.values]),
          0,
        ),
      ),
      shades = S.theme.scale.length;
    for (let p = 0; p < points.count; p++) {
      const value = points.valueOf(quantity, p);
      numbers[p] = Number.isFinite(value) ? Math.max(0, Math.min(shades - 1, Math.floor(((value - low) / (high - low || 1)) * shades))) : -1;
    }
    const end = (v) => (levels.length ? levels[Math.round(v)] : `${S.digits(v)} ${quantity.unit}`);
    return { numbers, legend: [`${quantity.label}: ${end(low)}`, end(high)], palette: S.theme.scale, scale: true };
  };

  /** The noise, ± 2σ of what the axes show. */
  function bands(g, box, { across, up }, { x, y }, { toX, toY }) {
    g.fillStyle = S.theme.band;
    if (up.sigma > 0) {
      const sigma = 2 * up.sigma,
        low = S.state.y === "r.length" ? 0 : -sigma;
      g.fillRect(box.x, toY(sigma), box.w, toY(low) - toY(sigma));
    }
    if (across.sigma > 0) {
      const left = toX(Math.max(-2 * across.sigma, x[0])),
        right = toX(Math.min(2 * across.sigma, x[1]));
      g.fillRect(left, box.y, right - left, box.h);
    }
  }

  const placed = (values, levels, to) => {
    // points of one level are spread, so that they do not lie on each other
    const spread = (p) => (levels.length ? 0.3 * (((p * 0.618034) % 1) - 0.5) : 0);
    return Float64Array.from(values, (value, p) => to(value + spread(p)));
  };

  function circles(g, xs, ys, r, colour, keep = () => true) {
    g.beginPath();
    for (let p = 0; p < xs.length; p++)
      if (Number.isFinite(xs[p] + ys[p]) && keep(p)) {
        g.moveTo(xs[p] + r, ys[p]);
        g.arc(xs[p], ys[p], r, 0, 6.2832);
      }
    g.strokeStyle = colour;
    g.stroke();
  }

  /**
   * Draw points in a box; returns where they are, NaN where none is drawn.
   * @param {CanvasRenderingContext2D} g @param {{x: number, y: number, w: number, h: number}} box
   * @param {{points: any, colours: any, ends: {x: number[], y: number[]}, ghost: any, hollow: any, moved: number}} picture
   *   ghost: where points were, moved: how far they have come from there, 0 to 1; hollow: where they are forecast
   */
  S.drawPoints = function (g, box, { points, colours, ends, ghost, hollow, moved }) {
    const { across, up, count, stateOf } = points,
      { theme } = S,
      { numbers, palette, scale } = colours;
    const axes = S.axes(g, box, {
      ...ends,
      xLabel: S.withUnit(across),
      yLabel: box.yLabel ?? S.withUnit(up),
      xNames: across.levels,
      yNames: up.levels,
    });
    const { toX, toY } = axes;
    g.save();
    g.beginPath();
    g.rect(box.x, box.y, box.w, box.h);
    g.clip();
    bands(g, box, points, ends, axes);
    let { x, y } = points;
    const onPage = (at) => ({ px: placed(at.x, across.levels, toX), py: placed(at.y, up.levels, toY) }),
      before = ghost && onPage(ghost);
    if (ghost) {
      g.beginPath();
      for (let p = 0; p < count; p++) if (Number.isFinite(before.px[p] + before.py[p])) S.marker(g, 0, before.px[p], before.py[p], 1.6);
      g.fillStyle = theme.ghost;
      g.fill();
      const between = (from, to) => to.map((value, p) => (Number.isFinite(from[p]) ? from[p] + moved * (value - from[p]) : value));
      if (moved < 1) {
        x = between(ghost.x, x);
        y = between(ghost.y, y);
      }
    }
    const { px, py } = onPage({ x, y });
    const inside = (p) => px[p] >= box.x - 1 && px[p] <= box.x + box.w + 1 && py[p] >= box.y - 1 && py[p] <= box.y + box.h + 1;
    for (let p = 0; p < count; p++) if (!inside(p)) px[p] = NaN;
    const r = count > MANY ? 1.8 : 2.8;
    for (let group = -1; group < palette.length; group++) {
      g.beginPath();
      let drawn = 0;
      for (let p = 0; p < count; p++) {
        if (numbers[p] !== group || !Number.isFinite(px[p] + py[p])) continue;
        S.marker(g, scale || group < 0 ? 0 : group, px[p], py[p], r);
        drawn++;
      }
      if (drawn) {
        g.fillStyle = group < 0 ? theme.line : palette[group];
        g.fill();
      }
    }
    if (hollow) {
      const forecast = onPage(hollow);
      circles(g, forecast.px, forecast.py, 3, theme.accent);
    }
    g.lineWidth = 1.5;
    circles(g, px, py, 5, theme.warm, (p) => S.selected[stateOf(p)]);
    const apart = count / S.n;
    g.strokeStyle = theme.ink;
    for (let p = apart * S.state.at; p < apart * (S.state.at + 1); p++)
      if (Number.isFinite(px[p] + py[p])) g.strokeRect(px[p] - 7, py[p] - 7, 14, 14);
    g.restore();
    return { px, py };
  };
})(stiffcal);
