(function (S) {
  /** What the band is called: next to the categories, as no place among the points is sure to be free. */
  S.BAND = "noise ± 2σ";
  /**
   * Words above a picture: categories with their markers, or the ends of a scale, and the band; returns where the picture can begin.
   * @param {boolean} band whether there is one to be named
   */
  S.legend = function (g, box, words, palette, scale, band) {
    const swatch = {
      word: S.BAND,
      mark: (x, y) => {
        g.fillStyle = S.theme.band;
        g.fillRect(x, y - 6, 12, 12);
      },
    };
    g.textAlign = "left";
    g.textBaseline = "middle";
    let right = box.x;
    if (scale) {
      g.fillStyle = S.theme.ink;
      g.fillText(S.visible(words[0]), right, 12);
      right += g.measureText(S.visible(words[0])).width + 6;
      palette.forEach((c) => {
        g.fillStyle = c;
        g.fillRect(right, 6, 10, 12);
        right += 10;
      });
      g.fillStyle = S.theme.ink;
      g.fillText(S.visible(words[1]), right + 6, 12);
      right += 18 + g.measureText(S.visible(words[1])).width;
      if (band) S.keys(g, { x: right, w: box.x + box.w - right }, [swatch]);
      return 26;
    }
    return (
      10 +
      16 *
        S.keys(g, box, [
          ...words
            .map((word, k) => ({
              word,
              mark: (x, y) => {
                g.beginPath();
                S.marker(g, k, x + 6, y, 4);
                g.fillStyle = palette[k];
                g.fill();
              },
            }))
            .filter(({ word }) => word !== null),
          ...(band ? [swatch] : []),
        ])
    );
  };

  /**
   * Words with their marks, in as many lines as the width needs; returns their number.
   * @param {{x: number, w: number}} box @param {{word: string, mark: (x: number, y: number) => void}[]} entries @param {boolean} [dry] only count
   */
  S.keys = function (g, box, entries, dry) {
    let x = box.x,
      y = 12;
    g.textAlign = "left";
    g.textBaseline = "middle";
    for (const { word, mark } of entries) {
      const text = S.shortened(g, S.visible(word), box.w - 20),
        wide = 20 + g.measureText(text).width;
      if (x > box.x && x + wide > box.x + box.w) {
        x = box.x;
        y += 16;
      }
      if (!dry) {
        mark(x, y);
        g.fillStyle = S.theme.ink;
        g.fillText(text, x + 16, y);
      }
      x += wide + 12;
    }
    return 1 + (y - 12) / 16;
  };

  /** A text cut to a width, in pixels. @param {CanvasRenderingContext2D} g @param {string} text @param {number} width */
  S.shortened = function (g, text, width) {
    if (g.measureText(text).width <= width) return text;
    let end = text.length;
    while (end > 1 && g.measureText(`${text.slice(0, end)}…`).width > width) end--;
    return `${text.slice(0, end)}…`;
  };
  /**
   * The first of some texts for one thing that a width holds.
   * @param {CanvasRenderingContext2D} g @param {string[]} texts the longest first @param {number} width
   */
  S.fitting = (g, texts, width) => texts.find((text) => g.measureText(text).width <= width) ?? S.shortened(g, texts[texts.length - 1], width);
})(stiffcal);
