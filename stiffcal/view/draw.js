(function (S) {
  const CATEGORIES = 8;
  /** Colours of the theme, from the style sheet. */
  S.readTheme = function () {
    S.themeName = matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
    const style = getComputedStyle(document.documentElement);
    const get = (name) => style.getPropertyValue(name).trim();
    S.theme = {
      ink: get("--ink"),
      quiet: get("--quiet"),
      line: get("--line"),
      ground: get("--panel"),
      accent: get("--accent"),
      warm: get("--warm"),
      band: get("--band"),
      chosen: get("--chosen"),
      ghost: get("--ghost"),
      series: Array.from({ length: CATEGORIES }, (_, k) => get(`--series${k}`)),
      scale: get("--scale").split(" "),
    };
  };

  /** A canvas in pixels of the screen; lengths are CSS pixels. @param {HTMLCanvasElement} canvas */
  S.begin = function (canvas) {
    const ratio = S.drawsFile ? S.fileRatio : window.devicePixelRatio || 1;
    const width = canvas.clientWidth || 300,
      height = canvas.clientHeight || 200;
    if (canvas.width !== Math.round(width * ratio)) canvas.width = Math.round(width * ratio);
    if (canvas.height !== Math.round(height * ratio)) canvas.height = Math.round(height * ratio);
    // drawn by the processor: quick without a graphics card, and quick enough with one
    const g = canvas.getContext("2d", { willReadFrequently: true, alpha: false });
    g.setTransform(ratio, 0, 0, ratio, 0, 0);
    g.fillStyle = S.theme.ground;
    g.fillRect(0, 0, width, height);
    g.font = "12px system-ui, sans-serif";
    g.lineWidth = 1;
    return { g, width, height };
  };

  /** Round numbers within a span. @param {number} low @param {number} high @param {number} count */
  S.ticks = function (low, high, count) {
    const rough = (high - low) / Math.max(count, 1);
    if (!(rough > 0)) return [low];
    const marks = (step) => {
      const first = Math.ceil(low / step - 1e-9);
      return Array.from({ length: Math.floor(high / step + 1e-9) - first + 1 }, (_, k) => (first + k) * step);
    };
    // one mark is no scale: of the steps from the wanted one on, ever finer, the first with two
    const steps = [10, 5, 2, 1, 0.5, 0.2].map((k) => k * 10 ** Math.floor(Math.log10(rough))).filter((_, k, all) => !(all[k + 1] >= rough));
    return marks(steps.find((step) => marks(step).length > 1) ?? steps[0]);
  };

  /** Texts of marks on an axis: as many digits as neighbours need to differ. @param {number[]} marks @returns {string[]} */
  S.tickTexts = function (marks) {
    const step = marks.length > 1 ? marks[1] - marks[0] : 0,
      most = Math.max(...marks.map(Math.abs));
    if (!(step > 0) || most >= 1e5 || step < 1e-4) return marks.map(S.digits);
    const decimals = Math.max(0, Math.ceil(-Math.log10(step) - 1e-9));
    return marks.map((mark) => mark.toFixed(decimals).replace("-", "−"));
  };

  /** @param {number[]} values @returns {number} NaN of none */
  S.median = function (values) {
    const sorted = [...values].sort((a, b) => a - b),
      half = sorted.length / 2;
    return sorted.length % 2 ? sorted[Math.floor(half)] : (sorted[half - 1] + sorted[half]) / 2;
  };

  /**
   * Share of the weighted variance that a parabola explains, for its three numbers corrected; 0 where it is none.
   * @param {number[]} x @param {number[]} y @param {number[]} weight
   */
  S.parabolaShare = function (x, y, weight) {
    const n = x.length,
      [low, high] = S.span(x, 0);
    if (n < 4 || !(high > low)) return 0;
    // normal equations [U'WU | U'Wy] of 1, u and u², u from −1 to 1, and y'Wy, eliminated row by row (Cholesky's order)
    const m = [
      [0, 0, 0, 0],
      [0, 0, 0, 0],
      [0, 0, 0, 0],
      [0, 0, 0, 0],
    ];
    for (let i = 0; i < n; i++) {
      const u = (2 * (x[i] - low)) / (high - low) - 1,
        row = [1, u, u * u, y[i]];
      for (let a = 0; a < 4; a++) for (let b = a; b < 4; b++) m[a][b] += weight[i] * row[a] * row[b];
    }
    const whole = m[0][0];
    let free = n,
      about = 0;
    for (let k = 0; k < 3; k++) {
      if (k === 1) about = m[3][3];
      if (!(m[k][k] > 1e-9 * whole)) continue;
      free--;
      for (let a = k + 1; a < 4; a++) for (let b = a; b < 4; b++) m[a][b] -= (m[k][a] * m[k][b]) / m[k][k];
    }
    return free > 0 && about > 0 ? Math.max(0, 1 - m[3][3] / free / (about / (n - 1))) : 0;
  };

  /**
   * The share that the best of several curves explains by chance: its level in `rounds` shuffles that 95 of 100 do not exceed.
   * @param {(order: number[]) => number} best the largest share where pose k has the variables of pose order[k] @param {number} poses @param {number} rounds
   */
  S.shareByChance = function (best, poses, rounds) {
    const order = [...Array(poses).keys()],
      found = [];
    let seed = 1;
    for (let round = 0; round < rounds; round++) {
      for (let k = poses - 1; k > 0; k--) {
        seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0;
        const other = Math.floor((seed / 4294967296) * (k + 1));
        [order[k], order[other]] = [order[other], order[k]];
      }
      found.push(best(order));
    }
    return found.sort((a, b) => a - b)[Math.floor(0.95 * rounds)];
  };

  /** Ends of finite numbers, with a margin. @param {Iterable<number>} values */
  S.span = function (values, margin = 0.05) {
    let low = Infinity,
      high = -Infinity;
    for (const value of values)
      if (Number.isFinite(value)) {
        if (value < low) low = value;
        if (value > high) high = value;
      }
    if (low > high) return [0, 1];
    const room = high > low ? (high - low) * margin : Math.abs(high) * 0.1 || 1;
    return [low - room, high + room];
  };

  /** A text, in two lines of about one length where it is longer than there is room. */
  function inTwo(g, text, room) {
    const words = text.split(" "),
      wide = (some) => g.measureText(some.join(" ")).width;
    if (words.length < 2 || wide(words) <= room) return [text];
    const splits = words.slice(1).map((_, k) => [words.slice(0, k + 1), words.slice(k + 1)]);
    const longer = (pair) => Math.max(...pair.map(wide));
    return splits.reduce((best, pair) => (longer(pair) < longer(best) ? pair : best)).map((some) => some.join(" "));
  }

  /**
   * Axes with labels; returns how numbers become pixels.
   * @param {CanvasRenderingContext2D} g @param {{x: number, y: number, w: number, h: number}} box
   * @param {{x: number[], y: number[], xLabel: string, yLabel: string, xNames?: string[], yNames?: string[], yLetters?: number}} axes
   */
  S.axes = function (g, box, axes) {
    const toX = (v) => box.x + ((v - axes.x[0]) / (axes.x[1] - axes.x[0])) * box.w;
    const toY = (v) => box.y + box.h - ((v - axes.y[0]) / (axes.y[1] - axes.y[0])) * box.h;
    g.strokeStyle = S.theme.line;
    g.fillStyle = S.theme.quiet;
    g.textBaseline = "top";
    g.textAlign = "center";
    const names = axes.xNames || [];
    const marks = names.length ? names.map((_, k) => k) : S.ticks(axes.x[0], axes.x[1], Math.max(2, box.w / 60));
    const every = names.length ? Math.ceil(names.length / Math.max(1, box.w / 84)) : 1;
    const texts = names.length ? names.map((name) => S.visible(name).slice(0, 12)) : S.tickTexts(marks);
    g.beginPath();
    marks.forEach((mark, k) => {
      if (k % every) return;
      const x = Math.round(toX(mark)) + 0.5;
      g.moveTo(x, box.y);
      g.lineTo(x, box.y + box.h);
      g.fillText(texts[k], x, box.y + box.h + 4);
    });
    g.textAlign = "right";
    g.textBaseline = "middle";
    const named = axes.yNames && axes.yNames.length > 0;
    const rows = named
        ? axes.yNames.map((_, k) => k).filter((k) => k % Math.ceil(axes.yNames.length / Math.max(1, box.h / 16)) === 0)
        : S.ticks(axes.y[0], axes.y[1], Math.max(2, box.h / 45)),
      rowTexts = named ? rows.map((k) => S.visible(axes.yNames[k]).slice(0, axes.yLetters || 9)) : S.tickTexts(rows);
    rows.forEach((mark, k) => {
      const y = Math.round(toY(mark)) + 0.5;
      g.moveTo(box.x, y);
      g.lineTo(box.x + box.w, y);
      g.fillText(rowTexts[k], box.x - 4, y);
    });
    g.stroke();
    g.fillStyle = S.theme.ink;
    g.textAlign = "center";
    g.textBaseline = "bottom";
    g.fillText(axes.xLabel, box.x + box.w / 2, box.y + box.h + 36, box.w);
    g.save();
    g.translate(14, box.y + box.h / 2);
    g.rotate(-Math.PI / 2);
    g.textBaseline = "middle";
    const lines = inTwo(g, axes.yLabel, box.h);
    lines.forEach((line, k) => g.fillText(line, 0, 13 * (k - (lines.length - 1) / 2), box.h));
    g.restore();
    return { toX, toY };
  };

  const SHAPES = ["o", "^", "s", "v", "d", "+", "x", "-"];
  /** Add a marker to the path; categories differ in shape as in colour. */
  S.marker = function (g, shape, x, y, r) {
    switch (SHAPES[shape % SHAPES.length]) {
      case "o":
        g.moveTo(x + r, y);
        g.arc(x, y, r, 0, 6.2832);
        break;
      case "^":
        g.moveTo(x, y - r);
        g.lineTo(x + r, y + r);
        g.lineTo(x - r, y + r);
        g.closePath();
        break;
      case "v":
        g.moveTo(x, y + r);
        g.lineTo(x + r, y - r);
        g.lineTo(x - r, y - r);
        g.closePath();
        break;
      case "s":
        g.rect(x - r, y - r, 2 * r, 2 * r);
        break;
      case "d":
        g.moveTo(x, y - r);
        g.lineTo(x + r, y);
        g.lineTo(x, y + r);
        g.lineTo(x - r, y);
        g.closePath();
        break;
      case "+":
        g.rect(x - r, y - 1, 2 * r, 2);
        g.rect(x - 1, y - r, 2, 2 * r);
        break;
      case "x":
        g.moveTo(x - r, y - r + 1);
        g.lineTo(x + r - 1, y + r);
        g.lineTo(x + r, y + r - 1);
        g.lineTo(x - r + 1, y - r);
        g.closePath();
        break;
      default:
        g.rect(x - r, y - 1, 2 * r, 2);
    }
  };
})(stiffcal);
