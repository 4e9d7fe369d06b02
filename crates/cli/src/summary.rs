//! What an episode amounts to, for people and for programs.

use std::path::PathBuf;

use anyhow::Result;
use b2b_benchmark::Versions;
use b2b_energyplus::Level;
use b2b_env::{Env, EpisodeMetrics, Setpoints, Task};
use cpu_time::ProcessTime;
use serde::Serialize;

use crate::run::Rollout;
use crate::table::Table;

/// The object that `--json` prints and `summary.json` holds. Means over zones are over those with both heating
/// and cooling.
#[derive(Serialize)]
pub struct Summary {
    /// Building type, or id of a building of the dataset.
    pub building: String,
    /// What only the command line knows.
    #[serde(flatten)]
    pub about: About,
    /// What made it.
    pub versions: Versions,
    /// Run period, as on the command line.
    pub period: String,
    /// Zone time steps an hour.
    pub steps_per_hour: u32,
    /// Spelling of the task.
    pub task: String,
    /// SHA-256 of the task: equal hashes mean equal tasks.
    pub task_hash: String,
    /// The task itself; a file with it is a task for `--task`.
    pub task_definition: Task,
    /// Scale τ_E by which the reward divides what the task weighs.
    pub energy_scale: f64,
    /// Metrics of the episode, each under the name of its column.
    #[serde(flatten, serialize_with = "EpisodeMetrics::serialize_columns")]
    pub metrics: EpisodeMetrics,
    /// Controlled zones in which nobody ever is.
    pub never_occupied: Vec<String>,
    /// Way of each actuator over the episode, in times its range, in the order of the action.
    pub travel: Vec<f64>,
    /// Largest relative difference between our energy sums and the engine's own meters.
    pub meter_relative_error: f64,
    /// Warnings of the engine.
    pub engine_warnings: usize,
    /// Severe messages of the engine.
    pub engine_severes: usize,
    /// First severe messages.
    pub severe_messages: Vec<String>,
    /// SHA-256 of every observation, action and penalty: equal hashes mean equal episodes.
    pub trajectory_hash: String,
    /// CPU time of the process up to the end of the episode, s.
    pub cpu_s: f64,
    /// CPU time within `Env::reset` and `Env::step`, s: the engine, and the little the environment adds.
    pub engine_cpu_s: f64,
    /// Steps a second, on the clock.
    pub steps_per_s: f64,
    /// The controlled zones.
    pub zones: Vec<ZoneSummary>,
}

/// What an environment does not know of its run.
#[derive(Serialize)]
pub struct About {
    /// Name of the place, or of the weather file.
    pub place: String,
    /// Name of the controller.
    pub controller: &'static str,
    /// Seed of the random controller.
    pub seed: u64,
    /// Where the files are.
    pub files: Vec<PathBuf>,
}

/// Deviation of one zone from target.
#[derive(Serialize)]
pub struct ZoneSummary {
    /// Name.
    pub name: String,
    /// Root mean square deviation, K.
    pub rms_deviation_k: f64,
    /// Mean absolute deviation, K.
    pub mean_abs_deviation_k: f64,
    /// Hours further from target than the task's comfort band.
    pub hours_outside_band: f64,
    /// Thermal discomfort beyond the band, K h.
    pub discomfort_k_h: f64,
    /// Whether it has both heating and cooling.
    pub heating_and_cooling: bool,
}

/// Severe messages that are kept.
const SEVERES_KEPT: usize = 5;

impl Summary {
    /// Name of the file.
    pub const NAME: &str = "summary.json";

    /// Sums up a finished episode.
    pub fn of(env: &Env, rollout: &Rollout, about: About) -> Result<Self> {
        let (metrics, episode) = (env.metrics(), env.episode());
        let severes = env.messages();
        let severes = severes.at_least(Level::Severe).take(SEVERES_KEPT);
        Ok(Self {
            building: env.building().name.clone(),
            about,
            versions: Versions::current(),
            period: episode.period.to_string(),
            steps_per_hour: episode.steps_per_hour,
            task: episode.task.to_string(),
            task_hash: episode.task.hash(),
            task_definition: episode.task.clone(),
            energy_scale: env.energy_scale(),
            metrics: metrics.into(),
            never_occupied: rollout.never_occupied.clone(),
            travel: metrics.travel.clone(),
            meter_relative_error: meter_relative_error(env)?,
            engine_warnings: env.message_count(Level::Warning),
            engine_severes: env.message_count(Level::Severe),
            severe_messages: severes.map(|message| message.text.clone()).collect(),
            trajectory_hash: rollout.trajectory.hash(),
            cpu_s: ProcessTime::now().as_duration().as_secs_f64(),
            engine_cpu_s: rollout.env_cpu.as_secs_f64(),
            steps_per_s: metrics.steps as f64 / rollout.wall.as_secs_f64(),
            zones: zones(env),
        })
    }

    /// For people.
    pub fn text(&self) -> String {
        let severes: String =
            self.severe_messages.iter().map(|m| format!("    severe: {}\n", m.replace('\n', " "))).collect();
        let files: Vec<_> = self.about.files.iter().map(|file| format!("  {}", file.display())).collect();
        format!(
            "{}\n\n{}\n{severes}\n{}\n\n{}",
            self.title(),
            self.figures(),
            self.zone_table(),
            files.join("\n")
        )
    }

    /// A line on zones without people, where targets follow them.
    fn emptiness(&self) -> String {
        let occupancy = matches!(self.task_definition.setpoints, Setpoints::Occupancy { .. });
        if !occupancy || self.never_occupied.is_empty() {
            return String::new();
        }
        format!("\n\n  nobody is ever in {}: always let go", self.never_occupied.join(", "))
    }

    /// One line that names the episode.
    pub fn title(&self) -> String {
        let Self { building, period, about: About { place, controller, .. }, task, .. } = self;
        let steps = self.metrics.steps;
        format!("{building} in {place}, {period}, task {task}, {controller} controller: {steps} steps")
    }

    fn figures(&self) -> String {
        let metrics = &self.metrics;
        let hours = metrics.steps as f64 / f64::from(self.steps_per_hour);
        let band = self.task_definition.comfort_band;
        let lines = [
            (
                "return",
                format!(
                    "{:.1}  (temperature {:.1}, energy {:.1})",
                    metrics.episode_return,
                    0.0 - metrics.temperature_penalty,
                    0.0 - metrics.energy_penalty
                ),
            ),
            ("mean absolute deviation", format!("{:.2} K", metrics.mean_abs_deviation)),
            ("RMS deviation", format!("{:.2} K", metrics.rms_deviation)),
            (
                "outside the comfort band",
                format!("{:.1} h of {hours:.0} h, at ±{band} K", metrics.hours_outside_band),
            ),
            ("discomfort beyond it", format!("{:.1} K h", metrics.discomfort)),
            ("HVAC electricity", format!("{:.2} kWh/m²", metrics.electricity / 1000.0)),
            ("HVAC gas", format!("{:.2} kWh/m²", metrics.gas / 1000.0)),
            ("cost, emissions", format!("{:.2} per m², {:.2} kg CO₂/m²", metrics.cost, metrics.emissions)),
            ("highest electric power", format!("{:.1} W/m²", metrics.peak_electricity)),
            ("way of the actuators", format!("{:.1} times their ranges a day", metrics.daily_travel)),
            ("energy against the engine's meters", format!("{:.1e} relative", self.meter_relative_error)),
            ("engine", format!("{} warnings, {} severe", self.engine_warnings, self.engine_severes)),
            ("action values clamped", metrics.clamped_actions.to_string()),
            ("speed", format!("{:.0} steps/s", self.steps_per_s)),
            (
                "CPU time",
                format!(
                    "{:.2} s in the environment, {:.2} s outside it (preparation, controller)",
                    self.engine_cpu_s,
                    self.cpu_s - self.engine_cpu_s
                ),
            ),
        ];
        let lines: Vec<_> = lines.iter().map(|(name, value)| format!("  {name:<36}{value}")).collect();
        lines.join("\n")
    }

    fn zone_table(&self) -> String {
        let mut table =
            Table::new(["zone", "equipment", "mean abs, K", "RMS, K", "outside, h", "discomfort, K h"]);
        for zone in &self.zones {
            table.row([
                zone.name.clone(),
                if zone.heating_and_cooling { "heating and cooling" } else { "heating" }.into(),
                format!("{:.2}", zone.mean_abs_deviation_k),
                format!("{:.2}", zone.rms_deviation_k),
                format!("{:.1}", zone.hours_outside_band),
                format!("{:.1}", zone.discomfort_k_h),
            ]);
        }
        table.text() + &self.emptiness()
    }
}

fn zones(env: &Env) -> Vec<ZoneSummary> {
    let metrics = env.metrics();
    let zone = |zone: &b2b_env::ZoneMetrics| ZoneSummary {
        name: env.building().zones[zone.slot].name.clone(),
        rms_deviation_k: zone.rms_deviation(metrics.steps),
        mean_abs_deviation_k: zone.mean_abs_deviation(metrics.steps),
        hours_outside_band: metrics.zone_hours_outside_band(zone),
        discomfort_k_h: zone.discomfort,
        heating_and_cooling: zone.fully_conditioned,
    };
    metrics.zones.iter().map(zone).collect()
}

/// A fuel that the building does not use is no error.
fn meter_relative_error(env: &Env) -> Result<f64> {
    const TINY: f64 = 1e-9;
    let ours = [env.metrics().electricity, env.metrics().gas];
    let errors =
        ours.iter().zip(env.engine_meters()?).map(|(ours, engine)| (ours - engine).abs() / engine.max(TINY));
    Ok(errors.fold(0.0, f64::max))
}
