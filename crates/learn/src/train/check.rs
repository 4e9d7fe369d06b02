//! Checks of a configuration.

use b2b_agent::{Acting, ObservationForm};
use b2b_dataset::Placement;

use super::config::{Algorithm, TrainConfig};
use super::policy::Policy;
use crate::error::{Error, Result};
use crate::ppo::LogStd;

impl TrainConfig {
    /// Checks that the values go together.
    ///
    /// # Errors
    /// [`Error::Invalid`] for the first that does not, and those of the algorithm's own options.
    pub fn check(&self) -> Result<()> {
        self.ppo.check()?;
        self.sac.check()?;
        let days = self.run_period()?.days();
        self.named()?;
        let is_placed = self.placement()? != Placement::default();
        let tasks = self.task.as_slice().len();
        self.check_problem()?;
        let wrong = match () {
            () if self.environments == 0 => "`environments` is 0; expected at least 1".to_owned(),
            () if self.credit_by_zone && self.algorithm == Algorithm::Sac => {
                "`credit_by_zone` is for ppo; with sac it must be false".to_owned()
            }
            () if self.steps == 0 => "`steps` is 0; expected at least 1".to_owned(),
            () if self.window_days > days => {
                format!("`window_days` is {}; the run period has {days} days", self.window_days)
            }
            () if !(self.travel_cost >= 0.0 && self.travel_cost.is_finite()) => {
                format!("`travel_cost` is {}; expected 0 or more", self.travel_cost)
            }
            () if !(self.travel_cost_growth >= 1.0 && self.travel_cost_growth.is_finite()) => {
                format!("`travel_cost_growth` is {}; expected 1 or more", self.travel_cost_growth)
            }
            () if !(0.0..1.0).contains(&self.noise_correlation) => {
                format!("`noise_correlation` is {}; expected 0 to less than 1", self.noise_correlation)
            }
            () if self.mirrored_noise && self.algorithm == Algorithm::Sac => {
                "`mirrored_noise` is for ppo; with sac it must be false".to_owned()
            }
            () if self.noise_cost != 0.0 && !(self.noise_cost > 1.0 && self.noise_cost.is_finite()) => {
                format!("`noise_cost` is {}; expected more than 1, or 0 for none", self.noise_cost)
            }
            () if !(self.final_noise > 0.0 && self.final_noise <= 1.0) => {
                format!("`final_noise` is {}; expected more than 0, at most 1", self.final_noise)
            }
            () if self.final_noise != 1.0 && self.algorithm == Algorithm::Sac => {
                "`final_noise` is for ppo; with sac it must be 1".to_owned()
            }
            () if self.ppo.log_std == LogStd::OfState && (self.noise_cost != 0.0 || self.final_noise != 1.0) => {
                "with `ppo.log_std` = of_state, the agent sets the noise: `noise_cost` must be 0 and `final_noise` 1".to_owned()
            }
            () if self.noise_cost != 0.0 && self.algorithm == Algorithm::Sac => {
                "`noise_cost` is for ppo; with sac it must be 0".to_owned()
            }
            () if tasks > 1 && self.observation.form != ObservationForm::Features => {
                "tasks with different observations require the observation `features`".to_owned()
            }
            () if self.evaluation.every > 0 && self.evaluation.days == 0 => {
                "`evaluation.days` is 0; expected at least 1".to_owned()
            }
            () if self.buildings.is_empty() == self.building_type.is_empty() => {
                "expected either `buildings` or `building_type`".to_owned()
            }
            () if is_placed && self.buildings.is_empty() => {
                "`place`, `weather` and `allow_external` are for `buildings`; remove them".to_owned()
            }
            () if !self.place.is_empty() && !self.weather.as_os_str().is_empty() => {
                "expected either `place` or `weather`".to_owned()
            }
            () if self.fault_of_zones().is_some() => self.fault_of_zones().unwrap_or_default(),
            () if self.building_episodes == 0 => "`building_episodes` is 0; expected at least 1".to_owned(),
            () if self.policy == Policy::Flat && self.building_type.len() > 1 => {
                "several building types are for graph networks; choose the preset graph, or one type"
                    .to_owned()
            }
            () if self.building_type.len() > self.distinct_environments() => format!(
                "`environments` is {}; expected at least {} for {} building types{}",
                self.environments,
                self.building_type.len() * self.environments.div_ceil(self.distinct_environments()),
                self.building_type.len(),
                if self.mirrored_noise { " with mirrored noise" } else { "" }
            ),
            () if self.fault_of_graph().is_some() => self.fault_of_graph().unwrap_or_default(),
            () => match self.acting {
                Acting::Residual { authority } if !(authority > 0.0 && authority <= 1.0) => {
                    format!("`authority` is {authority}; expected more than 0, at most 1")
                }
                _ => return self.building_types().map(|_| ()),
            },
        };
        Err(Error::Invalid(wrong))
    }

    /// Returns what is wrong with the excluded climate zones, if something is.
    fn fault_of_zones(&self) -> Option<String> {
        let zones = &self.excluded_climate_zones;
        if zones.is_empty() {
            return None;
        }
        if self.building_type.is_empty() {
            return Some("`excluded_climate_zones` are for `building_type`; remove them".to_owned());
        }
        let types = self.building_types().ok()?;
        let has = |zone: &String| {
            types.iter().any(|each| b2b_dataset::rows(*each).iter().any(|row| row.is_in_climate_zone(zone)))
        };
        if let Some(zone) = zones.iter().find(|zone| !has(zone)) {
            return Some(format!(
                "`excluded_climate_zones` has `{zone}`, which no {} is in; expected an ASHRAE 169 zone, such as 5B, or a number, \
                 such as 5",
                self.building_type.join(" or ")
            ));
        }
        let empty = types.iter().find(|each| self.drawn(**each).next().is_none());
        empty.map(|each| format!("`excluded_climate_zones` leave no {each} to train on"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_that_do_not_go_together_are_errors() {
        let valid = TrainConfig { buildings: vec!["OfficeSmall-0042".into()], ..TrainConfig::default() };
        let error = |config: TrainConfig| config.check().unwrap_err().to_string();
        assert!(error(TrainConfig { environments: 0, ..valid.clone() }).contains("environments"));
        assert!(error(TrainConfig { window_days: 100, ..valid.clone() }).contains("window_days"));
        assert!(error(TrainConfig { buildings: Vec::new(), ..valid.clone() }).contains("building_type"));
        assert!(error(TrainConfig { travel_cost: -1.0, ..valid.clone() }).contains("travel_cost"));
        let shrinking = TrainConfig { travel_cost_growth: 0.5, ..valid.clone() };
        assert!(error(shrinking).contains("`travel_cost_growth` is 0.5"));
        let of_sac = TrainConfig { algorithm: Algorithm::Sac, mirrored_noise: true, ..valid.clone() };
        assert!(error(of_sac).contains("`mirrored_noise` is for ppo"));
        let without = |zones: &[&str]| TrainConfig {
            buildings: Vec::new(),
            building_type: vec!["OfficeSmall".into()],
            excluded_climate_zones: zones.iter().map(ToString::to_string).collect(),
            ..valid.clone()
        };
        without(&["1", "5B"]).check().unwrap();
        assert!(error(without(&["9"])).contains("`9`, which no OfficeSmall is in"));
        assert!(error(without(&["1", "2", "3", "4", "5", "6", "7", "8"])).contains("leave no OfficeSmall"));
        let named = TrainConfig { excluded_climate_zones: vec!["1".into()], ..valid.clone() };
        assert!(error(named).contains("`excluded_climate_zones` are for `building_type`"));
        let acting = Acting::Residual { authority: 1.5 };
        assert!(error(TrainConfig { acting, ..valid }).contains("authority"));
    }
}
