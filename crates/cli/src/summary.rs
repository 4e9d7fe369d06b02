//! What an episode amounts to, for people and for programs.

use std::path::PathBuf;

use anyhow::Result;
use b2b_dataset::GENERATOR_VERSION;
use b2b_energyplus::Level;
use b2b_energyplus::install::ENGINE_VERSION;
use b2b_env::{Env, Setpoints, Task};
use cpu_time::ProcessTime;
use serde::{Deserialize, Serialize};

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
    /// Steps of the episode.
    pub steps: usize,
    /// Sum of the rewards.
    #[serde(rename = "return")]
    pub episode_return: f64,
    /// Sum of the temperature penalties, K².
    pub temperature_penalty: f64,
    /// Sum of the energy penalties.
    pub energy_penalty: f64,
    /// Root mean square deviation from target, K.
    pub rms_deviation_k: f64,
    /// Mean absolute deviation from target, K.
    pub mean_abs_deviation_k: f64,
    /// Hours further from target than the task's comfort band.
    pub hours_outside_band: f64,
    /// Thermal discomfort beyond the band, mean over the controlled zones, K h.
    pub discomfort_k_h: f64,
    /// Controlled zones in which nobody ever is.
    pub never_occupied: Vec<String>,
    /// HVAC electricity, Wh/m².
    pub electricity_wh_m2: f64,
    /// HVAC gas, Wh/m².
    pub gas_wh_m2: f64,
    /// Cost by the task's prices, currency/m².
    pub cost_m2: f64,
    /// Emissions by the task's factors, kg of CO₂/m².
    pub emissions_kg_m2: f64,
    /// Highest electric HVAC power, mean of a step, W/m².
    pub peak_electricity_w_m2: f64,
    /// Highest gas power, mean of a step, W/m².
    pub peak_gas_w_m2: f64,
    /// Way of the actuators a day, in times their ranges, mean over them.
    pub daily_travel: f64,
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
    /// Action values that were out of bounds and clamped.
    pub clamped_actions: usize,
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

/// Versions of what an episode depends on: with the same, it is the same.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Versions {
    /// Of this program.
    pub package: String,
    /// Of the buildings.
    pub generator: String,
    /// Of EnergyPlus.
    pub engine: String,
}

impl Versions {
    /// Those at work.
    pub fn current() -> Self {
        let [package, generator, engine] =
            [env!("CARGO_PKG_VERSION"), GENERATOR_VERSION, ENGINE_VERSION].map(str::to_owned);
        Self { package, generator, engine }
    }
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
            steps: metrics.steps,
            episode_return: metrics.episode_return,
            temperature_penalty: metrics.temperature_penalty,
            energy_penalty: metrics.energy_penalty,
            rms_deviation_k: metrics.rms_deviation(),
            mean_abs_deviation_k: metrics.mean_abs_deviation(),
            hours_outside_band: metrics.hours_outside_band(),
            discomfort_k_h: metrics.discomfort(),
            never_occupied: rollout.never_occupied.clone(),
            electricity_wh_m2: metrics.electricity,
            gas_wh_m2: metrics.gas,
            cost_m2: metrics.cost,
            emissions_kg_m2: metrics.emissions / 1000.0,
            peak_electricity_w_m2: metrics.peak_electricity,
            peak_gas_w_m2: metrics.peak_gas,
            daily_travel: metrics.daily_travel(),
            travel: metrics.travel.clone(),
            meter_relative_error: meter_relative_error(env)?,
            engine_warnings: env.message_count(Level::Warning),
            engine_severes: env.message_count(Level::Severe),
            severe_messages: severes.map(|message| message.text.clone()).collect(),
            clamped_actions: metrics.clamped_actions,
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
        let Self { building, period, steps, about: About { place, controller, .. }, .. } = self;
        let task = &self.task;
        format!("{building} in {place}, {period}, task {task}, {controller} controller: {steps} steps")
    }

    fn figures(&self) -> String {
        let hours = self.steps as f64 / f64::from(self.steps_per_hour);
        let band = self.task_definition.comfort_band;
        let lines = [
            (
                "return",
                format!(
                    "{:.1}  (temperature {:.1}, energy {:.1})",
                    self.episode_return,
                    0.0 - self.temperature_penalty,
                    0.0 - self.energy_penalty
                ),
            ),
            ("mean absolute deviation", format!("{:.2} K", self.mean_abs_deviation_k)),
            ("RMS deviation", format!("{:.2} K", self.rms_deviation_k)),
            (
                "outside the comfort band",
                format!("{:.1} h of {hours:.0} h, at ±{band} K", self.hours_outside_band),
            ),
            ("discomfort beyond it", format!("{:.1} K h", self.discomfort_k_h)),
            ("HVAC electricity", format!("{:.2} kWh/m²", self.electricity_wh_m2 / 1000.0)),
            ("HVAC gas", format!("{:.2} kWh/m²", self.gas_wh_m2 / 1000.0)),
            ("cost, emissions", format!("{:.2} per m², {:.2} kg CO₂/m²", self.cost_m2, self.emissions_kg_m2)),
            ("highest electric power", format!("{:.1} W/m²", self.peak_electricity_w_m2)),
            ("way of the actuators", format!("{:.1} times their ranges a day", self.daily_travel)),
            ("energy against the engine's meters", format!("{:.1e} relative", self.meter_relative_error)),
            ("engine", format!("{} warnings, {} severe", self.engine_warnings, self.engine_severes)),
            ("action values clamped", self.clamped_actions.to_string()),
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
