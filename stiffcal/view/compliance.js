(function (S) {
  S.compliancePanel = function () {
    const { data } = S;
    const angles = data.variables.filter((variable) => /^(angle\d*|speed)$/.test(variable.name));
    if (!data.effects.length || !angles.length) return;
    const effect = S.choice(
      "Effect",
      data.effects.map((entry, k) => [String(k), entry.name]),
      (value) => S.set({ joint: Number(value) }),
    );
    const over = S.choice(
      "Over",
      angles.map((variable, k) => [String(k), variable.label]),
      (value) => S.set({ over: Number(value) }),
    );
    const FEWEST = 6,
      FEWEST_OF_SCATTER = 4;
    const ROUNDS = 199,
      LEAST_SHARE = 0.2;
    let trends = { key: "", found: [] };
    /** Where each piece stands, and its pose: pieces with like angles have one. */
    function posesOf(parts) {
      const mean = (angle, members) => {
        const known = members.map((i) => angle.values[i]).filter(Number.isFinite);
        return known.reduce((sum, v) => sum + v, 0) / known.length;
      };
      const at = parts.map(({ members }) => angles.map((angle) => mean(angle, members))),
        poses = [];
      const near = angles.map((angle) => {
        const [low, high] = S.span(angle.values, 0);
        return angle.unit === "°" ? 1 : 0.01 * (high - low);
      });
      const pose = at.map((here) => {
        const known = poses.findIndex((other) => other.every((v, a) => Math.abs(v - here[a]) <= near[a]));
        return known >= 0 ? known : poses.push(here) - 1;
      });
      return { pose, poses };
    }
    /**
     * Effects over angles, by the share of the scatter between runs that a parabola over the angle explains, best first;
     * and the share that the best of them explains where the angles of the poses are exchanged at random.
     */
    function ranked() {
      const key = S.shownKey();
      if (trends.key === key) return trends;
      const whole = data.runs.length > 2 && posesOf(pieces(angles[0])),
        pairs = [];
      data.effects.forEach((_, k) =>
        angles.forEach((angle, a) => {
          const at = values(k, angle).filter((entry) => entry.half > 0),
            middle = S.median(at.map((entry) => entry.value));
          if (at.length < FEWEST) return;
          const spread = S.median(at.map((entry) => (entry.value - middle) ** 2));
          // scatter that the noise makes is none
          if (S.median(at.map((entry) => ((entry.value - middle) / entry.half) ** 2)) * 1.96 ** 2 < FEWEST_OF_SCATTER) return;
          const y = at.map((entry) => entry.value),
            weight = at.map((entry) => 1 / (entry.half ** 2 / 3.84 + spread)),
            x = at.map((entry) => entry.angle);
          // the pieces of one run along an angle are poses of their own
          pairs.push({
            joint: k,
            over: a,
            share: S.parabolaShare(x, y, weight),
            y,
            weight,
            x,
            pose: whole ? at.map((entry) => whole.pose[entry.piece]) : [...at.keys()],
            n: at.length,
          });
        }),
      );
      const exchanged = (order) => {
        let best = 0;
        for (const { over, x, y, weight, pose } of pairs)
          best = Math.max(
            best,
            S.parabolaShare(whole ? pose.map((p) => whole.poses[order[p]][over]) : order.filter((p) => p < x.length).map((p) => x[p]), y, weight),
          );
        return best;
      };
      const poses = whole ? whole.poses.length : Math.max(0, ...pairs.map((pair) => pair.n));
      const found = pairs.filter((pair) => pair.share > LEAST_SHARE).sort((one, other) => other.share - one.share);
      trends = { key, found, pairs: pairs.length, poses, chance: found.length ? S.shareByChance(exchanged, poses, ROUNDS) : NaN };
      return trends;
    }
    const chosenEffect = () => (S.state.joint >= 0 ? S.state.joint : (ranked().found[0]?.joint ?? 0));
    const chosenAngle = () => angles[Math.min(S.state.over >= 0 ? S.state.over : (ranked().found[0]?.over ?? 0), angles.length - 1)];
    const title = S.scalar && data.measure === "torque" ? "5b Apparent size of an effect" : "5b Apparent compliance by pose";
    const panel = S.panel({
      id: "compliance",
      title,
      height: 360,
      about:
        "How large an effect appears in each run against its fitted size, ± 95 % from the noise. A trend, or scatter far beyond the " +
        "bars, is an effect that the model lacks, also one outside the catalogue.",
      how:
        "1 plus the part of the residual along the effect, as a share of the effect. A click on a point, or left and right arrows and " +
        "Enter: select its run in all panels.",
      controls: [effect, over],
      draw,
      table,
      key: S.onKeys({ ArrowRight: () => step(1), ArrowLeft: () => step(-1) }, () => points.find(isHere)?.members),
      depends: () => `${S.shownKey()}/${S.state.joint}/${S.state.over}/${S.version}/${S.state.run}`,
    });
    const proposals = S.make("ol", { className: "proposals" });
    panel.section.insertBefore(S.make("h3", {}, "Where it follows an angle, by the share of the scatter between runs"), panel.details);
    panel.section.insertBefore(proposals, panel.details);
    const evidence = S.make("p", { className: "note", id: "chance" });
    panel.section.insertBefore(evidence, panel.details);
    let points = [],
      listed = "";
    function propose() {
      if (listed === S.shownKey()) return;
      listed = S.shownKey();
      const { found, pairs, poses, chance } = ranked(),
        piece = whole() ? "runs" : "pieces";
      const rows = found
        .slice(0, 5)
        .map(({ joint, over: at, share, n }) =>
          S.make(
            "li",
            {},
            S.button(
              { onclick: () => S.set({ joint, over: at }) },
              `${data.effects[joint].name} over ${angles[at].label}: ${S.percent(share)} of ${n} ${piece}, ` +
                `${share > chance ? "more than" : "no more than"} chance`,
            ),
          ),
        );
      proposals.replaceChildren(
        ...(rows.length
          ? rows
          : [
              S.make(
                "li",
                {},
                pairs
                  ? `It scatters by more than the noise, but no parabola over an angle explains more than ${S.percent(LEAST_SHARE)} of that.`
                  : data.runs.length > 2 && data.runs.length < FEWEST
                    ? `Fewer than ${FEWEST} runs: too few to judge by.`
                    : "No effect scatters between runs by more than the noise allows.",
              ),
            ]),
      );
      evidence.textContent = rows.length
        ? `Measured in ${poses} ${whole() ? "poses" : "pieces"}. Where their angles are exchanged at random, ` +
          `${pairs === 1 ? "this curve" : `the best of these ${pairs} curves`} explains up to ${S.percent(chance)} in 95 of 100 cases: a share below that ` +
          `is no evidence, and one above it is to be measured again in other poses.`
        : "";
    }
    const whole = () => data.runs.length > 2;
    panel.canvas.addEventListener("click", (event) => {
      const near = points.find((point) => Math.hypot(point.px - event.offsetX, point.py - event.offsetY) < 12);
      if (near) S.select(near.members, event.shiftKey);
    });
    const isHere = (point) => point.members.includes(S.state.at);
    function step(by) {
      const all = [...points].sort((a, b) => a.angle - b.angle),
        at = all.findIndex(isHere);
      if (all.length) S.goTo(all[(at + by + all.length + (by < 0 && at < 0)) % all.length].members[0]);
    }
    /** States that are judged together: a run, or where one run holds all, as many pieces of like counts along the variable. */
    const PIECES = 12;
    function pieces(angle) {
      if (data.runs.length > 2) return S.members.map((members, k) => ({ name: data.runs[k].name, members }));
      const ordered = [...angle.values.keys()].filter((i) => Number.isFinite(angle.values[i])).sort((a, b) => angle.values[a] - angle.values[b]);
      const found = [],
        levels = new Set(ordered.map((i) => angle.values[i]));
      if (levels.size <= 2 * PIECES)
        for (const level of levels) found.push({ name: S.digits(level), members: ordered.filter((i) => angle.values[i] === level) });
      else
        for (let k = 0; k < PIECES; k++)
          found.push({
            name: String(k + 1),
            members: ordered.slice(Math.floor((k * ordered.length) / PIECES), Math.floor(((k + 1) * ordered.length) / PIECES)),
          });
      return found;
    }
    function values(k = chosenEffect(), angle = chosenAngle()) {
      const chosen = data.effects[k],
        shown = S.residual().move,
        part = chosen.part[0],
        sigma = S.sigma();
      return pieces(angle)
        .map(({ name, members: all }, piece) => {
          let rp = 0,
            pp = 0,
            sum = 0,
            count = 0;
          const mean = [0, 0, 0, 0, 0, 0],
            members = all.filter((i) => data.states.used[i] && Number.isFinite(shown[3 * i]));
          const centred = members.length > 1 && data.measure !== "torque";
          for (const i of members)
            for (let a = 0; a < 3; a++) {
              mean[a] += part[3 * i + a] / members.length;
              mean[a + 3] += shown[3 * i + a] / members.length;
            }
          for (const i of members) {
            for (let a = 0; a < 3; a++) {
              const p = part[3 * i + a] - (centred ? mean[a] : 0),
                r = shown[3 * i + a] - (centred ? mean[a + 3] : 0);
              rp += r * p;
              pp += p * p;
            }
            sum += angle.values[i];
            count++;
          }
          return {
            members: all,
            name,
            piece,
            angle: sum / count,
            value: pp > 0 ? 1 + rp / pp : NaN,
            half: pp > 0 ? (1.96 * sigma) / Math.sqrt(pp) : NaN,
          };
        })
        .filter((entry) => Number.isFinite(entry.angle + entry.value) && !(entry.half > 1));
    }
    function draw(canvas) {
      effect.select.value = String(chosenEffect());
      over.select.value = String(angles.indexOf(chosenAngle()));
      propose();
      const { g, width, height } = S.begin(canvas),
        found = values(),
        angle = chosenAngle();
      const box = { x: 74, y: 16, w: width - 92, h: height - 62 };
      const { toX, toY } = S.axes(g, box, {
        x: S.span(found.map((entry) => entry.angle)),
        y: S.span([1, ...found.flatMap((entry) => [entry.value - (entry.half || 0), entry.value + (entry.half || 0)])]),
        xLabel: `${S.withUnit(angle)}, mean`,
        yLabel: "apparent over fitted size",
      });
      g.strokeStyle = S.theme.accent;
      g.setLineDash([5, 4]);
      g.beginPath();
      g.moveTo(box.x, toY(1));
      g.lineTo(box.x + box.w, toY(1));
      g.stroke();
      g.setLineDash([]);
      points = found.map((entry) => ({ ...entry, px: toX(entry.angle), py: toY(entry.value) }));
      for (const point of points) {
        const chosen = point.members.some((i) => S.selected[i]);
        g.strokeStyle = S.theme.series[0];
        g.beginPath();
        g.moveTo(point.px, toY(point.value - point.half));
        g.lineTo(point.px, toY(point.value + point.half));
        g.stroke();
        g.beginPath();
        S.marker(g, chosen ? 2 : 0, point.px, point.py, chosen ? 6 : 4);
        g.fillStyle = chosen ? S.theme.warm : S.theme.series[0];
        g.fill();
        if (isHere(point)) {
          g.beginPath();
          g.rect(point.px - 8, point.py - 8, 16, 16);
          g.strokeStyle = S.theme.ink;
          g.stroke();
        }
      }
      const left = pieces(angle).length - found.length;
      return (
        `${data.effects[chosenEffect()].name}, ${found.length} ` +
        `${data.runs.length > 2 ? "runs" : "pieces"}${left ? `; ${left} more, in which it is too small to be judged, are left out` : ""}.`
      );
    }
    function table() {
      const angle = chosenAngle();
      return {
        head: ["run or piece", S.withUnit(angle), "apparent over fitted", "± 95 %"],
        rows: values().map((entry) => [entry.name, entry.angle, entry.value, entry.half]),
      };
    }
  };
})(stiffcal);
