(function (S) {
  /** The bar that stays in sight: the error, the model's effects and the candidates. */
  const bar = document.getElementById("tryout");
  const STANDING = {
    missing: "missing", alike: "cannot be distinguished from it", undecided: "undecided between", possible: "possible", rejected: "rejected",
  };
  const MS = 700;

  /** True of a page that a server sent; `live.js` is only there then. */
  S.isLive = () => Boolean(S.parts?.[0].live);
  /** What is ticked on a live page: effects that model.toml lacks, effects of it taken out, rows left out. */
  S.wanted = { added: [], removed: [], excluded: [] };
  /** What a live page waits for, as a text for people; "" for nothing. */
  S.waitsFor = "";
  /** What went wrong with the last request; "" for nothing. */
  S.fault = "";
  /** True where somebody else has changed model.toml. */
  S.modelChanged = false;
  S.canUndo = () => false;

  /** Effects by name, each with its places. @param {string[]} names "effect place" @returns {[string, string[]][]} */
  function byEffect(names) {
    const groups = new Map();
    for (const name of names) {
      const [effect, place] = [name.slice(0, name.indexOf(" ")), name.slice(name.indexOf(" ") + 1)];
      if (!groups.has(effect)) groups.set(effect, []);
      groups.get(effect).push(place);
    }
    return [...groups];
  }

  const error = S.make("output", { id: "error" });
  const noise = S.make("span", { id: "error-noise" });
  const hint = S.make("span", { id: "error-hint", role: "status" });
  const undo = S.button({ id: "undo", onclick: () => S.undo() }, "Undo");
  const again = S.button({ id: "diagnose", onclick: () => S.diagnose() }, "Diagnose again");
  const write = S.button({ id: "write", onclick: () => S.writeModel() }, "Write to model.toml");
  const model = S.make("div", { className: "chips", id: "in-model", role: "group", "aria-label": "Effects of the model" });
  const candidates = S.make("div", { className: "chips", id: "candidates", role: "group", "aria-label": "Candidates" });
  const rejected = S.make("details", { id: "rejected" });
  const copied = S.make("span", { role: "status", className: "quiet" });

  /** Whether two lists hold the same. @param {string[]} a @param {string[]} b */
  const same = (a, b) => a.length === b.length && a.every((name) => b.includes(name));
  /** The stored refit of the present model with just these candidates. @param {string[]} names */
  function storedRefit(names) {
    return S.data.models.find((entry) => S.isDrawable(entry) && (entry.kind === "with" || entry.kind === "all") && same(entry.effect.split(", "), names));
  }
  const present = () => S.data.models.find((entry) => entry.present) || S.data.models[0];
  /** Candidates that are in what is shown. */
  function ticked() {
    if (S.isLive()) return S.wanted.added;
    const shown = S.modelById.get(S.state.model);
    return shown && (shown.kind === "with" || shown.kind === "all") && !S.state.off.length ? shown.effect.split(", ") : [];
  }
  /** Effects of the model that are out of what is shown. */
  const out = () => (S.isLive() ? S.wanted.removed : S.state.mode === "refit" ? S.state.off : []);

  function tickCandidate(name, on) {
    const names = on ? [...ticked(), name] : ticked().filter((entry) => entry !== name);
    if (S.isLive()) { S.want({ added: names }); return; }
    const refit = names.length ? storedRefit(names) : present();
    if (refit) S.set({ model: refit.id, off: [], mode: "part" });
  }
  function tickEffect(name, on) {
    if (S.isLive()) {
      if (S.wanted.added.includes(name)) S.want({ added: S.wanted.added.filter((entry) => entry !== name) });
      else S.want({ removed: on ? S.wanted.removed.filter((entry) => entry !== name) : [...S.wanted.removed, name] });
      return;
    }
    S.set({ model: present().id, mode: "refit", off: on ? [] : [name] });
  }

  async function copy(text) {
    try { await navigator.clipboard.writeText(text); copied.textContent = ` copied: ${S.visible(text)}`; } catch { copied.textContent = ` ${S.visible(text)}`; }
  }

  /** A tick with its words. */
  function chip(name, text, checked, enabled, change, title) {
    const made = S.check(text, checked, change);
    made.input.disabled = !enabled;
    made.input.dataset.effect = name;
    made.element.title = S.visible(title);
    return made.element;
  }

  function chipOfCandidate(entry) {
    const on = ticked().includes(entry.name), names = on ? ticked().filter((name) => name !== entry.name) : [...ticked(), entry.name];
    const possible = S.isLive() || !names.length || Boolean(storedRefit(names));
    const sure = entry.standing === "missing" || entry.standing === "undecided" ? (entry.first_in === null ? "" : `, first in ${S.percent(entry.first_in)}`) : "";
    const why = possible ? entry.why : "no refit of this combination is stored: stiffcal view --live fits any";
    return S.make("span", { className: `candidate ${entry.standing}` }, chip(entry.name, `${entry.name}${sure}`, on, possible, (value) => tickCandidate(entry.name, value), why),
      S.button({ className: "copy", title: S.visible(`Copy: ${entry.command}`), "aria-label": S.visible(`Copy ${entry.command}`), onclick: () => copy(entry.command) }, "copy"));
  }

  let listed = "";
  /** Fill the bar. */
  function list() {
    const { data } = S, live = S.isLive();
    const inModel = live ? [...new Set([...data.effects.map((effect) => effect.name).filter((name) => !S.wanted.added.includes(name)), ...S.wanted.removed])] : data.effects.map((effect) => effect.name);
    const key = JSON.stringify([inModel, ticked(), out(), S.part, data.diagnosis_of, data.candidates.map((entry) => entry.name), S.waitsFor !== ""]);
    if (key === listed) return;
    const focus = bar.contains(document.activeElement) ? document.activeElement.dataset?.effect : undefined;
    listed = key;
    const refits = data.models.filter((entry) => entry.kind === "without").map((entry) => entry.effect);
    model.replaceChildren(S.make("span", { className: "lead" }, "Model:"), ...byEffect(inModel).flatMap(([effect, places]) => [
      S.make("span", { className: "effect" }, effect, ...places.map((place) => {
        const name = `${effect} ${place}`;
        return chip(name, place === "setup" ? "" : place, !out().includes(name), live || refits.includes(name), (value) => tickEffect(name, value), `${name}: untick to see the error without it`);
      })),
    ]));
    const offered = data.candidates.filter((entry) => !inModel.includes(entry.name)), folded = offered.filter((entry) => entry.standing === "rejected"), shown = [];
    for (const standing of Object.keys(STANDING)) {
      const some = offered.filter((entry) => entry.standing === standing);
      if (!some.length || standing === "rejected") continue;
      shown.push(S.make("span", { className: "lead" }, `${STANDING[standing]}:`), ...some.map(chipOfCandidate));
    }
    candidates.replaceChildren(...(shown.length ? shown : [S.make("span", { className: "lead" }, S.data.candidates.length ? "No candidate is supported." : data.refits_missing || "Not diagnosed yet.")]),
      ...(data.diagnosis_of ? [S.make("span", { className: "quiet" }, `(diagnosis of ${data.diagnosis_of})`)] : []));
    candidates.classList.toggle("stale", Boolean(data.diagnosis_of));
    rejected.hidden = !folded.length;
    const isOpen = rejected.open;
    rejected.replaceChildren(S.make("summary", {}, `rejected: ${folded.length}`), S.make("div", { className: "chips" }, ...folded.map(chipOfCandidate)));
    rejected.open = isOpen;
    if (focus !== undefined) [...bar.querySelectorAll("input")].find((input) => input.dataset.effect === focus)?.focus();
  }

  /** The number that counts down: from the error shown before to the present one. */
  function number() {
    const shown = S.residual(), to = shown.heldout ? shown.model.heldout_rms : shown.model.fit_rms, from = S.ghost?.rms;
    const t = S.moved();
    if (!to) return "–";
    if (!from || t >= 1) return S.error(to);
    const between = {};
    for (const [name, value] of Object.entries(to)) between[name] = typeof value === "number" && typeof from[name] === "number" ? from[name] + (value - from[name]) * t : value;
    return S.error(between);
  }

  /** Show the bar as things are. */
  S.showTryout = function () {
    if (!S.data || !S.data.models.some(S.isDrawable)) { bar.hidden = true; return; }
    bar.hidden = false;
    const live = S.isLive(), dirty = live && (S.wanted.added.length + S.wanted.removed.length > 0);
    error.textContent = S.visible(number());
    error.classList.toggle("waiting", Boolean(S.waitsFor));
    noise.textContent = S.visible(`${S.residual().heldout ? S.leftOut() : "of the fit"}; noise ${S.error(S.data.noise)}`);
    hint.replaceChildren();
    if (S.fault) hint.append(S.make("span", { className: "warning" }, S.fault));
    else if (S.modelChanged) {
      hint.append(S.make("span", { className: "warning" }, "model.toml was changed by somebody else: "),
        S.button({ onclick: () => S.reloadModel() }, "take it as it is now"), " ", S.button({ onclick: () => S.writeModel(true) }, "write the ticks into it"));
    } else if (S.hollow) hint.append(S.visible(`forecast ${S.error(S.hollow.model.heldout_rms)}; ${S.waitsFor}`));
    else hint.append(S.visible(S.waitsFor));
    for (const element of [undo, again, write]) element.hidden = !live;
    undo.disabled = !S.canUndo();
    again.disabled = Boolean(S.waitsFor) || !S.data.diagnosis_of;
    write.disabled = !dirty || Boolean(S.waitsFor);
    list();
  };

  /** What was shown before the present model, drawn grey; null for nothing. */
  S.ghost = null;
  /** A forecast, drawn hollow; null for nothing. */
  S.hollow = null;
  /** Counts pictures of a movement. */
  S.frame = 0;
  let began = -Infinity;
  /** How far points have moved from where they were to where they are, 0 to 1. */
  S.moved = function () {
    const t = Math.min(1, Math.max(0, (performance.now() - began) / MS));
    return t * t * (3 - 2 * t);
  };
  /** Have points move from a residual to the one that is shown now. @param {Object<string, any>|null} ghost */
  S.moveFrom = function (ghost) {
    S.ghost = ghost;
    began = matchMedia("(prefers-reduced-motion: reduce)").matches ? -Infinity : performance.now();
    const step = () => {
      S.frame++;
      S.redraw();
      if (S.moved() < 1) requestAnimationFrame(step);
    };
    step();
  };
  /** What is shown now, to be a ghost of what comes; null where nothing is. */
  S.asGhost = function () {
    if (!S.n || !S.modelById.get(S.state.model)) return null;
    const { move, turn, model, heldout } = S.residual();
    return { move, turn, model, heldout, rms: S.state.off.length && S.state.mode === "part" ? null : heldout ? model.heldout_rms : model.fit_rms };
  };

  bar.append(S.make("div", { className: "count" }, error, noise, undo, again, write, hint, copied), model, candidates, rejected);
  S.startTryout = function () {
    listed = "";
    S.onChange(S.showTryout);
  };
})(stiffcal);
