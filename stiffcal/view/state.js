(function (S) {
  /** What the page shows; all of it is in the address after the "#". */
  const first = () => ({
    part: 0,
    model: "",
    sideBySide: -1,
    kind: "heldout",
    off: [],
    mode: "part",
    x: "",
    y: "",
    colour: "",
    run: 0,
    at: 0,
    scale: 0,
    arrows: "mprf",
    turn: 0.9,
    tilt: 0.35,
    zoom: 1,
    joint: -1,
    over: -1,
    tab: 0,
  });
  S.state = first();
  /** Replaced by the panel that plays a run. */
  S.stopPlaying = () => {};
  /** Forget all that was chosen, and who listens. @param {number} part the part of the data that comes */
  S.reset = function (part) {
    S.state = { ...first(), part };
    S.stopPlaying();
    listeners = [];
    written = "";
  };
  let listeners = [];
  let waiting = false;

  /** Call a function whenever the state or the selection changes. @param {() => void} draw */
  S.onChange = (draw) => listeners.push(draw);

  const LATER_MS = 120;
  let later = 0;
  /** True while pictures outside the window, or the address, are not yet up to date. */
  S.pending = false;
  /** True while pictures outside the window are drawn too. */
  S.drawsAll = true;

  /** A panel that cannot be drawn leaves the others alone. */
  function drawThem() {
    for (const draw of listeners) {
      try {
        draw();
      } catch (error) {
        reportError(error);
      }
    }
  }

  /** Draw all panels at once, outside the window too, each as high as it will be. */
  S.drawNow = function () {
    S.drawsAll = true;
    // what is drawn fills the lines above a picture, which leave it the rest of the window
    for (let round = 0; round < 2; round++) {
      drawThem();
      S.settlePanels();
    }
    S.drawsAll = false;
    S.redraw();
  };

  /** Draw the panels in the window before the next picture; the others, and the address, when changes have paused. */
  S.redraw = function () {
    S.pending = true;
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => {
      waiting = false;
      const began = performance.now();
      drawThem();
      S.lastFrame = performance.now() - began;
      S.drawsAll = false;
      clearTimeout(later);
      later = setTimeout(() => {
        S.drawsAll = true;
        drawThem();
        S.drawsAll = false;
        writeHash();
        S.pending = waiting;
      }, LATER_MS);
    });
  };

  /** Change the state. @param {Object<string, any>} changes */
  S.set = function (changes) {
    const other = ["model", "off", "mode"].some((name) => name in changes && String(changes[name]) !== String(S.state[name]));
    const ghost = other ? S.asGhost() : null;
    Object.assign(S.state, changes);
    if (ghost) S.moveFrom(ghost);
    else S.redraw();
  };

  /** Choose a state of the campaign, and its run. @param {number} i */
  S.goTo = function (i) {
    if (!S.n) return;
    const at = Math.max(0, Math.min(S.n - 1, i));
    S.set({ at, run: S.data.states.run[at] });
  };

  /** Choose the first state of another run. @param {number} by how many runs further */
  S.stepRun = function (by) {
    const runs = S.data.runs.length;
    for (let k = 1; k <= runs; k++) {
      const run = (((S.state.run + by * k) % runs) + runs) % runs;
      if (S.members[run].length) {
        S.goTo(S.members[run][0]);
        return;
      }
    }
  };

  /** Select states. @param {Iterable<number>} chosen @param {boolean} [add] keep what is selected already */
  S.select = function (chosen, add) {
    if (!add) S.selected.fill(0);
    let first = -1;
    for (const i of chosen) {
      S.selected[i] = 1;
      if (first < 0) first = i;
    }
    S.nSelected = S.selected.reduce((sum, value) => sum + value, 0);
    S.version++;
    if (first >= 0 && !S.selected[S.state.at]) S.goTo(first);
    S.redraw();
  };
  S.nSelected = 0;
  /** Counts changes of the selection. */
  S.version = 0;
  /** Which residual is shown, as a text: what errors depend on, whatever is selected. */
  S.shownKey = () => [S.part, S.state.model, S.state.kind, S.state.off.join("|"), S.state.mode].join("/");
  /** The state but for the camera, as a text: what most pictures depend on. */
  S.everything = function () {
    const { turn, tilt, zoom, scale, arrows, ...rest } = S.state;
    return Object.values(rest).join() + "/" + S.version + "/" + S.frame;
  };

  /** Ranges of the selected states: "3-7.12". */
  function ranges() {
    const parts = [];
    for (let i = 0; i < S.n; i++) {
      if (!S.selected[i]) continue;
      let end = i;
      while (end + 1 < S.n && S.selected[end + 1]) end++;
      parts.push(end > i ? `${i}-${end}` : String(i));
      i = end;
    }
    return parts.join(".");
  }

  let written = "";
  function writeHash() {
    const text = new URLSearchParams();
    for (const [key, value] of Object.entries(S.state)) {
      text.set(key, Array.isArray(value) ? value.join("|") : typeof value === "number" ? String(Number(value.toPrecision(4))) : value);
    }
    const chosen = ranges();
    if (chosen && chosen.length < 4000) text.set("chosen", chosen);
    const hash = `#${text}`;
    if (hash === written) return;
    written = hash;
    S.setAddress(hash);
  }
  /** Write what is shown into the address, where that is allowed: not in a page inside another, nor too often in a second. @param {string} hash */
  S.setAddress = function (hash) {
    try {
      history.replaceState(null, "", hash);
    } catch {
      /* the next change is written */
    }
  };

  /** Take the state from the address, as far as it makes sense here. */
  S.readHash = function () {
    const text = new URLSearchParams(location.hash.slice(1));
    for (const [key, standard] of Object.entries(S.state)) {
      if (!text.has(key)) continue;
      const value = text.get(key);
      if (Array.isArray(standard)) S.state[key] = value ? value.split("|") : [];
      else if (typeof standard === "number") {
        if (Number.isFinite(Number(value))) S.state[key] = Number(value);
      } else S.state[key] = value;
    }
    S.selected.fill(0);
    for (const part of (text.get("chosen") || "").split(".")) {
      const [first, last] = part.split("-").map(Number);
      if (!part || !Number.isInteger(first)) continue;
      for (let i = first; i <= Math.min(last ?? first, S.n - 1); i++) if (i >= 0) S.selected[i] = 1;
    }
    S.nSelected = S.selected.reduce((sum, value) => sum + value, 0);
    S.version++;
    if (!text.has("at")) S.state.at = mostLoaded();
    S.repair();
  };

  /** The state of the first run that is deflected most. */
  function mostLoaded() {
    const move = S.data.states.measured[0];
    let best = 0,
      most = -1;
    for (const i of S.members[S.data.states.run[0]] || []) {
      const size = Math.hypot(move[3 * i], move[3 * i + 1], move[3 * i + 2]);
      if (size > most) {
        most = size;
        best = i;
      }
    }
    return best;
  }

  /** Replace what this campaign does not hold by what it does. */
  S.repair = function () {
    const { state, data } = S;
    const drawable = data.models.filter(S.isDrawable);
    if (!drawable.some((model) => model.id === state.model)) {
      state.model = (drawable.find((model) => model.present) || drawable[0] || { id: "" }).id;
    }
    const names = data.effects.map((effect) => effect.name);
    if (!["part", "refit"].includes(state.mode)) state.mode = "part";
    // parts are those of the present model, and each refit leaves one effect out: of nothing else there is a picture
    const refits = data.models.filter((model) => model.kind === "without").map((model) => model.effect);
    state.off = state.off.filter((name) => names.includes(name) && (state.mode === "part" || refits.includes(name)));
    if (state.mode === "refit") state.off = state.off.slice(0, 1);
    if (state.off.length) state.model = (drawable.find((model) => model.present) || { id: state.model }).id;
    const proposed = S.modelById.get(state.model)?.shares?.[0];
    const keys = new Set([
      ...S.residualKeys().map(([key]) => key),
      ...data.variables.map((variable) => variable.name),
      ...(S.scalar ? [] : ["component"]),
    ]);
    // the effect that was added last, before and after; else what the diagnosis reads of what is missing
    const missing = data.evidence.findIndex((one) => one.standing === "missing");
    const opening = data.change?.variable
      ? { x: data.change.variable, y: `r.${data.change.component}` }
      : missing >= 0
        ? { x: data.evidence[missing].variable, y: `r.e${missing + 1}` }
        : null;
    if (opening && !keys.has(state.x) && !keys.has(state.y)) Object.assign(state, opening);
    if (![0, 1].includes(state.sideBySide)) state.sideBySide = data.change ? 1 : 0;
    if (!keys.has(state.x)) state.x = proposed ? proposed.variable : (data.variables[0]?.name ?? "");
    if (state.colour !== "none" && !keys.has(state.colour))
      state.colour = ["branch", "joint", data.direction, "run"].find((key) => keys.has(key)) ?? "none";
    if (!keys.has(state.y) || state.y === "component") state.y = proposed ? `r.${proposed.component}` : "r.x";
    const clamp = (value, most) => Math.max(0, Math.min(most, Math.round(value)));
    state.run = clamp(state.run, Math.max(data.runs.length - 1, 0));
    state.at = clamp(state.at, Math.max(S.n - 1, 0));
    state.part = S.part;
    state.joint = Math.max(-1, Math.min(data.effects.length - 1, Math.round(state.joint)));
    state.over = Math.max(-1, Math.min(data.joints.length - 1, Math.round(state.over)));
    state.tab = Math.max(0, Math.round(state.tab));
    if (S.n) state.run = data.states.run[state.at];
    if (!["fit", "heldout"].includes(state.kind)) state.kind = "heldout";
    if (!(state.zoom > 0.05 && state.zoom < 50)) state.zoom = 1;
  };
})(stiffcal);
