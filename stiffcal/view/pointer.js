(function (S) {
  const CLICK = 4,
    NEAR = 12;
  /** The point that is nearest to a place, at most `NEAR` pixels away; −1 where none is. */
  function nearestOf({ px, py }, x, y) {
    let nearest = -1,
      best = NEAR;
    for (let p = 0; p < px.length; p++) {
      const far = Math.hypot(px[p] - x, py[p] - y);
      if (far < best) {
        best = far;
        nearest = p;
      }
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
    canvas.addEventListener("pointercancel", () => {
      brush.from = null;
      S.redraw();
    });
    canvas.addEventListener("pointerup", (event) => {
      if (!brush.from) return;
      const [[x0, x1], [y0, y1]] = [0, 1].map((k) => [brush.from[k], brush.to[k]].sort((a, b) => a - b));
      const click = x1 - x0 < CLICK && y1 - y0 < CLICK,
        { px, py } = points(),
        inside = [];
      for (let p = 0; p < px.length; p++) if (px[p] >= x0 && px[p] <= x1 && py[p] >= y0 && py[p] <= y1) inside.push(p);
      const nearest = nearestOf({ px, py }, x0, y0),
        pans = brush.pans && !click;
      brush.from = null;
      if (!pans) choose(click ? (nearest >= 0 ? [nearest] : []) : inside, event, click);
      S.redraw();
    });
    if (view) {
      canvas.addEventListener(
        "wheel",
        (event) => {
          if (document.activeElement !== canvas) return;
          event.preventDefault();
          view.zoom(event.deltaY < 0 ? 1 / 1.15 : 1.15, ...where(event));
          S.redraw();
        },
        { passive: false },
      );
      canvas.addEventListener("dblclick", () => {
        view.all();
        S.redraw();
      });
    }
    return {
      key: () => (brush.from ? brush.to.join() : ""),
      draw: (g) => {
        if (!brush.from || brush.pans) return;
        const [[x, y], [u, v]] = [brush.from, brush.to];
        g.strokeStyle = S.theme.accent;
        g.setLineDash([4, 3]);
        g.strokeRect(x, y, u - x, v - y);
        g.setLineDash([]);
      },
    };
  };
})(stiffcal);
