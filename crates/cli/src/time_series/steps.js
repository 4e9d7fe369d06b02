/* Values that stay the same for many steps: setpoints, prices, and states such as a mode or the presence of people. */
const STATE_COLORS = { "occupied": "#2f9e6e", "cool-down": "#74b9e8", "setup": "#2563eb", "warm-up": "#f2a24b",
  "setback": "#d9480f", "freeze protection": "#9333ea", "unoccupied": "rgba(130,140,155,.22)", "present": "#d39b00" };
const STRIP = 5;
const stateColor = (states, state) => STATE_COLORS[states[state - 1]] || (state ? color(state - 1) : "transparent");

/* A series from its changes: the point from which on it has a value, and the value. */
function decodeSteps({ changes, ...about }) {
  const points = new Float32Array(data.axis.points);
  changes.forEach(([from, value], k) => points.fill(value, from, (changes[k + 1] || [points.length])[0]));
  return makeSeries({ ...about, step: true }, points);
}

/* Calls `each` with the left and the right end of every stretch of the view in which the series keep their values, and its
   first point. */
function stretches(box, series, each) {
  const scale = box.w / (view.to - view.from), x = k => box.x + (START + k * POINT_MS - view.from) * scale;
  const first = Math.max(0, Math.floor((view.from - START) / POINT_MS));
  const last = Math.min(data.axis.points, Math.ceil((view.to - START) / POINT_MS));
  for (let begin = first, k = first + 1; k <= last; k++) {
    if (k < last && series.every(s => s.mean[k] === s.mean[begin])) continue;
    each(x(begin), x(k), begin);
    begin = k;
  }
}

/* A line with steps. */
function drawSteps(g, series, box, y) {
  g.beginPath();
  stretches(box, [series], (from, to, k) => { g.lineTo(from, y(series.mean[k])); g.lineTo(to, y(series.mean[k])); });
  g.stroke();
}

/* A comfort band, and below it the presence of people. */
function drawComfort(g, { heating, cooling, presence }, box, y) {
  g.fillStyle = style("--band"); g.strokeStyle = style("--edge"); g.lineWidth = 1.2;
  if (cooling) stretches(box, [heating, cooling], (from, to, k) => {
    const top = y(cooling.mean[k]);
    g.fillRect(from, top, to - from, y(heating.mean[k]) - top);
  });
  for (const series of [heating, cooling]) if (series && series.on) drawSteps(g, series, box, y);
  if (presence && presence.on) drawStates(g, presence, box, box.y + box.h - STRIP, STRIP);
}

/* Gives a panel these series and a comfort band. */
function showComfort(panel, comfort, series) {
  panel.comfort = Object.fromEntries(Object.entries(comfort).map(([name, steps]) => [name, steps && decodeSteps(steps)]));
  panel.series = [...series, ...Object.values(panel.comfort).filter(Boolean)];
}

/* A row of states. */
function drawStates(g, series, box, top, height) {
  stretches(box, [series], (from, to, k) => {
    g.fillStyle = stateColor(series.states, Math.round(series.mean[k]));
    g.fillRect(from, top, to - from + .4, height);
  });
}

/* Rows of states, one for each series. */
function drawStrips(g, panel, box) {
  panel.series.forEach((series, row) => {
    if (!series.on) return;
    const top = box.y + row * ROW + 1;
    g.save(); g.beginPath(); g.rect(box.x, 0, box.w, box.y + box.h); g.clip();
    drawStates(g, series, box, top, ROW - 2);
    g.restore();
    if (box.w < NARROW) nameRow(g, series.name, box.x + 4, top + ROW / 2 - 1);
  });
}

/* The name of a row, on it. */
function nameRow(g, name, x, y) {
  g.textAlign = "left"; g.textBaseline = "middle"; g.lineWidth = 3;
  g.strokeStyle = style("--card"); g.fillStyle = style("--ink");
  g.strokeText(name, x, y);
  g.fillText(name, x, y);
}

/* Lists the states that a panel shows, with their colors. */
function addStates(panel) {
  const states = panel.series[0].states, list = make("div", panel.section, undefined, "states");
  panel.section.querySelector(".head").after(list);
  const used = new Set(panel.series.flatMap(series => [...new Set(series.mean)].map(Math.round)));
  states.forEach((state, k) => {
    if (!used.has(k + 1)) return;
    make("i", list).style.background = stateColor(states, k + 1);
    make("span", list, state);
  });
}
