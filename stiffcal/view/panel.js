(function (S) {
  const ROW = 4,
    GAP = 12,
    sheet = document.getElementById("page");
  // a panel takes as many rows of the grid as it is high, so that panels of a column close up
  function fitRows(section) {
    section.style.gridRowEnd = `span ${Math.ceil((section.offsetHeight + GAP) / ROW)}`;
    leaveRoom(section);
  }
  const heights = new ResizeObserver((entries) => entries.forEach(({ target }) => fitRows(target)));
  /** Have panels that were put on the page stand where they will, before a picture of the page is made. */
  S.settlePanels = () => document.querySelectorAll(".panel").forEach(fitRows);
  /** What stands above a panel's picture in the window: of a panel that is there without scrolling also what is above the panel. */
  function leaveRoom(section) {
    const canvas = section.querySelector("canvas.large");
    if (!canvas) return;
    const { top } = canvas.getBoundingClientRect(),
      frame = sheet.getBoundingClientRect(),
      down = top - frame.top + sheet.scrollTop;
    const own = down < frame.height ? down : top - section.getBoundingClientRect().top;
    canvas.style.setProperty("--above", `${Math.ceil(frame.top + own + GAP)}px`);
  }
  const above = new ResizeObserver(() => document.querySelectorAll(".panel").forEach(leaveRoom));
  for (const element of [sheet, document.getElementById("summary")]) above.observe(element);
  /** Put a panel on the page. @param {HTMLElement} section */
  S.place = function (section) {
    document.getElementById("panels").append(section);
    heights.observe(section);
  };

  /** What a picture shows, and how it is used, behind one line. @param {string[]} texts */
  S.explained = function (...texts) {
    const known = texts.filter(Boolean);
    return known.length
      ? [S.make("details", {}, S.make("summary", {}, "About"), ...known.map((text) => S.make("p", { className: "about" }, text)))]
      : [];
  };

  const MOST_ROWS = 100,
    MOST_HIGH = 640;
  /**
   * A panel: heading, controls, canvas with a table behind it, PNG and CSV.
   * @param {{id: string, title: string, about: string, how?: string, height?: number, wide?: boolean, least?: number, controls?: any[],
   *   draw: Function, table: Function, key?: Function, depends?: () => string}} options
   *   height: in pixels; as high as the window has room for where it is left out; wide: two columns where there are more;
   *   least: width below which the picture scrolls; depends: of what the picture depends; it is drawn anew where that has changed
   */
  S.panel = function (options) {
    const { id, title, height, least, draw: paint } = options;
    const canvas = S.make("canvas", { tabIndex: 0, id: `${id}-canvas` });
    canvas.setAttribute("role", "img");
    if (height === undefined) canvas.className = "large";
    else canvas.style.height = `${height}px`;
    if (least) canvas.style.minWidth = `${least}px`;
    const table = S.make("table", { className: "behind" });
    const details = S.make(
      "details",
      { className: "data", ontoggle: () => fillTable() },
      S.make("summary", {}, "Table of this picture"),
      S.make("div", { className: "scroll", tabIndex: 0, role: "region", "aria-label": `${title}: table` }, table),
    );
    const csv = () => {
      const { head, rows } = options.table();
      const text = [head, ...rows].map((row) => row.map((cell) => S.csvCell(cell instanceof Node ? cell.textContent : cell)).join(",")).join("\r\n");
      S.save(`${id}.csv`, text);
    };
    const saved = (save, text, words) =>
      S.button({ onclick: () => save(id, title, paint, canvas.clientWidth, canvas.clientHeight), title: words }, text);
    const note = S.make("p", { className: "note", id: `${id}-note` });
    const section = S.make(
      "section",
      { id, className: options.wide ? "panel wide" : "panel", "aria-labelledby": `${id}-title` },
      S.make(
        "div",
        { className: "heading" },
        S.make("h2", { id: `${id}-title` }, title),
        ...S.explained(options.about, options.how),
        saved(S.savePng, "PNG", "Save this picture"),
        saved(S.saveSvg, "SVG", "Save this picture as lines and texts"),
        S.button({ onclick: csv, title: "Save the numbers of this picture" }, "CSV"),
      ),
      ...(options.controls ? [S.make("div", { className: "controls" }, ...options.controls.map((entry) => entry.element || entry))] : []),
      height > MOST_HIGH || least ? S.make("div", { className: "scroll tall", tabIndex: 0, role: "region", "aria-label": title }, canvas) : canvas,
      note,
      details,
    );
    function fillTable() {
      if (!details.open) return;
      const { head, rows } = options.table();
      S.fill(
        table,
        head,
        rows.slice(0, MOST_ROWS),
        rows.length > MOST_ROWS ? `first ${MOST_ROWS} of ${rows.length} rows; CSV holds all` : `${rows.length} rows`,
      );
    }
    if (options.key)
      canvas.addEventListener("keydown", (event) => {
        if (options.key(event)) event.preventDefault();
      });
    let drawn = "",
      visible = true;
    new IntersectionObserver((entries) => {
      visible = entries[entries.length - 1].isIntersecting;
      if (visible) draw();
    }).observe(canvas);
    const draw = () => {
      if (!visible && !S.drawsAll) return;
      const key = [options.depends ? options.depends() : S.everything(), S.themeName, canvas.clientWidth, canvas.clientHeight].join("/");
      if (key === drawn) return;
      drawn = key;
      const words = paint(canvas) || "";
      canvas.setAttribute("aria-label", S.visible(`${title}. ${words}`));
      if (note.textContent !== S.visible(words)) note.textContent = S.visible(words);
      fillTable();
    };
    S.onChange(draw);
    S.place(section);
    // what stands above it may grow or shrink: a picture of another size is stretched until it is drawn anew
    new ResizeObserver(() => S.redraw()).observe(canvas);
    return { canvas, section, details };
  };
})(stiffcal);
