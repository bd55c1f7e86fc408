(function (S) {
  /** Samples of a pixel along each axis: edges are smooth without more of them. */
  const FINE = 2;
  /** From where the light comes, in the picture: left, above, in front. */
  const LIGHT = [-0.42, -0.57, 0.71];
  /** Brightness of a face that looks away from the light, and how much a face towards it has more. */
  const SHADE = 0.55,
    LIT = 0.55;
  /** A step in depth that is drawn as an edge, in pixels. */
  const STEP = 14;
  let canvas = null,
    depth = new Float32Array(0),
    owner = new Uint16Array(0);

  const packed = (rgb, by) => (255 << 24) | (Math.min(255, rgb[2] * by) << 16) | (Math.min(255, rgb[1] * by) << 8) | Math.min(255, rgb[0] * by);

  /**
   * Draw surfaces of triangles, what is nearer before what is farther, with their outlines.
   * @param {CanvasRenderingContext2D} g @param {{points: Float64Array, triangles: ArrayLike<number>, colour: string}[]} surfaces points in m
   * @param {any} camera of `S.cameraOf` @param {number} width of the picture @param {number} height @param {string} edge colour of outlines
   */
  S.drawSurfaces = function (g, surfaces, camera, width, height, edge) {
    const fine = Math.max(FINE, S.drawsFile ? S.fileRatio : window.devicePixelRatio || 1),
      views = surfaces.map(({ points }) => seen(points, camera, fine)),
      part = partOf(views, width * fine, height * fine),
      { w, h } = part;
    if (!(w > 0 && h > 0)) return;
    if (depth.length < w * h) [depth, owner] = [new Float32Array(w * h), new Uint16Array(w * h)];
    depth.fill(-Infinity, 0, w * h);
    owner.fill(0, 0, w * h);
    canvas ??= S.make("canvas");
    if (canvas.width !== w) canvas.width = w;
    if (canvas.height !== h) canvas.height = h;
    const paper = canvas.getContext("2d", { willReadFrequently: true }),
      image = paper.createImageData(w, h),
      colours = new Uint32Array(image.data.buffer);
    surfaces.forEach((surface, k) => fill(surface, k + 1, views[k], { w, h, colours }));
    outline(colours, w, h, STEP * fine, packed(S.parsedColour(edge), 1));
    paper.putImageData(image, 0, 0);
    g.drawImage(canvas, part.x / fine, part.y / fine, w / fine, h / fine);
  };

  /** The part of the picture that points reach, with a margin; points are moved to its corner. @param {Float32Array[]} views */
  function partOf(views, width, height) {
    const ends = [0, 1].map((axis) => {
      let low = Infinity,
        high = -Infinity;
      for (const at of views)
        for (let i = axis; i < at.length; i += 3) {
          low = Math.min(low, at[i]);
          high = Math.max(high, at[i]);
        }
      return [Math.max(Math.floor(low) - 2, 0), Math.min(Math.ceil(high) + 2, Math.ceil(axis ? height : width))];
    });
    const [[x, right], [y, bottom]] = ends;
    for (const at of views)
      for (let i = 0; i < at.length; i += 3) {
        at[i] -= x;
        at[i + 1] -= y;
      }
    return { x, y, w: right - x, h: bottom - y };
  }

  /** Points in the picture: across, down, towards the eye, in samples. */
  function seen(points, camera, fine) {
    const found = new Float32Array(points.length);
    for (let i = 0; i < points.length; i += 3) {
      const p = [points[i], points[i + 1], points[i + 2]],
        [x, y] = camera.project(p);
      found[i] = x * fine;
      found[i + 1] = y * fine;
      found[i + 2] = camera.depth(p) * camera.pixels * fine;
    }
    return found;
  }

  function fill({ triangles, colour }, number, at, { w, h, colours }) {
    const rgb = S.parsedColour(colour);
    for (let t = 0; t < triangles.length; t += 3) {
      const [a, b, c] = [3 * triangles[t], 3 * triangles[t + 1], 3 * triangles[t + 2]];
      const [ux, uy, uz] = [at[b] - at[a], at[b + 1] - at[a + 1], at[b + 2] - at[a + 2]],
        [vx, vy, vz] = [at[c] - at[a], at[c + 1] - at[a + 1], at[c + 2] - at[a + 2]];
      let [nx, ny, nz] = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
      if (Math.abs(nz) < 1e-6) continue;
      const size = Math.sign(nz) * Math.hypot(nx, ny, nz);
      [nx, ny, nz] = [nx / size, ny / size, nz / size];
      const paint = packed(rgb, SHADE + LIT * Math.max(nx * LIGHT[0] + ny * LIGHT[1] + nz * LIGHT[2], 0)),
        corners = [a, b, c];
      const first = Math.max(Math.ceil(Math.min(at[a + 1], at[b + 1], at[c + 1]) - 0.5), 0),
        last = Math.min(Math.floor(Math.max(at[a + 1], at[b + 1], at[c + 1]) - 0.5), h - 1);
      for (let row = first; row <= last; row++) {
        const y = row + 0.5;
        let left = Infinity,
          right = -Infinity;
        for (let k = 0; k < 3; k++) {
          const p = corners[k],
            q = corners[(k + 1) % 3];
          if (at[p + 1] <= y === at[q + 1] <= y) continue;
          const x = at[p] + ((y - at[p + 1]) * (at[q] - at[p])) / (at[q + 1] - at[p + 1]);
          left = Math.min(left, x);
          right = Math.max(right, x);
        }
        const end = Math.min(Math.ceil(right - 0.5), w);
        for (let column = Math.max(Math.ceil(left - 0.5), 0); column < end; column++) {
          const near = at[a + 2] - (nx * (column + 0.5 - at[a]) + ny * (y - at[a + 1])) / nz,
            i = row * w + column;
          if (near <= depth[i]) continue;
          depth[i] = near;
          owner[i] = number;
          colours[i] = paint;
        }
      }
    }
  }

  /** Lines where a body ends before another or the ground, or where its own depth steps. */
  function outline(colours, w, h, step, edge) {
    for (let row = 1; row < h - 1; row++)
      for (let i = row * w + 1; i < (row + 1) * w - 1; i++) {
        if (!owner[i]) continue;
        for (const j of [i - 1, i + 1, i - w, i + w])
          if ((owner[j] !== owner[i] && depth[j] < depth[i]) || depth[i] - depth[j] > step) {
            colours[i] = edge;
            break;
          }
      }
  }
})(stiffcal);
