(function (S) {
  /** A name in two lines of a smaller letter, the second "" where one holds it. */
  function twoLines(g, text, width) {
    const words = text.split(" ");
    let first = words.shift();
    while (words.length && g.measureText(`${first} ${words[0]}`).width <= width) first += ` ${words.shift()}`;
    return [first, words.join(" ")];
  }
  /** A name in one line, or in two where it is longer than there is room; a short one where it is longer than both. */
  function writeName(g, text, short, width, x, y) {
    g.textAlign = "left";
    g.textBaseline = "middle";
    if (g.measureText(text).width <= width) {
      g.fillText(text, x, y);
      return;
    }
    g.font = "11px system-ui, sans-serif";
    const isWhole = (lines) => lines.every((line) => g.measureText(line).width <= width),
      lines = [text, short].map((name) => twoLines(g, name, width)),
      [first, second] = lines.find(isWhole) ?? lines[1];
    g.fillText(S.shortened(g, first, width), x, second ? y - 6 : y);
    if (second) g.fillText(S.shortened(g, second, width), x, y + 6);
    g.font = "12px system-ui, sans-serif";
  }

  /** Two strokes across a bar that is longer than the scale. */
  function writeCut(g, end, y, height) {
    g.fillStyle = S.theme.ground;
    for (const at of [10, 15]) {
      g.beginPath();
      g.moveTo(end - at, y + height - 5);
      g.lineTo(end - at + 4, y + 3);
      g.lineTo(end - at + 6, y + 3);
      g.lineTo(end - at + 2, y + height - 5);
      g.closePath();
      g.fill();
    }
  }

  /** Where a row's figure begins: behind its bar and frame, and behind a line that would cross it. */
  function startOfFigure(g, row, end, line) {
    const start = end + 5;
    return line > end && line < start + g.measureText(row.text).width ? line + 5 : start;
  }

  function writeRow(g, row, y, { left, right, width, height, toX, lineX }) {
    const middle = y + height / 2 - 1;
    g.fillStyle = row.chosen ? S.theme.chosen : S.theme.ground;
    g.fillRect(0, y, width, height - 2);
    g.fillStyle = row.grey ? S.theme.quiet : S.theme.ink;
    const [name, short] = [row.name, row.short ?? row.name].map((words) => (row.chosen ? "▸ " : "") + S.visible(words));
    writeName(g, name, short, left - 10, 4, middle);
    if (row.value > 0) {
      const end = Math.min(toX(row.value), width - right + 4);
      g.fillStyle = row.grey ? S.theme.line : S.theme.series[0];
      g.fillRect(left, y + 4, end - left, height - 10);
      if (end < toX(row.value)) writeCut(g, end, y, height);
      g.fillStyle = S.theme.ink;
      g.fillText(row.text, startOfFigure(g, row, Math.max(end, row.second > 0 ? toX(row.second) : 0), lineX), middle);
    } else {
      g.fillStyle = S.theme.quiet;
      g.fillText(row.text, startOfFigure(g, row, left, lineX), middle);
    }
    if (row.second > 0) {
      g.strokeStyle = S.theme.warm;
      g.lineWidth = 2;
      g.strokeRect(left, y + 4, toX(row.second) - left, height - 10);
      g.lineWidth = 1;
    }
  }

  /** Bars with names, one below the other; returns where each is. */
  S.bars = function (g, width, rows, options) {
    const right = Math.max(64, ...rows.map((row) => g.measureText(row.text).width + 12)),
      height = options.rowHeight,
      { top, line, log } = options;
    const names = Math.max(...rows.map((row) => g.measureText(`▸ ${S.visible(row.name)}`).width)) + 14;
    const left = Math.max(90, Math.min(names, 0.45 * width, width - right - 70));
    const most = options.most || Math.max(...rows.map((row) => Math.max(row.value || 0, row.second || 0)), line || 0) || 1;
    const least = log ? Math.min(...rows.flatMap((row) => [row.value, row.second]).filter((v) => v > 0), line || most) / 2 : 0;
    const share = (v) => (log ? Math.max(Math.log(v / least), 0) / Math.log((most * 1.15) / least) : v / (most * 1.15));
    const toX = (v) => left + share(v) * (width - left - right);
    const x = line ? Math.round(toX(line)) + 0.5 : 0;
    rows.forEach((row, k) => writeRow(g, row, top + k * height, { left, right, width, height, toX, lineX: x }));
    if (line) {
      g.strokeStyle = S.theme.accent;
      g.setLineDash([5, 4]);
      g.beginPath();
      g.moveTo(x, top - 4);
      g.lineTo(x, top + rows.length * height);
      g.stroke();
      g.setLineDash([]);
      g.fillStyle = S.theme.accent;
      g.textAlign = "center";
      g.textBaseline = "bottom";
      g.fillText(options.lineLabel, Math.max(x, left + 30), top - 5);
    }
    return (y) => {
      const k = Math.floor((y - top) / height);
      return k >= 0 && k < rows.length ? k : -1;
    };
  };
})(stiffcal);
