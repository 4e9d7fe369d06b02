//! An air handler of several zones with reheat terminals (Guideline 36, 5.6 and 5.16): the sequences of the zones, the
//! terminals and the air handler together.
//!
//! Not representable: static pressure reset, discharge temperatures of terminals, return and relief fans, and the
//! stages of freeze protection that act on coils and dampers of the air handler.

mod economizer;
mod outdoor_air;
mod supply_temperature;
mod terminal;

use b2b_building::hvac;

use super::modes::{Mode, ZoneGroup};
use super::parameters::Guideline36AirLoopParameters;
use super::points::{SiteInput, ZoneInput};
use super::record::Entry;
use super::supervision::Shift;
use super::zone::zone_loops::Reach;
use super::zone::{Zone, ZoneRules};
use economizer::{Economizer, HighLimit};
use outdoor_air::{Air, OutdoorAir};
use supply_temperature::{SupplyTemperature, SupplyTemperatureRules};
use terminal::{TerminalInput, TerminalRules};

/// Highest supply air temperature in cooling where summers are humid (climate zones 0A to 4A), °C.
const HUMID_SUPPLY: f64 = 16.0;

/// The sequences of an air loop.
#[derive(Clone, Debug)]
pub(super) struct AirLoop {
    group: ZoneGroup,
    zones: Vec<ServedZone>,
    supply: SupplyTemperature,
    economizer: Economizer,
    outdoor_air: OutdoorAir,
    /// Supply air temperature setpoint of the last step, °C.
    setpoint: f64,
    requests: f64,
}

/// A zone with its terminal.
#[derive(Clone, Debug)]
struct ServedZone {
    zone: Zone,
    terminal: TerminalRules,
    /// Number of the actuator of its damper.
    damper: usize,
    /// Number of the actuator of its reheat setpoint, and the setpoint at which the coil is off, °C.
    coil: Option<(usize, f64)>,
    /// Design flow, kg/s.
    design_flow: f64,
}

/// Air that the terminals let through.
#[derive(Clone, Copy, Debug)]
struct Flow {
    /// Supply flow, kg/s.
    total: f64,
    /// Temperature of the return air, °C.
    return_air: f64,
    /// The largest need of a zone for heat, 0 to 1.
    need: f64,
}

impl AirLoop {
    pub(super) fn new(
        air_loop: &hvac::AirLoop,
        parameters: &Guideline36AirLoopParameters,
        rules: ZoneRules,
        climate_zone: Option<&str>,
    ) -> Self {
        let system: &dyn hvac::System = air_loop;
        let limit = |actuator| {
            let limits = system.outdoor_air_limits().into_iter();
            limits.filter(|(index, _)| *index == actuator).map(|(_, limit)| limit).fold(0.0, f64::max)
        };
        let rules = ZoneRules { margins: [parameters.heating_margin, parameters.cooling_margin], ..rules };
        let zones = air_loop.terminals.iter().zip(air_loop.of_terminals());
        let zones = zones.map(|(terminal, (damper, reheat))| ServedZone {
            zone: Zone::new(rules),
            terminal: TerminalRules {
                minimum: limit(damper).max(parameters.min_flow),
                heating_max: parameters.heating_flow.min(terminal.heating_opening),
                coil: terminal.reheat.as_ref().map(|coil| [coil.low, coil.high]),
            },
            damper,
            coil: reheat.zip(terminal.reheat.as_ref().map(|coil| coil.low)),
            design_flow: terminal.design_flow,
        });
        let limit_of_zone = HighLimit::of_zone(climate_zone);
        let humid = limit_of_zone == HighLimit::of_zone(Some("4A"));
        let highest = parameters.max_supply_temperature.min(if humid { HUMID_SUPPLY } else { f64::INFINITY });
        Self {
            group: ZoneGroup::default(),
            zones: zones.collect(),
            supply: SupplyTemperature::new(SupplyTemperatureRules {
                cooling: [parameters.min_supply_temperature, highest.max(parameters.min_supply_temperature)],
                trim_respond: parameters.trim_respond,
                resets: parameters.supply_temperature_reset >= 0.5,
                reach: [air_loop.supply_temperature.low, air_loop.supply_temperature.high],
            }),
            economizer: Economizer::new(limit_of_zone),
            outdoor_air: OutdoorAir {
                minimum: limit(hvac::AirLoop::OUTDOOR_AIR),
                fan_rise: parameters.fan_rise,
                fan_flow: air_loop.fan_flow,
            },
            setpoint: highest,
            requests: 0.0,
        }
    }

    /// Forgets everything.
    pub(super) fn reset(&mut self) {
        self.group = ZoneGroup::default();
        self.supply.restart();
        self.economizer.reset();
        self.zones.iter_mut().for_each(|served| served.zone.reset());
    }

    /// Writes the action of a step.
    pub(super) fn act<'z>(
        &mut self,
        site: SiteInput,
        inputs: impl Iterator<Item = &'z ZoneInput>,
        action: &mut [f64],
        hours: f64,
    ) {
        for (served, input) in self.zones.iter_mut().zip(inputs) {
            served.zone.observe(input, site, hours);
        }
        let heated = self.group.mode().heats();
        let mode = self.group.step(self.zones.iter().map(|served| served.zone.need()));
        self.requests = 0.0;
        for served in &mut self.zones {
            if mode.heats() != heated {
                served.zone.forget_heating();
            }
            served.zone.control(mode, [Reach::up_to(1.0); 2], hours);
            self.requests += served.zone.cooling_requests();
        }
        let cools = self.zones.iter().any(|served| served.zone.outputs().cooling > 0.0);
        self.setpoint =
            self.supply.step(mode, cools.then_some(site.outdoor_temperature), self.requests, hours);
        let Flow { total: flow, return_air, need } = self.command_terminals(mode, action);
        let outdoor = site.outdoor_temperature;
        let air = Air { flow, supply: self.setpoint, return_air, outdoor, economizes: false };
        if flow > 0.0 && !mode.heats() {
            let idle = self.supply.at_most(self.setpoint, self.outdoor_air.untempered(mode, air));
            self.setpoint = idle + need * (self.setpoint - idle);
        }
        action[hvac::AirLoop::SUPPLY_TEMPERATURE] = self.setpoint;
        let cools = !mode.heats() && flow > 0.0;
        let economizes = self.economizer.step(cools, outdoor, return_air, hours);
        let air = Air { supply: self.setpoint, economizes, ..air };
        action[hvac::AirLoop::OUTDOOR_AIR] = self.outdoor_air.step(mode, air);
    }

    /// Writes the commands of the terminals.
    fn command_terminals(&self, mode: Mode, action: &mut [f64]) -> Flow {
        let (mut flow, mut heat, mut mean, mut most) = (0.0, 0.0, 0.0, 0.0_f64);
        for served in &self.zones {
            let need = served.zone.need();
            let command = served.terminal.step(TerminalInput {
                mode,
                outputs: served.zone.outputs(),
                may_heat: mode.allows(need.calls)[0],
                temperature: need.temperature,
                heating_aim: served.zone.aims().heating,
                supply: self.setpoint,
            });
            action[served.damper] = command.opening;
            if let Some((coil, off)) = served.coil {
                action[coil] = command.heat.unwrap_or(off);
            }
            let own = command.opening * served.design_flow;
            flow += own;
            heat += own * need.temperature;
            most = most.max(command.needs_heat(need.temperature));
            mean += need.temperature / self.zones.len() as f64;
        }
        if flow > 0.0 {
            let total = flow.min(self.outdoor_air.fan_flow);
            Flow { total, return_air: heat / flow, need: most }
        } else {
            Flow { total: 0.0, return_air: mean, need: most }
        }
    }

    /// Returns whether a shift moves a choice of the air handler.
    pub(super) fn follows(&self, shift: Shift) -> bool {
        shift != Shift::EconomizerLimit || self.economizer.has_fixed_limit()
    }

    /// Shifts a choice of the air handler.
    pub(super) fn shift(&mut self, shift: Shift, value: f64) {
        match shift {
            Shift::SupplyTemperature => self.supply.shift(value),
            Shift::EconomizerLimit => self.economizer.shift(value),
            _ => (),
        }
    }

    /// Returns a zone by its number, to shift its choices.
    pub(super) fn zone_mut(&mut self, zone: usize) -> &mut Zone {
        &mut self.zones[zone].zone
    }

    /// Returns the zones, in order.
    pub(super) fn zones(&self) -> impl Iterator<Item = &Zone> {
        self.zones.iter().map(|served| &served.zone)
    }

    /// Returns the values of an entry of the record.
    pub(super) fn value(&self, entry: Entry) -> f64 {
        match entry {
            Entry::Mode => self.group.mode().number(),
            Entry::SupplyTemperature => self.setpoint,
            Entry::HighestSupplyTemperature => self.supply.highest(),
            Entry::Requests => self.requests,
            Entry::Economizer => f64::from(u8::from(self.economizer.is_enabled())),
            Entry::MinimumOutdoorAir => self.outdoor_air.minimum(self.group.mode()),
        }
    }
}
