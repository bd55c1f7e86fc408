(function (S) {
  const isUp = (branch, i, torque) => (branch.values[i] === 0) === torque > 0;

  /** The points of a clamped sweep that are nearest in torque to the states of its run. */
  function statesOfSweep(s, members, torque) {
    const found = [...s.x].map(() => []),
      order = [...s.y.keys()].sort((a, b) => s.y[a] - s.y[b]),
      branch = S.variableByName.get("branch");
    const reach = 2 * S.median(order.slice(1).map((k, n) => s.y[k] - s.y[order[n]]));
    for (const i of members) {
      const t = torque.values[i],
        way = branch && branch.values[i] < 2 ? (isUp(branch, i, t) ? "up" : "down") : "both";
      if (s.sweep !== "both" && way !== "both" && way !== s.sweep) continue;
      let low = 0,
        high = order.length - 1;
      while (high - low > 1) {
        const middle = (low + high) >> 1;
        if (s.y[order[middle]] < t) low = middle;
        else high = middle;
      }
      const near = Math.abs(s.y[order[low]] - t) < Math.abs(s.y[order[high]] - t) ? order[low] : order[high];
      if (Math.abs(s.y[near] - t) <= reach) found[near].push(i);
    }
    return found;
  }

  /** States that the points of a series are of: a row of the fit each, their whole run, or those of a clamped sweep that are nearest in torque. */
  S.statesOfPoints = function (s) {
    if (s.of_) return s.of_;
    const { data } = S,
      fitted = data.fitted_rows;
    const members = S.members[data.runs.findIndex((entry) => entry.name === s.run)] || [],
      torque = S.variableByName.get("moved_torque") || S.variableByName.get("torque1");
    if (s.rows && fitted) s.of_ = [...s.rows].map((row) => (fitted[row] >= 0 ? [fitted[row]] : []));
    else if (s.sweep && torque) s.of_ = statesOfSweep(s, members, torque);
    else s.of_ = [...s.x].map(() => members);
    return s.of_;
  };
})(stiffcal);
