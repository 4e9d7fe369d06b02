//! The metrics of an episode, as text and as JSON.

use std::path::PathBuf;

use anyhow::Result;
use b2b_base::digest::sha256;
use b2b_base::seal;
use b2b_building::Carrier;
use b2b_control::Versions;
use b2b_env::{BillPart, EpisodeMetrics, Inputs, Metrics, Setpoints, Spaces, Task, Term, ZoneMetrics};
use serde::Serialize;
use serde_json::Value;

use super::trajectory_file::Identity;
use crate::rollout::Rollout;
use crate::terminal::table::{Table, decimals};

/// The content of `summary.json`, which `--json` prints too. Means over zones include only zones with both heating and
/// cooling.
#[derive(Serialize)]
pub struct Summary {
    /// Building type, dataset id, or name of the model.
    pub building: String,
    /// Place, controller, seed and files.
    #[serde(flatten)]
    pub info: RunInfo,
    /// Versions that the episode depends on.
    pub versions: Versions,
    /// Model and weather.
    #[serde(flatten)]
    pub inputs: Inputs,
    /// Run period, as on the command line.
    pub period: String,
    /// Zone time steps per hour.
    pub steps_per_hour: u32,
    /// Short form of the task.
    pub task: String,
    /// SHA-256 of the task: equal hashes mean equal tasks.
    pub task_hash: String,
    /// The task in full. A file with this object is valid for `--task`.
    pub task_definition: Task,
    /// Scale τ_E that normalizes the reward's energy term.
    pub energy_scale: f64,
    /// Metrics of the episode, each under the name of its column.
    #[serde(flatten, serialize_with = "EpisodeMetrics::serialize_columns")]
    pub metrics: EpisodeMetrics,
    /// Currency of the costs in a task with bands; `None` in other tasks, and for a task's own prices, which do not
    /// state one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub currency: Option<String>,
    /// Parts of the bill of the whole building's HVAC; none without a tariff.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub bill: Vec<BillPart>,
    /// Energy carriers used by its HVAC; all but electricity count as gas in the metrics.
    pub energy_carriers: Vec<Carrier>,
    /// Controlled zones that are never occupied.
    pub never_occupied: Vec<String>,
    /// Travel of each actuator over the episode, full strokes, in action order.
    pub travel: Vec<f64>,
    /// Largest relative mismatch between the energy of the steps and EnergyPlus's meters.
    pub meter_relative_error: f64,
    /// Number of engine warnings.
    pub engine_warnings: usize,
    /// Number of severe engine messages.
    pub engine_severes: usize,
    /// The first 100 warnings.
    pub warning_messages: Vec<String>,
    /// The first severe and fatal messages.
    pub severe_messages: Vec<String>,
    /// SHA-256 of all observations, actions and penalties: equal hashes mean equal episodes.
    pub trajectory_hash: String,
    /// CPU time of this process and of the environment's up to the end of the episode, s.
    pub cpu_s: f64,
    /// CPU time of the environment, s: warm-up and steps.
    pub environment_cpu_s: f64,
    /// Steps per second of wall-clock time.
    pub steps_per_s: f64,
    /// The controlled zones.
    pub zones: Vec<ZoneSummary>,
    /// SHA-256 of the file with zeros in place of this.
    pub summary_sha256: String,
}

/// Properties of a run that are not part of the environment.
#[derive(Serialize)]
pub struct RunInfo {
    /// Name of the place, or of the weather file.
    pub place: String,
    /// Name of the controller.
    pub controller: String,
    /// Its parameters, unless they are those that it has without an argument.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parameters: Option<Value>,
    /// Random seed of the controller.
    pub seed: u64,
    /// Output files.
    pub files: Vec<PathBuf>,
}

/// Comfort metrics of one zone.
#[derive(Serialize)]
pub struct ZoneSummary {
    /// Name of the zone.
    pub name: String,
    /// Root mean square deviation, K.
    pub rms_deviation_k: f64,
    /// Mean absolute deviation, K.
    pub mean_abs_deviation_k: f64,
    /// Hours outside the task's comfort band.
    pub hours_outside_band: f64,
    /// Discomfort outside the band, K·h.
    pub discomfort_k_h: f64,
    /// Whether the rewarded deviation was outside the comfort band in every step.
    pub never_near_target: bool,
    /// Whether it has both heating and cooling.
    pub heating_and_cooling: bool,
}

impl ZoneSummary {
    /// Returns the zone's equipment.
    pub fn equipment(&self) -> &'static str {
        if self.heating_and_cooling { "heating and cooling" } else { "heating only" }
    }
}

impl Summary {
    /// Name of the file.
    pub const NAME: &str = "summary.json";
    /// The text before its own SHA-256.
    pub const SEAL: &str = "\"summary_sha256\": \"";

    /// Summarizes a finished episode.
    pub fn of(spaces: &Spaces, rollout: &Rollout, info: RunInfo) -> Result<Self> {
        let (metrics, engine, episode) = (&rollout.metrics, &rollout.engine, &spaces.episode);
        let mut summary = Self {
            building: spaces.building.name.clone(),
            info,
            versions: Versions::current(),
            inputs: Inputs::of(spaces)?,
            period: episode.period.to_string(),
            steps_per_hour: episode.steps_per_hour,
            task: episode.task.to_string(),
            task_hash: episode.task.hash(),
            task_definition: episode.task.clone(),
            energy_scale: spaces.energy_scale(),
            metrics: metrics.into(),
            currency: match episode.task.is_operation() || episode.task.tariff.is_some() {
                true => episode.task.currency()?,
                false => None,
            },
            bill: engine.bill.clone(),
            energy_carriers: spaces.building.carriers().collect(),
            never_occupied: engine.never_occupied.clone(),
            travel: metrics.travel.clone(),
            meter_relative_error: meter_relative_error(metrics, engine.meters),
            engine_warnings: engine.warnings,
            engine_severes: engine.severes,
            warning_messages: engine.warning_messages.clone(),
            severe_messages: engine.severe_messages.clone(),
            trajectory_hash: rollout.trajectory.hash(),
            cpu_s: rollout.total_cpu.as_secs_f64(),
            environment_cpu_s: rollout.env_cpu.as_secs_f64(),
            steps_per_s: metrics.steps as f64 / rollout.wall.as_secs_f64(),
            zones: zones(spaces, metrics),
            summary_sha256: seal::open(),
        };
        summary.summary_sha256 = sha256(summary.json()?);
        Ok(summary)
    }

    /// Returns the content of the file.
    pub fn json(&self) -> Result<Vec<u8>> {
        Ok(serde_json::to_vec_pretty(self)?)
    }

    /// Returns the identity that the trajectory file repeats.
    pub fn identity(&self) -> Identity {
        Identity {
            place: self.info.place.clone(),
            controller: self.info.controller.clone(),
            weather_sha256: self.inputs.weather_sha256.clone(),
            trajectory_hash: self.trajectory_hash.clone(),
            discomfort: self.metrics.tdis_tot,
            resource: self.metrics.used(self.task_definition.resource),
        }
    }

    /// Returns the text report.
    pub fn text(&self) -> String {
        let severes: String =
            self.severe_messages.iter().map(|m| format!("    severe: {}\n", m.replace('\n', " "))).collect();
        let files: Vec<_> = self.info.files.iter().map(|file| format!("  {}", file.display())).collect();
        format!(
            "{}\n\n{}\n{severes}\n{}{}{}{}\n\n{}",
            self.title(),
            self.metrics_text(),
            self.bill_text(),
            if self.is_operation() { self.band_table() } else { self.zone_table() },
            self.never_occupied_note(),
            self.never_near_target_note(),
            files.join("\n")
        )
    }

    fn is_operation(&self) -> bool {
        self.task_definition.is_operation()
    }

    /// Returns a line that identifies the episode.
    pub fn title(&self) -> String {
        let Self { building, period, task, info: RunInfo { place, controller, .. }, .. } = self;
        let steps = self.metrics.steps;
        let minutes = 60 / self.steps_per_hour;
        format!(
            "{building} in {place}, {period}, task {task}, {controller} controller: {steps} steps of {minutes} min"
        )
    }

    fn metrics_text(&self) -> String {
        let outcome = if self.is_operation() { self.operation_metrics() } else { self.outcome_metrics() };
        let metrics = [outcome, self.run_diagnostics()].concat();
        let lines: Vec<_> = metrics.iter().map(|(name, value)| format!("  {name:<39}{value}")).collect();
        lines.join("\n")
    }

    /// Returns the results of the episode: return, comfort, energy and actuator travel.
    fn outcome_metrics(&self) -> Vec<(&'static str, String)> {
        let metrics = &self.metrics;
        let of = |term: Term| metrics.terms.get(term).unwrap_or(f64::NAN);
        let hours = metrics.steps as f64 / f64::from(self.steps_per_hour);
        let band = self.task_definition.comfort_band;
        vec![
            ("return", self.return_text("temperature")),
            ("mean absolute deviation", format!("{:.2} K", metrics.mean_abs_deviation)),
            ("RMS deviation", self.rms_deviation_text()),
            (
                "outside comfort band",
                format!("{:.1} h of {hours:.0} h (±{band} K)", metrics.hours_outside_band),
            ),
            ("discomfort outside the band", format!("{:.1} K·h", metrics.discomfort)),
            ("too cold, too warm while occupied", self.occupied_text()),
            ("HVAC electricity", format!("{:.2} kWh/m²", of(Term::Electricity) / 1000.0)),
            ("HVAC non-electric", format!("{:.2} kWh/m²", of(Term::Gas) / 1000.0)),
            ("HVAC energy by end use", self.end_uses_text()),
            (
                "cost, emissions",
                format!("{:.2} {}, {:.2} kg CO₂/m²", of(Term::Cost), self.cost_unit(), of(Term::Emissions)),
            ),
            ("peak electric demand", format!("{:.1} W/m²", of(Term::PeakElectricity))),
            ("actuator travel", self.travel_text()),
            ("outdoor air per person", self.outdoor_air_text()),
        ]
    }

    /// Returns the return with its parts, the penalty of comfort under a name.
    pub(super) fn return_text(&self, comfort: &str) -> String {
        let EpisodeMetrics { episode_return, temperature_penalty, energy_penalty, .. } = self.metrics;
        let [of_comfort, of_resource] = [temperature_penalty, energy_penalty].map(|penalty| 0.0 - penalty);
        let resource = self.task_definition.resource.penalty().word;
        format!("{episode_return:.1}  ({comfort} {of_comfort:.1}, {resource} {of_resource:.1})")
    }

    /// Returns the actuator travel; a model under its own controls has no actuators.
    pub(super) fn travel_text(&self) -> String {
        match self.travel.is_empty() {
            true => "–".to_owned(),
            false => format!("{:.1} full strokes/day", self.metrics.daily_travel),
        }
    }

    /// Returns the shares of occupied hours outside the comfort band.
    pub(super) fn occupied_text(&self) -> String {
        match (self.metrics.occupied_too_cold, self.metrics.occupied_too_warm) {
            (Some(cold), Some(warm)) => {
                format!("{:.1} %, {:.1} % of occupied hours", 100.0 * cold, 100.0 * warm)
            }
            _ => "never occupied".to_owned(),
        }
    }

    /// Returns the outdoor air that systems supply to people; there is none in houses.
    pub(super) fn outdoor_air_text(&self) -> String {
        match self.metrics.outdoor_air_per_person {
            0.0 => "none through the systems".to_owned(),
            flow => format!("{flow:.1} L/s"),
        }
    }

    /// Returns HVAC energy by end use, without traces.
    pub(super) fn end_uses_text(&self) -> String {
        let of = |term| self.metrics.terms.get(term).unwrap_or_default() / 1000.0;
        let trace = 0.005 * Term::END_USES.into_iter().map(of).sum::<f64>().min(1.0);
        let used = Term::END_USES.into_iter().filter(|term| of(*term) > trace).map(|term| {
            let (energy, name) = (of(term), term.entry().name.replace('_', " "));
            format!("{name} {energy:.*}", decimals(energy, 2))
        });
        let used: Vec<_> = used.collect();
        if used.is_empty() { "–".to_owned() } else { format!("{} kWh/m²", used.join(", ")) }
    }

    /// Returns the unit of costs: prices of the task have no known currency.
    pub(super) fn cost_unit(&self) -> String {
        match self.task_definition.currency() {
            Ok(Some(currency)) => format!("{currency}/m²"),
            _ => "per m² at the task's prices".to_owned(),
        }
    }

    /// Returns the deviation of the zones with heating and cooling, and of the zones without cooling if there are any.
    fn rms_deviation_text(&self) -> String {
        let both = format!("{:.2} K", self.metrics.rms_deviation);
        match self.zones.iter().filter(|zone| !zone.heating_and_cooling).count() {
            0 => both,
            heated => {
                let below = self.metrics.rms_heating_only;
                let zones = if heated == 1 { "zone" } else { "zones" };
                format!("{both}; {heated} {zones} without cooling: {below:.2} K below target")
            }
        }
    }

    /// Returns the number of the engine's messages, and where they are.
    fn engine_text(&self) -> String {
        let Self { engine_warnings, engine_severes, .. } = self;
        let place = if engine_warnings + engine_severes > 0 { " (in summary.json)" } else { "" };
        format!("{engine_warnings} warnings, {engine_severes} severe{place}")
    }

    /// Returns indicators of the validity of the run, and its computational cost.
    fn run_diagnostics(&self) -> Vec<(&'static str, String)> {
        let other_cpu = self.cpu_s - self.environment_cpu_s;
        vec![
            ("clamped action values", self.metrics.clamped_actions.to_string()),
            ("steps under the ventilation interlock", self.metrics.ventilation_overrides.to_string()),
            ("engine messages", self.engine_text()),
            (
                "energy mismatch vs. EnergyPlus meters",
                format!("{:.1e} (relative)", self.meter_relative_error),
            ),
            ("speed", format!("{:.0} steps/s", self.steps_per_s)),
            (
                "CPU time",
                format!(
                    "{:.2} s environment, {other_cpu:.2} s other (preparation, controller)",
                    self.environment_cpu_s
                ),
            ),
        ]
    }

    fn zone_table(&self) -> String {
        let mut table = Table::new([
            "zone",
            "equipment",
            "mean abs. deviation (K)",
            "RMS deviation (K)",
            "outside band (h)",
            "discomfort (K·h)",
        ]);
        for zone in &self.zones {
            table.row([
                zone.name.clone(),
                zone.equipment().to_owned(),
                format!("{:.2}", zone.mean_abs_deviation_k),
                format!("{:.2}", zone.rms_deviation_k),
                format!("{:.1}", zone.hours_outside_band),
                format!("{:.1}", zone.discomfort_k_h),
            ]);
        }
        table.text()
    }

    fn never_near_target_note(&self) -> String {
        let what = if self.is_operation() {
            "never inside their bands".to_owned()
        } else {
            format!("never within {} K of target", self.task_definition.comfort_band)
        };
        let warning = never_near_target(&self.zones, &what);
        warning.map_or_else(String::new, |warning| format!("\n\n  warning: {warning}"))
    }

    /// Returns a note on zones whose setpoint is always the unoccupied one.
    fn never_occupied_note(&self) -> String {
        let by_occupancy = matches!(self.task_definition.setpoints, Setpoints::Occupancy { .. });
        if !by_occupancy || self.never_occupied.is_empty() {
            return String::new();
        }
        let zones = self.never_occupied.join(", ");
        format!("\n\n  never occupied, always at the unoccupied setpoint: {zones}")
    }
}

/// Returns a warning, beginning with `what`, about zones that were never within the comfort band.
fn never_near_target(zones: &[ZoneSummary], what: &str) -> Option<String> {
    let names: Vec<&str> =
        zones.iter().filter(|zone| zone.never_near_target).map(|zone| zone.name.as_str()).collect();
    (!names.is_empty()).then(|| format!("{what}: {}", names.join(", ")))
}

fn zones(spaces: &Spaces, metrics: &Metrics) -> Vec<ZoneSummary> {
    let zone = |zone: &ZoneMetrics| ZoneSummary {
        name: spaces.building.zones[zone.slot].name.clone(),
        rms_deviation_k: zone.rms_deviation(metrics.steps),
        mean_abs_deviation_k: zone.mean_abs_deviation(metrics.steps),
        hours_outside_band: metrics.zone_hours_outside_band(zone),
        discomfort_k_h: zone.discomfort,
        never_near_target: zone.is_never_near_target(metrics.steps),
        heating_and_cooling: zone.fully_conditioned,
    };
    metrics.zones.iter().map(zone).collect()
}

/// Returns the larger relative mismatch of electricity and gas; NaN without the engine's meters. The mismatch of an
/// unused fuel is 0.
fn meter_relative_error(metrics: &Metrics, meters: Option<[f64; 2]>) -> f64 {
    const TINY: f64 = 1e-9;
    let Some(meters) = meters else { return f64::NAN };
    let errors = [Term::Electricity, Term::Gas].map(|term| metrics.total(term)).into_iter().zip(meters);
    errors.map(|(ours, engine)| (ours - engine).abs() / engine.max(TINY)).fold(0.0, f64::max)
}
