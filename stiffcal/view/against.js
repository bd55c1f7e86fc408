(function (S) {
  const LEFT = 74,
    RIGHT = 18,
    BELOW = 44,
    GAP = 46,
    SIDE_BY_SIDE = 560;

  S.againstPanel = function () {
    const { data } = S,
      { states } = data;
    const names = data.variables.map((variable) => [variable.name, S.withUnit(variable)]);
    const component = S.scalar ? [] : [["component", "component of the residual"]],
      keys = S.residualKeys();
    const variables = ["Variable", [...names, ...component]];
    const x = S.choice("x axis", [variables, ["Residual", keys]], (value) => S.set({ x: value }));
    const y = S.choice(
      "y axis",
      [
        ["Residual", keys],
        ["Variable", names],
      ],
      (value) => S.set({ y: value }),
    );
    const colour = S.choice("Colour", [["none", "none"], variables, ["Residual", keys.filter(([key]) => key !== "r.all")]], (value) =>
      S.set({ colour: value }),
    );
    const kind = S.choice(
      "Residual",
      [
        ["heldout", S.leftOut()],
        ["fit", "of the fit"],
      ],
      (value) => S.set({ kind: value }),
    );
    const rescale = S.button({ onclick: () => S.rescale() }, "Rescale");
    const views = S.make("span", { className: "views", role: "group", "aria-label": "Before and after" });
    /** Categories that are not drawn, by what gives the colours. */
    const hidden = new Set(),
      legendButtons = S.make("span", { className: "legend", role: "group", "aria-label": "Categories that are drawn" });
    const drawn = { px: [], py: [], boxes: [], ends: { x: [0, 1], y: [0, 1] }, stateOf: (p) => p, words: () => "" };
    let brush = null;

    const middle = () => [drawn.boxes[0].x + drawn.boxes[0].w / 2, drawn.boxes[0].y + drawn.boxes[0].h / 2];
    const panel = S.panel({
      id: "against",
      title: "1 Residual against any variable",
      wide: true,
      about:
        "Band: noise, ± 2σ. Points outside it are what the model does not explain. Grey: where points were with the model shown " +
        "before; hollow: where one linear step puts them. " +
        "Scales stay as they were for the worst model that was shown; Rescale fits them to the present one.",
      how:
        "Drag a rectangle from a point, or from anywhere with Shift: select states in all panels; with Ctrl they are added. Drag from " +
        "an empty place: move the picture; " +
        "wheel after a click: zoom; double click: all of it. Left and right arrows: step through the states, + and −: zoom, Enter " +
        "selects, Escape clears the selection.",
      controls: [views, x, y, colour, kind, rescale, legendButtons],
      draw,
      table,
      key: S.onKeys(
        {
          ArrowRight: () => S.goTo(S.state.at + 1),
          ArrowLeft: () => S.goTo(S.state.at - 1),
          "+": () => zoom(1 / 1.25, ...middle()),
          "-": () => zoom(1.25, ...middle()),
        },
        () => [S.state.at],
      ),
      depends: () => [S.everything(), S.scaling, brush?.key() ?? ""].join("/"),
    });
    const proposals = S.proposals();
    panel.section.insertBefore(S.make("h3", {}, "What explains the residual, by its share of the variance (all states)"), panel.details);
    panel.section.insertBefore(proposals.list, panel.details);

    brush = S.brush(
      panel.canvas,
      () => drawn,
      (chosen, event, click) => {
        const found = [...new Set(chosen.map((p) => drawn.stateOf(p)))].sort((a, b) => a - b);
        if (click && found.length) S.goTo(found[0]);
        S.select(found, (event.ctrlKey || event.metaKey) && found.length > 0);
      },
      { pan, zoom, all: () => S.setWindow(windowName(), null), words: (p) => drawn.words(p) },
    );

    const windowName = () => `${S.state.x}/${S.state.y}`;
    function pan(dx, dy) {
      const {
          boxes: [box],
          ends,
        } = drawn,
        u = (-dx / box.w) * (ends.x[1] - ends.x[0]),
        v = (dy / box.h) * (ends.y[1] - ends.y[0]);
      S.setWindow(windowName(), { x: ends.x.map((value) => value + u), y: ends.y.map((value) => value + v) });
    }
    function zoom(by, px, py) {
      const { boxes, ends } = drawn,
        box = boxes.find((one) => px <= one.x + one.w && py <= one.y + one.h) || boxes[0];
      const u = ends.x[0] + ((px - box.x) / box.w) * (ends.x[1] - ends.x[0]),
        v = ends.y[1] - ((py - box.y) / box.h) * (ends.y[1] - ends.y[0]);
      S.setWindow(windowName(), { x: ends.x.map((value) => u + by * (value - u)), y: ends.y.map((value) => v + by * (value - v)) });
    }

    let viewsKey = "";
    /** Buttons for a model and the one before it: where there may be one they are there before it is, so that nothing below them moves. */
    function showViews(pair) {
      const shown = S.state.sideBySide ? "side by side" : pair?.before.id === S.residual().model.id ? "before" : "after";
      const isPossible = S.isLive() || S.data.models.filter(S.isDrawable).length > 1;
      const key = pair ? [pair.before.id, pair.after.id, shown].join("/") : String(isPossible);
      if (key === viewsKey) return;
      viewsKey = key;
      const focus = [...views.children].indexOf(document.activeElement);
      const button = (name, text, changes, title) =>
        S.make("button", { type: "button", "aria-pressed": String(name === shown), title: S.visible(title), onclick: () => S.set(changes) }, text);
      views.replaceChildren(
        ...(pair
          ? [
              button("before", "before", { ...showing(pair.before), sideBySide: 0 }, pair.before.label),
              button("after", "after", { ...showing(pair.after), sideBySide: 0 }, pair.after.label),
              button("side by side", "side by side", { ...showing(pair.after), sideBySide: 1 }, "both on one scale"),
            ]
          : isPossible
            ? ["before", "after", "side by side"].map((text) =>
                S.make("button", { type: "button", disabled: true, title: "once an effect was ticked: the model before it, and the one with it" }, text),
              )
            : []),
      );
      if (focus >= 0) views.children[focus]?.focus();
    }
    /** What has all panels show a model; a refit without an effect is shown as the present model with the effect out. */
    const showing = (model) => (model.kind === "without" ? { mode: "refit", off: [model.effect] } : { model: model.id, mode: "part", off: [] });

    /** Names of the categories, null of those of which nothing is drawn: a button would do nothing. */
    function namesOfDrawn(sides, colours) {
      const [{ legend, scale }] = colours,
        drawn = new Set();
      if (scale) return legend;
      sides.forEach(({ x, y }, k) =>
        y.forEach((value, p) => {
          if (Number.isFinite(x[p] + value)) drawn.add(colours[k].numbers[p]);
        }),
      );
      return legend.map((word, k) => (drawn.has(k) ? word : null));
    }

    let legendKey = "";
    function showLegend(words, palette, band) {
      const key = JSON.stringify([words, S.state.colour, S.themeName, [...hidden], band]);
      if (key === legendKey) return;
      legendKey = key;
      const focus = [...legendButtons.children].indexOf(document.activeElement);
      legendButtons.replaceChildren(
        ...words.flatMap((word, k) => {
          if (word === null) return [];
          const name = `${S.state.colour}/${k}`,
            mark = S.make("canvas", { width: 24, height: 24, className: "mark" }),
            g = mark.getContext("2d");
          g.scale(2, 2);
          g.beginPath();
          S.marker(g, k, 6, 6, 4.5);
          g.fillStyle = palette[k];
          g.fill();
          const toggle = () => {
            if (!hidden.delete(name)) hidden.add(name);
            S.scaling++;
            S.redraw();
          };
          return S.make("button", { type: "button", "aria-pressed": String(!hidden.has(name)), title: "Show or hide", onclick: toggle }, mark, word);
        }),
        ...(band ? [S.make("span", { className: "band" }, S.BAND)] : []),
      );
      if (focus >= 0) legendButtons.children[focus]?.focus();
    }

    /** Where the pictures stand: one, or two side by side, or one above the other where there is no room. */
    function boxesOf(count, width, height, top) {
      const head = count > 1 ? 18 : 0;
      if (count === 1) return [{ x: LEFT, y: top, w: width - LEFT - RIGHT, h: height - BELOW - top }];
      if (width >= SIDE_BY_SIDE) {
        const w = (width - LEFT - RIGHT - GAP) / 2,
          box = { y: top + head, w, h: height - BELOW - top - head };
        return [
          { ...box, x: LEFT },
          { ...box, x: LEFT + w + GAP, yLabel: "" },
        ];
      }
      const h = (height - top) / 2 - BELOW - head;
      return [0, 1].map((k) => ({ x: LEFT, y: top + head + k * (h + BELOW + head), w: width - LEFT - RIGHT, h }));
    }

    /** Ends of an axis that hold all of these pictures, and those of the worst model that was shown. */
    function endsOf(axis, quantity, pictures) {
      if (quantity.levels.length) return [-0.5, quantity.levels.length - 0.5];
      const values = pictures.flatMap((one) => [...one[axis]].filter((_, p) => Number.isFinite(one.x[p] + one.y[p])));
      const ends = S.locked(`${axis} ${S.state.x} ${S.state.y}`, S.span(values)),
        sigma = axis === "y" ? 2.4 * quantity.sigma : 0;
      return sigma > 0 && S.state.y !== "r.length" ? [Math.min(ends[0], -sigma), Math.max(ends[1], sigma)] : ends;
    }

    function draw(canvas) {
      const shown = S.residual(),
        pair = S.pair();
      for (const [entry, value] of [
        [x, S.state.x],
        [y, S.state.y],
        [colour, S.state.colour],
        [kind, shown.heldout ? "heldout" : "fit"],
      ])
        entry.select.value = value;
      kind.select.options[0].disabled = !shown.model.residual_heldout;
      kind.select.options[1].disabled = !shown.model.residual_fit;
      showViews(pair);
      const { g, width, height } = S.begin(canvas);
      const others = pair ? pair.residuals : [];
      const sides = (pair && S.state.sideBySide ? others : [shown]).map(S.pointsOf);
      const colours = sides.map((points) => S.coloursOf(points, others)),
        [{ palette, scale }] = colours,
        legend = namesOfDrawn(sides, colours);
      const band = sides[0].up.sigma > 0 || sides[0].across.sigma > 0;
      showLegend(scale ? [] : legend, palette, band);
      if (!scale && legend.length) {
        sides.forEach((points, k) =>
          points.y.forEach((_, p) => {
            if (hidden.has(`${S.state.colour}/${colours[k].numbers[p]}`)) points.y[p] = NaN;
          }),
        );
      }
      const ofResidual = [S.state.x, S.state.y].some((key) => key.startsWith("r.")),
        alone = sides.length === 1;
      const ghost = S.ghost && ofResidual && alone ? S.pointsOf(S.ghost) : null,
        hollow = S.hollow && ofResidual ? S.pointsOf(S.hollow) : null;
      const [{ across, up, count, stateOf, valueOf }] = sides,
        pictures = [...sides, ...(S.isRescaled() ? [] : others.map(S.pointsOf)), ...[ghost, hollow].filter(Boolean)];
      const ends = { x: endsOf("x", across, pictures), y: endsOf("y", up, pictures) },
        part = S.windowOf(windowName());
      if (part && !across.levels.length) ends.x = part.x;
      if (part && !up.levels.length) ends.y = part.y;
      const top = scale ? 26 : S.drawsFile ? S.legend(g, { x: LEFT, w: width - LEFT - RIGHT }, legend, palette, scale, band) : 12;
      const boxes = boxesOf(sides.length, width, height, top),
        last = sides.length - 1;
      const pixels = sides.map((points, k) => {
        if (!alone) title(g, boxes[k], k ? "after" : "before", points.residual);
        return S.drawPoints(g, boxes[k], { points, colours: colours[k], ends, ghost, hollow: k === last ? hollow : null, moved: S.moved() });
      });
      const join = (name) => Float64Array.from(pixels.flatMap((one) => [...one[name]]));
      Object.assign(drawn, {
        px: join("px"),
        py: join("py"),
        boxes,
        ends,
        stateOf: (p) => stateOf(p % count),
        words: (p) => wordsOf(sides[Math.floor(p / count)], p % count),
      });
      brush.draw(g);
      if (scale) S.legend(g, { x: LEFT, w: width - LEFT - RIGHT }, legend, palette, scale, band && S.drawsFile);
      proposals.show();
      const some = data.n_states > S.n ? ` Shown ${S.count(S.n)} of ${S.count(data.n_states)} states.` : "";
      const which = alone ? shown.model.label : `${pair.before.label}, and ${pair.after.label}`;
      const sigma = up.sigma > 0 ? " Points outside the band are not explained by the model and the noise." : "";
      return `${up.label} against ${across.label}, ${which}.${sigma}${S.nSelected ? ` ${S.count(S.nSelected)} states selected.` : ""}${some}`;
    }

    function title(g, box, word, { model, heldout }) {
      const text = (name) => S.visible(`${word}: ${S.error(heldout ? model.heldout_rms : model.fit_rms)}, ${name}`);
      g.fillStyle = S.theme.ink;
      g.textAlign = "left";
      g.textBaseline = "bottom";
      // what a long name has last, what was added, must not be cut off
      g.fillText(S.fitting(g, [model.label, model.short].map(text), box.w), box.x, box.y - 5);
    }

    /** Run, row and values of a point. */
    function wordsOf({ across, up, stateOf, valueOf }, p) {
      const i = stateOf(p);
      const value = (quantity) =>
        quantity.levels.length ? (quantity.levels[valueOf(quantity, p)] ?? "") : `${S.digits(valueOf(quantity, p))} ${quantity.unit}`;
      return `${data.runs[states.run[i]].name}, row ${states.row[i]}: ${value(up)} at ${across.label} ${value(across)}`;
    }

    function table() {
      const { across, up, count, stateOf, valueOf } = S.pointsOf(S.residual()),
        rows = [];
      const cell = (quantity, p) => (quantity.levels.length ? (quantity.levels[valueOf(quantity, p)] ?? "") : valueOf(quantity, p));
      for (let p = 0; p < count; p++) {
        const i = stateOf(p);
        if (S.nSelected && !S.selected[i]) continue;
        rows.push([
          data.runs[states.run[i]].name,
          states.row[i],
          cell(across, p),
          cell(up, p),
          states.used[i] ? "used" : states.why[i] || "reference",
        ]);
      }
      return { head: ["run", "row", S.withUnit(across), S.withUnit(up), "state"], rows };
    }
  };
})(stiffcal);
