(function (S) {
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const at = (array, i) => [array[3 * i], array[3 * i + 1], array[3 * i + 2]];

  /**
   * The axes of a body's frame at rest, and where it is: that of a joint has z along the joint's axis.
   * @param {any} run @param {number} body 0 the base @returns {{x: number[], y: number[], z: number[], origin: number[]}}
   */
  function frameOf(run, body) {
    const origin = at(run.chain, body);
    if (!body) return { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1], origin };
    const x = at(run.across, body - 1),
      z = at(run.axes, body - 1);
    return { x, y: cross(z, x), z, origin };
  }

  /**
   * The points of a body in base axes, moved as the load moves it: with its frame, and bent so that its far end is where the next
   * joint is. The move is exaggerated as that of the chain is, in proportion.
   * @param {any} body of the data @param {any} run @param {number|null} state null: at rest @param {number} scale
   * @returns {Float64Array} x, y, z of one point after the other, m
   */
  S.placedPoints = function (body, run, state, scale) {
    const { states, joints } = S.data,
      K = joints.length + 2,
      k = body.body,
      { x, y, z, origin } = frameOf(run, k),
      link = at(run.chain, k + 1).map((value, a) => value - origin[a]),
      square = link[0] ** 2 + link[1] ** 2 + link[2] ** 2,
      points = new Float64Array(body.points.length);
    const moves = state !== null,
      shift = moves ? at(states.shape, state * K + k) : [0, 0, 0],
      turn = moves ? at(states.turns, state * (K - 1) + k) : [0, 0, 0],
      carried = cross(turn, link);
    // what the far end moves beyond the body's own turn
    const bend = moves && square > 1e-9 ? at(states.shape, state * K + k + 1).map((value, a) => value - shift[a] - carried[a]) : [0, 0, 0];
    for (let i = 0; i < points.length; i += 3) {
      const [a, b, c] = [body.points[i], body.points[i + 1], body.points[i + 2]];
      const p = [0, 1, 2].map((n) => a * x[n] + b * y[n] + c * z[n]);
      const along = square > 1e-9 ? Math.min(Math.max((p[0] * link[0] + p[1] * link[1] + p[2] * link[2]) / square, 0), 1) : 0,
        turned = cross(turn, p);
      for (let n = 0; n < 3; n++) points[i + n] = origin[n] + p[n] + scale * (shift[n] + turned[n] + along * along * bend[n]);
    }
    return points;
  };
})(stiffcal);
