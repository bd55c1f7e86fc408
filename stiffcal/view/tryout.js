(function (S) {
  /** The bar that does not scroll: the error, the candidates, the model's effects. */
  const bar = document.getElementById("tryout");
  const STANDING = {
    missing: "missing",
    alike: "cannot be distinguished from it",
    undecided: "undecided between",
    possible: "possible",
    rejected: "rejected",
  };

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

  const effectOf = (name) => name.slice(0, name.indexOf(" "));
  /** Effects by name, each with its places. @param {string[]} names @returns {[string, string[]][]} */
  function byEffect(names) {
    const groups = new Map();
    for (const name of names) {
      const effect = effectOf(name);
      groups.set(effect, [...(groups.get(effect) ?? []), name.slice(effect.length + 1)]);
    }
    return [...groups];
  }

  const error = S.make("output", { id: "error" });
  const noise = S.make("span", { id: "error-noise" });
  const hint = S.make("span", { id: "error-hint", role: "status" });
  const undo = S.button({ id: "undo", onclick: () => S.undo() }, "Undo");
  const again = S.button({ id: "diagnose", onclick: () => S.diagnose() }, "Diagnose again");
  const write = S.button({ id: "write", onclick: () => S.writeModel() }, "Write to model.toml");
  const refill = () => {
    listed = "";
    list();
  };
  const candidates = S.chipRow("candidates", "Candidates", "Add", refill);
  const model = S.chipRow("in-model", "Effects of the model", "Shown", refill);
  const copied = S.make("span", { role: "status", className: "quiet" });

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
    if (S.isLive()) {
      S.want({ added: names });
      return;
    }
    const refit = names.length ? S.storedRefit(names) || S.forecast(names) : S.presentModel();
    if (refit) S.set({ model: refit.id, off: [], mode: "part" });
  }
  function tickEffect(name, on) {
    if (S.isLive()) {
      if (S.wanted.added.includes(name)) S.want({ added: S.wanted.added.filter((entry) => entry !== name) });
      else S.want({ removed: on ? S.wanted.removed.filter((entry) => entry !== name) : [...S.wanted.removed, name] });
      return;
    }
    S.set({ model: S.presentModel().id, mode: "refit", off: on ? [] : [name] });
  }

  async function copy(text) {
    try {
      await navigator.clipboard.writeText(text);
      copied.textContent = `copied: ${S.visible(text)}`;
    } catch {
      copied.textContent = S.visible(text);
    }
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
    const on = ticked().includes(entry.name),
      names = on ? ticked().filter((name) => name !== entry.name) : [...ticked(), entry.name];
    const possible = S.isLive() || !names.length || Boolean(S.storedRefit(names)) || S.canForecast(names);
    const sure = entry.sure ? `, ${entry.sure}` : "";
    // of many rejected ones the store holds the error alone
    const known = names.length === 1 && entry.heldout_rms ? `${S.error(entry.heldout_rms)} with it; ` : "";
    const why = possible ? entry.why : `${known}the store holds no residuals of that: stiffcal view --live fits any`;
    const made = S.make(
      "span",
      { className: `candidate ${entry.standing}` },
      chip(entry.name, `${entry.name}${sure}`, on, possible, (value) => tickCandidate(entry.name, value), why),
    );
    // a live page writes model.toml itself
    if (!S.isLive()) {
      made.append(
        S.button(
          {
            className: "copy",
            title: S.visible(`Copy: ${entry.command}`),
            "aria-label": S.visible(`Copy ${entry.command}`),
            onclick: () => copy(entry.command),
          },
          "copy",
        ),
      );
    }
    return made;
  }

  /** Candidates in groups, by what the diagnosis says of them. @param {any[]} offered @param {boolean} whole also what is rejected */
  function groupsOf(offered, whole) {
    return Object.entries(STANDING).flatMap(([standing, words]) => {
      const some = offered.filter((entry) => entry.standing === standing && (whole || standing !== "rejected"));
      if (!some.length) return [];
      // words stand in one line with the first that they are about
      const [first, ...others] = some.map(chipOfCandidate);
      return [S.make("span", { className: "group" }, S.make("span", { className: "standing" }, `${words}:`), first), ...others];
    });
  }

  let listed = "";
  /** Fill the lines of chips. */
  function list() {
    const { data } = S,
      live = S.isLive(),
      own = data.effects.map((effect) => effect.name);
    // an effect that is tried stands among the candidates; a diagnosis of the tried model offers it no more
    const offers = data.candidates.map((entry) => entry.name);
    const isTried = (name) => S.wanted.added.includes(name) && offers.includes(name);
    const removable = (name) => !data.effects.some((entry) => entry.name === name && !entry.removable);
    // the effect that was added last stands first, and last what comes with what was measured: a line may not hold all
    const added = (data.change?.added ?? []).map(effectOf);
    const rank = (name) => (added.includes(effectOf(name)) ? 0 : removable(name) ? 1 : 2);
    const inModel = [...new Set(live ? [...own.filter((name) => !isTried(name)), ...S.wanted.removed] : own)].sort((a, b) => rank(a) - rank(b));
    const key = JSON.stringify([
      inModel,
      ticked(),
      out(),
      S.part,
      data.diagnosis_of,
      data.is_diagnosed,
      offers,
      S.waitsFor !== "",
    ]);
    if (key === listed) return;
    const focus = bar.contains(document.activeElement) ? document.activeElement.dataset?.effect : undefined;
    listed = key;
    const refits = data.models.filter((entry) => entry.kind === "without").map((entry) => entry.effect);
    model.chips.replaceChildren(
      ...byEffect(inModel).map(([effect, places]) => {
        const [first, ...others] = places.map((place) => {
          const name = `${effect} ${place}`,
            can = live ? removable(name) : refits.includes(name);
          return chip(
            name,
            place === "setup" ? "" : place,
            !out().includes(name),
            can,
            (value) => tickEffect(name, value),
            can
              ? `${name}: untick to see the error without it`
              : `${name}: ${live ? "comes with what was measured" : "no refit without it is stored"}`,
          );
        });
        return S.make("span", { className: "effect" }, S.make("span", { className: "group" }, effect, first), ...others);
      }),
    );
    const offered = data.candidates.filter((entry) => !inModel.includes(entry.name)),
      nRejected = offered.filter((entry) => entry.standing === "rejected").length;
    const shown = groupsOf(offered, candidates.isOpen());
    const none = data.candidates.length
      ? "no candidate is supported"
      : data.is_diagnosed
        ? "nothing"
        : live
          ? "Diagnose finds what is missing"
          : "nothing without a diagnosis";
    candidates.chips.replaceChildren(
      ...(shown.length ? shown : [S.make("span", { className: "quiet" }, none)]),
      ...(data.diagnosis_of ? [S.make("span", { className: "quiet" }, `(diagnosis of ${data.diagnosis_of})`)] : []),
    );
    for (const element of [candidates.chips, document.getElementById("verdict")]) element.classList.toggle("stale", Boolean(data.diagnosis_of));
    candidates.more.dataset.always = nRejected ? "yes" : "";
    candidates.more.dataset.words = nRejected ? `all ${offered.length}, ${nRejected} rejected` : `all ${offered.length}`;
    model.more.dataset.words = `all ${inModel.length}`;
    fit();
    if (focus !== undefined) [...bar.querySelectorAll("input")].find((input) => input.dataset.effect === focus)?.focus();
  }

  /** Offer what a line has no room for; what is missing is shown in as many lines as it needs. */
  function fit() {
    const last = [...candidates.chips.querySelectorAll(".missing, .undecided")].pop();
    const { top } = candidates.chips.getBoundingClientRect(),
      lines = last && !candidates.isOpen() ? last.getBoundingClientRect().bottom - top : 0;
    candidates.chips.style.minHeight = `${Math.min(lines, 0.26 * innerHeight)}px`;
    for (const { chips, more, isOpen } of [candidates, model]) {
      more.hidden = !isOpen() && !more.dataset.always && chips.scrollHeight <= chips.clientHeight + 4;
      more.textContent = isOpen() ? "one line" : more.dataset.words || "all";
    }
  }
  new ResizeObserver(fit).observe(bar);

  function fillHint() {
    const { is_forecast, remark } = S.modelById.get(S.state.model) ?? {};
    Object.assign(hint, { className: S.isLive() ? "room" : "", title: S.visible(S.waitsFor) }).replaceChildren();
    if (S.fault) hint.append(S.make("span", { className: "warning" }, S.fault));
    else if (S.modelChanged) {
      hint.append(
        S.make("span", { className: "warning" }, "model.toml was changed by somebody else: "),
        S.button({ onclick: () => S.reloadModel() }, "take it as it is now"),
        " ",
        S.button({ onclick: () => S.writeModel(true) }, "write the ticks into it"),
      );
    } else if (S.waitsFor) {
      hint.className = "doing";
      hint.append(S.visible(S.hollow ? `forecast ${S.error(S.hollow.model.heldout_rms)}; ${S.waitsFor}` : S.waitsFor));
    } else if (is_forecast)
      hint.append("an estimate by the refits with each; stiffcal view --live fits it");
    else if (remark) Object.assign(hint, { className: "remark" }).append(S.visible(remark));
  }

  /** Show the bar as things are. */
  S.showTryout = function () {
    const drawable = Boolean(S.data?.models.some(S.isDrawable)),
      live = S.isLive();
    for (const element of [error, noise, hint, candidates.element, model.head, model.chips]) element.hidden = !drawable;
    for (const element of [undo, again, write]) element.hidden = !live || !drawable;
    if (!drawable) {
      model.more.hidden = true;
      return;
    }
    const now = S.errorNow();
    error.textContent = S.visible(S.error(now));
    error.classList.toggle("waiting", Boolean(S.waitsFor));
    const known = S.data.noise ? "" : ": repeat readings or state sigma";
    const judged = S.residual().heldout ? S.leftOut() : "of the fit";
    noise.textContent = S.visible(`${judged}; ${S.noiseWords()}${known}${S.ofRods(now)}`);
    fillHint();
    undo.disabled = !S.canUndo();
    const isDue = !S.data.is_diagnosed || Boolean(S.data.diagnosis_of);
    again.textContent = S.data.is_diagnosed ? "Diagnose again" : "Diagnose";
    again.classList.toggle("due", isDue);
    again.disabled = Boolean(S.waitsFor) || !isDue;
    write.disabled = S.wanted.added.length + S.wanted.removed.length === 0 || Boolean(S.waitsFor);
    list();
  };

  bar.append(
    S.make(
      "div",
      { className: "count" },
      error,
      noise,
      hint,
      copied,
      S.make("span", { id: "readings" }),
      S.make("span", { id: "chosen" }),
      S.make("span", { className: "actions" }, undo, again, write),
    ),
    candidates.element,
    model.element,
  );
  model.head.after(S.make("div", { id: "bar" }));
  S.startTryout = function () {
    listed = "";
    S.onChange(S.showTryout);
  };
})(stiffcal);
