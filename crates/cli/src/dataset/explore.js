const COLORS = ["#2563eb", "#e4572e", "#0f9d76", "#9333ea", "#d39b00", "#0891b2"];
const SPLITS = ["train", "test", "test, in the small test"];
const PAGE = 25, MARGIN = { left: 54, right: 10, top: 10, bottom: 38 };
const byId = id => document.getElementById(id);

/* A building is its type and its row in the columns of the type. */
const buildings = data.types.flatMap((type, number) => type.columns.split.map((split, row) => ({
  type: number, row, split, id: `${type.name}-${String(row + 1).padStart(4, "0")}`,
})));
const value = (building, column) => data.types[building.type].columns[column]?.[building.row] ?? null;
const parameter = Object.fromEntries(data.parameters.map(each => [each.column, each]));
const numeric = data.parameters.filter(each => each.number);
const named = column => parameter[column].name + (parameter[column].unit ? ` (${parameter[column].unit})` : "");
const text = v => v === null ? "–" : typeof v === "number" ? String(v).replace("-", "−") : v;
const distinct = column => [...new Set(buildings.map(b => value(b, column)).filter(v => v !== null))].sort();

const filter = { types: new Set(data.types.keys()), search: "", place: "", zone: "", split: "", limits: new Map() };
let shown = buildings, page = 0, chosen = null, sort = { column: "id", down: false }, axes = ["floor_area", "window_u"];
let hover = null, drag = null, points = [];

function passes(b, but) {
  if (but !== "type" && !filter.types.has(b.type)) return false;
  if (filter.search && !b.id.toLowerCase().includes(filter.search)) return false;
  if (filter.place && value(b, "place") !== filter.place) return false;
  if (filter.zone && value(b, "climate_zone") !== filter.zone) return false;
  if (filter.split && (filter.split === "small" ? b.split !== 2 : (b.split > 0) !== (filter.split === "test"))) return false;
  for (const [column, [low, high]] of filter.limits) {
    if (low === null && high === null) continue;
    const v = value(b, column);
    if (v === null || (low !== null && v < low) || (high !== null && v > high)) return false;
  }
  return true;
}

const key = b => sort.column === "id" ? b.type * 1e4 + b.row : sort.column === "split" ? b.split : value(b, sort.column);
function update() {
  shown = buildings.filter(b => passes(b));
  const sign = sort.down ? -1 : 1;
  // Buildings without the value come last in both directions.
  shown.sort((a, b) => {
    const [u, v] = [key(a), key(b)];
    if (u === v) return a.type - b.type || a.row - b.row;
    if (u === null || v === null) return u === null ? 1 : -1;
    return u < v ? -sign : sign;
  });
  page = 0;
  byId("count").textContent = `${shown.length.toLocaleString("en")} of ${buildings.length.toLocaleString("en")} buildings.`;
  data.types.forEach((type, k) => {
    type.button.setAttribute("aria-pressed", filter.types.has(k));
    type.number.textContent = buildings.filter(b => b.type === k && passes(b, "type")).length.toLocaleString("en");
  });
  writeTable();
  draw();
}

/* Filters */
function options(select, first, all) {
  select.replaceChildren(new Option(first, ""), ...all.map(([text, value]) => new Option(text, value)));
}
data.types.forEach((type, k) => {
  const button = make("button", document.querySelector(".types"));
  make("i", button).style.background = COLORS[k];
  button.append(type.name);
  button.title = type.description;
  type.number = make("span", button);
  type.button = button;
  button.onclick = () => {
    // From all types, a click selects one; deselecting the last selects all.
    if (filter.types.size === data.types.length) filter.types.clear();
    if (!filter.types.delete(k)) filter.types.add(k);
    if (!filter.types.size) data.types.forEach((_, each) => filter.types.add(each));
    update();
  };
});
options(byId("place"), "all", distinct("place").map(place => [place, place]));
options(byId("zone"), "all (houses have none)", distinct("climate_zone").map(zone => [zone, zone]));
options(byId("split"), "all", [["train", "train"], ["test", "test"], ["small test", "small"]]);
for (const name of ["place", "zone", "split"]) {
  byId(name).addEventListener("input", e => { filter[name] = e.target.value; update(); });
}
byId("search").addEventListener("input", e => { filter.search = e.target.value.trim().toLowerCase(); update(); });

function writeLimits() {
  const list = byId("limits");
  list.replaceChildren();
  for (const [column, limit] of filter.limits) {
    const row = make("div", list, undefined, "limit");
    make("b", row, named(column));
    const values = buildings.map(b => value(b, column)).filter(v => v !== null);
    [Math.min(...values), Math.max(...values)].forEach((bound, side) => {
      const input = make("input", row);
      Object.assign(input, { type: "number", step: "any", placeholder: bound, value: limit[side] ?? "" });
      input.setAttribute("aria-label", `${side ? "largest" : "smallest"} ${named(column)}`);
      input.oninput = () => { limit[side] = input.value === "" ? null : Number(input.value); update(); };
      if (!side) make("span", row, "to");
    });
    const remove = make("button", row, "×");
    remove.setAttribute("aria-label", `Remove the limit of ${named(column)}`);
    remove.onclick = () => { filter.limits.delete(column); writeLimits(); update(); };
  }
  options(byId("add"), "choose…", numeric.filter(p => !filter.limits.has(p.column)).map(p => [named(p.column), p.column]));
}
byId("add").onchange = e => { filter.limits.set(e.target.value, [null, null]); writeLimits(); update(); };
function reset() {
  Object.assign(filter, { types: new Set(data.types.keys()), search: "", place: "", zone: "", split: "" });
  filter.limits = new Map([["floor_area", [null, null]], ["year", [null, null]], ["wall_resistance", [null, null]],
    ["wall_u", [null, null]]]);
  for (const name of ["place", "zone", "split", "search"]) byId(name).value = "";
  writeLimits();
  update();
}
byId("reset").onclick = reset;

/* Plot */
const canvas = document.querySelector("canvas"), tip = document.querySelector(".tip");
["x", "y"].forEach((name, k) => {
  for (const p of numeric) byId(name).add(new Option(named(p.column), p.column));
  byId(name).value = axes[k];
  byId(name).onchange = e => { axes[k] = e.target.value; hover = null; writeTable(); draw(); };
});

function ticks(low, high, count) {
  const rough = (high - low) / count, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map(f => f * power).find(s => s >= rough), digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const all = [];
  for (let v = Math.ceil(low / step) * step; v <= high + step * 1e-9; v += step) all.push([v, v.toFixed(digits).replace("-", "−")]);
  return all;
}

/* The ranges of both axes and functions between values and pixels. */
let scales = [];
function scale(column, all, from, to) {
  const values = all.map(b => value(b, column));
  let low = Math.min(...values), high = Math.max(...values);
  if (!(high > low)) { low -= .5; high += .5; }
  const pad = (high - low) * .03;
  low -= pad; high += pad;
  return { low, high, at: v => from + (v - low) / (high - low) * (to - from), of: p => low + (p - from) / (to - from) * (high - low) };
}

function draw() {
  const ratio = devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
  canvas.width = width * ratio; canvas.height = height * ratio;
  const g = canvas.getContext("2d");
  g.scale(ratio, ratio);
  g.font = "11px system-ui, sans-serif";
  const both = shown.filter(b => axes.every(column => value(b, column) !== null));
  const without = shown.length - both.length;
  byId("missing").textContent = without ? `${without.toLocaleString("en")} buildings have only one of them or none` : "";
  points = [];
  if (!both.length) {
    g.fillStyle = style("--soft"); g.textAlign = "center";
    g.fillText("No building of the selection has both parameters.", width / 2, height / 2);
    return;
  }
  const box = { l: MARGIN.left, r: width - MARGIN.right, t: MARGIN.top, b: height - MARGIN.bottom };
  const [x, y] = scales = [scale(axes[0], both, box.l, box.r), scale(axes[1], both, box.b, box.t)];
  g.strokeStyle = style("--grid"); g.fillStyle = style("--soft"); g.lineWidth = 1;
  g.textAlign = "center"; g.textBaseline = "top";
  for (const [v, label] of ticks(x.low, x.high, (box.r - box.l) / 80)) {
    g.beginPath(); g.moveTo(x.at(v), box.t); g.lineTo(x.at(v), box.b); g.stroke();
    g.fillText(label, x.at(v), box.b + 5);
  }
  g.fillText(named(axes[0]), (box.l + box.r) / 2, box.b + 22);
  g.textAlign = "right"; g.textBaseline = "middle";
  for (const [v, label] of ticks(y.low, y.high, (box.b - box.t) / 45)) {
    g.beginPath(); g.moveTo(box.l, y.at(v)); g.lineTo(box.r, y.at(v)); g.stroke();
    g.fillText(label, box.l - 6, y.at(v));
  }
  g.save(); g.translate(11, (box.t + box.b) / 2); g.rotate(-Math.PI / 2); g.textAlign = "center";
  g.fillText(named(axes[1]), 0, 0); g.restore();
  g.globalAlpha = both.length > 1500 ? .45 : .7;
  for (const b of both) {
    const point = { b, x: x.at(value(b, axes[0])), y: y.at(value(b, axes[1])) };
    points.push(point);
    g.fillStyle = COLORS[b.type];
    g.beginPath(); g.arc(point.x, point.y, both.length > 1500 ? 2.2 : 3.4, 0, 7); g.fill();
  }
  g.globalAlpha = 1; g.lineWidth = 2; g.strokeStyle = style("--ink");
  for (const point of points) if (point.b === chosen || point.b === hover) {
    g.fillStyle = COLORS[point.b.type];
    g.beginPath(); g.arc(point.x, point.y, 5.5, 0, 7); g.fill(); g.stroke();
  }
  if (drag?.moved) {
    g.fillStyle = "rgba(120,130,150,.22)";
    g.fillRect(drag.x, drag.y, drag.to.x - drag.x, drag.to.y - drag.y);
  }
}

function position(event) {
  const frame = canvas.getBoundingClientRect();
  return { x: event.clientX - frame.left, y: event.clientY - frame.top };
}
function nearest({ x, y }) {
  let best = null, least = 15 ** 2;
  for (const p of points) {
    const square = (p.x - x) ** 2 + (p.y - y) ** 2;
    if (square < least) { least = square; best = p; }
  }
  return best;
}
canvas.onpointerdown = e => { drag = { ...position(e), moved: false }; canvas.setPointerCapture(e.pointerId); };
canvas.onpointermove = e => {
  const at = position(e);
  if (drag) {
    drag.to = at;
    drag.moved = Math.abs(at.x - drag.x) > 5 && Math.abs(at.y - drag.y) > 5;
  }
  const point = drag?.moved ? null : nearest(at);
  hover = point?.b ?? null;
  tip.hidden = !point;
  if (point) {
    tip.textContent = `${point.b.id}: ${axes.map(column => text(value(point.b, column))).join(", ")}`;
    tip.style.left = Math.min(point.x + 10, Math.max(0, canvas.clientWidth - tip.offsetWidth)) + "px";
    tip.style.top = Math.max(0, point.y - 34) + "px";
  }
  draw();
};
canvas.onpointerup = e => {
  const done = drag, point = nearest(position(e));
  drag = null;
  if (done?.moved) {
    const sides = [[done.x, done.to.x], [done.to.y, done.y]];
    sides.forEach((pair, k) => {
      const limit = pair.map(p => Number(scales[k].of(p).toPrecision(4))).sort((a, b) => a - b);
      filter.limits.set(axes[k], limit);
    });
    writeLimits();
    update();
  } else if (point) choose(point.b);
};
canvas.onpointerleave = () => { hover = null; tip.hidden = true; draw(); };
canvas.onpointercancel = () => { drag = null; draw(); };

/* Table */
const columns = () => [...new Set(["id", "place", "climate_zone", "split", "floor_area", "year", ...axes])];
const cell = (b, column) => column === "id" ? b.id : column === "split" ? SPLITS[b.split] : text(value(b, column));
function writeTable() {
  const all = columns(), isText = column => ["place", "climate_zone", "split"].includes(column);
  const head = document.createElement("tr");
  for (const column of all) {
    const name = column === "id" ? "building" : column === "split" ? "split" : named(column);
    const arrow = sort.column === column ? (sort.down ? " ▼" : " ▲") : "";
    make("th", head, name + arrow, isText(column) ? "text" : "").onclick = () => {
      sort = { column, down: sort.column === column && !sort.down };
      update();
    };
  }
  document.querySelector("thead").replaceChildren(head);
  const body = document.querySelector("tbody"), pages = Math.max(1, Math.ceil(shown.length / PAGE));
  body.replaceChildren();
  for (const b of shown.slice(page * PAGE, (page + 1) * PAGE)) {
    const row = make("tr", body, undefined, b === chosen ? "chosen" : "");
    for (const column of all) make("td", row, cell(b, column), isText(column) ? "text" : "");
    row.onclick = () => choose(b);
  }
  byId("page").textContent = `page ${page + 1} of ${pages.toLocaleString("en")}`;
  const moves = { first: 0, back: page - 1, next: page + 1, last: pages - 1 };
  for (const [name, to] of Object.entries(moves)) {
    byId(name).disabled = to < 0 || to >= pages || to === page;
    byId(name).onclick = () => { page = to; writeTable(); };
  }
}

/* The chosen building */
function copy(button, line) {
  const done = () => { button.textContent = "Copied"; setTimeout(() => { button.textContent = "Copy"; }, 1500); };
  const select = () => {
    getSelection().selectAllChildren(button.previousSibling);
    document.execCommand("copy");
    done();
  };
  if (navigator.clipboard) navigator.clipboard.writeText(line).then(done, select); else select();
}
function choose(b) {
  chosen = b;
  const section = byId("building"), list = section.querySelector("dl"), commands = section.querySelector(".commands");
  section.hidden = !b;
  writeTable();
  draw();
  if (!b) return;
  section.querySelector("h2").replaceChildren(b.id);
  make("small", section.querySelector("h2"), `${data.types[b.type].description}; ${SPLITS[b.split]}`);
  commands.replaceChildren();
  for (const line of [`b2b view ${b.id}`, `b2b run ${b.id}`, `b2b show ${b.id}`]) {
    const row = make("div", commands);
    make("code", row, line);
    const button = make("button", row, "Copy");
    button.onclick = () => copy(button, line);
  }
  list.replaceChildren();
  for (const { column, name, unit } of data.parameters) {
    const own = value(b, column);
    if (own === null) continue;
    const row = make("div", list);
    make("dt", row, name);
    make("dd", row, [text(own), unit].filter(Boolean).join(" "));
  }
  section.scrollIntoView({ block: "nearest" });
}
byId("close").onclick = () => choose(null);

document.querySelector("footer").textContent = `Dataset ${data.generator}. The floor area is conditioned; of a house, it is
  the heated area with the basement. Resistances are nominal, without air films. b2b view draws a building in 3D; b2b run
  simulates a winter.`;
addEventListener("resize", draw);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
reset();
