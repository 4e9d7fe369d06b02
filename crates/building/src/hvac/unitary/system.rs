//! The unitary system as a kind of system.

use serde::{Deserialize, Serialize};

use super::{Packaged, has_unit, make_controllable};
use crate::hvac::actuator::Actuator;
use crate::hvac::candidate::Candidate;
use crate::hvac::capacity::{Capacity, Equipment, SystemEquipment, air_loop_of};
use crate::hvac::sequence::Sequence;
use crate::hvac::system::{FromModel, KindName, System, ZoneState};
use crate::hvac::ventilation::Ventilation;
use crate::morphology::universe::NodeType;
use crate::{Model, Result};

/// Temperature deviation at full command during warm-up, K. At half of this, kitchens, whose supply is a large share of
/// their air, oscillate in cold climates, and warm-up does not converge.
const WARM_UP_BAND: f64 = 4.0;
/// Minimum flow during warm-up, as a fraction of the design flow.
const WARM_UP_FLOW: f64 = 0.3;
/// Supply air temperature above target at full heating during warm-up, K.
const WARM_UP_LIFT: f64 = 20.0;
/// Supply air temperature below target at full cooling during warm-up, K.
const WARM_UP_DROP: f64 = 8.0;

/// A zone that shares the air of a unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Follower {
    /// The zone.
    pub zone: String,
    /// Design flow of its terminal, kg/s.
    pub design_flow: f64,
}

/// A unitary system.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Unitary {
    /// Zone whose thermostat controls it.
    pub zone: String,
    /// Other zones that it serves.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub followers: Vec<Follower>,
    /// [`Quantity::SupplyAirFlow`](crate::hvac::Quantity::SupplyAirFlow), of all zones together.
    pub flow: Actuator,
    /// [`Quantity::SupplyAirTemperature`](crate::hvac::Quantity::SupplyAirTemperature).
    pub supply_temperature: Actuator,
    /// Its outdoor air; `None` for a unit without any.
    pub ventilation: Option<Ventilation>,
    /// Properties of the unit that rule-based controllers use.
    pub packaged: Packaged,
}

impl Unitary {
    /// Number of the actuator of the supply air flow.
    pub const FLOW: usize = 0;
    /// Number of the actuator of the supply air temperature.
    pub const SUPPLY_TEMPERATURE: usize = 1;
}

impl System for Unitary {
    fn name(&self) -> &str {
        &self.zone
    }

    fn zones(&self) -> Vec<&str> {
        std::iter::once(&self.zone)
            .chain(self.followers.iter().map(|f| &f.zone))
            .map(String::as_str)
            .collect()
    }

    fn zones_with_loops(&self) -> usize {
        1
    }

    fn actuators(&self) -> Vec<&Actuator> {
        vec![&self.flow, &self.supply_temperature]
    }

    fn node_type(&self, zone: usize) -> NodeType {
        if zone == 0 { NodeType::UnitaryZone } else { NodeType::FollowingZone }
    }

    fn ventilation(&self) -> Option<&Ventilation> {
        self.ventilation.as_ref()
    }

    fn outdoor_air_limits(&self) -> Vec<(usize, f64)> {
        let minimum = self.ventilation.as_ref().map(|air| air.min_outdoor_air);
        minimum.map(|minimum| (Self::FLOW, minimum.min(self.flow.high))).into_iter().collect()
    }

    fn warm_up(&self, zone: &dyn Fn(usize) -> ZoneState, action: &mut [f64]) {
        let zone = zone(0);
        let demand = ((zone.target - zone.temperature) / WARM_UP_BAND).clamp(-1.0, 1.0);
        action[Self::FLOW] = self.flow.high * (WARM_UP_FLOW + (1.0 - WARM_UP_FLOW) * demand.abs());
        action[Self::SUPPLY_TEMPERATURE] =
            zone.target + demand * if demand > 0.0 { WARM_UP_LIFT } else { WARM_UP_DROP };
    }

    fn sequence(&self) -> Sequence<'_> {
        let Self { flow, supply_temperature, packaged, .. } = self;
        Sequence::SingleZone { flow, supply_temperature, packaged: *packaged }
    }

    fn equipment(&self, model: &Model) -> Result<SystemEquipment> {
        let name = air_loop_of(model, &self.zone)?.unwrap_or_else(|| self.zone.clone());
        let unit = Capacity::of_air_loop(model, &name)?.with_flow(self.flow.high.max(0.0));
        let of_follower = |f: &Follower| Equipment { design_flow: f.design_flow, ..Equipment::default() };
        let mut equipment = SystemEquipment::of_one(&name, unit);
        equipment.zones.extend(self.followers.iter().map(of_follower));
        Ok(equipment)
    }
}

impl FromModel for Unitary {
    const NAME: KindName = KindName { id: "unitary", name: "unitary", plural: "unitary" };

    fn claims(model: &Model, candidate: Candidate<'_>) -> Result<bool> {
        match candidate {
            Candidate::AirLoop(air_loop) => has_unit(model, air_loop),
            Candidate::Equipment { .. } | Candidate::Zone(_) => Ok(false),
        }
    }

    fn make_controllable(model: &mut Model, candidate: Candidate<'_>, air_density: f64) -> Result<Self> {
        make_controllable(model, candidate.air_loop()?, air_density)
    }
}
