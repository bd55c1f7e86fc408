(function (S) {
  /** What the table behind a picture holds of a series. */
  function rowsOf(panel, s, k) {
    if (!s.x) return [[s.label || s.kind_.toLowerCase(), "", NaN, s.low, s.high]];
    return [...s.x.keys()].map((i) => {
      const half = s.spread ? s.spread[i] : NaN,
        y = s.y ? s.y[i] : NaN;
      const place = panel.x_names?.[Math.round(s.x[i])] ?? s.x[i];
      return [s.label || `${s.kind_.toLowerCase()} ${k + 1}`, place, y, s.low ? s.low[i] : y - half, s.high ? s.high[i] : y + half];
    });
  }

  /** What a panel is called, and what it draws over what; of a title of several lines the first, the others are its note. */
  function titleOf({ title, x_label, y_label }) {
    const axes = y_label && x_label ? `${y_label} over ${x_label}` : y_label,
      [first, ...others] = title.split("\n");
    return others.length ? first : [first, axes].filter(Boolean).join(", ");
  }

  const HOW =
    "Drag a rectangle, or click on a point: select the states of these points in all panels; with Shift they are added. " +
    "Left and right arrows: go from point to point; Enter selects; Escape clears the selection.";
  const OF_SWEEPS = " A point of a clamped run is an average over cycles; of it are the states of its sweep that are nearest in torque.";

  /** A picture of a kind: a rectangle, a click or keys select the states of its points. @returns {HTMLElement} */
  function kindPanel(panel, number, caption) {
    let points = [],
      brush = null,
      at = -1;
    const chosen = (near, event) =>
      S.select(
        [...new Set(near.flatMap((point) => point.members))].sort((a, b) => a - b),
        event.shiftKey,
      );
    const linked = panel.series.some((s) => s.run || s.rows),
      sweeps = panel.series.some((s) => s.sweep);
    const step = (by) => {
      if (points.length) at = (at + by + points.length + (by < 0 && at < 0)) % points.length;
      S.redraw();
    };
    const made = S.panel({
      id: `kind${number}`,
      title: titleOf(panel),
      about: caption,
      height: 340,
      how: linked ? HOW + (sweeps ? OF_SWEEPS : "") : "",
      draw: (canvas) => {
        points = S.drawKindPanel(canvas, panel);
        const g = canvas.getContext("2d");
        brush?.draw(g);
        if (at >= 0 && points[at]) {
          g.strokeStyle = S.theme.ink;
          g.strokeRect(points[at].px - 7, points[at].py - 7, 14, 14);
        }
        const chosenPoints = S.nSelected && points.length ? `${points.filter(S.isChosenPoint).length} of ${points.length} points are of selected states.` : "";
        return [...panel.title.split("\n").slice(1), chosenPoints].filter(Boolean).join("; ");
      },
      depends: () => `${S.version}/${at}/${brush?.key() ?? ""}`,
      key: linked ? S.onKeys({ ArrowRight: () => step(1), ArrowLeft: () => step(-1) }, () => points[at]?.members) : undefined,
      table: () => ({
        head: ["series", panel.x_label || "place", panel.y_label, "low", "high"],
        rows: panel.series.flatMap((s, k) => rowsOf(panel, s, k)),
      }),
    });
    const pixels = () => ({ px: points.map((point) => point.px), py: points.map((point) => point.py) });
    if (linked)
      brush = S.brush(made.canvas, pixels, (near, event) =>
        chosen(
          near.map((k) => points[k]),
          event,
        ),
      );
    return made.section;
  }

  function tableOf(block, name) {
    const table = S.make("table");
    S.fill(table, block.heads, block.rows, block.caption);
    return S.make("div", { className: "scroll", tabIndex: 0, role: "region", "aria-label": S.visible(name) }, table);
  }

  /**
   * Buttons in each picture that show those of another joint in place of it, in the order of the joints.
   * @param {{joint: string, section: HTMLElement}[]} pictures
   */
  function tabs(pictures) {
    const ofJoints = pictures.filter((entry) => entry.joint),
      joints = [...new Set(ofJoints.map((entry) => entry.joint))];
    if (joints.length < 2) return;
    const places = ofJoints.map(({ joint }, k) => ofJoints.slice(0, k).filter((entry) => entry.joint === joint).length);
    /** The place of the picture in which a button was chosen: that of the same kind gets the focus. */
    let chosen = -1;
    const groups = ofJoints.map(({ joint, section }, k) => {
      const buttons = joints.map((other, number) => {
        const show = () => {
          chosen = places[k];
          S.set({ tab: number });
        };
        return S.button({ onclick: show, "aria-pressed": String(other === joint) }, other);
      });
      section.querySelector(".heading").after(S.make("div", { className: "tabs", role: "group", "aria-label": "Joint that the picture shows" }, ...buttons));
      return buttons;
    });
    S.onChange(() => {
      const number = Math.min(S.state.tab, joints.length - 1);
      ofJoints.forEach(({ joint, section }, k) => {
        section.hidden = joint !== joints[number];
        if (!section.hidden && places[k] === chosen) groups[k][number].focus();
      });
      chosen = -1;
    });
  }

  /** Pages of clamped, friction and other kinds of experiment: pictures, tables, sentences. */
  S.kindPanels = function () {
    let number = 0,
      tables = 0;
    for (const page of S.data.pages) {
      const section = S.make("section", { className: "panel kind wide", "aria-label": S.visible(page.title) }, S.make("h2", {}, page.title)),
        pictures = [];
      S.place(section);
      if (!page.blocks.length) section.append(S.make("p", {}, page.why_empty));
      for (const block of page.blocks) {
        if (block.kind_ === "Subheading") section.append(S.make("h3", {}, block.text));
        else if (block.kind_ === "Sentence")
          section.append(S.make("p", { className: block.level }, (block.level === "warning" ? "Warning: " : "") + block.words));
        else if (block.kind_ === "Listing")
          section.append(S.make("ul", {}, ...block.sentences.map((sentence) => S.make("li", {}, sentence.words))));
        else if (block.kind_ === "Table") section.append(tableOf(block, `${block.caption || page.title}, table ${++tables}`));
        else {
          block.panels.forEach((panel, k) => {
            if (panel.series.length) pictures.push({ joint: panel.joint, section: kindPanel(panel, ++number, k ? "" : block.caption) });
          });
        }
      }
      if (page.next_step) section.append(S.make("p", {}, `${page.next_step.once ? `once ${page.next_step.once}` : "next"}: ${page.next_step.command}`));
      tabs(pictures);
    }
  };
})(stiffcal);
