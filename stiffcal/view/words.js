(function (S) {
  /** A share below this is too small to matter on any picture. */
  const LEAST_SHARE = 0.001;
  /** A number with three significant digits, as `stiffcal.wording.significant` writes it. @param {number|null} value @returns {string} */
  S.digits = function (value) {
    if (value === null || value === undefined || !Number.isFinite(value)) return "–";
    if (value === 0) return "0";
    const [mantissa, power] = rounded(value);
    const text = power >= -4 && power < 4 ? Number(`${mantissa}e${power}`).toFixed(Math.max(2 - power, 0)) : `${mantissa}·10${raisedTo(power)}`;
    return text.replace("-", "−");
  };
  /** Mantissa and power of ten of a number, rounded to three digits; a half goes to the even digit, as in Python. */
  const rounded = function (value) {
    const [mantissa, power] = value.toExponential(2).split("e"),
      [exact, own] = value.toExponential(60).split("e"); // a half has few digits
    const down = exact.slice(0, mantissa.length),
      isHalf = own === power && /^50*$/.test(exact.slice(mantissa.length));
    return [isHalf && Number(down.at(-1)) % 2 === 0 ? down : mantissa, Number(power)];
  };
  const raisedTo = (power) => [...String(power)].map((c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[Number(c)])).join("");
  /** A quantity with its unit, as axes and tables name it. @param {{label: string, unit: string}} quantity */
  S.withUnit = ({ label, unit }) => (unit ? `${label} [${unit}]` : label);
  /** A count, in groups of three digits. @param {number} n */
  S.count = (n) => String(n).replace(/\B(?=(\d{3})+$)/g, "\u202f");
  /** A length. @param {number|null} metres */
  S.length = (metres) => inUnit(metres, S.units.length);
  const inUnit = function (value, { factor, name }) {
    if (!Number.isFinite(value ?? NaN)) return "–";
    const isRounding = factor > 1 && value !== 0 && Math.abs(value) < 1e-9;
    return isRounding ? `below 1 n${name.slice(1)}` : `${S.digits(factor * value)} ${name}`;
  };
  /** An angle. @param {number|null} radians */
  S.angle = (radians) => inUnit(radians, S.units.angle);
  /** A size in the measure of the campaign. @param {number|null} value SI */
  S.size = (value) => inUnit(value, S.units.main);
  /** The SI unit of errors. */
  S.si = () => ({ motor_angle: "rad", torque: "N·m" })[S.data.measure] || "m";
  /** Where models are judged on what their fit has not used. */
  S.leftOut = () => (S.data.measure === "torque" ? "at held-out speeds" : `in ${S.data.held_out}`);
  /** An error as people read it. @param {{translation: number|null, rotation: number|null}|null} rms */
  S.error = function (rms) {
    if (!rms) return "–";
    if (S.scalar) return S.size(S.main(rms));
    return S.length(rms.translation) + (S.data.rotation && rms.rotation !== null ? `, ${S.angle(rms.rotation)}` : "");
  };
  /** The error of the rods next to that of the tool, and their noise; "" where there are none. @param {{length: number|null}|null} rms */
  S.ofRods = (rms) =>
    S.data.measure === "length" || !Number.isFinite(rms?.length ?? NaN)
      ? ""
      : `; at the rods ${S.length(rms.length)}${S.data.noise ? `, noise ${S.length(S.data.noise.length)}` : ""}`;
  /** The noise that a model's error is compared with. @param {string} [size] */
  S.noiseWords = (size = S.error(S.data.noise)) => (S.data.noise ? `noise ${size}` : "noise not known");
  /** Why the diagnosis states another error of the present fit than the page, where what is printed differs; "" else. */
  S.whyOther = function (data) {
    const present = data.models.find((entry) => entry.present),
      [own, judged] = [present?.heldout_rms?.translation, data.diagnosed?.translation];
    if (data.diagnosis_of || !(own > 0 && judged > 0) || S.length(own) === S.length(judged)) return "";
    return (
      `The diagnosis states ${S.length(judged)}, this page ${S.length(own)}: it leaves out single poses, and fits the robot's ` +
      `geometry too, within its tolerance.`
    );
  };
  /** @param {number|null} share */
  S.percent = (share) =>
    !Number.isFinite(share) ? "–" : share !== 0 && Math.abs(share) < LEAST_SHARE ? `< ${100 * LEAST_SHARE} %` : `${S.digits(100 * share)} %`;

  /** A text in which no line ends between a number and its unit. @param {string} text */
  S.unbroken = (text) => String(text).replace(/(\d) (?=(?:%|°|[mµ]?m|[mµ]?rad|N(?:·m)?)(?![\w·]))/g, "$1\u00a0");

  /** Hidden and direction-changing characters of names from files, made visible. @param {string} text */
  S.visible = function (text) {
    return String(text).replace(
      /[\u0000-\u001f\u007f-\u009f\u00ad\u061c\u180e\u200b-\u200f\u2028-\u202f\u2060-\u206f\ufeff\ufff9-\ufffb]/g,
      (c) => `\\u${c.charCodeAt(0).toString(16).padStart(4, "0")}`,
    );
  };
  /** A text as a TOML string. @param {string} text */
  S.tomlText = (text) =>
    JSON.stringify(String(text)).replace(/[\u007f-\uffff]/g, (c) =>
      /[\u007f-\u009f\u00ad\u061c\u200b-\u200f\u2028-\u202f\u2060-\u206f\ufeff]/.test(c) ? `\\u${c.charCodeAt(0).toString(16).padStart(4, "0")}` : c,
    );
  /** A cell of a CSV file; a spreadsheet must not take it for a formula. @param {any} value */
  S.csvCell = function (value) {
    if (typeof value === "number") return Number.isFinite(value) ? String(value) : "";
    let text = S.visible(value ?? "");
    if (/^[=+\-@\t\r]/.test(text)) text = `'${text}`;
    return /[",\n\r;]/.test(text) ? `"${text.replace(/"/g, '""')}"` : text;
  };
})(stiffcal);
