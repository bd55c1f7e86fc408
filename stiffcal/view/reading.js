(function (S) {
  S.readingPanel = function () {
    const { data } = S,
      { states } = data,
      names = Object.keys(data.readings);
    const table = S.make("table", { id: "reading-table" });
    const lines = S.make("pre", { id: "exclude", role: "region", tabIndex: 0, "aria-label": "Lines for campaign.toml" });
    const rawHead = S.make("h3", {}, "Raw rows as they stand in the file"),
      rawLines = S.make("pre", { id: "raw-rows", role: "region", tabIndex: 0, "aria-label": "Raw rows" });
    const about = S.make("p", { className: "note", id: "reading-note" });
    const copied = S.make("span", { role: "status" });
    const copy = S.button(
      {
        onclick: async () => {
          try {
            await navigator.clipboard.writeText(lines.textContent);
            copied.textContent = " copied";
          } catch {
            getSelection().selectAllChildren(lines);
            copied.textContent = " selected: copy with Ctrl+C";
          }
        },
      },
      "Copy the lines",
    );
    // on a live page they are left out at once, in memory: a refit shows what hangs on them
    const leaveOut = S.button(
      { id: "leave-out", onclick: () => S.want({ excluded: [...S.wanted.excluded, ...rowsLeftOut()] }) },
      "Leave out and refit",
    );
    const back = S.button({ id: "take-back", onclick: () => S.want({ excluded: [] }) }, "Take all back in");
    const leftOut = data.live?.excluded ?? [];
    back.disabled = !leftOut.length;
    for (const element of [leaveOut, back]) element.hidden = !S.isLive() || !data.raw;
    const csv = () => {
      const head = ["run", "row", ...names];
      const rows = [...states.run.keys()]
        .filter((i) => !S.nSelected || S.selected[i])
        .map((i) => [data.runs[states.run[i]].name, states.row[i], ...names.map((name) => data.readings[name][i])]);
      S.save("reading.csv", [head, ...rows].map((row) => row.map(S.csvCell).join(",")).join("\r\n"));
    };
    const picture = () =>
      S.saveText("reading", [
        [about.textContent],
        ...[...table.rows].map((row) => [...row.cells].map((cell) => cell.textContent)),
        ...(rawLines.hidden ? [] : rawLines.textContent.split("\n").map((line) => [line])),
        ...lines.textContent.split("\n").map((line) => [line]),
      ]);
    S.place(
      S.make(
        "section",
        { id: "reading", className: "panel", "aria-labelledby": "reading-title" },
        S.make(
          "div",
          { className: "heading" },
          S.make("h2", { id: "reading-title" }, "6 Reading"),
          S.button({ onclick: picture, title: "Save this panel as a picture" }, "PNG"),
          S.button({ onclick: csv, title: "Save the readings of the selected states, of all where none is selected" }, "CSV"),
        ),
        S.make("p", { className: "about" }, "The chosen state between its neighbours, in SI units, and where it stands in the logs."),
        S.make(
          "div",
          { className: "controls" },
          S.button({ onclick: () => S.goTo(S.state.at - 1) }, "Previous state"),
          S.button({ onclick: () => S.goTo(S.state.at + 1) }, "Next state"),
        ),
        about,
        S.make("div", { className: "scroll tall", tabIndex: 0, role: "region", "aria-label": "Reading and its neighbours" }, table),
        rawHead,
        rawLines,
        S.make("h3", {}, "Leave the selected states out"),
        lines,
        S.make("div", { className: "controls" }, copy, copied, leaveOut, back),
      ),
    );

    /** Rows and ranges of rows as the manifest has them: 3, "7-9". @param {number[][]} rows first and last of each state */
    function joined(rows) {
      const found = [];
      for (const [first, last] of rows.sort((a, b) => a[0] - b[0])) {
        const before = found[found.length - 1];
        if (before && first <= before[1] + (last > first)) before[1] = Math.max(before[1], last);
        else found.push([first, last]);
      }
      return found.map(([first, last]) => (last > first ? `${first}-${last}` : first));
    }
    /** What leaves the selected states out, or the one that is chosen: rows of sources. @returns {{source: string, run: string, rows: any[]}[]} */
    function rowsLeftOut() {
      const chosen = [...S.selected.keys()].filter((i) => S.selected[i]),
        groups = new Map();
      for (const i of chosen.length ? chosen : [S.state.at]) {
        const run = data.runs[states.run[i]];
        if (!states.first_row[i]) continue;
        const key = JSON.stringify([run.source, run.own_file ? run.name : ""]);
        if (!groups.has(key)) groups.set(key, []);
        groups.get(key).push([states.first_row[i], states.last_row[i]]);
      }
      return [...groups].map(([key, rows]) => {
        const [source, run] = JSON.parse(key);
        return { source, run, rows: joined(rows) };
      });
    }
    /** The lines of campaign.toml that leave them out. */
    function exclusion() {
      if (!data.raw) return "# readings are left out of this page (--no-raw)";
      const found = leftOut.length && !S.nSelected ? [] : rowsLeftOut(),
        chosen = found.map(({ source, run, rows }) =>
          [
            "[[exclude]]",
            `source = ${S.tomlText(source)}`,
            ...(run ? [`run = ${S.tomlText(run)}`] : []),
            `rows = [${rows.map((row) => (typeof row === "string" ? `"${row}"` : row)).join(", ")}]`,
            'why = "…"',
          ].join("\n"),
        );
      // what is out already stays among the lines, whatever is selected next
      const blocks = [...new Set([...leftOut, ...chosen])];
      if (!blocks.length)
        return "# these states were found in several logs and have no rows of their own:\n# leave their run out of the fit with holdout = true under [[runs]]";
      return (data.measure === "torque" ? "# a pass is left out as a whole\n" : "") + blocks.join("\n\n");
    }
    let listed = "",
      visible = true;
    const list = () => {
      if (!visible && !S.drawsAll) return;
      const key = `${S.state.at}/${S.version}`;
      if (key === listed) return;
      listed = key;
      const i = S.state.at,
        run = data.runs[states.run[i]],
        near = (j) => (j >= 0 && j < S.n ? j : undefined);
      const neighbours = [near(i - 1), i, near(i + 1)];
      const used = states.used[i] ? "used" : states.why[i] ? `not used: ${states.why[i]}` : "reference of its run";
      const line = states.line_number[i],
        first = line ? ` (line ${line})` : run.first_row ? ` (data row 1 is ${run.first_row})` : "";
      const [from, to] = [states.first_row[i], states.last_row[i]],
        name = `${data.measure === "torque" ? "mean" : "hold"} ${states.row[i]}`;
      const place = !run.source
        ? name
        : run.is_sampled
          ? `${name}${from ? `${data.measure === "torque" ? " of the pass in" : ","} data rows ${from} to ${to}, the middle one in line ${line || "–"}` : ""}`
          : `data row ${states.row[i]}${first}`;
      about.textContent = S.visible(`Run ${run.name}, ${place}${run.files.length ? ` of ${run.files.join(", ")}` : ""}; ${used}.`);
      lines.textContent = exclusion();
      const raw = neighbours.filter((j) => j !== undefined && states.lines[j] && (j === i || states.line_number[j] !== line));
      rawHead.hidden = rawLines.hidden = !raw.length;
      rawLines.textContent = [
        `columns: ${run.columns.map(S.visible).join(" | ")}`,
        ...raw.map((j) => `line ${states.line_number[j]}${j === i ? " (chosen)" : ""}: ${S.visible(states.lines[j])}`),
      ].join("\n");
      const cells = names.map((name) => [
        name,
        ...neighbours.map((j) =>
          j === undefined
            ? "–"
            : Number.isFinite(data.readings[name][j])
              ? String(Number(data.readings[name][j].toPrecision(7))).replace("-", "−")
              : "–",
        ),
      ]);
      S.fill(
        table,
        ["quantity", "previous", "chosen", "next"],
        [
          ["run", ...neighbours.map((j) => (j === undefined ? "–" : data.runs[states.run[j]].name))],
          ["row", ...neighbours.map((j) => (j === undefined ? "–" : String(states.row[j])))],
          ...cells,
        ],
        data.raw
          ? run.source && !run.is_sampled
            ? "As read, in SI units"
            : "Averages over the state, in SI units"
          : "Readings are left out of this page (--no-raw).",
      );
    };
    S.onChange(list);
    new IntersectionObserver((entries) => {
      visible = entries[entries.length - 1].isIntersecting;
      if (visible) list();
    }).observe(table);
  };
})(stiffcal);
