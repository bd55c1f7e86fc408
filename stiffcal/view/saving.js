(function (S) {
  function save(name, blob) {
    const link = S.make("a", { href: URL.createObjectURL(blob), download: name });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }

  /** Save a canvas. @param {string} name @param {HTMLCanvasElement} canvas */
  S.savePicture = (name, canvas) => canvas.toBlob((blob) => save(`${name}.png`, blob));
  /** True while a picture is drawn for a file: what stands around it on the page is then drawn into it. */
  S.drawsFile = false;
  const TWICE = 2,
    TITLE = "600 14px system-ui, sans-serif",
    BELOW = "12px system-ui, sans-serif",
    LINE = 16;

  /** A text in as many lines as the width needs. @param {CanvasRenderingContext2D} g @param {string} text @param {number} width */
  function wrapped(g, text, width) {
    const lines = [];
    for (const word of text.split(" ")) {
      const longer = lines.length ? `${lines[lines.length - 1]} ${word}` : word;
      if (lines.length && g.measureText(longer).width <= width) lines[lines.length - 1] = longer;
      else lines.push(word);
    }
    return lines.map((line) => S.shortened(g, line, width));
  }
  /** What stands above a picture: what it shows, of which model and campaign, and when it was saved. @param {string} title @param {number} width */
  function headOf(title, width) {
    const g = S.make("canvas").getContext("2d"),
      { robot, campaign } = S.data,
      below = `${robot}, campaign ${campaign}; ${S.modelById.get(S.state.model)?.label ?? ""}; ${new Date().toISOString().slice(0, 10)}`;
    const linesOf = (font, text) => {
      g.font = font;
      return wrapped(g, S.visible(text), width - 16).map((line) => ({ font, line }));
    };
    const lines = [...linesOf(TITLE, title.replace(/^\d+[a-z]? /, "")), ...linesOf(BELOW, below)];
    return { lines, height: 12 + LINE * lines.length };
  }

  /** Save a panel's picture, twice as fine as on the screen, with a title. @param {string} id @param {string} title */
  S.savePng = function (id, title, draw, width, height) {
    const canvas = S.make("canvas"),
      head = headOf(title, width),
      file = S.make("canvas", { width: TWICE * width, height: TWICE * (height + head.height) }),
      g = file.getContext("2d");
    Object.defineProperties(canvas, { clientWidth: { value: width }, clientHeight: { value: height } });
    drawForFile(draw, canvas, TWICE);
    g.fillStyle = S.theme.ground;
    g.fillRect(0, 0, file.width, file.height);
    g.drawImage(canvas, 0, TWICE * head.height);
    g.scale(TWICE, TWICE);
    writeHead(g, head);
    S.savePicture(id, file);
  };
  function writeHead(g, { lines }) {
    g.textAlign = "left";
    g.textBaseline = "middle";
    lines.forEach(({ font, line }, k) => {
      g.fillStyle = font === TITLE ? S.theme.ink : S.theme.quiet;
      g.font = font;
      g.fillText(line, 8, 14 + LINE * k);
    });
  }
  /** Save a panel's picture as lines and texts. */
  S.saveSvg = function (id, title, draw, width, height) {
    const canvas = S.make("canvas"),
      head = headOf(title, width),
      recorder = S.svgContext(width, height + head.height);
    Object.defineProperties(canvas, { clientWidth: { value: width }, clientHeight: { value: height }, getContext: { value: () => recorder } });
    recorder.within(0, head.height, () => drawForFile(draw, canvas, 1));
    writeHead(recorder, head);
    save(`${id}.svg`, new Blob([recorder.text()], { type: "image/svg+xml" }));
  };
  function drawForFile(draw, canvas, ratio) {
    S.drawsFile = true;
    S.fileRatio = ratio;
    try {
      draw(canvas);
    } finally {
      S.drawsFile = false;
    }
  }

  /** Save texts, one line each, as a picture. @param {string} name @param {string[][]} rows columns of each line */
  S.saveText = function (name, rows) {
    const canvas = S.make("canvas"),
      g = canvas.getContext("2d"),
      font = "13px ui-monospace, monospace",
      high = 19,
      most = 1600;
    g.font = font;
    const columns = Math.max(...rows.map((row) => row.length));
    const wide = Array.from(
      { length: columns },
      (_, k) => Math.max(0, ...rows.filter((row) => row.length > 1).map((row) => g.measureText(S.visible(row[k] ?? "")).width)) + 18,
    );
    const whole = Math.max(
      wide.reduce((sum, value) => sum + value, 0),
      ...rows.filter((row) => row.length === 1).map((row) => g.measureText(S.visible(row[0])).width),
    );
    canvas.width = 2 * Math.min(whole + 24, most);
    canvas.height = 2 * (rows.length * high + 16);
    g.scale(2, 2);
    g.fillStyle = S.theme.ground;
    g.fillRect(0, 0, canvas.width, canvas.height);
    g.fillStyle = S.theme.ink;
    g.font = font;
    g.textBaseline = "middle";
    rows.forEach((row, k) => {
      let x = 12;
      row.forEach((text, column) => {
        g.fillText(S.shortened(g, S.visible(text), most - x), x, 8 + high * (k + 0.5));
        x += wide[column];
      });
    });
    S.savePicture(name, canvas);
  };

  /** Save a text as a CSV file. @param {string} name @param {string} text */
  S.save = (name, text) => save(name, new Blob([`\ufeff${text}\r\n`], { type: "text/csv" }));
})(stiffcal);
