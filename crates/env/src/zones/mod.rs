//! The controlled zones of an environment.

pub(crate) mod carbon_dioxide;
pub(crate) mod comfort;
pub(crate) mod presence;
pub(crate) mod ventilation;
pub(crate) mod zone_air;

use b2b_building::{Conditioning, PreparedBuilding, people};

use serde::{Deserialize, Serialize};

use crate::Result;

/// Treatment of zones with heating and no cooling in the reward.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HeatingOnlyZones {
    /// Only temperatures below target are penalized, because nothing can cool the zone: a warehouse at 35 °C in summer
    /// is not the agent's fault.
    #[default]
    BelowTarget,
    /// Deviations on both sides are penalized, as in the paper.
    BothSides,
}

/// A controlled zone and how a task rewards it.
#[derive(Clone, Copy, Debug)]
pub struct ControlledZone {
    /// Index of the zone in the building, which is also the slot of its air temperature in the observation.
    pub slot: usize,
    /// Whether temperatures above target are penalized.
    pub penalize_above_target: bool,
    /// Whether the zone has both heating and cooling.
    pub fully_conditioned: bool,
    /// Smallest number of people that makes the zone occupied; with 0, any person does.
    pub least_people: f64,
}

/// Returns the controlled zones of a building in model order. In operation tasks, a zone is occupied while it is [in
/// use](people::least_in_use); in others, while anyone is in it.
///
/// # Errors
/// The errors of [`people::groups`].
pub(crate) fn controlled_zones(
    building: &PreparedBuilding,
    heating_only: HeatingOnlyZones,
    is_operation: bool,
) -> Result<Vec<ControlledZone>> {
    let both_sides = heating_only == HeatingOnlyZones::BothSides;
    let model = building.model();
    let groups = is_operation.then(|| people::groups(model)).transpose()?;
    let zones = building.zones.iter().enumerate();
    let zones = zones.filter(|(_, zone)| zone.conditioning != Conditioning::None).map(|(slot, zone)| {
        let fully_conditioned = zone.conditioning == Conditioning::HeatingAndCooling;
        let penalize_above_target = fully_conditioned || both_sides;
        let in_use =
            groups.as_ref().map(|groups| people::least_in_use(model, groups, &zone.name)).transpose()?;
        let least_people = in_use.unwrap_or(0.0);
        Ok(ControlledZone { slot, penalize_above_target, fully_conditioned, least_people })
    });
    zones.collect()
}
