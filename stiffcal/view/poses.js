(function (S) {
  const ROW = 20,
    LINE = 13,
    LEAST_ROW = 15,
    LEAST_COLUMN = 36,
    MOST_HEIGHT = 8000;

  S.matrixPanel = function () {
    const { data } = S,
      direction = S.variableByName.get(data.direction);
    // where each run is one state, its components are the columns
    const byComponent = !S.scalar && S.n < 2 * data.runs.length;
    const { factor, name: unit } = S.units.main;
    const words = byComponent ? ["x", "y", "z"] : direction ? direction.levels : ["all"];
    // runs of another kind of experiment have nothing in this measure
    const runs = [...data.runs.keys()].filter((run) => S.members[run].some((i) => Number.isFinite(data.states.measured[0][3 * i])));
    // a heading may need a line for each of its words
    const head = 8 + LINE * Math.max(2, ...words.map((word) => word.split(" ").length));
    const height = Math.min(head + 34 + (runs.length > 40 ? LEAST_ROW : ROW) * runs.length, MOST_HEIGHT);
    const cell = (run, k) => S.members[run].filter((i) => byComponent || !direction || direction.values[i] === k);
    const of = byComponent ? "component" : direction ? direction.label : "all states";
    const panel = S.panel({
      id: "poses",
      title: "5 Poses",
      height,
      least: 70 + LEAST_COLUMN * words.length,
      about: `Error by run and ${of}, rms in ${unit} over the drawn states.`,
      how:
        "A click on a cell: select its states in all panels; with Shift they are added. Up and down arrows: choose a run; Enter " +
        "selects it; Escape clears the selection.",
      draw,
      table,
      depends: () => [S.shownKey(), S.state.run, S.version, S.scaling].join("/"),
      key: S.onKeys({ ArrowDown: () => S.stepRun(1), ArrowUp: () => S.stepRun(-1) }, () => S.members[S.state.run]),
    });
    let place = null;
    panel.canvas.addEventListener("click", (event) => {
      const k = Math.floor((event.offsetX - place.left) / place.w),
        run = runs[Math.floor((event.offsetY - head) / place.h)];
      if (run !== undefined) S.select(k >= 0 ? cell(run, k) : S.members[run], event.shiftKey);
    });
    /** (row, column) rms, SI. */
    function errors({ move }) {
      const { used } = data.states;
      return runs.map((run) => {
        const sums = words.map(() => [0, 0]);
        const add = (k, square) => {
          if (sums[k] && Number.isFinite(square)) {
            sums[k][0] += square;
            sums[k][1]++;
          }
        };
        for (const i of S.members[run]) {
          if (!used[i]) continue;
          if (byComponent) for (let k = 0; k < 3; k++) add(k, move[3 * i + k] ** 2);
          else add(direction ? direction.values[i] : 0, move[3 * i] ** 2 + move[3 * i + 1] ** 2 + move[3 * i + 2] ** 2);
        }
        return sums.map(([sum, count]) => (count ? Math.sqrt(sum / count) : NaN));
      });
    }
    let kept = { of: null, rows: [], most: 0 };
    /** Errors of what is shown, and the largest there is of it and of the model that it is compared with. */
    function shown() {
      const residual = S.residual(),
        pair = S.pair();
      if (kept.of === residual) return kept;
      const largest = (rows) => Math.max(...rows.flat().filter(Number.isFinite), 1e-12);
      const rows = errors(residual),
        others = pair ? pair.residuals.map((one) => largest(errors(one))) : [];
      kept = { of: residual, rows, most: Math.max(largest(rows), ...others) };
      return kept;
    }
    /** A heading in lines as wide as its column, broken between words. */
    function linesOf(g, text, room) {
      const lines = [];
      for (const part of text.split(" ")) {
        const last = lines[lines.length - 1],
          longer = `${last} ${part}`;
        if (last !== undefined && g.measureText(longer).width <= room) lines[lines.length - 1] = longer;
        else lines.push(part);
      }
      return lines;
    }
    function draw(canvas) {
      const { g, width, height: h } = S.begin(canvas),
        { rows, most: worst } = shown(),
        names = Math.max(...runs.map((run) => g.measureText(`▸ ● ${S.visible(data.runs[run].name)}`).width)) + 12,
        left = Math.min(names, 140, width - LEAST_COLUMN * words.length);
      place = { left, w: (width - left - 8) / words.length, h: (h - head - 8) / Math.max(runs.length, 1) };
      const every = Math.ceil(13 / place.h),
        [, most] = S.locked("errors by run", [0, worst]),
        count = S.theme.scale.length;
      const decimals = Math.max(0, Math.min(6, 2 - Math.floor(Math.log10(factor * most))));
      g.textBaseline = "middle";
      g.textAlign = "center";
      g.fillStyle = S.theme.ink;
      words.forEach((word, k) => {
        const parts = linesOf(g, S.visible(word), place.w - 6);
        parts.forEach((part, line) => g.fillText(part, left + (k + 0.5) * place.w, head - 8 - LINE * (parts.length - 1 - line), place.w - 6));
      });
      rows.forEach((row, number) => {
        const run = runs[number],
          y = head + number * place.h,
          selected = S.members[run].some((i) => S.selected[i]);
        g.textAlign = "left";
        g.fillStyle = S.theme.ink;
        if (selected) {
          g.fillStyle = S.theme.chosen;
          g.fillRect(0, y, left - 2, place.h - 1);
          g.fillStyle = S.theme.ink;
        }
        if (number % every === 0)
          g.fillText((run === S.state.run ? "▸ " : "") + (selected ? "● " : "") + S.visible(data.runs[run].name), 4, y + place.h / 2, left - 8);
        row.forEach((value, k) => {
          const x = left + k * place.w;
          if (!Number.isFinite(value)) {
            g.strokeStyle = S.theme.line;
            g.strokeRect(x + 1.5, y + 1.5, place.w - 3, place.h - 3);
            return;
          }
          const shade = Math.min(count - 1, Math.floor((value / most) * count));
          g.fillStyle = S.theme.scale[shade];
          g.fillRect(x + 1, y + 1, place.w - 2, place.h - 2);
          if (place.h >= 12 && place.w >= 30) {
            g.fillStyle = light(S.theme.scale[shade]) ? "#000000" : "#ffffff";
            g.textAlign = "center";
            g.fillText((factor * value).toFixed(decimals), x + place.w / 2, y + place.h / 2, place.w - 4);
          }
        });
      });
      return (
        `Colours from 0 (dark) to ${S.size(most)} (light), the largest error of a cell in the models shown so far; ` +
        `${S.noiseWords(S.size(S.main(data.noise)))}.`
      );
    }
    const light = (colour) => {
      const [r, gr, b] = [1, 3, 5].map((k) => parseInt(colour.slice(k, k + 2), 16));
      return 0.3 * r + 0.59 * gr + 0.11 * b > 130;
    };
    function table() {
      return {
        head: ["run", ...words.map((word) => `${word} [${unit}]`)],
        rows: shown().rows.map((row, number) => [data.runs[runs[number]].name, ...row.map((value) => factor * value)]),
      };
    }
  };
})(stiffcal);
