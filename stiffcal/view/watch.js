(function () {
  /** The logs that a server follows while they are measured: what `check` says of each run; newer ones are shown. */
  const S = typeof stiffcal === "undefined" ? null : stiffcal, EVERY_MS = 1000;
  const token = new URLSearchParams(location.search).get("token");
  const WORDS = { waiting: "waiting", read: "read", faulty: "not used" };
  let shown = Number(document.querySelector('meta[name="watched"]').content);

  /** @param {string} tag @param {string} [text] @param {string} [name] of its class @returns {HTMLElement} */
  function made(tag, text = "", name = "") {
    const element = document.createElement(tag);
    element.textContent = text;
    if (name) element.className = name;
    return element;
  }

  const section = made("details", "", "watch");
  section.id = "watch";
  section.open = !S;
  const counts = made("summary", "Logs"), whole = made("ul"), runs = made("ul", "", "runs");
  counts.setAttribute("role", "status");
  section.append(counts, whole, runs);
  document.getElementById("panels").before(section);

  /** How much of a run is used. */
  function amount(run) {
    if (run.stage !== "read") return "";
    const parts = [];
    if (run.n_states) parts.push(`${run.n_states} load states`);
    if (run.n_readings) parts.push(`${run.n_readings} readings`);
    return parts.length ? `: ${parts.join(", ")}` : "";
  }

  let drawn = "", faulty = 0;
  /** Show what is known; all of it as text, as names and lines come from the campaign. */
  function draw(logs) {
    const text = JSON.stringify([logs.runs, logs.lines]);
    if (text === drawn) return;
    drawn = text;
    const number = (stage) => logs.runs.filter((run) => run.stage === stage).length;
    counts.textContent = `Logs: ${number("read")} read, ${number("waiting")} waiting, ${number("faulty")} not used`;
    if (number("faulty") > faulty) section.open = true; // something new is wrong
    faulty = number("faulty");
    whole.replaceChildren(...logs.lines.map((line) => made("li", line)));
    runs.replaceChildren(...logs.runs.map((run) => {
      const entry = made("li", "", run.stage), name = made("b", run.id || "tables");
      entry.append(name, ` ${WORDS[run.stage]}${amount(run)}`);
      if (run.lines.length) {
        const lines = made("ul");
        lines.append(...run.lines.map((line) => made("li", line)));
        entry.append(lines);
      }
      return entry;
    }));
  }

  /** Fit what is ticked to the readings that have come, once nothing else is waited for. */
  async function follow(version) {
    if (version === shown || S.waitsFor) return;
    shown = version;
    await S.refit();
    S.startLive();
  }

  async function look() {
    let answer;
    try {
      const response = await fetch("/watched", {
        method: "POST", headers: { "Content-Type": "application/json", "X-Stiffcal-Token": token }, body: "{}",
      });
      if (!response.ok) throw new Error(response.statusText);
      answer = await response.json();
    } catch {
      counts.textContent = "the server no longer answers: start stiffcal view --watch again";
      return;
    }
    draw(answer);
    // there is something to show: the server sends it, and until then nothing else is asked for
    if (!S && answer.version !== shown) { location.reload(); return; }
    if (S) await follow(answer.version);
    setTimeout(look, EVERY_MS);
  }
  look();
})();
