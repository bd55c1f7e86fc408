(function (S) {
  /**
   * A line of chips; what it has no room for is behind a button.
   * @param {string} id @param {string} name for screen readers @param {string} lead @param {() => void} opened
   */
  S.chipRow = function (id, name, lead, opened) {
    const chips = S.make("div", { className: "chips", id, role: "group", "aria-label": name });
    const more = S.make("button", {
      type: "button",
      className: "more",
      "aria-expanded": "false",
      "aria-controls": id,
      onclick: () => {
        const open = element.classList.toggle("open");
        more.setAttribute("aria-expanded", String(open));
        opened();
        element.scrollIntoView({ block: "nearest" });
      },
    });
    const head = S.make("span", { className: "lead" }, lead),
      element = S.make("div", { className: "row" }, head, chips, more);
    return { element, head, chips, more, isOpen: () => element.classList.contains("open") };
  };
})(stiffcal);
