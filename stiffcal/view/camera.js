(function (S) {
  const UPRIGHT = Math.PI / 2;
  /** Where one looks from: angles about and above the vertical, rad. Base axes: x forward, z up. */
  S.CAMERAS = [
    ["front", { turn: 0, tilt: 0 }],
    ["side", { turn: -UPRIGHT, tilt: 0 }],
    ["top", { turn: -UPRIGHT, tilt: UPRIGHT }],
    ["oblique", { turn: 0.9, tilt: 0.35 }],
  ];
  /** @param {number} tilt rad @returns {number} no further than straight from above or below */
  S.tilted = (tilt) => Math.max(-UPRIGHT, Math.min(UPRIGHT, tilt));

  /**
   * How points of space come onto the picture: parallel, as large as the box has room for.
   * @param {{turn: number, tilt: number, zoom: number}} state @param {number[][]} points what the picture has to show, m
   * @param {{x: number, y: number, w: number, h: number}} box @param {number} least m that the box shows at least, across and up
   * @returns {{project: (p: number[]) => number[], depth: (p: number[]) => number, pixels: number}} depth: larger is nearer; pixels: of a metre
   */
  S.cameraOf = function ({ turn, tilt, zoom }, points, box, least) {
    const [ct, st, ce, se] = [Math.cos(turn), Math.sin(turn), Math.cos(tilt), Math.sin(tilt)];
    const flat = ([x, y, z]) => [-st * x + ct * y, se * (ct * x + st * y) - ce * z];
    const depth = ([x, y, z]) => ce * (ct * x + st * y) + se * z;
    const seen = points.map(flat),
      ends = [0, 1].map((k) => [Math.min(...seen.map((p) => p[k])), Math.max(...seen.map((p) => p[k]))]);
    const [wide, high] = ends.map(([low, top]) => Math.max(top - low, least)),
      [cu, cv] = ends.map(([low, top]) => (low + top) / 2);
    const pixels = Math.max(Math.min(box.w / wide, box.h / high), 1e-9) * zoom;
    const project = (p) => {
      const [u, v] = flat(p);
      return [box.x + box.w / 2 + pixels * (u - cu), box.y + box.h / 2 + pixels * (v - cv)];
    };
    return { project, depth, pixels };
  };
})(stiffcal);
