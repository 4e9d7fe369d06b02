//! A simulation in progress with its handles.

use std::path::Path;

use b2b_building::hvac::{self, EngineVariable};
use b2b_building::people::PeopleGroup;
use b2b_building::{Carrier, CarrierEnergy, EndUse, EndUseEnergy, HvacMeter, OutdoorAir, PreparedBuilding};
use b2b_energyplus::{Actuator, Library, Meter, Run, Simulation, Variable};

use super::meters::{by_carrier, per_area};
use crate::Result;
use crate::spaces::Spaces;
use crate::zones::ControlledZone;
use crate::zones::presence::Attendance;

pub(super) const ZONE_TEMPERATURE: &str = "Zone Mean Air Temperature";
pub(super) const OUTDOOR: [&str; 2] =
    ["Site Outdoor Air Drybulb Temperature", "Site Outdoor Air Relative Humidity"];
const SITE: &str = "Environment";
const PEOPLE: &str = "Zone People Occupant Count";
const SCHEDULE: &str = "Schedule Value";
const PEOPLE_ACTUATOR: [&str; 2] = ["People", "Number of People"];

/// Density of standard air, kg/m³ (ASHRAE Fundamentals), for volume flows in reports.
const STANDARD_AIR: f64 = 1.204;

/// The outdoor air of a system.
#[derive(Debug)]
struct Ventilated {
    /// Its zones, as indices of controlled zones.
    zones: Vec<usize>,
    /// Mass flow of its outdoor air, kg/s.
    outdoor_air: Variable,
    /// Schedule of the damper of a unit: 1 is open to the design minimum, 0 closed.
    damper: Option<Actuator>,
}

/// A simulation in progress with the handles that are read and set.
#[derive(Debug)]
pub(super) struct Engine {
    pub(super) simulation: Simulation,
    pub(super) temperatures: Vec<Variable>,
    /// Quantities of zone air besides the temperature, in the order of their slots.
    pub(super) air: Vec<Variable>,
    pub(super) outdoor: [Variable; 2],
    /// People in each controlled zone; `None` where the model never has any.
    pub(super) people: Vec<Option<Variable>>,
    /// Number of identical zones that each of them stands for.
    multipliers: Vec<f64>,
    /// Least number of people with which each of them is occupied.
    least_people: Vec<f64>,
    /// The building's meters that the engine has.
    meters: Vec<(Carrier, Meter)>,
    /// The end-use meters of these carriers that the engine has.
    end_uses: Vec<(Carrier, EndUse, Meter)>,
    /// Electricity of fans that the fan meter includes but that are not part of the HVAC, J.
    fans_outside: Vec<Variable>,
    actuators: Vec<(Actuator, f64)>,
    /// Schedule and number of people of each group with random presence.
    groups: Vec<(Variable, Actuator)>,
    /// Outdoor air of each system, if it has any.
    ventilated: Vec<Option<Ventilated>>,
    /// Quantities driven by the actuators, if observed.
    pub(super) effects: Vec<Variable>,
    /// Heating or cooling rates under setpoints, if observed.
    pub(super) heats: Vec<Option<Variable>>,
}

/// The parts of the engine that an episode reads and sets.
struct Points<'a> {
    building: &'a PreparedBuilding,
    zones: &'a [ControlledZone],
    /// Variables of the air of controlled zones besides the temperature.
    air: Vec<&'static str>,
    groups: Vec<&'a PeopleGroup>,
    fans_outside: Vec<EngineVariable>,
    /// Actuators whose effects are observed.
    observed: Vec<&'a hvac::Actuator>,
}

impl<'a> Points<'a> {
    fn new(
        spaces: &'a Spaces,
        zones: &'a [ControlledZone],
        attendance: Option<&'a Attendance>,
        observe_effects: bool,
    ) -> Self {
        let building = &*spaces.building;
        Self {
            building,
            zones,
            air: spaces.observation.air().iter().map(|quantity| quantity.slot().variable).collect(),
            groups: attendance.into_iter().flat_map(Attendance::groups).collect(),
            fans_outside: building.fans_outside().collect(),
            observed: building.actuators().filter(|_| observe_effects).collect(),
        }
    }

    /// Names of the controlled zones.
    fn controlled(&self) -> impl Iterator<Item = &'a str> {
        let building = self.building;
        self.zones.iter().map(|zone| building.zones[zone.slot].name.as_str())
    }

    /// Requests the variables from a run.
    fn request(&self, mut run: Run) -> Run {
        for zone in &self.building.zones {
            run = run.request(ZONE_TEMPERATURE, &zone.name);
        }
        for name in OUTDOOR {
            run = run.request(name, SITE);
        }
        for name in self.controlled() {
            run =
                self.air.iter().fold(run.request(PEOPLE, name), |run, variable| run.request(*variable, name));
        }
        for group in &self.groups {
            run = run.request(SCHEDULE, &group.schedule);
        }
        for OutdoorAir { ventilation, .. } in self.building.outdoor_air().flatten() {
            let variable = &ventilation.outdoor_air;
            run = run.request(&variable.name, &variable.key);
        }
        for fan in &self.fans_outside {
            run = run.request(&fan.name, &fan.key);
        }
        for variable in self.observed.iter().flat_map(|a| [Some(&a.effect), a.heat.as_ref()]).flatten() {
            run = run.request(&variable.name, &variable.key);
        }
        run
    }
}

fn variable(simulation: &Simulation, variable: &EngineVariable) -> Result<Variable> {
    Ok(simulation.variable(&variable.name, &variable.key)?)
}

impl Ventilated {
    fn new(simulation: &Simulation, air: OutdoorAir) -> Result<Self> {
        let OutdoorAir { ventilation, zones } = air;
        let damper = ventilation.damper.as_ref();
        let damper = damper.map(|d| simulation.actuator(&d.component, &d.control, &d.key)).transpose()?;
        Ok(Self { zones, outdoor_air: variable(simulation, &ventilation.outdoor_air)?, damper })
    }
}

/// Returns the handles of the end-use meters that the engine has.
fn end_use_meters(simulation: &Simulation, meter: &HvacMeter) -> Vec<(Carrier, EndUse, Meter)> {
    let named = meter.end_uses().into_iter();
    named
        .filter_map(|(end_use, name)| Some((meter.carrier, end_use, simulation.meter(&name).ok()?)))
        .collect()
}

impl Engine {
    pub(super) fn start(
        library: &Library,
        spaces: &Spaces,
        zones: &[ControlledZone],
        model: &Path,
        attendance: Option<&Attendance>,
        observe_effects: bool,
    ) -> Result<Self> {
        let points = Points::new(spaces, zones, attendance, observe_effects);
        let folder = model.parent().unwrap_or(Path::new("."));
        let run = Run::new(model, &spaces.episode.weather).output(folder).yield_in_warmup();
        Self::with_handles(points.request(run).start(library)?, &points)
    }

    fn with_handles(simulation: Simulation, points: &Points<'_>) -> Result<Self> {
        let Points { building, zones, air, groups, fans_outside, observed } = points;
        let of = |name: &str, key: &str| simulation.variable(name, key);
        let ventilated =
            |air: Option<OutdoorAir>| air.map(|air| Ventilated::new(&simulation, air)).transpose();
        let actuator =
            |a: &hvac::Actuator| Ok((simulation.actuator(&a.component, &a.control, &a.key)?, a.scale));
        let meter = |m: &HvacMeter| Some((m.carrier, simulation.meter(&m.name).ok()?));
        let handles = |group: &&PeopleGroup| {
            let [component, control] = PEOPLE_ACTUATOR;
            let schedule = of(SCHEDULE, &group.schedule)?;
            Ok((schedule, simulation.actuator(component, control, &group.name)?))
        };
        let ventilated = building.outdoor_air().map(ventilated).collect::<Result<_>>()?;
        let temperatures = building.zones.iter().map(|zone| Ok(of(ZONE_TEMPERATURE, &zone.name)?));
        let of_air = points.controlled().flat_map(|name| air.iter().map(move |variable| (*variable, name)));
        Ok(Self {
            ventilated,
            temperatures: temperatures.collect::<Result<_>>()?,
            air: of_air.map(|(variable, name)| Ok(of(variable, name)?)).collect::<Result<_>>()?,
            outdoor: [of(OUTDOOR[0], SITE)?, of(OUTDOOR[1], SITE)?],
            // The engine has this variable only for zones with people.
            people: points.controlled().map(|name| of(PEOPLE, name).ok()).collect(),
            multipliers: building.controlled_zones().map(|zone| zone.multiplier).collect(),
            least_people: zones.iter().map(|zone| zone.least_people).collect(),
            meters: building.meters.iter().filter_map(meter).collect(),
            end_uses: building.meters.iter().flat_map(|meter| end_use_meters(&simulation, meter)).collect(),
            fans_outside: fans_outside.iter().filter_map(|fan| of(&fan.name, &fan.key).ok()).collect(),
            actuators: building.actuators().map(actuator).collect::<Result<_>>()?,
            groups: groups.iter().map(handles).collect::<Result<_>>()?,
            effects: observed.iter().map(|a| variable(&simulation, &a.effect)).collect::<Result<_>>()?,
            heats: observed
                .iter()
                .map(|a| a.heat.as_ref().map(|heat| variable(&simulation, heat)).transpose())
                .collect::<Result<_>>()?,
            simulation,
        })
    }

    pub(super) fn act(&mut self, action: &[f64]) {
        for ((actuator, scale), value) in self.actuators.iter().zip(action) {
            self.simulation.set(*actuator, value * scale);
        }
    }

    /// Sets the number of people of every group for the next step.
    pub(super) fn admit(&mut self, attendance: &mut Attendance) {
        for (number, (schedule, people)) in self.groups.iter().enumerate() {
            let scheduled = self.simulation.read(*schedule);
            self.simulation.set(*people, attendance.draw(number, scheduled));
        }
    }

    /// Opens the outdoor air dampers of units with an occupied zone to the design minimum, and closes the others.
    pub(super) fn open_dampers(&mut self) {
        for index in 0..self.ventilated.len() {
            let Some(Ventilated { zones, damper: Some(damper), .. }) = &self.ventilated[index] else {
                continue;
            };
            let (open, damper) = (zones.iter().any(|&zone| self.occupied(zone)), *damper);
            self.simulation.set(damper, f64::from(u8::from(open)));
        }
    }

    /// Returns whether a controlled zone is occupied.
    pub(super) fn occupied(&self, controlled_zone: usize) -> bool {
        let people = self.people(controlled_zone);
        people > 0.0 && people >= self.least_people[controlled_zone]
    }

    fn people(&self, controlled_zone: usize) -> f64 {
        self.people[controlled_zone].map_or(0.0, |people| self.simulation.read(people))
    }

    /// Returns the outdoor air (L/s of standard air) and the number of people, over the systems with people in their
    /// zones.
    pub(super) fn outdoor_air(&self) -> [f64; 2] {
        let occupied = self.ventilated.iter().flatten().map(|air| self.flow_and_people(air));
        let add = |sum: [f64; 2], [flow, people]: [f64; 2]| match people > 0.0 {
            true => [sum[0] + flow / STANDARD_AIR * 1000.0, sum[1] + people],
            false => sum,
        };
        occupied.fold([0.0; 2], add)
    }

    /// Returns the outdoor air of each system, kg/s, with the people in its zones.
    pub(super) fn outdoor_air_by_system(&self) -> Vec<Option<[f64; 2]>> {
        self.ventilated.iter().map(|air| air.as_ref().map(|air| self.flow_and_people(air))).collect()
    }

    fn flow_and_people(&self, system: &Ventilated) -> [f64; 2] {
        // The engine counts the people of one zone, and the air of all identical ones.
        let people = system.zones.iter().map(|&zone| self.people(zone) * self.multipliers[zone]).sum();
        [self.simulation.read(system.outdoor_air), people]
    }

    /// HVAC energy of the step, Wh/m².
    pub(super) fn energy(&self, floor_area: f64) -> CarrierEnergy {
        let read = |&(carrier, meter)| (carrier, self.simulation.read_meter(meter));
        by_carrier(self.meters.iter().map(read), floor_area)
    }

    /// HVAC energy of the step by end use and by carrier, Wh/m². Unlike [`Engine::energy`], it excludes the losses of a
    /// building's transformer.
    pub(super) fn end_uses(&self, floor_area: f64) -> (EndUseEnergy, CarrierEnergy) {
        let (mut by_end_use, mut by_carrier) = (EndUseEnergy::default(), CarrierEnergy::default());
        let metered = self.end_uses.iter();
        let metered =
            metered.map(|&(carrier, end_use, meter)| (carrier, end_use, self.simulation.read_meter(meter)));
        let outside = self.fans_outside.iter();
        let outside = outside.map(|fan| (Carrier::Electricity, EndUse::Fans, -self.simulation.read(*fan)));
        for (carrier, end_use, joules) in metered.chain(outside) {
            let energy = per_area(joules, floor_area);
            by_end_use[end_use as usize] += energy;
            by_carrier[carrier as usize] += energy;
        }
        (by_end_use, by_carrier)
    }
}
