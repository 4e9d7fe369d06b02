//! The central air loop as a kind of system.

use super::make_controllable;
use super::parts::{AirLoop, Terminal};
use crate::hvac::actuator::Actuator;
use crate::hvac::candidate::Candidate;
use crate::hvac::capacity::{Capacity, Equipment, SystemEquipment};
use crate::hvac::sequence::Sequence;
use crate::hvac::system::{FromModel, KindName, SharedFlow, System, ZoneState};
use crate::hvac::ventilation::Ventilation;
use crate::morphology::universe::NodeType;
use crate::{Model, Result};

/// Temperature deviation that opens a damper by 1 during warm-up, K.
const WARM_UP_BAND: f64 = 2.0;
/// Supply air temperature during warm-up, °C.
const WARM_UP_SUPPLY: f64 = 14.0;
/// Minimum damper opening during warm-up.
const WARM_UP_OPENING: f64 = 0.2;
/// Outdoor air during warm-up, as a fraction of the fan's design flow.
const WARM_UP_OUTDOOR_AIR: f64 = 0.2;

impl System for AirLoop {
    fn name(&self) -> &str {
        &self.name
    }

    fn zones(&self) -> Vec<&str> {
        self.terminals.iter().map(|terminal| terminal.zone.as_str()).collect()
    }

    fn actuators(&self) -> Vec<&Actuator> {
        let terminals = self.terminals.iter().flat_map(|terminal| {
            let Terminal { damper, reheat, .. } = terminal;
            std::iter::once(damper).chain(reheat)
        });
        [&self.supply_temperature, &self.outdoor_air].into_iter().chain(terminals).collect()
    }

    fn zone_of(&self, actuator: usize) -> Option<usize> {
        self.of_terminals().position(|(damper, reheat)| actuator == damper || Some(actuator) == reheat)
    }

    fn node_type(&self, zone: usize) -> NodeType {
        if self.terminals[zone].reheat.is_some() { NodeType::VavZone } else { NodeType::DamperZone }
    }

    fn ventilation(&self) -> Option<&Ventilation> {
        Some(&self.ventilation)
    }

    /// The outdoor air, and the common damper opening that lets it through.
    fn outdoor_air_limits(&self) -> Vec<(usize, f64)> {
        let minimum = self.ventilation.min_outdoor_air.min(self.fan_flow);
        let design: f64 = self.terminals.iter().map(|terminal| terminal.design_flow).sum();
        let opening = (minimum / design).min(1.0);
        let dampers = self.of_terminals().map(|(damper, _)| (damper, opening));
        std::iter::once((Self::OUTDOOR_AIR, minimum)).chain(dampers).collect()
    }

    fn shared_flow(&self) -> Option<SharedFlow> {
        Some(SharedFlow { fan: self.fan_flow, exhaust: self.exhaust_flow })
    }

    fn warm_up(&self, zone: &dyn Fn(usize) -> ZoneState, action: &mut [f64]) {
        action[Self::SUPPLY_TEMPERATURE] = WARM_UP_SUPPLY;
        action[Self::OUTDOOR_AIR] = WARM_UP_OUTDOOR_AIR * self.fan_flow;
        for (terminal, (damper, reheat)) in self.of_terminals().enumerate() {
            let zone = zone(terminal);
            let cooling = (zone.temperature - zone.target) / WARM_UP_BAND;
            action[damper] = (WARM_UP_OPENING + cooling).clamp(WARM_UP_OPENING, 1.0);
            if let Some(reheat) = reheat {
                action[reheat] = zone.target;
            }
        }
    }

    fn sequence(&self) -> Sequence<'_> {
        Sequence::MultipleZones(self)
    }

    fn equipment(&self, model: &Model) -> Result<SystemEquipment> {
        let terminal = |terminal: &Terminal| {
            let heating_capacity = Capacity::of_zone_equipment(model, &terminal.zone)?.heating;
            Ok(Equipment { design_flow: terminal.design_flow, heating_capacity, cooling_capacity: 0.0 })
        };
        Ok(SystemEquipment {
            name: self.name.clone(),
            central: Capacity::of_air_loop(model, &self.name)?.with_flow(self.fan_flow),
            zones: self.terminals.iter().map(terminal).collect::<Result<_>>()?,
        })
    }
}

impl FromModel for AirLoop {
    const NAME: KindName = KindName { id: "air_loop", name: "air loop", plural: "air loops" };

    /// Every air loop without a unit.
    fn claims(_: &Model, candidate: Candidate<'_>) -> Result<bool> {
        Ok(matches!(candidate, Candidate::AirLoop(_)))
    }

    fn make_controllable(model: &mut Model, candidate: Candidate<'_>, air_density: f64) -> Result<Self> {
        make_controllable(model, candidate.air_loop()?, air_density)
    }
}
