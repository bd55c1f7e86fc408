(function (S) {
  const text = (value) => String(value).replace(/[&<>"]/g, (c) => `&#${c.charCodeAt(0)};`);
  const short = (value) => Number(value.toFixed(2));

  /**
   * What takes the place of a canvas' context, as far as the panels use it, and writes SVG.
   * @param {number} width @param {number} height
   */
  S.svgContext = function (width, height) {
    const ruler = S.make("canvas").getContext("2d"),
      out = [];
    let path = "",
      dash = [],
      clips = 0,
      groups = 0;
    const saved = [];
    const g = {
      fillStyle: "#000",
      strokeStyle: "#000",
      lineWidth: 1,
      globalAlpha: 1,
      font: "12px system-ui, sans-serif",
      textAlign: "left",
      textBaseline: "alphabetic",
      /** Draw something with its origin elsewhere. @param {() => void} draw */
      within(x, y, draw) {
        out.push(`<g transform="translate(${short(x)} ${short(y)})">`);
        draw();
        while (groups) {
          out.push("</g>");
          groups--;
        }
        out.push("</g>");
      },
      setTransform() {},
      scale() {},
      beginPath() {
        path = "";
      },
      moveTo(x, y) {
        path += `M${short(x)} ${short(y)}`;
      },
      lineTo(x, y) {
        path += `${path ? "L" : "M"}${short(x)} ${short(y)}`;
      },
      closePath() {
        path += "Z";
      },
      rect(x, y, w, h) {
        path += `M${short(x)} ${short(y)}h${short(w)}v${short(h)}h${short(-w)}Z`;
      },
      arc(x, y, r) {
        path += `M${short(x - r)} ${short(y)}a${short(r)} ${short(r)} 0 1 0 ${short(2 * r)} 0a${short(r)} ${short(r)} 0 1 0 ${short(-2 * r)} 0`;
      },
      setLineDash(pattern) {
        dash = pattern;
      },
      fill() {
        if (path) add(`<path d="${path}" fill="${text(g.fillStyle)}"/>`);
      },
      stroke() {
        if (path) add(`<path d="${path}" fill="none" ${pen()}/>`);
      },
      fillRect(x, y, w, h) {
        add(`<path d="M${short(x)} ${short(y)}h${short(w)}v${short(h)}h${short(-w)}Z" fill="${text(g.fillStyle)}"/>`);
      },
      strokeRect(x, y, w, h) {
        add(`<path d="M${short(x)} ${short(y)}h${short(w)}v${short(h)}h${short(-w)}Z" fill="none" ${pen()}/>`);
      },
      /** A picture of pixels: what has no lines. @param {HTMLCanvasElement} canvas */
      drawImage(canvas, x, y, w, h) {
        add(`<image x="${short(x)}" y="${short(y)}" width="${short(w)}" height="${short(h)}" href="${canvas.toDataURL()}"/>`);
      },
      measureText(words) {
        ruler.font = g.font;
        return ruler.measureText(words);
      },
      fillText(words, x, y, most) {
        write(words, x, y, `fill="${text(g.fillStyle)}"`, most);
      },
      strokeText(words, x, y) {
        write(words, x, y, `fill="none" stroke-linejoin="round" ${pen()}`);
      },
      save() {
        saved.push([g.fillStyle, g.strokeStyle, g.lineWidth, g.globalAlpha, g.font, g.textAlign, g.textBaseline, dash, groups]);
      },
      restore() {
        const before = saved.pop();
        if (!before) return;
        let kept;
        [g.fillStyle, g.strokeStyle, g.lineWidth, g.globalAlpha, g.font, g.textAlign, g.textBaseline, dash, kept] = before;
        while (groups > kept) {
          out.push("</g>");
          groups--;
        }
      },
      translate(x, y) {
        open(`transform="translate(${short(x)} ${short(y)})"`);
      },
      rotate(angle) {
        open(`transform="rotate(${short((180 * angle) / Math.PI)})"`);
      },
      clip() {
        clips++;
        out.push(`<clipPath id="c${clips}"><path d="${path}"/></clipPath>`);
        open(`clip-path="url(#c${clips})"`);
      },
      /** The file. */
      text() {
        const size = `width="${width}" height="${height}" viewBox="0 0 ${width} ${height}"`,
          ground = `<rect width="100%" height="100%" fill="${text(S.theme.ground)}"/>`;
        return `<svg xmlns="http://www.w3.org/2000/svg" ${size}>${ground}${out.join("\n")}</svg>`;
      },
    };
    const pen = () =>
      `stroke="${text(g.strokeStyle)}" stroke-width="${short(g.lineWidth)}"${dash.length ? ` stroke-dasharray="${dash.map(short).join(" ")}"` : ""}`;
    function write(words, x, y, paint, most) {
      const anchor = { center: "middle", right: "end" }[g.textAlign] || "start";
      const base = { middle: "central", top: "hanging", bottom: "text-after-edge" }[g.textBaseline] || "alphabetic";
      const wide = most && g.measureText(words).width > most ? ` textLength="${short(most)}" lengthAdjust="spacingAndGlyphs"` : "";
      const place = `x="${short(x)}" y="${short(y)}" text-anchor="${anchor}" dominant-baseline="${base}"`;
      add(`<text ${place} style="font:${text(g.font)}" ${paint}${wide}>${text(words)}</text>`);
    }
    function open(attribute) {
      out.push(`<g ${attribute}>`);
      groups++;
    }
    function add(element) {
      out.push(g.globalAlpha < 1 ? `<g opacity="${g.globalAlpha}">${element}</g>` : element);
    }
    return g;
  };
})(stiffcal);
