(function (S) {
  const ROW = 26;
  S.effectsPanel = function () {
    const { data } = S;
    const mode = S.choice(
      "Mode",
      [
        ["part", "its part taken out"],
        ["refit", "refitted without it"],
      ],
      (value) => S.set({ mode: value, off: value === "refit" ? S.state.off.slice(0, 1) : S.state.off }),
    );
    const refitOf = (effect) => data.models.find((model) => model.kind === "without" && model.effect === effect.name);
    const turn = (effect, on) => {
      const present = data.models.find((model) => model.present);
      const off = S.state.mode === "refit" ? [] : S.state.off.filter((name) => name !== effect.name);
      S.set({ off: on ? off : [...off, effect.name], model: present ? present.id : S.state.model });
    };
    const allowed = (effect) => S.state.mode !== "refit" || Boolean(refitOf(effect));
    const checks = data.effects.map((effect) => S.check(effect.name, true, (on) => turn(effect, on)));
    const panel = S.panel({
      id: "effects",
      title: "4 Effects of the present model",
      height: 44 + ROW * Math.max(data.effects.length, 1),
      about:
        "What is left without an effect. “Its part taken out”: the prediction without it, all other values unchanged (exact for one " +
        "effect, no fit). “Refitted without it”: all other values fitted again, one effect at a time.",
      how: "Uncheck an effect, or click its bar: it is taken out in all panels.",
      controls: [mode, ...checks],
      draw,
      table,
      depends: S.shownKey,
    });
    let find = () => -1;
    panel.canvas.addEventListener("click", (event) => {
      const effect = data.effects[find(event.offsetY)];
      if (effect && allowed(effect)) turn(effect, S.state.off.includes(effect.name));
    });
    let partial = { key: "", values: [] };
    /** Error with the part of each effect taken out, of the drawn states; m. */
    function errors() {
      const present = data.models.find((model) => model.present);
      const residual =
        present &&
        (S.state.kind === "heldout" && present.residual_heldout ? present.residual_heldout : present.residual_fit || present.residual_heldout);
      const key = `${S.state.kind}`;
      if (partial.key === key || !residual) return partial.values;
      partial = { key, values: data.effects.map((effect) => S.rms(residual[0].map((value, i) => value + effect.part[0][i]))) };
      return partial.values;
    }
    function draw(canvas) {
      mode.select.value = S.state.mode;
      checks.forEach((check, k) => {
        check.input.checked = !S.state.off.includes(data.effects[k].name);
        check.input.disabled = !allowed(data.effects[k]);
      });
      const { g, width } = S.begin(canvas),
        taken = errors();
      const rows = data.effects.map((effect, k) => {
        const refit = refitOf(effect),
          value = S.state.mode === "part" ? taken[k] : S.main(refit?.heldout_rms);
        return {
          name: `${effect.name} (${S.percent(effect.share)})`,
          value,
          text: Number.isFinite(value) ? S.size(value) : "no refit stored",
          chosen: S.state.off.includes(effect.name),
          grey: !Number.isFinite(value),
        };
      });
      find = S.bars(g, width, rows, { top: 34, rowHeight: ROW, log: true, line: S.main(data.noise) || 0, lineLabel: "noise" });
      const shown = S.residual(),
        off = S.state.off;
      if (!off.length)
        return (
          `Bars, on a logarithmic scale: error without the effect ` +
          `(${S.state.mode === "part" ? "its part taken out, drawn states" : "refitted, all states"}); ` +
          `in brackets its share of the predicted ${data.measure === "torque" ? "torque" : "deflection"}.`
        );
      if (S.state.mode === "refit")
        return shown.model.kind === "without"
          ? `Shown in all panels: refitted without ${off[0]}, ${S.error(shown.model.heldout_rms)} rms ${S.leftOut()} (all states).`
          : `No refit without ${off[0]} is stored: ${data.refits_missing || "run stiffcal diagnose"}.`;
      const error = S.size(S.rms(shown.move));
      return (
        `Shown in all panels: the present fit with the part of ${off.join(", ")} taken out, not a fit; ${error} rms of the drawn ` +
        `states.${shown.exact ? "" : " Parts of several effects are added, which is not exact to second order."}`
      );
    }
    function table() {
      const taken = errors();
      return {
        head: [
          "effect",
          `share of the ${data.measure === "torque" ? "torque" : "deflection"}`,
          `rms, part taken out [${S.si()}]`,
          `rms ${S.leftOut()}, refitted without it [${S.si()}]`,
        ],
        rows: data.effects.map((effect, k) => [effect.name, effect.share, taken[k] ?? NaN, S.main(refitOf(effect)?.heldout_rms) ?? NaN]),
      };
    }
    return panel;
  };
})(stiffcal);
