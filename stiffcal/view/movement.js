(function (S) {
  const MS = 700;
  /** What was shown before the present model, drawn grey; null for nothing. */
  S.ghost = null;
  /** A forecast, drawn hollow; null for nothing. */
  S.hollow = null;
  /** Counts pictures of a movement. */
  S.frame = 0;
  let began = -Infinity;

  /** How far points have moved from where they were to where they are, 0 to 1. */
  S.moved = function () {
    const t = Math.min(1, Math.max(0, (performance.now() - began) / MS));
    return t * t * (3 - 2 * t);
  };

  /** Have points move from a residual to the one that is shown now. @param {Object<string, any>|null} ghost */
  S.moveFrom = function (ghost) {
    S.ghost = ghost;
    began = matchMedia("(prefers-reduced-motion: reduce)").matches ? -Infinity : performance.now();
    const step = () => {
      S.frame++;
      S.redraw();
      if (S.moved() < 1) requestAnimationFrame(step);
    };
    step();
  };

  /** What is shown now, to be a ghost of what comes; null where nothing is. */
  S.asGhost = function () {
    if (!S.n || !S.modelById.get(S.state.model)) return null;
    const { move, turn, model, heldout } = S.residual();
    const isPart = S.state.off.length > 0 && S.state.mode === "part";
    return { move, turn, model, heldout, rms: isPart ? null : heldout ? model.heldout_rms : model.fit_rms };
  };

  /** The error that counts down: from that of the model shown before to the present one. @returns {Object<string, any>|null} */
  S.errorNow = function () {
    const shown = S.residual(),
      to = shown.heldout ? shown.model.heldout_rms : shown.model.fit_rms,
      from = S.ghost?.rms,
      t = S.moved();
    if (!to || !from || t >= 1) return to;
    const isNumber = (value) => typeof value === "number";
    return Object.fromEntries(
      Object.entries(to).map(([name, value]) => [name, isNumber(value) && isNumber(from[name]) ? from[name] + (value - from[name]) * t : value]),
    );
  };
})(stiffcal);
