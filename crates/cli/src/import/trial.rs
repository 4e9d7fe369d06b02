//! A trial episode of an imported model under the reactive controllers.

use anyhow::{Context, Result};
use b2b_building::RunPeriod;
use b2b_env::{Task, Term, ZoneMetrics};
use serde::Serialize;

use crate::arguments::controller::{Parameters, reactive};
use crate::program::prepare::Prepared;
use crate::rollout::Rollout;

/// Temperature deviations and engine messages of a trial episode.
#[derive(Default, Serialize)]
pub struct Trial {
    pub period: String,
    /// Over the controlled zones with heating and cooling; 0 if there are none.
    pub rms_deviation_k: f64,
    /// Whether a controlled zone has heating and cooling.
    #[serde(skip)]
    pub cools: bool,
    /// Below target, over the controlled zones without cooling; 0 if there are none.
    pub rms_heating_only_k: f64,
    /// The controlled zones that were never within the comfort band of their target.
    pub never_near_target: Vec<String>,
    /// The controlled zone with the largest deviation.
    pub worst_zone: String,
    pub worst_zone_rms_k: f64,
    pub electricity_kwh_m2: f64,
    /// Gas, other fuels and district energy.
    pub gas_kwh_m2: f64,
    pub warnings: usize,
    pub severes: usize,
    /// The first severe message.
    pub severe_message: Option<String>,
}

impl Trial {
    /// Simulates a run period with a constant target of 21 °C.
    pub fn run(prepared: &Prepared, period: RunPeriod, quiet: bool) -> Result<Self> {
        let spaces = prepared.spaces(period, prepared.trial_steps()?, Task::default())?;
        let mut controller = reactive(&spaces, &Parameters::Tuned)?;
        let Rollout { metrics, engine, .. } = prepared.roll_out(&spaces, &mut controller, quiet)?;
        let name = |zone: &ZoneMetrics| spaces.building.zones[zone.slot].name.clone();
        let rms = |zone: &ZoneMetrics| zone.rms_penalized_deviation(metrics.steps);
        let far = metrics.zones.iter().filter(|zone| zone.is_never_near_target(metrics.steps));
        let worst = metrics.zones.iter().max_by(|a, b| rms(a).total_cmp(&rms(b)));
        let worst = worst.context("no zone is controlled")?;
        Ok(Self {
            period: period.to_string(),
            rms_deviation_k: metrics.rms_deviation(),
            cools: metrics.zones.iter().any(|zone| zone.fully_conditioned),
            rms_heating_only_k: metrics.rms_heating_only(),
            never_near_target: far.map(name).collect(),
            worst_zone: name(worst),
            worst_zone_rms_k: rms(worst),
            electricity_kwh_m2: metrics.total(Term::Electricity) / 1000.0,
            gas_kwh_m2: metrics.total(Term::Gas) / 1000.0,
            warnings: engine.warnings,
            severes: engine.severes,
            severe_message: engine.severe_messages.into_iter().next(),
        })
    }
}
