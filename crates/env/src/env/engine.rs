//! A simulation in progress with its handles.

use std::path::Path;

use b2b_building::PreparedBuilding;
use b2b_building::hvac::EngineVariable;
use b2b_energyplus::{Actuator, Library, Meter, Run, Simulation, Variable};

use super::meters::{JOULES_PER_WATT_HOUR, METERS};
use crate::Result;
use crate::zones::ControlledZone;

const ZONE_TEMPERATURE: &str = "Zone Mean Air Temperature";
const OUTDOOR: [&str; 2] = ["Site Outdoor Air Drybulb Temperature", "Site Outdoor Air Relative Humidity"];
const SITE: &str = "Environment";
const PEOPLE: &str = "Zone People Occupant Count";

/// A simulation in progress with the handles of what is read and set in it.
#[derive(Debug)]
pub(super) struct Engine {
    pub(super) simulation: Simulation,
    pub(super) temperatures: Vec<Variable>,
    pub(super) outdoor: [Variable; 2],
    /// People in each controlled zone; `None` where the model never has any.
    pub(super) people: Vec<Option<Variable>>,
    meters: [Option<Meter>; 2],
    actuators: Vec<(Actuator, f64)>,
    /// What the actuators drive, if it is observed.
    pub(super) effects: Vec<Variable>,
    /// The heat that heating setpoints call for, if it is observed.
    pub(super) heats: Vec<Option<Variable>>,
}

impl Engine {
    pub(super) fn start(
        library: &Library,
        building: &PreparedBuilding,
        zones: &[ControlledZone],
        model: &Path,
        weather: &Path,
        observe_effects: bool,
    ) -> Result<Self> {
        let folder = model.parent().unwrap_or(Path::new("."));
        let mut run = Run::new(model, weather).output(folder).yield_in_warmup();
        for zone in &building.zones {
            run = run.request(ZONE_TEMPERATURE, &zone.name);
        }
        for name in OUTDOOR {
            run = run.request(name, SITE);
        }
        let controlled = || zones.iter().map(|zone| building.zones[zone.slot].name.as_str());
        for name in controlled() {
            run = run.request(PEOPLE, name);
        }
        let observed: Vec<_> = building.actuators().filter(|_| observe_effects).collect();
        for variable in observed.iter().flat_map(|a| [Some(&a.effect), a.heat.as_ref()]).flatten() {
            run = run.request(&variable.name, &variable.key);
        }
        let simulation = run.start(library)?;
        let actuator = |a: &b2b_building::hvac::Actuator| {
            Ok((simulation.actuator(&a.component, &a.control, &a.key)?, a.scale))
        };
        let variable = |v: &EngineVariable| Ok(simulation.variable(&v.name, &v.key)?);
        Ok(Self {
            temperatures: building
                .zones
                .iter()
                .map(|zone| simulation.variable(ZONE_TEMPERATURE, &zone.name))
                .collect::<std::result::Result<_, _>>()?,
            outdoor: [simulation.variable(OUTDOOR[0], SITE)?, simulation.variable(OUTDOOR[1], SITE)?],
            // The engine has the variable for zones with people alone.
            people: controlled().map(|name| simulation.variable(PEOPLE, name).ok()).collect(),
            meters: METERS.map(|meter| simulation.meter(meter).ok()),
            actuators: building.actuators().map(actuator).collect::<Result<_>>()?,
            effects: observed.iter().map(|a| variable(&a.effect)).collect::<Result<_>>()?,
            heats: observed
                .iter()
                .map(|a| a.heat.as_ref().map(variable).transpose())
                .collect::<Result<_>>()?,
            simulation,
        })
    }

    pub(super) fn act(&mut self, action: &[f64]) {
        for ((actuator, scale), value) in self.actuators.iter().zip(action) {
            self.simulation.set(*actuator, value * scale);
        }
    }

    /// Whether a controlled zone is occupied.
    pub(super) fn occupied(&self, controlled_zone: usize) -> bool {
        self.people[controlled_zone].is_some_and(|people| self.simulation.read(people) > 0.0)
    }

    /// HVAC energy of the step by fuel, Wh/m².
    pub(super) fn energy(&self, floor_area: f64) -> [f64; 2] {
        self.meters.map(|meter| {
            meter.map_or(0.0, |m| self.simulation.read_meter(m)) / JOULES_PER_WATT_HOUR / floor_area
        })
    }
}
