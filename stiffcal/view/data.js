"use strict";
/** The one name of the page. @type {Object<string, any>} */
const stiffcal = {};
(function (S) {
  /** @typedef {{$: {at: number, n: number, width: number, step: number, shape: number[]}}} Reference */

  /** Bytes of base 64. @param {string} text @returns {Uint8Array} */
  function bytesOf(text) {
    const binary = atob(text.trim());
    const bytes = new Uint8Array(binary.length);
    for (let i = 0; i < binary.length; i++) bytes[i] = binary.charCodeAt(i);
    return bytes;
  }

  /** @param {Uint8Array} bytes @returns {Promise<Uint8Array>} */
  async function inflate(bytes) {
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  }

  /** Numbers of an array, NaN where none is known. @param {Uint8Array} bytes @param {Reference["$"]} entry */
  function numbersOf(bytes, entry) {
    const { at, n, width, step } = entry;
    const values = new Float64Array(n);
    const missing = -(2 ** (8 * width - 1));
    for (let i = 0; i < n; i++) {
      let integer = bytes[at + i] | (bytes[at + n + i] << 8);
      if (width === 2) integer = (integer << 16) >> 16;
      else integer = integer | (bytes[at + 2 * n + i] << 16) | (bytes[at + 3 * n + i] << 24);
      values[i] = integer === missing ? NaN : integer * step;
    }
    return values;
  }

  /** Replace references by arrays, everywhere. @param {any} value @param {Uint8Array} bytes */
  function resolve(value, bytes) {
    if (Array.isArray(value)) return value.map((item) => resolve(item, bytes));
    if (value === null || typeof value !== "object") return value;
    if (value.$) return numbersOf(bytes, value.$);
    const result = {};
    for (const key of Object.keys(value)) result[key] = resolve(value[key], bytes);
    return result;
  }

  let cached = { key: "", value: null };
  /** What Python packed. @param {string} packed @returns {Promise<any>} */
  S.unpacked = async function (packed) {
    const whole = await inflate(bytesOf(packed));
    const length = new DataView(whole.buffer).getUint32(0, true);
    return resolve(JSON.parse(new TextDecoder().decode(whole.subarray(4, 4 + length))), whole.subarray(4 + length));
  };
  /** Take data for the page: its parts, one of each kind of readings. @param {any} data */
  S.take = function (data) {
    S.parts = [data, ...data.others];
  };
  /** Name of a part, by what was measured. */
  S.partName = (data) => ({ torque: "friction of moving joints", motor_angle: "clamped robot" })[data.measure] || "displacements under load";

  /** Show a part of the data. @param {number} part */
  S.use = function (part) {
    S.part = S.parts[part] ? part : 0;
    S.data = S.parts[S.part];
    const states = S.data.states;
    S.n = states ? states.run.length : 0;
    S.selected = new Uint8Array(S.n);
    S.nSelected = 0;
    S.modelById = new Map(S.data.models.map((model) => [model.id, model]));
    S.variableByName = new Map(S.data.variables.map((variable) => [variable.name, variable]));
    S.members = S.data.runs.map(() => []);
    for (let i = 0; i < S.n; i++) S.members[states.run[i]].push(i);
    S.scalar = S.data.measure !== "translation";
    S.units = S.data.units;
    S.components = S.scalar ? ["x"] : S.data.rotation ? ["x", "y", "z", "rx", "ry", "rz"] : ["x", "y", "z"];
    cached = { key: "", value: null };
    return S.data;
  };

  /** The error of a model in the measure of the campaign. @param {Object<string, number|null>|null} rms @returns {number|null} */
  S.main = (rms) => rms?.[S.data.measure] ?? null;
  /** Standard deviation of one component of the residual, SI. */
  S.sigma = () => (S.main(S.data.noise) ?? NaN) / (S.scalar || S.data.one_direction ? 1 : Math.sqrt(3));

  /** Whether a model has something to draw. */
  S.isDrawable = (model) => Boolean(model.residual_fit || model.residual_heldout);

  /** The residual of a model, in held-out data where it is known there and chosen. @param {any} model @param {boolean} [allowed] whether it may be */
  S.residualOf = function (model, allowed = true) {
    const heldout = (allowed && S.state.kind === "heldout" && Boolean(model.residual_heldout)) || !model.residual_fit;
    const [move, turn] = heldout ? model.residual_heldout : model.residual_fit;
    return { move, turn: S.data.rotation ? turn : null, model, heldout };
  };

  /**
   * The model that is shown and the one to compare it with: the fit before the last effect was added, or the present fit
   * of a refit with or without an effect; null where there is none.
   * @returns {{before: any, after: any, residuals: any[]}|null} residuals: of both, of one kind where both have that
   */
  S.pair = function () {
    const { models, change } = S.data,
      present = models.find((model) => model.present),
      { model: shown } = S.residual();
    const earlier = change && S.modelById.get(change.before);
    const pair =
      shown.kind === "with" || shown.kind === "all"
        ? { before: present, after: shown }
        : shown.kind === "without"
          ? { before: shown, after: present }
          : shown === present || shown === earlier
            ? { before: earlier, after: present }
            : { before: null };
    const both = [pair.before, pair.after];
    if (!both.every((model) => model && S.isDrawable(model))) return null;
    const heldout = both.every((model) => model.residual_heldout);
    return { ...pair, residuals: both.map((model) => S.residualOf(model, heldout)) };
  };

  /**
   * The residual that all panels show: of the model that is chosen, the parts of effects added that are taken out.
   * @returns {{move: Float64Array, turn: Float64Array|null, model: any, heldout: boolean, exact: boolean}}
   */
  S.residual = function () {
    const state = S.state;
    const key = S.shownKey();
    if (cached.key === key) return cached.value;
    let model = S.modelById.get(state.model);
    if (state.mode === "refit" && state.off.length) {
      model = S.data.models.find((entry) => entry.kind === "without" && entry.effect === state.off[0]) || model;
    }
    const whole = S.residualOf(model),
      { heldout } = whole;
    let { move, turn } = whole;
    if (state.mode === "part" && state.off.length) {
      move = Float64Array.from(move);
      turn = turn && Float64Array.from(turn);
      for (const effect of S.data.effects.filter((entry) => state.off.includes(entry.name))) {
        for (let i = 0; i < move.length; i++) move[i] += effect.part[0][i];
        if (turn) for (let i = 0; i < turn.length; i++) turn[i] += effect.part[1][i];
      }
    }
    const exact = !(state.mode === "part" && state.off.length > 1);
    cached = { key, value: { move, turn, model, heldout, exact } };
    return cached.value;
  };

  /**
   * Square root of the mean squared length of three components, over the drawn states that are judged.
   * @param {Float64Array} values (n × 3) @param {(i: number) => boolean} [keep] @returns {number} NaN of none
   */
  S.rms = function (values, keep) {
    const used = S.data.states.used;
    let sum = 0,
      count = 0;
    for (let i = 0; i < S.n; i++) {
      if (!used[i] || (keep && !keep(i))) continue;
      const square = values[3 * i] ** 2 + values[3 * i + 1] ** 2 + values[3 * i + 2] ** 2;
      if (Number.isFinite(square)) {
        sum += square;
        count++;
      }
    }
    return count ? Math.sqrt(sum / count) : NaN;
  };

  /** What a residual key may be, with its words. @returns {[string, string][]} */
  S.residualKeys = function () {
    if (S.scalar) return [["r.x", S.data.measure === "torque" ? "torque" : "angle of the moved motor"]];
    return [
      ...S.components.map((name, k) => [`r.${name}`, k < 3 ? `along ${name}` : `about ${name.slice(1)}`]),
      ["r.length", "length"],
      ["r.all", "along x, y and z together"],
      ...S.data.evidence.map((one, k) => [`r.e${k + 1}`, `along ${one.name} (${one.standing})`]),
      ...S.data.effects.map((effect) => [`r.along ${effect.name}`, `along the effect ${effect.name}`]),
    ];
  };

  /**
   * Numbers to draw or to colour by: a variable, a residual ("r.x"), or the component of a residual ("component").
   * @param {string} key @param {{move: Float64Array, turn: Float64Array|null, heldout: boolean}} [shown] the residual, if not the one that is shown
   * @returns {{values: Float64Array|null, label: string, unit: string, levels: string[], sigma: number, wide: boolean}}
   *   sigma: of the noise, in the unit, 0 where none belongs to it; wide: three values of each state, null: its component
   */
  S.quantity = function (key, shown = S.residual()) {
    const variable = S.variableByName.get(key);
    if (variable) return { ...variable, sigma: 0, wide: false };
    if (key === "component") return { values: null, label: "component of the residual", unit: "", levels: ["x", "y", "z"], sigma: 0, wide: true };
    const name = key.slice(2),
      axis = S.components.indexOf(name),
      { noise } = S.data;
    const kind = shown.heldout ? "held-out residual" : "residual of the fit",
      length = S.units.length,
      sigma = S.sigma();
    const { factor, name: unit } = S.scalar ? S.units.main : axis < 3 ? length : S.units.angle;
    if (key === "r.all") {
      return {
        values: shown.move.map((value) => length.factor * value),
        label: kind,
        unit: length.name,
        levels: [],
        sigma: length.factor * sigma,
        wide: true,
      };
    }
    const values = new Float64Array(S.n);
    if (axis >= 0) {
      const source = axis < 3 ? shown.move : shown.turn;
      for (let i = 0; i < S.n; i++) {
        const value = source[3 * i + (axis % 3)];
        values[i] = S.data.one_direction && value === 0 ? NaN : factor * value;
      }
      const words = S.scalar
        ? S.data.measure === "torque"
          ? " torque"
          : " angle of the moved motor"
        : ` ${axis < 3 ? "along" : "about"} ${"xyz"[axis % 3]}`;
      return {
        values,
        label: kind + words,
        unit,
        levels: [],
        sigma: factor * (axis < 3 ? sigma : (noise?.rotation ?? NaN) / Math.sqrt(3)),
        wide: false,
      };
    }
    const one = S.data.evidence[/^e\d+$/.test(name) ? Number(name.slice(1)) - 1 : -1];
    if (one) {
      const scale = one.turns ? S.units.angle : length,
        source = one.turns ? shown.turn : shown.move;
      for (let i = 0; i < S.n; i++) values[i] = scale.factor * [0, 1, 2].reduce((sum, k) => sum + one.along[3 * i + k] * source[3 * i + k], 0);
      const noiseAlong = one.turns ? (noise?.rotation ?? NaN) / Math.sqrt(3) : sigma;
      return { values, label: `${kind} along ${one.name}`, unit: scale.name, levels: [], sigma: scale.factor * noiseAlong, wide: false };
    }
    const effect = S.data.effects.find((entry) => `along ${entry.name}` === name);
    for (let i = 0; i < S.n; i++) {
      const r = [0, 1, 2].map((k) => shown.move[3 * i + k]);
      if (!effect) {
        values[i] = length.factor * Math.hypot(...r);
        continue;
      }
      const p = [0, 1, 2].map((k) => effect.part[0][3 * i + k]),
        size = Math.hypot(...p);
      values[i] = size > 0 ? (length.factor * (r[0] * p[0] + r[1] * p[1] + r[2] * p[2])) / size : NaN;
    }
    const label = effect ? `${kind} along the effect ${effect.name}` : `length of the ${kind}`;
    return { values, label, unit: length.name, levels: [], sigma: length.factor * (effect ? sigma : (S.main(noise) ?? NaN) / 2), wide: false };
  };
})(stiffcal);
