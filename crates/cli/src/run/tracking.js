/* What a task with targets shows. */
/* The targets as lines, each once, named after its zones. */
function eachOnce(goals, names) {
  const once = new Map();
  goals.forEach((goal, k) => {
    const key = goal.mean.join();
    once.set(key, { ...(once.get(key) || goal), zones: [...(once.get(key)?.zones || []), names[k]] });
  });
  return [...once.values()].map((goal, _, all) =>
    ({ ...goal, name: all.length === 1 ? "target" : `target, ${goal.zones.join(", ")}`, tinted: all.length > 1 }));
}

/* The zones with their targets, all or one. */
function addZones({ title, unit, series, targets, band }) {
  const all = series.map(decodeSeries), zones = all.filter(each => !each.dashed).length;
  const goals = targets && targets.map(decodeSeries).map(each => ({ ...each, name: "target", target: true }));
  const own = k => all.filter((_, n) => n % zones === k);
  const middle = target => target === undefined ? null : [target - band, target + band];
  const choose = (panel, k) => {
    panel.series = [...(k ? own(k - 1) : all), ...(goals ? k ? [goals[k - 1]] : together : [])];
    panel.width = k || together?.length === 1 ? band : 0;
    panel.note = panel.band || panel.width ? "comfort band shaded" : "";
  };
  const names = all.slice(0, zones).map(each => each.name);
  const together = goals && eachOnce(goals, names);
  const options = ["all zones", ...names];
  addPanel(list, { title, unit, height: 250, band: goals ? null : middle(data.target),
    choice: { label: "Zone", options, choose } });
  if (!goals) return;
  const deviations = all.map((each, n) => deviation(each, goals[n % zones]));
  addPanel(list, { title: "Deviation from target", unit: "K", height: 250, band: [-band, band], note: "comfort band shaded",
    choice: { label: "Zone", options, choose: (panel, k) => {
      panel.series = k ? deviations.filter((_, n) => n % zones === k - 1) : deviations;
    } } });
}

/* The metrics of tracking. */
function trackingTiles(s) {
  metric("return", of => fixed(of.return, 1).replace("-", "−"));
  metric("mean absolute deviation", of => fixed(of.mean_abs_deviation_k, 2) + " K");
  metric("RMS deviation", of => fixed(of.rms_deviation_k, 2) + " K");
  const heated = s.zones.filter(zone => !zone.heating_and_cooling).length;
  if (heated) metric(`RMS below target, ${heated} zones without cooling`, of => fixed(of.rms_heating_only_k, 2) + " K");
  metric("outside comfort band", of => fixed(of.hours_outside_band, 1) + " h");
  metric("HVAC electricity", of => fixed(of.electricity_wh_m2 / 1000, 2) + " kWh/m²");
  metric("HVAC non-electric", of => fixed(of.gas_wh_m2 / 1000, 2) + " kWh/m²");
  for (const use of ["heating", "cooling", "fans", "pumps"]) {
    if (s[`${use}_wh_m2`]) metric(`HVAC energy, ${use}`, of => fixed(of[`${use}_wh_m2`] / 1000, 2) + " kWh/m²");
  }
  const share = value => value === null || value === undefined ? "–" : `${fixed(100 * value, 1)} %`;
  metric("occupied hours too cold", of => share(of.occupied_too_cold_share));
  metric("occupied hours too warm", of => share(of.occupied_too_warm_share));
  metric("peak electric demand", of => fixed(of.peak_electricity_w_m2, 1) + " W/m²");
  metric("actuator travel, full strokes", of => fixed(of.daily_travel, 1) + " /day");
  tile("engine messages", `${s.engine_warnings} warnings, ${s.engine_severes} severe`);
  spreadTiles();
  const far = s.zones.filter(zone => zone.never_near_target).map(zone => zone.name);
  if (far.length) warn(`never within ${fixed(s.task_definition.comfort_band, 1)} K of target: ${far.join(", ")}`);
}
