(function (S) {
  const SIDES = 20;
  const add = (a, b, by = 1) => a.map((value, k) => value + by * b[k]);
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  function unit(a) {
    const size = Math.hypot(...a);
    return size > 0 ? a.map((value) => value / size) : [0, 0, 1];
  }

  /** Points of a circle about an axis. */
  function circle(centre, axis, radius) {
    const u = unit(cross(axis, Math.abs(axis[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0])),
      v = cross(axis, u);
    return Array.from({ length: SIDES }, (_, k) => {
      const angle = (2 * Math.PI * k) / SIDES;
      return add(add(centre, u, radius * Math.cos(angle)), v, radius * Math.sin(angle));
    });
  }

  /** The outline of points of the picture, in order (Andrew's monotone chain). @param {number[][]} points */
  function outline(points) {
    const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
    const turns = (o, a, b) => (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
    const half = (list) => {
      const found = [];
      for (const p of list) {
        while (found.length > 1 && turns(found[found.length - 2], found[found.length - 1], p) <= 0) found.pop();
        found.push(p);
      }
      return found.slice(0, -1);
    };
    return [...half(sorted), ...half(sorted.reverse())];
  }

  /** A round body between two circles. @param {number[]} from @param {number[]} to @param {number[]} radii m @param {string} colour */
  S.roundBody = (from, to, radii, colour) => ({ from, to, radii, colour });

  /** Red, green, blue of "#rrggbb", 0 to 255. @param {string} colour */
  S.parsedColour = (colour) => [1, 3, 5].map((k) => parseInt(colour.slice(k, k + 2), 16));
  /** A colour between two, "#rrggbb". @param {string} a @param {string} b @param {number} share of the second */
  S.mixed = function (a, b, share) {
    const [from, to] = [a, b].map(S.parsedColour);
    return `#${from
      .map((value, k) =>
        Math.round(value + share * (to[k] - value))
          .toString(16)
          .padStart(2, "0"),
      )
      .join("")}`;
  };

  /** Points on a round body's ends: what it reaches. */
  S.endsOfBody = function ({ from, to, radii }) {
    const axis = unit(add(to, from, -1));
    return [...circle(from, axis, radii[0]), ...circle(to, axis, radii[1])];
  };

  /** A round body as a surface, for `S.drawSurfaces`. */
  S.surfaceOfBody = function (body) {
    const points = [...S.endsOfBody(body), body.from, body.to],
      triangles = [];
    for (let k = 0; k < SIDES; k++) {
      const next = (k + 1) % SIDES;
      triangles.push(k, next, SIDES + k, next, SIDES + next, SIDES + k, 2 * SIDES, next, k, 2 * SIDES + 1, SIDES + k, SIDES + next);
    }
    return { points: Float64Array.from(points.flat()), triangles, colour: body.colour };
  };

  /** Draw round bodies, the farther ones first. @param {CanvasRenderingContext2D} g @param {any[]} bodies @param {any} camera of `S.cameraOf` */
  S.drawBodies = function (g, bodies, camera) {
    const shape = (points) => {
      g.beginPath();
      points.forEach(([x, y], k) => (k ? g.lineTo(x, y) : g.moveTo(x, y)));
      g.closePath();
    };
    const far = ({ from, to }) => camera.depth(add(from, to)) / 2;
    const edge = S.mixed(S.theme.quiet, S.theme.ground, 0.35);
    for (const { from, to, radii, colour } of [...bodies].sort((a, b) => far(a) - far(b))) {
      const axis = unit(add(to, from, -1)),
        ends = [circle(from, axis, radii[0]), circle(to, axis, radii[1])].map((points) => points.map(camera.project));
      g.lineWidth = 1;
      g.strokeStyle = edge;
      shape(outline(ends.flat()));
      g.fillStyle = colour;
      g.fill();
      g.stroke();
      const near = camera.depth(to) > camera.depth(from) ? 1 : 0;
      shape(outline(ends[near]));
      g.fillStyle = S.mixed(colour, S.theme.ground, 0.35);
      g.fill();
      g.stroke();
    }
  };
})(stiffcal);
