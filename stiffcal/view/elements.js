(function (S) {
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
    const made = ([value, text]) =>
      Array.isArray(text) ? S.make("optgroup", { label: S.visible(value) }, ...text.map(made)) : S.make("option", { value }, text);
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

  /** What a table shows of a number: counts and row numbers whole, all else in three digits. @param {number} value */
  const cellText = (value) => (Number.isSafeInteger(value) ? String(value).replace("-", "−") : S.digits(value));
  /** Fill a table. @param {HTMLTableElement} table @param {string[]} head @param {any[][]} rows @param {string} caption */
  S.fill = function (table, head, rows, caption) {
    table.replaceChildren(
      S.make("caption", {}, caption),
      S.make("thead", {}, S.make("tr", {}, ...head.map((text) => S.make("th", { scope: "col" }, text)))),
      S.make(
        "tbody",
        {},
        ...rows.map((row) =>
          S.make(
            "tr",
            {},
            ...row.map((cell, k) =>
              cell instanceof Node
                ? S.make("td", {}, cell)
                : S.make(k ? "td" : "th", k ? {} : { scope: "row" }, typeof cell === "number" ? cellText(cell) : String(cell)),
            ),
          ),
        ),
      ),
    );
  };
})(stiffcal);
