(function (S) {
  S.matrixPanel = function () {
    const { data } = S, direction = S.variableByName.get("direction");
    const unit = S.scalar ? "µrad" : "µm";
    const words = direction ? direction.levels : ["all"];
    const ROW = 20, height = 60 + ROW * data.runs.length;
    const cell = (run, k) => S.members[run].filter((i) => !direction || direction.values[i] === k);
    const panel = S.panel({
      id: "poses", title: "5 Poses", height: Math.min(height, 900),
      about: "Error of the shown residual by run and direction of the load, over the drawn states. A click on a cell selects its states in all panels.",
      draw, table, depends: () => `${S.shownKey()}/${S.state.run}`,
    });
    let place = null;
    panel.canvas.addEventListener("click", (event) => {
      const rect = panel.canvas.getBoundingClientRect();
      const k = Math.floor((event.clientX - rect.left - place.left) / place.w), run = Math.floor((event.clientY - rect.top - 26) / place.h);
      if (run >= 0 && run < data.runs.length) S.select(k >= 0 ? cell(run, k) : S.members[run], event.shiftKey);
    });
    /** (run, direction) rms in m. */
    function errors() {
      const move = S.residual().move;
      return data.runs.map((_, run) => words.map((__, k) => {
        const chosen = new Set(cell(run, k));
        return chosen.size ? S.rms(move, (i) => chosen.has(i)) : NaN;
      }));
    }
    let kept = { of: null, rows: [] };
    const rowsOf = () => { const of = S.residual(); if (kept.of !== of) kept = { of, rows: errors() }; return kept.rows; };
    function draw(canvas) {
      const { g, width, height: h } = S.begin(canvas), rows = rowsOf(), left = Math.min(140, width * 0.3);
      place = { left, w: (width - left - 8) / words.length, h: (h - 60) / data.runs.length };
      const every = Math.ceil(13 / place.h);
      const most = Math.max(...rows.flat().filter(Number.isFinite), 1e-12), count = S.theme.scale.length;
      g.textBaseline = "middle"; g.textAlign = "center"; g.fillStyle = S.theme.ink;
      words.forEach((word, k) => g.fillText(S.visible(word), left + (k + 0.5) * place.w, 14, place.w - 4));
      rows.forEach((row, run) => {
        const y = 26 + run * place.h;
        g.textAlign = "left"; g.fillStyle = S.theme.ink;
        if (run % every === 0) g.fillText((run === S.state.run ? "▸ " : "") + S.visible(data.runs[run].name), 4, y + place.h / 2, left - 8);
        row.forEach((value, k) => {
          const x = left + k * place.w;
          if (!Number.isFinite(value)) { g.strokeStyle = S.theme.line; g.strokeRect(x + 1.5, y + 1.5, place.w - 3, place.h - 3); return; }
          const shade = Math.min(count - 1, Math.floor((value / most) * count));
          g.fillStyle = S.theme.scale[shade];
          g.fillRect(x + 1, y + 1, place.w - 2, place.h - 2);
          if (place.h > 11 && place.w > 30) {
            g.textAlign = "center"; g.fillStyle = light(S.theme.scale[shade]) ? "#000" : "#fff";
            g.fillText(S.digits(1e6 * value), x + place.w / 2, y + place.h / 2, place.w - 4);
          }
        });
      });
      g.fillStyle = S.theme.quiet; g.textAlign = "left";
      g.fillText(`rms in ${unit}`, 4, h - 12);
      return `Largest error of a cell ${S.size(most)}; noise ${S.size(S.main(data.noise))}.`;
    }
    const light = (colour) => {
      const [r, gr, b] = [1, 3, 5].map((k) => parseInt(colour.slice(k, k + 2), 16));
      return 0.3 * r + 0.59 * gr + 0.11 * b > 130;
    };
    function table() {
      return { head: ["run", ...words.map((word) => `${word} [${unit}]`)], rows: rowsOf().map((row, run) => [data.runs[run].name, ...row.map((value) => 1e6 * value)]) };
    }
  };

  S.compliancePanel = function () {
    const { data } = S;
    const angles = data.variables.filter((variable) => /^angle\d+$/.test(variable.name));
    if (!data.effects.length || !angles.length) return;
    const effect = S.choice("Effect", data.effects.map((entry, k) => [String(k), entry.name]), (value) => S.set({ joint: Number(value) }));
    const over = S.choice("Over", angles.map((variable, k) => [String(k), variable.label]), (value) => S.set({ over: Number(value) }));
    const panel = S.panel({
      id: "compliance", title: "5b Apparent compliance by pose", height: 360,
      about: "How large an effect appears in each run against its fitted size: 1 plus the part of the residual along the effect, as a share of it, with ± 95 % from the noise. A trend over an angle shows an effect that the model lacks, also one outside the catalogue.",
      controls: [effect, over], draw, table, depends: () => `${S.shownKey()}/${S.state.joint}/${S.state.over}/${S.version}`,
    });
    let points = [];
    panel.canvas.addEventListener("click", (event) => {
      const rect = panel.canvas.getBoundingClientRect(), x = event.clientX - rect.left, y = event.clientY - rect.top;
      const near = points.filter((point) => Math.hypot(point.px - x, point.py - y) < 12)[0];
      if (near) S.select(S.members[near.run], event.shiftKey);
    });
    function values() {
      const chosen = data.effects[S.state.joint], shown = S.residual().move, part = chosen.part[0];
      const sigma = S.sigma();
      const angle = angles[Math.min(S.state.over, angles.length - 1)];
      return data.runs.map((run, k) => {
        let rp = 0, pp = 0, sum = 0, count = 0;
        const mean = [0, 0, 0, 0, 0, 0], members = S.members[k].filter((i) => data.states.used[i] && Number.isFinite(shown[3 * i]));
        for (const i of members) for (let a = 0; a < 3; a++) { mean[a] += part[3 * i + a] / members.length; mean[a + 3] += shown[3 * i + a] / members.length; }
        for (const i of members) {
          for (let a = 0; a < 3; a++) {
            const p = part[3 * i + a] - (members.length > 1 ? mean[a] : 0), r = shown[3 * i + a] - (members.length > 1 ? mean[a + 3] : 0);
            rp += r * p; pp += p * p;
          }
          sum += angle.values[i]; count++;
        }
        return { run: k, name: run.name, angle: sum / count, value: pp > 0 ? 1 + rp / pp : NaN, half: pp > 0 ? (1.96 * sigma) / Math.sqrt(pp) : NaN };
      }).filter((entry) => Number.isFinite(entry.angle + entry.value) && !(entry.half > 1));
    }
    function draw(canvas) {
      effect.select.value = String(S.state.joint);
      over.select.value = String(Math.min(S.state.over, angles.length - 1));
      const { g, width, height } = S.begin(canvas), found = values(), angle = angles[Math.min(S.state.over, angles.length - 1)];
      const box = { x: 74, y: 16, w: width - 92, h: height - 62 };
      const { toX, toY } = S.axes(g, box, { x: S.span(found.map((entry) => entry.angle)), y: S.span([1, ...found.flatMap((entry) => [entry.value - (entry.half || 0), entry.value + (entry.half || 0)])]), xLabel: `${angle.label} [°], mean of the run`, yLabel: "apparent over fitted" });
      g.strokeStyle = S.theme.accent; g.setLineDash([5, 4]); g.beginPath(); g.moveTo(box.x, toY(1)); g.lineTo(box.x + box.w, toY(1)); g.stroke(); g.setLineDash([]);
      points = found.map((entry) => ({ ...entry, px: toX(entry.angle), py: toY(entry.value) }));
      for (const point of points) {
        const chosen = S.members[point.run].some((i) => S.selected[i]);
        g.strokeStyle = S.theme.series[0]; g.beginPath(); g.moveTo(point.px, toY(point.value - point.half)); g.lineTo(point.px, toY(point.value + point.half)); g.stroke();
        g.beginPath(); S.marker(g, chosen ? 2 : 0, point.px, point.py, chosen ? 6 : 4); g.fillStyle = chosen ? S.theme.warm : S.theme.series[0]; g.fill();
      }
      return `${data.effects[S.state.joint].name} in ${found.length} runs; runs whose loads hardly turn it are left out.`;
    }
    function table() {
      return { head: ["run", "angle [°]", "apparent over fitted", "± 95 %"], rows: values().map((entry) => [entry.name, entry.angle, entry.value, entry.half]) };
    }
  };
})(stiffcal);
