//! `picture.html`: the time series of an episode, in one file that needs no network.

use std::io::Write;

use anyhow::Result;
use b2b_building::hvac::Quantity;
use b2b_building::morphology::Owner;
use b2b_building::{Conditioning, PreparedBuilding};
use b2b_env::{EpisodeMetrics, Spaces, Target, Trajectory};
use serde::Serialize;
use serde_json::json;

use super::Baseline;
use super::operation::Operation;
use super::summary::Summary;
use crate::rollout::Rollout;
use crate::time_series::{Series, TimeAxis, fill};

/// Name of the file.
pub const NAME: &str = "picture.html";

const PAGE: &str = include_str!("picture.html");
/// The script for tasks with bands.
const OPERATION: &str = include_str!("operation.js");
/// The script for tasks with targets.
const TRACKING: &str = include_str!("tracking.js");

/// Series of one unit over the time axis.
#[derive(Serialize)]
struct Panel {
    title: String,
    unit: &'static str,
    series: Vec<Series>,
    /// Targets of the first series, if they vary.
    #[serde(skip_serializing_if = "Option::is_none")]
    targets: Option<Vec<Series>>,
    /// Half width of the comfort band, for temperatures of controlled zones.
    #[serde(skip_serializing_if = "Option::is_none")]
    band: Option<f64>,
}

/// The baseline's metrics, by column name.
#[derive(Serialize)]
struct Beside {
    name: &'static str,
    #[serde(flatten, serialize_with = "EpisodeMetrics::serialize_columns")]
    metrics: EpisodeMetrics,
}

/// Writes the page. If the baseline's episode is given, its zone temperatures, power and metrics are shown next to the
/// agent's.
pub fn write(
    file: &mut impl Write,
    spaces: &Spaces,
    rollout: &Rollout,
    baseline: Option<&Baseline>,
    summary: &Summary,
) -> Result<()> {
    let Rollout { trajectory, decisions, .. } = rollout;
    let episode = &spaces.episode;
    let axis = TimeAxis::new(episode.period, episode.steps_per_hour, trajectory.len());
    let beside =
        baseline.map(|Baseline { name, rollout }| Beside { name, metrics: (&rollout.metrics).into() });
    let picture = Picture { spaces, trajectory, baseline, axis };
    let data = json!({
        "title": summary.title(),
        "summary": summary,
        "baseline": beside,
        "axis": axis,
        "resolution": axis.resolution(),
        "target": spaces.observation.constant_target(),
        "panels": picture.panels(),
        "operation": Operation::of(spaces, trajectory, decisions, axis)?,
    });
    Ok(file.write_all(fill(&PAGE.replace("{{SCRIPT}}", &[OPERATION, TRACKING].concat()), &data).as_bytes())?)
}

struct Picture<'a> {
    spaces: &'a Spaces,
    trajectory: &'a Trajectory,
    baseline: Option<&'a Baseline>,
    axis: TimeAxis,
}

impl Picture<'_> {
    fn panels(&self) -> Vec<Panel> {
        let mut panels = vec![self.temperatures(), self.outdoor(), self.power()];
        const GROUPS: [(Quantity, &str); 6] = [
            (Quantity::SupplyAirFlow, "supply air flow"),
            (Quantity::SupplyAirTemperature, "supply air temperature"),
            (Quantity::OutdoorAirFlow, "outdoor air flow"),
            (Quantity::DamperOpening, "damper opening"),
            (Quantity::HeatingSetpoint, "heating setpoint"),
            (Quantity::CoolingSetpoint, "cooling setpoint"),
        ];
        panels.extend(GROUPS.map(|(quantity, what)| self.actions(quantity, what)));
        panels.retain(|panel| !panel.series.is_empty());
        panels
    }

    fn temperatures(&self) -> Panel {
        let band = self.spaces.episode.task.comfort_band;
        let zones = |picture: &Self| {
            picture.zones(|conditioning| conditioning != Conditioning::None).collect::<Vec<_>>()
        };
        let series = self.with_baseline(zones);
        let has_targets = !self.spaces.episode.task.is_operation();
        let targets = Some(self.targets()).filter(|targets| has_targets && !targets.is_empty());
        Panel { title: "Zone air temperature".into(), unit: "°C", series, targets, band: Some(band) }
    }

    /// Returns the targets that vary over time.
    fn targets(&self) -> Vec<Series> {
        let zones = self.spaces.building.zones.iter().enumerate();
        let controlled = zones.filter(|(_, zone)| zone.conditioning != Conditioning::None);
        let targets = controlled.enumerate().filter_map(|(index, (number, zone))| {
            match self.spaces.observation.target(index) {
                Target::Slot(slot) => Some(self.slot(zone.name.clone(), number, slot, 1.0)),
                Target::Always(_) | Target::Between(_) => None,
            }
        });
        targets.collect()
    }

    /// Returns the temperatures of the outdoor air and of uncontrolled zones: unconditioned zones, such as attics and
    /// plenums, and zones with their own controls.
    fn outdoor(&self) -> Panel {
        let outdoor = self.spaces.observation.outdoor_temperature();
        let mut series =
            vec![self.slot("outdoor air".into(), self.spaces.building.zones.len(), outdoor, 1.0)];
        let zones = &self.spaces.building.zones;
        let kind = |series: Series| {
            let own_controls = zones.iter().any(|zone| zone.own_controls && zone.name == series.name);
            let kind = if own_controls { "own controls" } else { "unconditioned" };
            let name = format!("{}, {kind}", series.name);
            series.named(name)
        };
        series.extend(self.zones(|conditioning| conditioning == Conditioning::None).map(kind));
        Panel {
            title: "Outdoor air and zones that are not controlled".into(),
            unit: "°C",
            series,
            targets: None,
            band: None,
        }
    }

    /// Returns the temperatures of the zones whose conditioning matches.
    fn zones(&self, matches: impl Fn(Conditioning) -> bool) -> impl Iterator<Item = Series> {
        let zones = self.spaces.building.zones.iter().enumerate();
        let slots = self.spaces.observation.zone_temperatures();
        zones
            .zip(slots)
            .filter(move |((_, zone), _)| matches(zone.conditioning))
            .map(|((number, zone), slot)| self.slot(zone.name.clone(), number, slot, 1.0))
    }

    fn power(&self) -> Panel {
        let space = &self.spaces.observation;
        let per_hour = f64::from(self.spaces.episode.steps_per_hour);
        let series = self.with_baseline(|picture| {
            vec![
                picture.slot("electricity".into(), 0, space.electricity(), per_hour),
                picture.slot("gas".into(), 1, space.gas(), per_hour),
            ]
        });
        Panel { title: "HVAC power".into(), unit: "W/m²", series, targets: None, band: None }
    }

    fn actions(&self, quantity: Quantity, what: &str) -> Panel {
        let building = &self.spaces.building;
        let actuators = building.owned_actuators().enumerate();
        let series = actuators.filter(|(_, (_, actuator))| actuator.quantity == quantity).map(
            |(k, (owner, actuator))| {
                let name = actuator.name.trim_end_matches(what).trim_end().to_owned();
                self.series(name, zone_of(building, owner), self.trajectory.acted(k).collect())
            },
        );
        Panel {
            title: format!("Action: {what}"),
            unit: quantity.unit(),
            series: series.collect(),
            targets: None,
            band: None,
        }
    }

    /// Returns series, followed by the same series of the baseline, dashed, if it is given.
    fn with_baseline(&self, series: impl Fn(&Self) -> Vec<Series>) -> Vec<Series> {
        let mut all = series(self);
        if let Some(Baseline { name: baseline, rollout }) = self.baseline {
            let other = Self { trajectory: &rollout.trajectory, baseline: None, ..*self };
            all.extend(series(&other).into_iter().map(|each| {
                let name = format!("{}, {baseline}", each.name);
                each.named(name).dashed()
            }));
        }
        all
    }

    /// Returns a slot of the observation, multiplied by a scale.
    fn slot(&self, name: String, color: usize, slot: usize, scale: f64) -> Series {
        self.series(name, color, self.trajectory.observed(slot).map(|value| value * scale).collect())
    }

    fn series(&self, name: String, color: usize, values: Vec<f64>) -> Series {
        self.axis.series(name, color, &values)
    }
}

/// Returns the index of the zone that an actuator belongs to; for an air loop, its first zone.
fn zone_of(building: &PreparedBuilding, owner: Owner) -> usize {
    match owner {
        Owner::Zone(zone) => zone,
        Owner::AirLoop(system) => building.layouts()[system].zones[0].index,
        Owner::Weather | Owner::Calendar | Owner::Energy => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_needs_no_network() {
        assert_eq!(PAGE.matches("{{DATA}}").count(), 1);
        for word in ["http://", "https://", "src=", "@import", "<link"] {
            assert!(![PAGE, OPERATION, TRACKING].iter().any(|part| part.contains(word)), "{word}");
        }
    }
}
