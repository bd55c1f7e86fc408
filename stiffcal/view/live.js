(function (S) {
  /** The server that the page came from asks for this; a page in a file has none. */
  const token = new URLSearchParams(location.search).get("token");
  /** What one page asks for ends what it asked for before; several pages of one server wait for each other. */
  const page = String(Math.random()).slice(2);
  const nothing = () => ({ added: [], removed: [], excluded: [] });
  /** What was ticked before, the last one last. */
  const past = [];
  S.canUndo = () => past.length > 0;

  /**
   * Ask the server.
   * @param {string} name @param {Object<string, any>} [more] @param {AbortSignal} [signal] @returns {Promise<string>}
   */
  async function ask(name, more = {}, signal = undefined) {
    const response = await fetch(`/${name}`, {
      method: "POST",
      signal,
      keepalive: name === "leave",
      headers: { "Content-Type": "application/json", "X-Stiffcal-Token": token },
      body: JSON.stringify({ choice: S.wanted, page, ...more }),
    });
    const text = await response.text();
    if (response.ok) return text;
    throw Object.assign(new Error("refused"), { answer: JSON.parse(text) });
  }

  /** Words for people of what the server refused. */
  function refusal(error) {
    const answer = error.answer || {};
    if (answer.error) {
      const { file, place, reason, mend } = answer.error;
      return `${[file, place].filter(Boolean).join(", ")}: ${reason}; ${mend}`;
    }
    return answer.refused || "the server no longer answers: start stiffcal view --live again";
  }

  S.shownExcluded = [];
  /** Whether the server has said if it can forecast. */
  let prepared = false;
  let asked = 0,
    stopAsking = new AbortController();
  /** What was asked for last, in words. */
  const askedFor = { words: "" };
  /**
   * Ask for new contents of the page, show what the server is doing meanwhile, and show them.
   * @param {string} name @param {string} words @param {Object<string, any>} [more]
   * @param {() => Promise<void>} [first] is asked for before, so that the server does not compute two things at once
   * @returns {Promise<boolean>} whether it was answered, and nothing else was asked for meanwhile
   */
  async function askForContent(name, words, more = {}, first = undefined) {
    const mine = ++asked;
    stopAsking.abort();
    stopAsking = new AbortController();
    S.waitsFor = askedFor.words = words;
    S.fault = "";
    S.modelChanged = false;
    S.showTryout();
    const watch = setInterval(async () => {
      const { doing, share, left } = JSON.parse(await ask("progress").catch(() => "{}"));
      if (mine !== asked || !S.waitsFor) return;
      const parts = [`${askedFor.words}: ${doing}`, share ? `${Math.round(100 * share)} %` : "", left];
      S.waitsFor = doing ? parts.filter(Boolean).join(", ") : askedFor.words;
      S.showTryout();
    }, 400);
    try {
      await first?.();
      if (mine !== asked) return false;
      const data = await S.unpacked(await ask(name, more, stopAsking.signal));
      if (mine !== asked) return false;
      S.waitsFor = "";
      S.showContent(data);
      return true;
    } catch (error) {
      if (mine !== asked || error.answer?.superseded) return false;
      S.waitsFor = "";
      S.hollow = null;
      if (error.answer?.model_changed) S.modelChanged = true;
      else S.fault = refusal(error);
      return false;
    } finally {
      clearInterval(watch);
      if (mine === asked) {
        S.showTryout();
        S.redraw();
      }
    }
  }

  /** What the page waits for while a model is fitted that has no forecast. */
  const NO_FORECAST = "fitting, without a forecast for these readings";

  /** A linear forecast of what is ticked, drawn hollow until the refit is there. */
  async function forecast() {
    const mine = asked;
    const text = await ask("forecast").catch(() => "");
    if (mine !== asked) return;
    if (!text) {
      if (prepared) askedFor.words = NO_FORECAST;
      return;
    }
    const { models } = await S.unpacked(text);
    const model = models[S.part];
    if (mine !== asked || !model) return;
    S.hollow = { model, move: model.residual_heldout[0], turn: S.data.rotation ? model.residual_heldout[1] : null, heldout: true };
    S.frame++;
    S.showTryout();
    S.redraw();
  }

  async function fitted() {
    const shown = JSON.stringify(S.parts[0].live);
    const done = await askForContent("content", "fitting", {}, S.wanted.excluded.length ? undefined : forecast);
    if (!done && S.fault) {
      // what cannot be fitted is not ticked
      const { added, removed } = JSON.parse(shown);
      S.wanted = { ...S.wanted, added, removed, excluded: S.shownExcluded };
      S.showTryout();
    } else if (!S.fault && !S.modelChanged) {
      S.shownExcluded = S.wanted.excluded;
      if (!prepared) prepare();
    }
  }

  /** Tick or untick. @param {Object<string, any>} changes of `S.wanted` */
  S.want = function (changes) {
    past.push(S.wanted);
    S.wanted = { ...S.wanted, ...changes };
    fitted();
  };
  /** Go back to what was ticked before. */
  S.undo = function () {
    const before = past.pop();
    if (!before) return;
    S.wanted = before;
    fitted();
  };
  /** Diagnose the model that is shown, and show what is read of the first effect that it lacks. */
  S.diagnose = async function () {
    if (!(await askForContent("diagnose", "diagnosing"))) return;
    const missing = S.data.evidence.findIndex((one) => one.standing === "missing");
    if (missing >= 0) S.set({ x: S.data.evidence[missing].variable, y: `r.e${missing + 1}` });
    prepare();
  };
  /** Write what is ticked into model.toml. @param {boolean} [anyway] also where somebody else has changed it */
  S.writeModel = async function (anyway = false) {
    const wanted = S.wanted;
    S.wanted = { ...wanted, excluded: [] };
    if (!(await askForContent("write", "writing model.toml", { to_changed_file: anyway }))) {
      S.wanted = wanted;
      return;
    }
    afresh();
  };
  /** Take model.toml as it is now. */
  S.reloadModel = async function () {
    if (await askForContent("reload", "reading model.toml")) afresh();
  };
  function afresh() {
    S.wanted = nothing();
    S.shownExcluded = [];
    past.length = 0;
    S.showTryout();
    prepare();
  }

  /** Have every candidate tried once, in the background, so that forecasts are there when they are asked for. */
  async function prepare() {
    prepared = false;
    const answer = JSON.parse(await ask("prepare").catch(() => "{}"));
    // what was asked for meanwhile comes first; then it is prepared anew
    if (answer.forecasts === undefined) return;
    prepared = true;
    S.parts[0].live.forecasts = answer.forecasts;
  }

  /** Fit what is shown again: other readings have come. */
  S.refit = fitted;
  /** Begin, once the page is drawn. */
  S.startLive = prepare;
  // nobody waits any more for what a closed page has asked for
  addEventListener("pagehide", () => ask("leave").catch(() => {}));
})(stiffcal);
