(function (S) {
  /** The lowest and the highest values of points. @param {ArrayLike<number>} values x, y, z of one point after the other */
  function endsOf(values) {
    const low = [Infinity, Infinity, Infinity],
      high = [-Infinity, -Infinity, -Infinity];
    for (let k = 0; k < values.length; k++) {
      low[k % 3] = Math.min(low[k % 3], values[k]);
      high[k % 3] = Math.max(high[k % 3], values[k]);
    }
    return [low, high];
  }
  /** Half the size of a box about points. */
  function halfSize(values) {
    const [low, high] = endsOf(values);
    return Math.hypot(...low.map((v, a) => high[a] - v)) / 2 || 1;
  }
  /** The eight corners of a box about points. */
  S.boxOf = function (values) {
    const ends = endsOf(values);
    return [0, 1, 2, 3, 4, 5, 6, 7].map((k) => [0, 1, 2].map((a) => ends[(k >> a) & 1][a]));
  };

  /** Largest sizes of what is drawn, for the scales. */
  S.robotSizes = function () {
    const { states } = S.data,
      at = (values, i) => Math.hypot(values[3 * i], values[3 * i + 1], values[3 * i + 2]);
    let m = 0,
      f = 0;
    for (let i = 0; i < S.n; i++) {
      m = Math.max(m, at(states.measured[0], i) || 0);
      f = Math.max(f, at(states.force, i) || 0);
    }
    return { m, f, chain: Math.max(...S.data.runs.map((run) => halfSize(run.chain)), 1e-9) };
  };

  /** Share of the deflection of each drive, of its bearing and of the link after it; of the base link at 0. */
  S.sharesOfParts = function (data) {
    const none = () => new Float64Array(data.joints.length + 1),
      parts = { joint: none(), bearing: none(), link: none() };
    for (const effect of data.effects)
      if (parts[effect.part_of] && effect.joint !== null) parts[effect.part_of][effect.joint] += Math.max(effect.share, 0);
    return parts;
  };

  /** The largest shares, what is missing, and why no meshes are drawn, in words. */
  S.standingOfRobot = function (data) {
    const nowhere = data.suspects.some((name) => name.endsWith(" setup"));
    const largest = data.effects
      .filter((effect) => effect.share >= 0.01)
      .sort((a, b) => b.share - a.share)
      .slice(0, 5)
      .map((effect) => `${effect.name} ${S.percent(effect.share)}`);
    return (
      (largest.length ? ` Largest shares of the deflection: ${largest.join(", ")}.` : "") +
      (data.suspects.length ? ` Missing: ${data.suspects.join(", ")}${nowhere ? " (the set-up has no place on the robot)" : ""}.` : "") +
      (data.meshes_fault ? ` Drawn without the meshes of the URDF: ${data.meshes_fault}` : "")
    );
  };

  /**
   * Names of joints with their shares next to them, those of one place together, none over another, nor over another joint, an arrow or a diamond.
   * @param {CanvasRenderingContext2D} g @param {number[][]} points of the joints @param {any} shares @param {number} width
   * @param {number[][]} marks points of arrows and diamonds
   */
  S.writeJointNames = function (g, points, shares, width, marks) {
    const HIGH = 15,
      ASIDE = 20,
      DRIVE = 16,
      labels = [],
      placed = [];
    points.forEach(([x, y], k) => {
      const share = shares.joint[k + 1] >= 0.01 ? ` ${S.percent(shares.joint[k + 1])}` : "",
        text = S.visible(S.data.joints[k] ?? `j${k + 1}`) + share;
      const near = labels.find((label) => Math.hypot(label.x - x, label.y - y) < 12);
      if (near) near.text += `, ${text}`;
      else labels.push({ x, y, text });
    });
    g.textBaseline = "middle";
    g.textAlign = "left";
    g.lineJoin = "round";
    g.lineWidth = 3;
    g.strokeStyle = S.theme.ground;
    for (const { x, y, text } of labels) {
      const wide = g.measureText(text).width,
        sides = [x + ASIDE, x - ASIDE - wide].filter((left) => left >= 4 && left + wide <= width),
        lefts = sides.length ? sides : [Math.max(4, width - 4 - wide)];
      const places = [0, -1, 1, -2, 2, -3, 3].flatMap((k) => lefts.map((left) => ({ left, up: y + HIGH * k, wide })));
      const isApart = ({ left, up }) =>
        !placed.some((other) => Math.abs(other.up - up) < HIGH && left < other.left + other.wide + 4 && other.left < left + wide + 4);
      const isBare = ({ left, up }) =>
        !points.some(([px, py]) => px > left - DRIVE && px < left + wide + DRIVE && Math.abs(py - up) < HIGH / 2 + DRIVE && Math.hypot(px - x, py - y) >= 12) &&
        !marks.some(([px, py]) => px > left - 4 && px < left + wide + 4 && Math.abs(py - up) < HIGH / 2 + 4);
      const apart = places.filter(isApart),
        { left, up } = apart.find(isBare) ?? apart[0] ?? places[0];
      placed.push({ left, up, wide });
      g.strokeText(text, left, up);
      g.fillStyle = S.theme.ink;
      g.fillText(text, left, up);
    }
  };
})(stiffcal);
