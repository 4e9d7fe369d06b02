/* What a task with targets shows. */
/* The zones, all or one with its target. */
function addZones({ title, unit, series, targets, band }) {
  const all = series.map(decodeSeries), zones = all.filter(each => !each.dashed).length;
  const goals = targets && targets.map(decodeSeries).map(each => ({ ...each, name: "target", target: true }));
  const own = k => all.filter((_, n) => n % zones === k);
  const middle = target => target === undefined ? null : [target - band, target + band];
  const choose = (panel, k) => {
    panel.series = k ? own(k - 1) : all;
    if (k && goals) panel.series = [...panel.series, goals[k - 1]];
    panel.width = band;
    panel.note = panel.band || (k && goals) ? "comfort band shaded" : goals ? "choose a zone to see its target" : "";
  };
  const names = all.slice(0, zones).map(each => each.name);
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
  tile("return", fixed(s.return, 1).replace("-", "−"));
  tile("mean absolute deviation", fixed(s.mean_abs_deviation_k, 2) + " K");
  tile("RMS deviation", fixed(s.rms_deviation_k, 2) + " K");
  const heated = s.zones.filter(zone => !zone.heating_and_cooling).length;
  if (heated) tile(`RMS below target, ${heated} zones without cooling`, fixed(s.rms_heating_only_k, 2) + " K");
  tile("outside comfort band", fixed(s.hours_outside_band, 1) + " h");
  tile("HVAC electricity", fixed(s.electricity_wh_m2 / 1000, 2) + " kWh/m²");
  const others = s.energy_carriers.length > 2 ? " and other carriers" : "";
  tile(`HVAC gas${others}`, fixed(s.gas_wh_m2 / 1000, 2) + " kWh/m²");
  tile("peak electric demand", fixed(s.peak_electricity_w_m2, 1) + " W/m²");
  tile("actuator travel, full strokes", fixed(s.daily_travel, 1) + " /day");
  tile("engine messages", `${s.engine_warnings} warnings, ${s.engine_severes} severe`);
  spreadTiles();
  const far = s.zones.filter(zone => zone.never_near_target).map(zone => zone.name);
  if (far.length) warn(`never within ${fixed(s.task_definition.comfort_band, 1)} K of target: ${far.join(", ")}`);
}
