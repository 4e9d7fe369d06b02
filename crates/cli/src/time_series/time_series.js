/* Time series in panels with one time axis. `data.axis` has first_day, steps_per_hour, span (steps per point)
   and points; all panels share the view, the cursor and zooming. */
const PALETTE = ["#2563eb", "#e4572e", "#0f9d76", "#9333ea", "#d39b00", "#0891b2", "#db2777", "#65800f",
  "#7c5c3e", "#5b6b8c"];
const MONTHS = ["Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"];
const WEEKDAYS = ["Sun", "Mon", "Tue", "Wed", "Thu", "Fri", "Sat"];
const HOUR = 3600e3, DAY = 24 * HOUR, POINT_MS = HOUR / data.axis.steps_per_hour * data.axis.span;
/* Days of a year that has the simulated days of the week. The year itself is not shown. */
const [YEAR, MONTH, FIRST] = data.axis.first_day;
const START = Date.UTC(YEAR, MONTH - 1, FIRST), END = START + data.axis.points * POINT_MS;
const PER_DAY = Math.round(DAY / POINT_MS), DAYS = Math.ceil(data.axis.points / PER_DAY);
/* Views of more days than this show daily means and ranges. */
const LONG = 21 * DAY;
/* Setpoints farther from all temperatures than this are not shown, K. */
const FAR = 3;
const MARGIN = { left: 48, right: 6, top: 8, bottom: 20 }, ROW = 18, NARROW = 560;
const view = { from: START, to: END }, panels = [];
let cursor = null, drag = null;

const color = k => k < PALETTE.length ? PALETTE[k] : `hsl(${(k * 137.5) % 360} 55% 48%)`;
const DIGITS = { "°C": 2, "K": 2, "W/m²": 1, "1": 2, "kg/s": 3, "kWh/m²": 2 };
const digits = unit => unit.endsWith("/kWh") ? 4 : DIGITS[unit] ?? 2;
const valueText = (unit, value) => value.toFixed(digits(unit)).replace("-", "−");
const date = t => new Date(t), isDaily = () => view.to - view.from > LONG;
const dateText = t => `${date(t).getUTCDate()} ${MONTHS[date(t).getUTCMonth()]}`;
const clockText = t => date(t).toISOString().slice(11, 16);
const momentText = t => `${WEEKDAYS[date(t).getUTCDay()]} ${dateText(t)} ${clockText(t)}`;

function decode(text, low, high) {
  const bytes = Uint8Array.from(atob(text), c => c.charCodeAt(0));
  const numbers = new DataView(bytes.buffer), range = (high - low) / 65535;
  return Float32Array.from({ length: bytes.length / 2 }, (_, k) => low + range * numbers.getUint16(2 * k, true));
}

/* A series from its encoded form. */
function decodeSeries({ name, color, dashed, low, high, mean, days }) {
  const points = decode(mean, low, high);
  return makeSeries({ name, color, dashed }, points, days && days.map(text => decode(text, low, high)));
}

/* A series of points, and daily means and ranges. Without given ranges, they come from the points. */
function makeSeries(about, mean, ranges) {
  const days = { mean: new Float32Array(DAYS), min: new Float32Array(DAYS), max: new Float32Array(DAYS) };
  let low = Infinity, high = -Infinity;
  for (let d = 0; d < DAYS; d++) {
    const own = mean.subarray(d * PER_DAY, (d + 1) * PER_DAY);
    days.mean[d] = own.reduce((a, b) => a + b, 0) / own.length;
    days.min[d] = ranges ? ranges[0][d] : Math.min(...own);
    days.max[d] = ranges ? ranges[1][d] : Math.max(...own);
    low = Math.min(low, days.min[d]); high = Math.max(high, days.max[d]);
  }
  return { ...about, mean, days, low, high, on: true };
}

/* Temperature minus target. A step is judged by the target at its start. */
function deviation(series, target) {
  const at = k => target.mean[data.axis.span > 1 ? k : Math.max(k - 1, 0)];
  return makeSeries({ name: series.name, color: series.color, dashed: series.dashed }, series.mean.map((v, k) => v - at(k)));
}

const constant = (about, value) => makeSeries(about, new Float32Array(data.axis.points).fill(value));

/* Means and ranges over the view: of the days if it is long, else of the points in a column of pixels. */
function samples(series, box) {
  const scale = box.w / (view.to - view.from), all = [];
  if (isDaily()) {
    const first = Math.max(0, Math.floor((view.from - START) / DAY) - 1);
    const last = Math.min(DAYS, Math.ceil((view.to - START) / DAY) + 1);
    for (let d = first; d < last; d++) {
      const x = box.x + (START + (d + .5) * DAY - view.from) * scale;
      all.push({ x, mean: series.days.mean[d], min: series.days.min[d], max: series.days.max[d] });
    }
    return all;
  }
  const per = Math.max(1, Math.floor(1 / (POINT_MS * scale)));
  const first = Math.max(0, Math.floor((view.from - START) / POINT_MS / per) - 1);
  for (let k = first * per; k < data.axis.points && START + (k - per) * POINT_MS <= view.to; k += per) {
    let sum = 0, min = Infinity, max = -Infinity, n = 0;
    for (let j = k; j < Math.min(k + per, data.axis.points); j++, n++) {
      const value = series.mean[j];
      sum += value; min = Math.min(min, value); max = Math.max(max, value);
    }
    all.push({ x: box.x + (START + (k + per / 2) * POINT_MS - view.from) * scale, mean: sum / n, min, max });
  }
  return all;
}

function ticks(low, high, count) {
  const rough = (high - low) / count, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map(f => f * power).find(s => s >= rough);
  const all = [];
  for (let v = Math.ceil(low / step) * step; v <= high + step * 1e-9; v += step) all.push(v);
  return { all, digits: Math.max(0, -Math.floor(Math.log10(step) + 1e-9)) };
}

function timeTicks(width) {
  const wanted = (view.to - view.from) / Math.max(2, width / 80);
  const steps = [1, 2, 3, 6, 12, 24, 48, 7 * 24, 14 * 24].map(hours => hours * HOUR);
  const step = steps.find(s => s >= wanted);
  const all = [];
  if (!step) {
    for (let m = 0; m < 24; m++) {
      const t = Date.UTC(YEAR, m, 1);
      if (t >= view.from && t < view.to) all.push(t);
    }
    return { all, label: t => MONTHS[date(t).getUTCMonth()] };
  }
  const zero = Date.UTC(YEAR, 0, 1);
  for (let t = zero + Math.ceil((view.from - zero) / step) * step; t <= view.to; t += step) all.push(t);
  return { all, label: t => t % DAY ? clockText(t) : dateText(t) };
}

function range(panel, drawn) {
  let low = Infinity, high = -Infinity;
  for (const { points } of drawn) for (const p of points) {
    low = Math.min(low, p.min); high = Math.max(high, p.max);
  }
  if (panel.band) { low = Math.min(low, panel.band[0]); high = Math.max(high, panel.band[1]); }
  const near = drawn.length ? [low - FAR, high + FAR] : [-Infinity, Infinity];
  for (const series of panel.series) if (series.step && !series.states) {
    low = Math.min(low, Math.max(series.low, near[0])); high = Math.max(high, Math.min(series.high, near[1]));
  }
  if (panel.zero) low = Math.min(0, low);
  if (!(high > low)) { low = (isFinite(low) ? low : 0) - (panel.zero ? 0 : .5); high = low + 1; }
  const pad = (high - low) * .05;
  return [panel.zero && low === 0 ? 0 : low - pad, high + pad];
}

function draw(panel) {
  const canvas = panel.canvas, ratio = devicePixelRatio || 1;
  const width = canvas.clientWidth, height = canvas.clientHeight;
  canvas.width = width * ratio; canvas.height = height * ratio;
  const g = canvas.getContext("2d");
  g.scale(ratio, ratio);
  g.font = "11px system-ui, sans-serif";
  const box = { x: MARGIN.left, y: MARGIN.top, w: width - MARGIN.left - MARGIN.right,
    h: height - MARGIN.top - MARGIN.bottom };
  const x = t => box.x + (t - view.from) / (view.to - view.from) * box.w;
  drawTimeAxis(g, box, height, x);
  (panel.states ? drawStrips : panel.heat ? drawHeat : drawLines)(g, panel, box);
  if (drag && drag.to !== null) {
    g.fillStyle = "rgba(120,130,150,.22)";
    g.fillRect(x(drag.from), box.y, x(drag.to) - x(drag.from), box.h);
  }
  if (cursor !== null) {
    g.strokeStyle = style("--hand"); g.lineWidth = 1;
    g.beginPath(); g.moveTo(x(cursor), box.y); g.lineTo(x(cursor), box.y + box.h); g.stroke();
  }
}

function drawTimeAxis(g, box, height, x) {
  const time = timeTicks(box.w);
  g.textAlign = "center"; g.textBaseline = "alphabetic"; g.lineWidth = 1;
  for (const t of time.all) {
    g.strokeStyle = style("--grid");
    g.beginPath(); g.moveTo(x(t), box.y); g.lineTo(x(t), box.y + box.h); g.stroke();
    g.fillStyle = style("--soft");
    g.fillText(time.label(t), Math.min(Math.max(x(t), box.x + 14), box.x + box.w - 18), height - 5);
  }
}

/* The area between two lines over samples. */
function fill(g, points, high, low) {
  g.beginPath();
  points.forEach((p, k) => k ? g.lineTo(p.x, high(p)) : g.moveTo(p.x, high(p)));
  for (let k = points.length - 1; k >= 0; k--) g.lineTo(points[k].x, low(points[k]));
  g.fill();
}

function drawLines(g, panel, box) {
  const drawn = panel.series.filter(s => s.on && !s.step).map(series => ({ series, points: samples(series, box) }));
  const [low, high] = range(panel, drawn);
  const y = v => box.y + (high - v) / (high - low) * box.h;
  const marks = ticks(low, high, box.h / 28);
  g.textAlign = "right"; g.textBaseline = "middle";
  for (const v of marks.all) {
    g.strokeStyle = style("--grid");
    g.beginPath(); g.moveTo(box.x, y(v)); g.lineTo(box.x + box.w, y(v)); g.stroke();
    g.fillStyle = style("--soft");
    g.fillText(v.toFixed(marks.digits).replace("-", "−"), box.x - 7, y(v));
  }
  g.save(); g.beginPath(); g.rect(box.x, box.y - 1, box.w, box.h + 2); g.clip();
  if (panel.band) {
    g.fillStyle = style("--band");
    g.fillRect(box.x, y(panel.band[1]), box.w, y(panel.band[0]) - y(panel.band[1]));
    g.strokeStyle = style("--edge"); g.setLineDash([5, 4]);
    const middle = y((panel.band[0] + panel.band[1]) / 2);
    g.beginPath(); g.moveTo(box.x, middle); g.lineTo(box.x + box.w, middle); g.stroke();
    g.setLineDash([]);
  }
  if (panel.comfort) drawComfort(g, panel.comfort, box, y);
  for (const series of panel.series) if (series.step && series.on && series.color !== undefined) {
    g.strokeStyle = color(series.color); g.lineWidth = 1.3;
    g.setLineDash(series.dashed ? [2, 3] : []);
    drawSteps(g, series, box, y);
    g.setLineDash([]);
  }
  const lines = drawn.filter(each => !each.series.target).length;
  for (const { series, points } of drawn) {
    const faded = panel.lit && panel.lit !== series, lit = panel.lit === series;
    const inked = series.target && !series.tinted ? style("--ink") : color(series.color);
    g.fillStyle = g.strokeStyle = inked;
    if (series.target && panel.width && !isDaily()) {
      g.fillStyle = style("--band");
      fill(g, points, p => y(p.mean + panel.width), p => y(p.mean - panel.width));
    } else if (!series.target) {
      g.globalAlpha = faded ? .04 : lit ? .3 : Math.max(.04, .22 - .035 * lines);
      fill(g, points, p => y(p.max), p => y(p.min));
    }
    g.globalAlpha = faded ? .15 : 1; g.lineWidth = lit ? 2.2 : 1.4; g.lineJoin = "round";
    g.setLineDash(series.dashed || series.target ? [6, 4] : []);
    g.beginPath();
    points.forEach((p, k) => {
      if (k && series.target && !isDaily()) g.lineTo(p.x, y(points[k - 1].mean));
      k ? g.lineTo(p.x, y(p.mean)) : g.moveTo(p.x, y(p.mean));
    });
    g.stroke();
    g.setLineDash([]);
    g.globalAlpha = 1;
  }
  g.restore();
}

/* Many series: one row each, from light (minimum) to dark (maximum) over all rows of the panel. */
function drawHeat(g, panel, box) {
  const low = Math.min(...panel.series.map(s => s.low)), high = Math.max(...panel.series.map(s => s.high));
  panel.series.forEach((series, row) => {
    if (!series.on) return;
    const points = samples(series, box), y = box.y + row * ROW + 1;
    g.save(); g.beginPath(); g.rect(box.x, 0, box.w, box.y + box.h); g.clip();
    points.forEach((p, k) => {
      const wide = (points[k + 1] || p).x - p.x || 3;
      g.fillStyle = ramp(high > low ? (p.mean - low) / (high - low) : 0);
      g.fillRect(p.x - wide / 2, y, wide + .6, ROW - 2);
    });
    if (box.w < NARROW) nameRow(g, series.name, box.x + 4, y + ROW / 2 - 1);
    g.restore();
  });
}
const RAMP = [[240, 244, 252], [158, 197, 236], [62, 140, 204], [24, 78, 150], [12, 32, 82]];
function ramp(share) {
  const at = Math.min(Math.max(share, 0), 1) * (RAMP.length - 1), k = Math.min(Math.floor(at), RAMP.length - 2);
  return `rgb(${RAMP[k].map((v, i) => Math.round(v + (RAMP[k + 1][i] - v) * (at - k))).join()})`;
}

function showValues() {
  const index = (length, last) => Math.min(Math.max(Math.floor((cursor - START) / length), 0), last);
  const point = index(POINT_MS, data.axis.points - 1);
  const at = cursor === null ? null : isDaily() ? index(DAY, DAYS - 1) : point;
  for (const panel of panels) for (const s of panel.series) {
    if (s.states) s.value.textContent = cursor === null ? "" : s.states[Math.round(s.mean[point]) - 1] || "–";
    else s.value.textContent = at === null ? "" : valueText(panel.unit, (isDaily() ? s.days : s).mean[at]);
  }
  const moment = at => isDaily() ? `${dateText(START + at * DAY)}, daily means` : momentText(START + at * POINT_MS);
  document.getElementById("view").textContent = at !== null ? moment(at)
    : `${dateText(view.from)} – ${dateText(view.to - 1)}${isDaily() ? ": daily means, daily ranges shaded" : ""}`;
}

let pending = false;
function refresh() {
  if (pending) return;
  pending = true;
  requestAnimationFrame(() => { pending = false; panels.forEach(draw); showValues(); });
}

function look(from, to) {
  const length = Math.min(Math.max(to - from, 12 * POINT_MS), END - START);
  from = Math.min(Math.max(from, START), END - length);
  view.from = from; view.to = from + length;
  refresh();
}

function timeAt(event) {
  const frame = event.currentTarget.getBoundingClientRect();
  const share = (event.clientX - frame.left - MARGIN.left) / (frame.width - MARGIN.left - MARGIN.right);
  return view.from + Math.min(Math.max(share, 0), 1) * (view.to - view.from);
}

function listen(canvas) {
  canvas.addEventListener("pointerdown", e => { drag = { from: timeAt(e), to: null }; canvas.setPointerCapture(e.pointerId); });
  canvas.addEventListener("pointermove", e => { cursor = timeAt(e); if (drag) drag.to = cursor; refresh(); });
  canvas.addEventListener("pointerup", () => {
    const range = drag && drag.to !== null ? [drag.from, drag.to].sort((a, b) => a - b) : null;
    drag = null;
    if (range && (range[1] - range[0]) / (view.to - view.from) > .008) look(...range); else refresh();
  });
  canvas.addEventListener("pointerleave", () => { cursor = null; refresh(); });
  canvas.addEventListener("dblclick", () => look(START, END));
  canvas.addEventListener("wheel", e => {
    if (!e.ctrlKey && !e.shiftKey) return;
    e.preventDefault();
    const t = timeAt(e), factor = Math.exp((e.deltaY || e.deltaX) * .002);
    look(t - (t - view.from) * factor, t + (view.to - t) * factor);
  }, { passive: false });
}

/* Adds a panel. `choice` has the names of options, and `choose(panel, index)`, which shows an option in the panel. */
function addPanel(parent, panel) {
  const section = document.createElement("section");
  section.innerHTML = `<div class="head"><h2></h2></div><div class="row"><div class="plot"><canvas></canvas></div><ul class="legend"></ul></div>`;
  panel.canvas = section.querySelector("canvas");
  panel.section = section;
  parent.append(section);
  panels.push(panel);
  if (panel.choice) {
    const select = document.createElement("select");
    select.setAttribute("aria-label", panel.choice.label);
    for (const name of panel.choice.options) select.add(new Option(name));
    select.onchange = () => { panel.choice.choose(panel, select.selectedIndex); fillPanel(panel); refresh(); };
    section.querySelector(".head").append(select);
    panel.select = select;
    panel.choice.choose(panel, select.selectedIndex);
  }
  fillPanel(panel);
  listen(panel.canvas);
  return panel;
}

/* Writes heading and legend of a panel for its series. */
function fillPanel(panel) {
  const section = panel.section, heading = section.querySelector("h2"), small = document.createElement("small");
  const unit = panel.unit === "1" ? "fraction" : panel.unit;
  small.textContent = [unit, panel.heat && scale(panel), panel.note].filter(Boolean).join(", ");
  heading.replaceChildren(panel.title, small);
  section.querySelector(".row").classList.toggle("heat", Boolean(panel.heat || panel.states));
  const rows = panel.series.length * ROW + MARGIN.top + MARGIN.bottom;
  const height = panel.heat || panel.states ? rows : panel.height || Math.max(panel.series.length > 2 ? 170 : 125, Math.min(rows, 330));
  panel.canvas.style.height = height + "px";
  const list = section.querySelector("ul");
  list.style.maxHeight = height + "px";
  list.replaceChildren();
  for (const series of panel.series) {
    const item = document.createElement("li"), mark = document.createElement("i"), name = document.createElement("em");
    series.value = document.createElement("b");
    name.textContent = name.title = series.name;
    mark.style.background = mark.style.borderColor = markColor(series);
    mark.className = series.dashed || series.target ? "dashed" : "";
    item.classList.toggle("off", !series.on);
    item.append(mark, name, series.value);
    item.onclick = () => { series.on = !series.on; item.classList.toggle("off", !series.on); refresh(); };
    item.onmouseenter = () => { panel.lit = series; refresh(); };
    item.onmouseleave = () => { panel.lit = null; refresh(); };
    list.append(item);
  }
}
const markColor = series => series.target && !series.tinted ? "var(--ink)" : series.states ? stateColor(series.states, 1)
  : series.color === undefined ? "var(--edge)" : color(series.color);
function scale(panel) {
  const low = Math.min(...panel.series.map(s => s.low)), high = Math.max(...panel.series.map(s => s.high));
  const [from, to] = [low, high].map(value => valueText(panel.unit, value));
  return from === to ? `constant ${from}` : `light ${from} to dark ${to}`;
}

/* The buttons that move the view. */
function addBar(bar) {
  bar.innerHTML = `<button data-days="0">All</button><button data-days="31">Month</button><button data-days="7">Week</button>
    <button data-days="1">Day</button><button data-move="-1" aria-label="Earlier">◀</button><button data-move="1"
    aria-label="Later">▶</button><span id="view"></span><span class="hint">drag to zoom · double-click to reset · arrow
    keys to pan · click a name to hide it</span>`;
  for (const button of bar.querySelectorAll("button")) button.onclick = () => {
    const length = view.to - view.from, { days, move } = button.dataset;
    if (move) look(view.from + move * length, view.to + move * length);
    else if (days === "0") look(START, END);
    else look(view.from, view.from + days * DAY);
  };
  addEventListener("keydown", e => {
    if (/^(INPUT|SELECT)$/.test(e.target.tagName)) return;
    const move = { ArrowLeft: -.5, ArrowRight: .5 }[e.key], length = view.to - view.from;
    if (move) look(view.from + move * length, view.to + move * length);
  });
  addEventListener("resize", refresh);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", refresh);
}

function tile(name, value, beside) {
  const div = document.createElement("div");
  div.className = "tile";
  div.innerHTML = "<b></b><span></span>";
  div.children[0].textContent = value; div.children[1].textContent = name;
  if (beside) make("small", div, beside);
  document.querySelector(".tiles").append(div);
}
