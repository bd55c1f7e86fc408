(function (S) {
  const KINDS = [["m", "measured"], ["p", "predicted"], ["r", "residual"], ["f", "force"]];

  /** Middle and half the size of a box about points. @param {Iterable<number>} values x, y, z of one point after the other */
  function boxOf(values) {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    let k = 0;
    for (const v of values) { low[k] = Math.min(low[k], v); high[k] = Math.max(high[k], v); k = (k + 1) % 3; }
    return { centre: low.map((v, a) => (v + high[a]) / 2), half: Math.hypot(...low.map((v, a) => high[a] - v)) / 2 || 1 };
  }

  /** Largest sizes of what is drawn, for the scales. */
  function sizes() {
    const { states } = S.data, longest = { m: 0, f: 0, chain: 0 };
    for (let i = 0; i < S.n; i++) {
      const m = Math.hypot(states.measured[0][3 * i], states.measured[0][3 * i + 1], states.measured[0][3 * i + 2]);
      const f = Math.hypot(states.force[3 * i], states.force[3 * i + 1], states.force[3 * i + 2]);
      if (m > longest.m) longest.m = m;
      if (f > longest.f) longest.f = f;
    }
    longest.chain = Math.max(...S.data.runs.map((run) => boxOf(run.chain).half), 1e-9);
    return longest;
  }

  S.robotPanel = function () {
    const { data } = S;
    const longest = sizes(), K = data.joints.length + 2;
    const natural = longest.m > 0 ? (0.25 * longest.chain) / longest.m : 1;
    let timer = 0;
    const ARROWS = KINDS.filter(([letter]) => letter !== "f" || longest.f > 0);
    const run = S.choice("Run", data.runs.map((entry, k) => [String(k), entry.name]), (value) => {
      const first = S.members[Number(value)][0];
      if (first !== undefined) S.goTo(first);
    });
    const exaggeration = S.slider("Exaggeration", -1.5, 1.5, (value) => S.set({ scale: value }));
    const arrows = ARROWS.map(([letter, word]) => S.check(word, true, (on) => {
      S.set({ arrows: ARROWS.map(([l]) => l).filter((l) => (l === letter ? on : S.state.arrows.includes(l))).join("") });
    }));
    const still = matchMedia("(prefers-reduced-motion: reduce)");
    S.stopPlaying = () => { clearInterval(timer); timer = 0; };
    const play = S.button({ onclick: () => {
      if (timer) S.stopPlaying(); else timer = setInterval(next, 400);
      play.textContent = timer ? "Stop" : "Play run";
      play.setAttribute("aria-pressed", String(Boolean(timer)));
    } }, "Play run");
    play.hidden = still.matches;
    still.addEventListener("change", () => { play.hidden = still.matches; if (timer) play.click(); });
    const step = (by) => {
      const members = S.members[S.state.run], k = members.indexOf(S.state.at);
      // places measured once each are runs of one state: there one goes from run to run
      if (members.length < 2) S.goTo((S.state.at + by + S.n) % S.n);
      else S.goTo(members[(k + by + members.length) % members.length]);
    };
    function next() { step(1); }

    /** Share of the deflection of each drive, of its bearing and of the link after it; of the base link at 0. */
    const parts = { joint: new Float64Array(data.joints.length + 1), bearing: new Float64Array(data.joints.length + 1), link: new Float64Array(data.joints.length + 1) };
    for (const effect of data.effects) if (parts[effect.part_of] && effect.joint !== null) parts[effect.part_of][effect.joint] += Math.max(effect.share, 0);
    const { joint, bearing, link } = parts;
    const nowhere = data.suspects.filter((name) => name.endsWith(" setup"));
    const largest = data.effects.filter((effect) => effect.share >= 0.01).sort((a, b) => b.share - a.share).slice(0, 5).map((effect) => `${effect.name} ${S.percent(effect.share)}`);
    const standing = (largest.length ? ` Largest shares of the deflection: ${largest.join(", ")}.` : "")
      + (data.suspects.length ? ` Missing: ${data.suspects.join(", ")}${nowhere.length ? " (the set-up has no place on the robot)" : ""}.` : "");
    const small = (label, text, change) => S.button({ "aria-label": label, title: label, onclick: change }, text);
    const view = S.make("span", { role: "group", "aria-label": "Camera", className: "camera" },
      small("Turn left", "◂", () => S.set({ turn: S.state.turn - 0.2 })), small("Turn right", "▸", () => S.set({ turn: S.state.turn + 0.2 })),
      small("Tilt up", "▴", () => S.set({ tilt: Math.min(S.state.tilt + 0.15, 1.5) })), small("Tilt down", "▾", () => S.set({ tilt: Math.max(S.state.tilt - 0.15, -1.5) })),
      small("Zoom in", "+", () => S.set({ zoom: S.state.zoom * 1.2 })), small("Zoom out", "−", () => S.set({ zoom: S.state.zoom / 1.2 })),
      small("First view", "⟲", () => S.set({ turn: 0.9, tilt: 0.35, zoom: 1 })));

    const panel = S.panel({
      id: "robot", title: "3 Robot", height: 420,
      about: "At rest (dashed) and deformed. Size of discs (drives), rings (bearings) and links: share of the deflection at the tool. Diamond: where an effect is missing.",
      how: "Drag or arrow keys: turn. + and −, or the wheel after a click: zoom. N and P: next and previous state.",
      controls: [run, S.button({ onclick: () => step(-1) }, "Previous state"),
        S.button({ onclick: next }, "Next state"), play, view, exaggeration, ...arrows],
      draw, table, key,
      depends: () => { const s = S.state; return [s.model, s.kind, s.off, s.mode, s.run, s.at, s.scale, s.arrows, s.turn, s.tilt, s.zoom, S.version].join(); },
    });

    function key(event) {
      const { turn, tilt, zoom } = S.state;
      const changes = { ArrowLeft: { turn: turn - 0.1 }, ArrowRight: { turn: turn + 0.1 }, ArrowUp: { tilt: Math.min(tilt + 0.1, 1.5) },
        ArrowDown: { tilt: Math.max(tilt - 0.1, -1.5) }, "+": { zoom: zoom * 1.15 }, "-": { zoom: zoom / 1.15 } }[event.key];
      if (changes) S.set(changes);
      else if (event.key === "n") step(1);
      else if (event.key === "p") step(-1);
      else return false;
      return true;
    }
    let drag = null;
    panel.canvas.addEventListener("pointerdown", (event) => { drag = [event.clientX, event.clientY]; panel.canvas.setPointerCapture(event.pointerId); });
    panel.canvas.addEventListener("pointermove", (event) => {
      if (!drag) return;
      const [x, y] = drag;
      drag = [event.clientX, event.clientY];
      S.set({ turn: S.state.turn + (event.clientX - x) / 150, tilt: Math.max(-1.5, Math.min(1.5, S.state.tilt + (event.clientY - y) / 150)) });
    });
    panel.canvas.addEventListener("pointerup", () => { drag = null; });
    panel.canvas.addEventListener("wheel", (event) => {
      if (document.activeElement !== panel.canvas) return;
      event.preventDefault();
      S.set({ zoom: S.state.zoom * (event.deltaY < 0 ? 1.1 : 1 / 1.1) });
    }, { passive: false });

    /** What is drawn of a state, m and N. @param {number} i */
    function vectors(i) {
      const shown = S.residual();
      const at = (array) => [array[3 * i], array[3 * i + 1], array[3 * i + 2]];
      const m = at(data.states.measured[0]), r = at(shown.move);
      return { m, r, p: m.map((value, k) => value - r[k]), f: at(data.states.force) };
    }

    function draw(canvas) {
      run.select.value = String(S.state.run);
      exaggeration.input.value = String(S.state.scale);
      ARROWS.forEach(([letter], k) => { arrows[k].input.checked = S.state.arrows.includes(letter); });
      const { g, width, height } = S.begin(canvas), { state, theme } = S;
      const scale = natural * 10 ** state.scale, chain = data.runs[state.run].chain;
      const [ct, st, ce, se] = [Math.cos(state.turn), Math.sin(state.turn), Math.cos(state.tilt), Math.sin(state.tilt)];
      // the picture is as large as the chain of the run and its arrows leave room for
      const flat = (x, y, z) => [-st * x + ct * y, se * (ct * x + st * y) - ce * z];
      let [left, top, right, bottom] = [Infinity, Infinity, -Infinity, -Infinity];
      for (let k = 0; k < K; k++) {
        const [u, v] = flat(chain[3 * k], chain[3 * k + 1], chain[3 * k + 2]);
        left = Math.min(left, u); right = Math.max(right, u); top = Math.min(top, v); bottom = Math.max(bottom, v);
      }
      const room = Math.min((width - 150) / Math.max(right - left, 0.7 * longest.chain), (height - 130) / Math.max(bottom - top, 0.7 * longest.chain));
      const pixels = Math.max(room, 1e-9) * state.zoom, [cu, cv] = [(left + right) / 2, (top + bottom) / 2];
      const project = (x, y, z) => { const [u, v] = flat(x, y, z); return [width / 2 + pixels * (u - cu), height / 2 + 12 + pixels * (v - cv)]; };
      const point = (values, k, move, by) => project(values[3 * k] + (move ? by * move[0] : 0), values[3 * k + 1] + (move ? by * move[1] : 0), values[3 * k + 2] + (move ? by * move[2] : 0));
      const line = (points, colour, w, dash) => {
        g.strokeStyle = colour; g.lineWidth = w; g.setLineDash(dash || []); g.beginPath();
        points.forEach(([x, y], k) => (k ? g.lineTo(x, y) : g.moveTo(x, y)));
        g.stroke(); g.setLineDash([]);
      };
      const reach = 0.3 * longest.chain;
      [[reach, 0, 0], [0, reach, 0], [0, 0, reach]].forEach((axis, k) => {
        const end = project(...axis);
        line([project(0, 0, 0), end], theme.line, 1.5);
        g.fillStyle = theme.quiet; g.textAlign = "center"; g.textBaseline = "middle";
        g.fillText("xyz"[k], end[0] + 6, end[1] - 6);
      });
      const { states } = data, i = state.at, hasState = S.members[state.run].includes(i);
      const rest = Array.from({ length: K }, (_, k) => point(chain, k));
      const target = [states.target[3 * i], states.target[3 * i + 1], states.target[3 * i + 2]];
      line([...rest, project(...target)], theme.quiet, 2, [6, 4]);
      const moved = hasState ? Array.from({ length: K }, (_, k) => {
        const at = 3 * (i * K + k);
        return point(chain, k, [states.shape[at], states.shape[at + 1], states.shape[at + 2]], scale);
      }) : rest;
      const diamond = (x, y, r) => { g.beginPath(); S.marker(g, 4, x, y, r); g.strokeStyle = theme.warm; g.lineWidth = 3; g.stroke(); };
      for (let k = 0; k + 1 < K; k++) {
        line([moved[k], moved[k + 1]], theme.ink, 3 + 14 * Math.sqrt(link[k] || 0));
        if (data.suspected_links.includes(k)) diamond((moved[k][0] + moved[k + 1][0]) / 2, (moved[k][1] + moved[k + 1][1]) / 2, 13);
      }
      const labels = [];
      for (let k = 1; k <= data.joints.length; k++) {
        const r = 4 + 16 * Math.sqrt(joint[k]);
        g.beginPath(); g.arc(moved[k][0], moved[k][1], r, 0, 6.2832);
        g.fillStyle = theme.series[0]; g.fill(); g.lineWidth = 1; g.strokeStyle = theme.ground; g.stroke();
        if (bearing[k] > 0) { g.beginPath(); g.arc(moved[k][0], moved[k][1], r + 3 + 6 * Math.sqrt(bearing[k]), 0, 6.2832); g.strokeStyle = theme.series[3]; g.lineWidth = 1.5 + 10 * Math.sqrt(bearing[k]); g.stroke(); }
        if (data.suspected.includes(k)) diamond(moved[k][0], moved[k][1], r + 7);
        const near = labels.find((label) => Math.abs(label.x - moved[k][0]) < 26 && Math.abs(label.y - moved[k][1]) < 14);
        if (near) { near.text += `, ${S.visible(data.joints[k - 1])}`; near.r = Math.max(near.r, r); } else labels.push({ x: moved[k][0], y: moved[k][1], r, text: S.visible(data.joints[k - 1]) });
      }
      g.fillStyle = theme.ink; g.textAlign = "left"; g.textBaseline = "bottom";
      for (const label of labels) g.fillText(label.text, label.x + label.r + 4, label.y - 3);
      const colours = { m: theme.ink, p: theme.series[2], r: theme.warm, f: theme.accent };
      const dashes = { m: [], p: [5, 3], r: [2, 2], f: [9, 3, 2, 3] };
      const arrow = (from, vector, by, colour, w, dash) => {
        const a = project(...from), b = project(...from.map((value, k) => value + by * vector[k]));
        if (!Number.isFinite(b[0])) return;
        line([a, b], colour, w, dash);
        const angle = Math.atan2(b[1] - a[1], b[0] - a[0]);
        line([[b[0] - 7 * Math.cos(angle - 0.4), b[1] - 7 * Math.sin(angle - 0.4)], b, [b[0] - 7 * Math.cos(angle + 0.4), b[1] - 7 * Math.sin(angle + 0.4)]], colour, w);
      };
      const fScale = longest.f > 0 ? (0.25 * longest.chain) / longest.f : 0;
      if (state.arrows.includes("r")) {
        for (const j of S.members[state.run]) {
          if (S.selected[j] && j !== i) arrow(target, vectors(j).r, 5 * scale, theme.chosen, 2, [2, 2]);
        }
      }
      const shown = vectors(i);
      for (const [letter] of ARROWS) {
        if (!state.arrows.includes(letter) || !hasState) continue;
        arrow(target, shown[letter], letter === "f" ? fScale : letter === "r" ? 5 * scale : scale, colours[letter], 2.5, dashes[letter]);
      }
      g.textAlign = "left"; g.textBaseline = "middle";
      ARROWS.forEach(([letter, word], k) => {
        line([[10, 16 + 18 * k], [40, 16 + 18 * k]], colours[letter], 2.5, dashes[letter]);
        g.fillStyle = theme.ink;
        g.fillText(`${word} ${letter === "f" ? S.digits(Math.hypot(...shown.f)) + " N" : S.length(Math.hypot(...shown[letter]))}`, 46, 16 + 18 * k);
      });
      return `Run ${data.runs[state.run].name}, state ${S.members[state.run].indexOf(i) + 1} of ${S.members[state.run].length}. Deflections × ${S.digits(scale)}, residuals × ${S.digits(5 * scale)}.${standing}`;
    }

    function table() {
      const rows = S.members[S.state.run].map((i) => {
        const v = vectors(i), um = (vector) => vector.map((value) => S.units.length.factor * value);
        return [data.states.row[i], ...v.f, ...um(v.m), ...um(v.p), ...um(v.r)];
      });
      const names = (word, unit) => ["x", "y", "z"].map((axis) => `${word} ${axis} [${unit}]`);
      return { head: ["row", ...names("force", "N"), ...names("measured", S.units.length.unit), ...names("predicted", S.units.length.unit), ...names("residual", S.units.length.unit)], rows };
    }
  };
})(stiffcal);
