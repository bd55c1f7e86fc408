(function (S) {
  const ROW = 4, GAP = 12;
  // a panel takes as many rows of the grid as it is high, so that panels of a column close up
  const heights = new ResizeObserver((entries) => {
    for (const { target } of entries) target.style.gridRowEnd = `span ${Math.ceil((target.offsetHeight + GAP) / ROW)}`;
  });
  /** Put a panel on the page. @param {HTMLElement} section */
  S.place = function (section) {
    document.getElementById("panels").append(section);
    heights.observe(section);
  };

  /** Make an element; texts go in as texts. @param {string} tag @param {Object<string, any>} [set] @param {...any} inside */
  S.make = function (tag, set = {}, ...inside) {
    const element = document.createElement(tag);
    for (const [name, value] of Object.entries(set)) {
      if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
      else if (name in element && name !== "list") element[name] = value;
      else element.setAttribute(name, value);
    }
    for (const part of inside) element.append(typeof part === "string" ? S.visible(part) : part);
    return element;
  };

  /** A button; see `S.make`. */
  S.button = (set, text) => S.make("button", { type: "button", ...set }, text);
  /**
   * What keys do on a canvas: move, select with Enter or Space, clear with Escape.
   * @param {Object<string, () => void>} moves by key @param {() => Iterable<number>|undefined} chosen the states to select
   */
  S.onKeys = (moves, chosen) => (event) => {
    const states = event.key === "Enter" || event.key === " " ? chosen() : undefined;
    if (moves[event.key]) moves[event.key]();
    else if (states) S.select(states, event.shiftKey);
    else if (event.key === "Escape") S.select([]);
    else return false;
    return true;
  };

  /** A choice with a label. @param {string} label @param {any[]} options value and text, or a heading with a list of them */
  S.choice = function (label, options, change) {
    const made = ([value, text]) => (Array.isArray(text) ? S.make("optgroup", { label: S.visible(value) }, ...text.map(made)) : S.make("option", { value }, text));
    const select = S.make("select", { onchange: () => change(select.value) }, ...options.map(made));
    return { element: S.make("label", {}, `${label} `, select), select };
  };
  S.check = function (label, checked, change) {
    const input = S.make("input", { type: "checkbox", checked, onchange: () => change(input.checked) });
    return { element: S.make("label", { className: "check" }, input, ` ${label}`), input };
  };
  S.slider = function (label, low, high, change) {
    const input = S.make("input", { type: "range", min: low, max: high, step: 0.01, oninput: () => change(Number(input.value)) });
    return { element: S.make("label", {}, `${label} `, input), input };
  };

  function save(name, blob) {
    const link = S.make("a", { href: URL.createObjectURL(blob), download: name });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }

  /** Save a canvas. @param {string} name @param {HTMLCanvasElement} canvas */
  S.savePicture = (name, canvas) => canvas.toBlob((blob) => save(`${name}.png`, blob));
  /** True while a picture is drawn for a file: what stands around it on the page is then drawn into it. */
  S.drawsFile = false;
  const HEAD = 44, TWICE = 2;
  /** What a picture shows, of which model and campaign, and when it was saved. */
  const headOf = (title) => [title.replace(/^\d+[a-z]? /, ""), `${S.data.robot}, campaign ${S.data.campaign}; ${S.modelById.get(S.state.model)?.label ?? ""}; ${new Date().toISOString().slice(0, 10)}`];

  /** Save a panel's picture, twice as fine as on the screen, with a title. @param {string} id @param {string} title */
  function savePng(id, title, draw, width, height) {
    const canvas = S.make("canvas"), file = S.make("canvas", { width: TWICE * width, height: TWICE * (height + HEAD) }), g = file.getContext("2d");
    Object.defineProperties(canvas, { clientWidth: { value: width }, clientHeight: { value: height } });
    drawForFile(draw, canvas, TWICE);
    g.fillStyle = S.theme.ground;
    g.fillRect(0, 0, file.width, file.height);
    g.drawImage(canvas, 0, TWICE * HEAD);
    g.scale(TWICE, TWICE);
    writeHead(g, title, width);
    S.savePicture(id, file);
  }
  function writeHead(g, title, width) {
    const [first, second] = headOf(title);
    g.textAlign = "left"; g.textBaseline = "middle";
    g.fillStyle = S.theme.ink; g.font = "600 14px system-ui, sans-serif"; g.fillText(S.shortened(g, S.visible(first), width - 16), 8, 14);
    g.fillStyle = S.theme.quiet; g.font = "12px system-ui, sans-serif"; g.fillText(S.shortened(g, S.visible(second), width - 16), 8, 33);
  }
  /** Save a panel's picture as lines and texts. */
  function saveSvg(id, title, draw, width, height) {
    const canvas = S.make("canvas"), recorder = S.svgContext(width, height + HEAD);
    Object.defineProperties(canvas, { clientWidth: { value: width }, clientHeight: { value: height }, getContext: { value: () => recorder } });
    recorder.within(0, HEAD, () => drawForFile(draw, canvas, 1));
    writeHead(recorder, title, width);
    save(`${id}.svg`, new Blob([recorder.text()], { type: "image/svg+xml" }));
  }
  function drawForFile(draw, canvas, ratio) {
    S.drawsFile = true;
    S.fileRatio = ratio;
    try { draw(canvas); } finally { S.drawsFile = false; }
  }

  /** Save texts, one line each, as a picture. @param {string} name @param {string[][]} rows columns of each line */
  S.saveText = function (name, rows) {
    const canvas = S.make("canvas"), g = canvas.getContext("2d"), font = "13px ui-monospace, monospace", high = 19, most = 1600;
    g.font = font;
    const columns = Math.max(...rows.map((row) => row.length));
    const wide = Array.from({ length: columns }, (_, k) => Math.max(0, ...rows.filter((row) => row.length > 1).map((row) => g.measureText(S.visible(row[k] ?? "")).width)) + 18);
    const whole = Math.max(wide.reduce((sum, value) => sum + value, 0), ...rows.filter((row) => row.length === 1).map((row) => g.measureText(S.visible(row[0])).width));
    canvas.width = 2 * Math.min(whole + 24, most);
    canvas.height = 2 * (rows.length * high + 16);
    g.scale(2, 2);
    g.fillStyle = S.theme.ground; g.fillRect(0, 0, canvas.width, canvas.height);
    g.fillStyle = S.theme.ink; g.font = font; g.textBaseline = "middle";
    rows.forEach((row, k) => {
      let x = 12;
      row.forEach((text, column) => { g.fillText(S.shortened(g, S.visible(text), most - x), x, 8 + high * (k + 0.5)); x += wide[column]; });
    });
    S.savePicture(name, canvas);
  };

  /** Save a text as a CSV file. @param {string} name @param {string} text */
  S.save = (name, text) => save(name, new Blob([`\ufeff${text}\r\n`], { type: "text/csv" }));

  /** Fill a table. @param {HTMLTableElement} table @param {string[]} head @param {any[][]} rows @param {string} caption */
  S.fill = function (table, head, rows, caption) {
    table.replaceChildren(
      S.make("caption", {}, caption),
      S.make("thead", {}, S.make("tr", {}, ...head.map((text) => S.make("th", { scope: "col" }, text)))),
      S.make("tbody", {}, ...rows.map((row) => S.make("tr", {}, ...row.map((cell, k) =>
        cell instanceof Node ? S.make("td", {}, cell) : S.make(k ? "td" : "th", k ? {} : { scope: "row" },
          typeof cell === "number" ? S.digits(cell) : String(cell)))))));
  };

  const CLICK = 4, NEAR = 12;
  /** The point that is nearest to a place, at most `NEAR` pixels away; −1 where none is. */
  function nearestOf({ px, py }, x, y) {
    let nearest = -1, best = NEAR;
    for (let p = 0; p < px.length; p++) {
      const far = Math.hypot(px[p] - x, py[p] - y);
      if (far < best) { best = far; nearest = p; }
    }
    return nearest;
  }

  /** The words next to the pointer. */
  const hover = S.make("div", { id: "hover", hidden: true });
  document.body.append(hover);
  function showHover(event, text) {
    hover.hidden = !text;
    if (!text) return;
    hover.textContent = S.visible(text);
    hover.style.left = `${Math.min(event.clientX + 12, innerWidth - hover.offsetWidth - 8)}px`;
    hover.style.top = `${Math.min(event.clientY + 12, innerHeight - hover.offsetHeight - 8)}px`;
  }

  /**
   * What the pointer does over a canvas: a click chooses the nearest point, a drag from a point, or with Shift, draws a
   * rectangle that selects; a drag from an empty place moves the picture where it can be moved, the wheel zooms it after
   * a click, a double click shows all of it again.
   * @param {HTMLCanvasElement} canvas @param {() => {px: ArrayLike<number>, py: ArrayLike<number>}} points pixels, NaN where none is drawn
   * @param {(chosen: number[], event: PointerEvent, click: boolean) => void} choose numbers of the points
   * @param {{pan: (dx: number, dy: number) => void, zoom: (by: number, x: number, y: number) => void, all: () => void, words: (p: number) => string}} [view]
   */
  S.brush = function (canvas, points, choose, view) {
    const brush = { from: null, to: null, pans: false };
    const where = (event) => [event.offsetX, event.offsetY];
    canvas.addEventListener("pointerdown", (event) => {
      brush.from = brush.to = where(event);
      brush.pans = Boolean(view) && !event.shiftKey && !event.ctrlKey && nearestOf(points(), ...brush.from) < 0;
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!brush.from) {
        if (!view) return;
        const near = nearestOf(points(), ...where(event));
        showHover(event, near < 0 ? "" : view.words(near));
        return;
      }
      showHover(event, "");
      const [x, y] = brush.to;
      brush.to = where(event);
      if (brush.pans) view.pan(brush.to[0] - x, brush.to[1] - y);
      S.redraw();
    });
    canvas.addEventListener("pointerleave", (event) => showHover(event, ""));
    canvas.addEventListener("pointercancel", () => { brush.from = null; S.redraw(); });
    canvas.addEventListener("pointerup", (event) => {
      if (!brush.from) return;
      const [[x0, x1], [y0, y1]] = [0, 1].map((k) => [brush.from[k], brush.to[k]].sort((a, b) => a - b));
      const click = x1 - x0 < CLICK && y1 - y0 < CLICK, { px, py } = points(), inside = [];
      for (let p = 0; p < px.length; p++) if (px[p] >= x0 && px[p] <= x1 && py[p] >= y0 && py[p] <= y1) inside.push(p);
      const nearest = nearestOf({ px, py }, x0, y0), pans = brush.pans && !click;
      brush.from = null;
      if (!pans) choose(click ? (nearest >= 0 ? [nearest] : []) : inside, event, click);
      S.redraw();
    });
    if (view) {
      canvas.addEventListener("wheel", (event) => {
        if (document.activeElement !== canvas) return;
        event.preventDefault();
        view.zoom(event.deltaY < 0 ? 1 / 1.15 : 1.15, ...where(event));
        S.redraw();
      }, { passive: false });
      canvas.addEventListener("dblclick", () => { view.all(); S.redraw(); });
    }
    return {
      key: () => (brush.from ? brush.to.join() : ""),
      draw: (g) => {
        if (!brush.from || brush.pans) return;
        const [[x, y], [u, v]] = [brush.from, brush.to];
        g.strokeStyle = S.theme.accent; g.setLineDash([4, 3]); g.strokeRect(x, y, u - x, v - y); g.setLineDash([]);
      },
    };
  };

  const MOST_ROWS = 100, MOST_HIGH = 640;
  /**
   * A panel: heading, controls, canvas with a table behind it, PNG and CSV.
   * @param {{id: string, title: string, about: string, how?: string, height: number, controls?: any[], draw: Function, table: Function, key?: Function, depends?: () => string}} options
   *   depends: of what the picture depends; it is drawn anew where that has changed
   */
  S.panel = function (options) {
    const canvas = S.make("canvas", { tabIndex: 0, id: `${options.id}-canvas` });
    canvas.setAttribute("role", "img");
    canvas.style.height = `${options.height}px`;
    if (options.least) canvas.style.minWidth = `${options.least}px`;
    const table = S.make("table", { className: "behind" });
    const details = S.make("details", { className: "data", ontoggle: () => fillTable() }, S.make("summary", {}, "Table of this picture"),
      S.make("div", { className: "scroll", tabIndex: 0, role: "region", "aria-label": `${options.title}: table` }, table));
    const csv = () => {
      const { head, rows } = options.table();
      const text = [head, ...rows].map((row) => row.map((cell) => S.csvCell(cell instanceof Node ? cell.textContent : cell)).join(",")).join("\r\n");
      S.save(`${options.id}.csv`, text);
    };
    const note = S.make("p", { className: "note", id: `${options.id}-note` });
    const section = S.make("section", { id: options.id, className: "panel", "aria-labelledby": `${options.id}-title` },
      S.make("div", { className: "heading" }, S.make("h2", { id: `${options.id}-title` }, options.title),
        S.button({ onclick: () => savePng(options.id, options.title, options.draw, canvas.clientWidth, canvas.clientHeight), title: "Save this picture" }, "PNG"),
        S.button({ onclick: () => saveSvg(options.id, options.title, options.draw, canvas.clientWidth, canvas.clientHeight), title: "Save this picture as lines and texts" }, "SVG"),
        S.button({ onclick: csv, title: "Save the numbers of this picture" }, "CSV")),
      ...(options.about ? [S.make("p", { className: "about" }, options.about)] : []),
      ...(options.how ? [S.make("details", { className: "how" }, S.make("summary", {}, "Mouse and keys"), S.make("p", { className: "about" }, options.how))] : []),
      ...(options.controls ? [S.make("div", { className: "controls" }, ...options.controls.map((entry) => entry.element || entry))] : []),
      options.height > MOST_HIGH || options.least ? S.make("div", { className: "scroll tall" }, canvas) : canvas, note, details);
    function fillTable() {
      if (!details.open) return;
      const { head, rows } = options.table();
      S.fill(table, head, rows.slice(0, MOST_ROWS), rows.length > MOST_ROWS ? `first ${MOST_ROWS} of ${rows.length} rows; CSV holds all` : `${rows.length} rows`);
    }
    if (options.key) canvas.addEventListener("keydown", (event) => { if (options.key(event)) event.preventDefault(); });
    let drawn = "", visible = true;
    new IntersectionObserver((entries) => { visible = entries[entries.length - 1].isIntersecting; if (visible) draw(); }).observe(canvas);
    const draw = () => {
      if (!visible && !S.drawsAll) return;
      const key = `${options.depends ? options.depends() : S.everything()}/${S.themeName}/${canvas.clientWidth}`;
      if (key === drawn) return;
      drawn = key;
      const words = options.draw(canvas) || "";
      canvas.setAttribute("aria-label", S.visible(`${options.title}. ${words}`));
      if (note.textContent !== S.visible(words)) note.textContent = S.visible(words);
      fillTable();
    };
    S.onChange(draw);
    S.place(section);
    return { canvas, section, details };
  };
})(stiffcal);
