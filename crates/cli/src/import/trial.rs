//! A trial episode of an imported model under the reactive controllers.

use anyhow::{Context, Result};
use b2b_building::RunPeriod;
use b2b_energyplus::Level;
use b2b_env::Task;
use serde::{Deserialize, Serialize};

use crate::arguments::controller::{Parameters, reactive};
use crate::prepare::Prepared;
use crate::rollout::roll_out;

/// Temperature deviations and engine messages of a trial episode.
#[derive(Serialize, Deserialize)]
pub struct Trial {
    pub period: String,
    /// Over the controlled zones with heating and cooling.
    pub rms_deviation_k: f64,
    /// The controlled zone with the largest deviation.
    pub worst_zone: String,
    pub worst_zone_rms_k: f64,
    pub warnings: usize,
    pub severes: usize,
    /// The first severe message.
    pub severe_message: Option<String>,
}

impl Trial {
    /// Simulates a run period at a constant 21 °C.
    pub fn run(prepared: &Prepared, period: RunPeriod, quiet: bool) -> Result<Self> {
        let mut env = prepared.env(period, 12, Task::default())?;
        let mut controller = reactive(&env, &Parameters::Tuned)?;
        roll_out(&mut env, &mut controller, quiet)?;
        let metrics = env.metrics();
        let rms = |zone: &b2b_env::ZoneMetrics| zone.rms_deviation(metrics.steps);
        let worst = metrics.zones.iter().max_by(|a, b| rms(a).total_cmp(&rms(b)));
        let worst = worst.context("no zone is controlled")?;
        Ok(Self {
            period: period.to_string(),
            rms_deviation_k: metrics.rms_deviation(),
            worst_zone: env.building().zones[worst.slot].name.clone(),
            worst_zone_rms_k: rms(worst),
            warnings: env.message_count(Level::Warning),
            severes: env.message_count(Level::Severe),
            severe_message: env.messages().at_least(Level::Severe).next().map(|m| m.text.clone()),
        })
    }
}
