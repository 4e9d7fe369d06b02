/* What a task with comfort bands shows. */
/* Number of zones that have a panel at first: the ones with the most discomfort. */
const ZONE_PANELS = 6;
const zonePanels = [];
/* At least two digits, so that the small energy of a mild day is not shown as 0. */
const twoDigits = (v, d) => fixed(v, v ? Math.min(6, Math.max(d, 1 - Math.floor(Math.log10(Math.abs(v))))) : d);
const cost = (v, d) => [twoDigits(v, d), data.operation.currency].filter(Boolean).join(" ");

function operationTiles(s) {
  metric("cost", of => cost(of.cost_tot, 3) + "/m²");
  metric("HVAC energy", of => twoDigits(of.ener_tot, 2) + " kWh/m²");
  metric("thermal discomfort, per zone", of => fixed(of.tdis_tot, 1) + " K·h");
  metric(`peak electric demand, ${Math.max(15, 60 / s.steps_per_hour)} min`, of => fixed((of.pele_tot || 0) * 1000, 1) + " W/m²");
  const shares = of => [of.occupied_too_cold_share, of.occupied_too_warm_share].map(share => fixed(100 * share, 1)).join(", ") + " %";
  if (s.occupied_too_cold_share !== null) metric("occupied hours too cold, too warm", shares);
  const used = ["heating_wh_m2", "cooling_wh_m2", "fans_wh_m2"];
  metric("heating, cooling, fans", of => used.map(name => twoDigits(of[name] / 1000, 2)).join(", ") + " kWh/m²");
  metric("emissions", of => twoDigits(of.emis_tot, 2) + " kg CO₂/m²");
  metric("actuator travel, full strokes", of => s.travel.length ? fixed(of.daily_travel, 1) + " /day" : "–");
  tile("engine messages", `${s.engine_warnings} warnings, ${s.engine_severes} severe`);
  spreadTiles();
  const outside = s.zones.filter(zone => zone.never_near_target).map(zone => zone.name);
  if (outside.length) warn(`never inside their bands: ${outside.join(", ")}`);
}

/* A table in a section, with a note beside its title. */
function addTable(title, note, header) {
  const section = make("section", document.querySelector(".pair"));
  make("small", make("h2", section, title), note);
  const table = make("table", make("div", section, undefined, "scroll")), head = make("tr", make("thead", table));
  header.forEach(name => make("th", head, name));
  const body = make("tbody", table);
  const row = (cells, kind) => cells.reduce((line, cell) => (make("td", line, cell), line), make("tr", body, undefined, kind));
  return { section, row };
}

/* The bill with its parts, and the zones with their discomfort. */
function operationTables(s) {
  if (s.bill && s.bill.length) {
    const { row } = addTable("Bill", "HVAC of the whole building", ["", "quantity", `cost (${data.operation.currency})`, "share"]);
    const sum = s.bill.reduce((sum, part) => sum + part.cost, 0);
    const share = part => sum > 0 ? fixed(100 * part.cost / sum, 0) + " %" : "–";
    for (const part of s.bill) row([part.name, `${fixed(part.quantity, 0)} ${part.unit}`, fixed(part.cost, 2), share(part)]);
    row(["total", "", fixed(sum, 2), ""], "all");
  }
  const { section, row } = addTable("Zones", `more than ${s.task_definition.comfort_band} K outside their bands; click a zone to see it below`,
    ["zone", "discomfort (K·h)", "hours outside"]);
  section.classList.add("zones");
  worstZones(s).forEach(k => {
    const zone = s.zones[k];
    const line = row([zone.name, fixed(zone.discomfort_k_h, 1), fixed(zone.hours_outside_band, 1)]);
    line.onclick = () => {
      const [panel] = zonePanels;
      panel.select.selectedIndex = k;
      panel.select.onchange();
      panel.section.scrollIntoView({ block: "center" });
    };
  });
}

/* The numbers of the zones, from the most discomfort to the least. */
const worstZones = s => [...s.zones.keys()].sort((a, b) => s.zones[b].discomfort_k_h - s.zones[a].discomfort_k_h || a - b);

/* The modes of the controller, and zones in their bands. */
function addBands({ title, unit, series }) {
  const { zones, states } = data.operation;
  if (states.length) {
    addStates(addPanel(list, { title: "Mode", unit: "", states: true, series: states.map(decodeSteps) }));
  }
  const temperatures = series.map(decodeSeries), names = temperatures.slice(0, zones.length).map(each => each.name);
  const choose = (panel, k) => {
    showComfort(panel, zones[k].comfort,
      [...temperatures.filter((_, n) => n % zones.length === k), ...zones[k].in_use.map(decodeSteps)]);
  };
  for (const k of worstZones(data.summary).slice(0, ZONE_PANELS)) {
    const panel = addPanel(list, { title, unit, height: 165, series: [], note: "comfort band shaded",
      choice: { label: "Zone", options: names, choose } });
    panel.select.selectedIndex = k;
    panel.select.onchange();
    zonePanels.push(panel);
  }
}

/* The price of electricity, below the power. */
function addPrice() {
  const { price, price_unit } = data.operation;
  addPanel(list, { title: "Price of electricity", unit: price_unit, height: 100, zero: true, series: [decodeSteps(price)] });
}

