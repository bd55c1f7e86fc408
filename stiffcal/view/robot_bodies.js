(function (S) {
  /** Half the thickness of links and drives, as a share of half the size of the chain. */
  const LINK = 0.055,
    DRIVE = 0.095,
    THINNEST = 0.55;
  /** Of drives within meshes: as large as the meshes let through, and lighter than they. */
  const WITHIN = 0.6,
    THROUGH = 0.8,
    PALE = 0.5;
  const plus = (a, b, by) => a.map((value, k) => value + by * b[k]);

  /** What the bodies are, in words. */
  S.wordsOfBodies = (data) =>
    data.bodies.length
      ? "Links are the shapes of the robot's URDF, simplified; drives are drawn through them and have no measures."
      : "Bodies have no measures: only their axes are the robot's.";

  /**
   * What draws links, drives and rings of bearings.
   * @param {any} shares of the deflection, `S.sharesOfParts` @param {number} size half that of the largest chain, m
   */
  S.partsOfRobot = function (shares, size) {
    const { data } = S,
      J = data.joints.length,
      meshes = new Map(data.bodies.map((body) => [body.body, body]));
    const thin = (k) => size * (1 - (1 - THINNEST) * (k / (J + 1)));
    // what has light and shade is brighter than what has none, so that its dark side keeps clear of a dark ground
    const plain = () => (meshes.size ? S.mixed(S.theme.quiet, S.theme.ground, PALE) : S.mixed(S.theme.line, S.theme.ground, 0.3));
    const shaded = (share, colour) => S.mixed(plain(), colour, Math.sqrt(Math.min(share || 0, 1)));
    const colourOf = (k) => shaded(shares.link[k], S.theme.series[0]);

    /** The links that have no mesh. */
    function links(chain) {
      const found = [];
      for (let k = 0; k + 1 < chain.length; k++)
        if (!meshes.has(k) && Math.hypot(...plus(chain[k + 1], chain[k], -1)) > 1e-6)
          found.push(S.roundBody(chain[k], chain[k + 1], [LINK * thin(k), LINK * thin(k + 1)], colourOf(k)));
      return found;
    }
    function drives(chain, axes) {
      const found = [];
      for (let k = 1; k < chain.length - 1; k++) {
        const radius = DRIVE * thin(k) * (meshes.has(k) ? WITHIN : 1),
          half = 0.8 * radius,
          around = (by) => [plus(chain[k], axes[k - 1], -by), plus(chain[k], axes[k - 1], by)];
        found.push(S.roundBody(...around(half), [radius, radius], shaded(shares.joint[k], S.theme.series[0])));
        if (shares.bearing[k] > 0)
          found.push(S.roundBody(...around(0.25 * half), [1.25 * radius, 1.25 * radius], shaded(shares.bearing[k], S.theme.series[3])));
      }
      return found;
    }

    /**
     * What is drawn of a pose: `reach`, points that the picture has to show in addition to the chain, and `draw`.
     * @param {{moved: number[][], axes: number[][], run: any, state: number|null, scale: number}} pose moved: the chain
     */
    return function ({ moved, axes, run, state, scale }) {
      const bare = links(moved),
        joints = drives(moved, axes),
        round = [...bare, ...joints];
      if (!meshes.size) return { reach: round.flatMap(S.endsOfBody), draw: (g, camera) => S.drawBodies(g, round, camera) };
      const surfaces = data.bodies.map((body) => ({
        points: S.placedPoints(body, run, state, scale),
        triangles: body.triangles,
        colour: colourOf(body.body),
      }));
      const draw = (g, camera, width, height) => {
        S.drawSurfaces(g, [...surfaces, ...bare.map(S.surfaceOfBody)], camera, width, height, S.theme.quiet);
        g.globalAlpha = THROUGH;
        S.drawBodies(g, joints, camera);
        g.globalAlpha = 1;
      };
      return { reach: [...surfaces.flatMap(({ points }) => S.boxOf(points)), ...round.flatMap(S.endsOfBody)], draw };
    };
  };
})(stiffcal);
