// Diagrams over one time axis, one below the other, on a canvas.
const curves = (() => {
  const NARROW = 480; // pixels
  const [LEFT, RIGHT, TOP, BETWEEN] = [58, 8, 24, 40]; // around diagrams, pixels
  const LEGEND = 33; // below a diagram, pixels
  const WIDTHS = { "--accent": 1.5, "--faint": 1.2, "--live-measured": 5 }; // of lines, pixels

  // Round numbers that divide a range into about `count` parts.
  function ticks(low, high, count) {
    const rough = (high - low) / count;
    const power = 10 ** Math.floor(Math.log10(rough));
    const unit = power * [1, 2, 5, 10].find((one) => one * power >= rough);
    const first = Math.ceil(low / unit);
    const length = Math.floor(high / unit) - first + 1;
    return Array.from({ length }, (_, i) => Number(((first + i) * unit).toPrecision(6)));
  }

  function rangeOf(lines) {
    let [low, high] = [0, 0];
    lines.forEach(({ values }) =>
      values.forEach((value) => {
        if (value < low) low = value;
        if (value > high) high = value;
      }),
    );
    const margin = 0.06 * (high - low) || 1e-9;
    return [low - margin, high + margin];
  }

  function scale([low, high], from, to) {
    const factor = (to - from) / (high - low);
    return (value) => from + (value - low) * factor;
  }

  function drawStates(pen, colours, { states, top, bottom }, time, x) {
    for (let from = 0, to = 0; from < states.length; from = to) {
      while (to < states.length && states[to] === states[from]) to += 1;
      const [left, right] = [x(time[from]), x(time[Math.min(to, time.length - 1)])];
      if (states[from] === 3) continue;
      pen.fillStyle = colours("--live-slack");
      pen.fillRect(left, top, right - left, bottom - top);
      const name = { 1: "I", 2: "II", 4: "0" }[states[from]];
      if (right - left < 2 * pen.measureText(name).width) continue;
      pen.fillStyle = colours("--text");
      pen.fillText(name, (left + right) / 2, bottom - 5);
    }
  }

  function drawAxes(pen, colours, row, x, y, width, horizontal) {
    pen.strokeStyle = colours("--line");
    pen.fillStyle = colours("--faint");
    pen.lineWidth = 1;
    pen.setLineDash([]);
    pen.beginPath();
    pen.textAlign = "right";
    ticks(...row.range, 5).forEach((value) => {
      pen.moveTo(LEFT, y(value));
      pen.lineTo(width - RIGHT, y(value));
      pen.fillText(String(value), LEFT - 6, y(value) + 4);
    });
    pen.textAlign = "center";
    ticks(...horizontal, Math.max(width / 90, 2)).forEach((value) => {
      pen.moveTo(x(value), row.bottom);
      pen.lineTo(x(value), row.bottom + 4);
      pen.fillText(String(value), x(value), row.bottom + 16);
    });
    pen.stroke();
    pen.textAlign = "left";
    pen.fillStyle = colours("--text");
    pen.fillText(row.title, LEFT, row.top - 7);
  }

  function drawLine(pen, colours, { values, colour, dash = [] }, time, x, y) {
    pen.strokeStyle = colours(colour);
    pen.lineWidth = WIDTHS[colour];
    pen.setLineDash(dash);
    pen.beginPath();
    time.forEach((t, i) => pen.lineTo(x(t), y(values[i])));
    pen.stroke();
  }

  function drawLegend(pen, colours, row, width) {
    pen.textAlign = "right";
    const named = row.lines.map(({ label = "simulated", ...line }) => ({ label, ...line }));
    let right = width - RIGHT;
    if (named.length < 2) return;
    named.forEach(({ label, colour, dash = [] }) => {
      pen.fillStyle = colours("--text");
      pen.fillText(label, right, row.bottom + LEGEND);
      right -= pen.measureText(label).width + 4;
      pen.strokeStyle = colours(colour);
      pen.lineWidth = WIDTHS[colour];
      pen.setLineDash(dash);
      pen.beginPath();
      pen.moveTo(right - 16, row.bottom + LEGEND - 4);
      pen.lineTo(right, row.bottom + LEGEND - 4);
      pen.stroke();
      right -= 26;
    });
  }

  // Rows with a title, lines (values, colour, dash, label) and slack states over a time that may
  // end before the axis does. The look has colours by name, and a font.
  function draw(canvas, { colours, font }, rows, { time, end }) {
    const width = canvas.clientWidth;
    const size = width < NARROW ? 100 : 150;
    const height = rows.length * (TOP + size + BETWEEN);
    const density = window.devicePixelRatio;
    canvas.style.height = `${height}px`;
    canvas.width = width * density;
    canvas.height = height * density;
    const pen = canvas.getContext("2d");
    pen.scale(density, density);
    pen.font = `12px ${font}`;
    const horizontal = [end[0], end[end.length - 1]];
    const across = [LEFT, width - RIGHT];
    const x = scale(horizontal, ...across);
    rows.forEach((row, i) => {
      row.top = TOP + i * (TOP + size + BETWEEN);
      row.bottom = row.top + size;
      row.range = rangeOf(row.lines);
      const y = scale(row.range, row.bottom, row.top);
      pen.textAlign = "center";
      if (row.states) drawStates(pen, colours, row, time, x);
      drawAxes(pen, colours, row, x, y, width, horizontal);
      row.lines.forEach((line) => drawLine(pen, colours, line, time, x, y));
      drawLegend(pen, colours, row, width);
    });
    pen.textAlign = "left"; // a legend may be to the right
    pen.fillStyle = colours("--faint");
    pen.fillText("time (s)", LEFT, height - 8);
    return { rows, horizontal, across };
  }

  return { draw, scale };
})();
