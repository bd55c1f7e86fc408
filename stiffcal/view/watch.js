(function () {
  /** The logs that a server follows while they are measured: what `check` says of each run; newer ones are shown. */
  const S = window.stiffcal, EVERY_MS = 1000;
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

  const section = made("section", "", "watch");
  section.id = "watch";
  section.setAttribute("aria-label", "Logs that are followed");
  const head = made("h2", "Logs"), counts = made("p", "", "counts"), whole = made("ul"), runs = made("ul", "", "runs");
  counts.setAttribute("role", "status");
  section.append(head, counts, whole, runs);
  document.getElementById("panels").before(section);

  /** How much of a run is used. */
  function amount(run) {
    if (run.stage !== "read") return "";
    const parts = [];
    if (run.n_states) parts.push(`${run.n_states} load states`);
    if (run.n_readings) parts.push(`${run.n_readings} readings`);
    return parts.length ? `: ${parts.join(", ")}` : "";
  }

  let drawn = "";
  /** Show what is known; all of it as text, as names and lines come from the campaign. */
  function draw(logs) {
    const text = JSON.stringify([logs.runs, logs.lines]);
    if (text === drawn) return;
    drawn = text;
    const number = (stage) => logs.runs.filter((run) => run.stage === stage).length;
    counts.textContent = `${number("read")} read, ${number("waiting")} waiting, ${number("faulty")} not used`;
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
    if (version === shown) return;
    if (!S) { location.reload(); return; }
    if (S.waitsFor) return;
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
    await follow(answer.version);
    setTimeout(look, EVERY_MS);
  }
  look();
})();
