(function (S) {
  /** Ends of axes and of colours, by what they show. */
  const ends = new Map();
  /** Which part of a picture is shown, by what it shows; none: all of it. */
  const windows = new Map();
  /** Counts changes of scales. */
  S.scaling = 0;

  /**
   * Scales stay, so that a fall looks as large as it is: each grows to the worst model that was shown.
   * @param {string} name of the scale @param {number[]} now the ends that what is shown needs @returns {number[]}
   */
  S.locked = function (name, now) {
    const key = `${S.part}/${name}`,
      before = ends.get(key);
    const grown = before ? [Math.min(before[0], now[0]), Math.max(before[1], now[1])] : now;
    ends.set(key, grown);
    return [...grown];
  };

  let only = "";
  /** Whether scales were fitted to what is shown alone, not to the model that it is compared with too. */
  S.isRescaled = () => only === S.shownKey();
  /** Forget all scales but those of what is shown now. */
  S.rescale = function () {
    only = S.shownKey();
    ends.clear();
    windows.clear();
    S.ghost = null;
    S.scaling++;
    S.redraw();
  };

  /** @param {string} name of a picture @returns {{x: number[], y: number[]}|undefined} */
  S.windowOf = (name) => windows.get(`${S.part}/${name}`);
  /** Show a part of a picture; null: all of it. @param {string} name @param {{x: number[], y: number[]}|null} part */
  S.setWindow = function (name, part) {
    if (part) windows.set(`${S.part}/${name}`, part);
    else windows.delete(`${S.part}/${name}`);
    S.scaling++;
    S.redraw();
  };
})(stiffcal);
