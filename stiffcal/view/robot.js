(function (S) {
  const KINDS = [
    ["m", "measured"],
    ["p", "predicted"],
    ["r", "residual"],
    ["f", "force"],
  ];
  const RESIDUALS = 5;
  const MOTION_MS = 400;

  S.robotPanel = function () {
    const { data } = S,
      { states } = data;
    const longest = S.robotSizes(),
      J = Math.max(...data.runs.map((entry) => entry.axes.length / 3)),
      K = J + 2,
      shares = S.sharesOfParts(data),
      partsOf = S.partsOfRobot(shares, longest.chain),
      standing = S.standingOfRobot(data);
    const natural = longest.m > 0 ? (0.25 * longest.chain) / longest.m : 1;
    const ofForce = longest.f > 0 ? (0.25 * longest.chain) / longest.f : 0;
    const ARROWS = KINDS.filter(([letter]) => letter !== "f" || longest.f > 0);
    let timer = 0;
    const run = S.choice(
      "Run",
      data.runs.map((entry, k) => [String(k), entry.name]),
      (value) => {
        const first = S.members[Number(value)][0];
        if (first !== undefined) S.goTo(first);
      },
    );
    const exaggeration = S.slider("Exaggeration", -1.5, 1.5, (value) => S.set({ scale: value }));
    const arrows = ARROWS.map(([letter, word]) =>
      S.check(word, true, (on) => {
        S.set({
          arrows: ARROWS.map(([l]) => l)
            .filter((l) => (l === letter ? on : S.state.arrows.includes(l)))
            .join(""),
        });
      }),
    );
    const still = matchMedia("(prefers-reduced-motion: reduce)");
    S.stopPlaying = () => {
      clearInterval(timer);
      timer = 0;
    };
    const play = S.button(
      {
        onclick: () => {
          if (timer) S.stopPlaying();
          else timer = setInterval(() => step(1), MOTION_MS);
          play.textContent = timer ? "Stop" : "Play run";
          play.setAttribute("aria-pressed", String(Boolean(timer)));
        },
      },
      "Play run",
    );
    play.hidden = still.matches;
    still.addEventListener("change", () => {
      play.hidden = still.matches;
      if (timer) play.click();
    });
    function step(by) {
      const members = S.members[S.state.run],
        k = members.indexOf(S.state.at);
      // places measured once each are runs of one state: there one goes from run to run
      if (members.length < 2) S.goTo((S.state.at + by + S.n) % S.n);
      else S.goTo(members[(k + by + members.length) % members.length]);
    }

    const small = (label, text, change) => S.button({ "aria-label": label, title: label, onclick: change }, text);
    const turned = (turn, tilt) => S.set({ turn: S.state.turn + turn, tilt: S.tilted(S.state.tilt + tilt) });
    const cameras = S.CAMERAS.map(([name, where]) => S.button({ onclick: () => S.set({ ...where, zoom: 1 }) }, name));
    const view = S.make(
      "span",
      { role: "group", "aria-label": "Camera", className: "camera" },
      ...cameras,
      small("Turn left", "◂", () => turned(-0.2, 0)),
      small("Turn right", "▸", () => turned(0.2, 0)),
      small("Tilt up", "▴", () => turned(0, 0.15)),
      small("Tilt down", "▾", () => turned(0, -0.15)),
      small("Zoom in", "+", () => S.set({ zoom: S.state.zoom * 1.2 })),
      small("Zoom out", "−", () => S.set({ zoom: S.state.zoom / 1.2 })),
    );

    const panel = S.panel({
      id: "robot",
      title: "3 Robot",
      about:
        "At rest (dashed) and deformed. Colour of drives, links and rings (bearings): share of the deflection at the tool, the darker " +
        `the larger. Diamond: where an effect is missing. ${S.wordsOfBodies(data)}`,
      how: "Drag or arrow keys: turn. + and −, or the wheel after a click: zoom. N and P: next and previous state.",
      controls: [
        run,
        S.button({ onclick: () => step(-1) }, "Previous state"),
        S.button({ onclick: () => step(1) }, "Next state"),
        play,
        view,
        exaggeration,
        ...arrows,
      ],
      draw,
      table,
      key,
      depends: () => {
        const s = S.state;
        return [s.model, s.kind, s.off, s.mode, s.run, s.at, s.scale, s.arrows, s.turn, s.tilt, s.zoom, S.version].join();
      },
    });

    function key(event) {
      const { zoom } = S.state;
      const moves = {
        ArrowLeft: () => turned(-0.1, 0),
        ArrowRight: () => turned(0.1, 0),
        ArrowUp: () => turned(0, 0.1),
        ArrowDown: () => turned(0, -0.1),
        "+": () => S.set({ zoom: zoom * 1.15 }),
        "-": () => S.set({ zoom: zoom / 1.15 }),
        n: () => step(1),
        p: () => step(-1),
      };
      if (!moves[event.key]) return false;
      moves[event.key]();
      return true;
    }
    let drag = null;
    panel.canvas.addEventListener("pointerdown", (event) => {
      drag = [event.clientX, event.clientY];
      panel.canvas.setPointerCapture(event.pointerId);
    });
    panel.canvas.addEventListener("pointermove", (event) => {
      if (!drag) return;
      const [x, y] = drag;
      drag = [event.clientX, event.clientY];
      turned((event.clientX - x) / 150, (event.clientY - y) / 150);
    });
    panel.canvas.addEventListener("pointerup", () => {
      drag = null;
    });
    panel.canvas.addEventListener(
      "wheel",
      (event) => {
        if (document.activeElement !== panel.canvas) return;
        event.preventDefault();
        S.set({ zoom: S.state.zoom * (event.deltaY < 0 ? 1.1 : 1 / 1.1) });
      },
      { passive: false },
    );

    const plus = (a, b, by) => a.map((value, k) => value + by * b[k]);
    const at = (array, i) => [array[3 * i], array[3 * i + 1], array[3 * i + 2]];
    /** What is drawn of a state, m and N. @param {number} i */
    function vectors(i) {
      const m = at(states.measured[0], i),
        r = at(S.residual().move, i);
      return { m, r, p: plus(m, r, -1), f: at(states.force, i) };
    }

    /** The directions of the base axes. @param {Function} line @param {number[]} corner where they begin */
    function axesInCorner(line, g, { project, pixels }, corner) {
      const { quiet } = S.theme,
        from = project([0, 0, 0]),
        long = 26 / Math.max(pixels, 1e-9);
      g.fillStyle = quiet;
      g.textAlign = "center";
      g.textBaseline = "middle";
      for (const k of [0, 1, 2]) {
        const to = project([0, 1, 2].map((a) => Number(a === k))),
          way = corner.map((_, a) => long * (to[a] - from[a])),
          [x, y] = corner.map((value, a) => value + way[a]);
        line([corner, [x, y]], quiet, 1.5);
        if (Math.hypot(...way) > 6) g.fillText("xyz"[k], x + 0.3 * way[0], y + 0.3 * way[1]);
      }
    }

    function draw(canvas) {
      run.select.value = String(S.state.run);
      exaggeration.input.value = String(S.state.scale);
      ARROWS.forEach(([letter], k) => {
        arrows[k].input.checked = S.state.arrows.includes(letter);
      });
      S.CAMERAS.forEach(([, { turn, tilt }], k) =>
        cameras[k].setAttribute("aria-pressed", String(Math.abs(turn - S.state.turn) + Math.abs(tilt - S.state.tilt) < 1e-3)),
      );
      const { g, width, height } = S.begin(canvas),
        { state, theme } = S,
        i = state.at,
        hasState = S.members[state.run].includes(i);
      const scale = natural * 10 ** state.scale,
        values = data.runs[state.run];
      const chain = Array.from({ length: K }, (_, k) => at(values.chain, k)),
        axes = Array.from({ length: J }, (_, k) => at(values.axes, k));
      const moved = hasState ? chain.map((p, k) => plus(p, at(states.shape, i * K + k), scale)) : chain;
      const parts = partsOf({ moved, axes, run: values, state: hasState ? i : null, scale });
      const target = at(states.target, i),
        shown = vectors(i),
        colours = { m: theme.ink, p: theme.series[2], r: theme.warm, f: theme.accent },
        dashes = { m: [], p: [5, 3], r: [2, 2], f: [9, 3, 2, 3] };
      const arrowsOf = (letter) => [shown[letter], letter === "f" ? ofForce : letter === "r" ? RESIDUALS * scale : scale];
      const drawn = ARROWS.filter(([letter]) => hasState && state.arrows.includes(letter)).map(([letter]) => letter);
      const line = (points, colour, w, dash) => {
        g.strokeStyle = colour;
        g.lineWidth = w;
        g.setLineDash(dash || []);
        g.beginPath();
        points.forEach(([x, y], k) => (k ? g.lineTo(x, y) : g.moveTo(x, y)));
        g.stroke();
        g.setLineDash([]);
      };
      // the words stand above the picture, not in it
      const entries = ARROWS.map(([letter, word]) => ({
        word: `${word} ${letter === "f" ? `${S.digits(Math.hypot(...shown.f))} N` : S.length(Math.hypot(...shown[letter]))}`,
        mark: (x, y) =>
          line(
            [
              [x - 8, y],
              [x + 13, y],
            ],
            colours[letter],
            2.5,
            dashes[letter],
          ),
      }));
      const top = 10 + 16 * S.keys(g, { x: 14, w: width - 28 }, entries);
      const tips = drawn.map((letter) => plus(target, ...arrowsOf(letter))).filter((p) => p.every(Number.isFinite));
      // clear of the axes in the corner, next to them or above, whichever leaves more room; names find theirs next to the joints
      const room = [
        { x: 76, y: top + 20, w: width - 136, h: height - top - 40 },
        { x: 24, y: top + 20, w: width - 84, h: height - top - 90 },
      ];
      const inSight = [...chain, ...moved, ...parts.reach, target, ...tips],
        [first, second] = room.map((box) => S.cameraOf(state, inSight, box, 0.5 * longest.chain)),
        camera = second.pixels > first.pixels ? second : first,
        { project } = camera;
      // whatever one zooms to, nothing is drawn over the words
      g.save();
      g.beginPath();
      g.rect(0, top, width, height - top);
      g.clip();
      parts.draw(g, camera, width, height);
      line([...chain, target].map(project), theme.ink, 1.5, [6, 4]);
      const joints = moved.slice(1, -1).map(project),
        diamond = ([x, y], r) => {
          g.beginPath();
          S.marker(g, 4, x, y, r);
          g.strokeStyle = theme.warm;
          g.lineWidth = 3;
          g.stroke();
        };
      for (const k of data.suspected) diamond(joints[k - 1], 16);
      const ofLinks = data.suspected_links.filter((k) => moved[k + 1]).map((k) => project(plus(moved[k], moved[k + 1], 1).map((v) => v / 2)));
      for (const place of ofLinks) diamond(place, 13);
      const corners = ofLinks.flatMap(([x, y]) => [-13, 0, 13].flatMap((by) => [[x + by, y], [x, y + by]]));
      const along = tips.flatMap((tip) => [0, 0.25, 0.5, 0.75, 1].map((share) => project(target.map((value, k) => value + share * (tip[k] - value)))));
      S.writeJointNames(g, joints, shares, width, [...along, ...corners]);
      const arrow = (from, vector, by, colour, w, dash) => {
        const a = project(from),
          b = project(plus(from, vector, by));
        if (!Number.isFinite(b[0])) return;
        line([a, b], colour, w, dash);
        const angle = Math.atan2(b[1] - a[1], b[0] - a[0]),
          barb = (turn) => [b[0] - 8 * Math.cos(angle + turn), b[1] - 8 * Math.sin(angle + turn)];
        line([barb(-0.4), b, barb(0.4)], colour, w);
      };
      if (state.arrows.includes("r")) {
        for (const j of S.members[state.run]) if (S.selected[j] && j !== i) arrow(target, vectors(j).r, RESIDUALS * scale, theme.chosen, 2, [2, 2]);
      }
      for (const letter of drawn) arrow(target, ...arrowsOf(letter), colours[letter], 2.5, dashes[letter]);
      axesInCorner(line, g, camera, [38, height - 34]);
      g.restore();
      return (
        `Run ${values.name}, state ${S.members[state.run].indexOf(i) + 1} of ${S.members[state.run].length}. Deflections × ` +
        `${S.digits(scale)}, residuals × ${S.digits(RESIDUALS * scale)}.${standing}`
      );
    }

    function table() {
      const { factor, name: unit } = S.units.length,
        scaled = (vector) => vector.map((value) => factor * value);
      const rows = S.members[S.state.run].map((i) => {
        const v = vectors(i);
        return [states.row[i], ...v.f, ...scaled(v.m), ...scaled(v.p), ...scaled(v.r)];
      });
      const names = (word, of) => ["x", "y", "z"].map((axis) => `${word} ${axis} [${of}]`);
      return { head: ["row", ...names("force", "N"), ...names("measured", unit), ...names("predicted", unit), ...names("residual", unit)], rows };
    }
  };
})(stiffcal);
