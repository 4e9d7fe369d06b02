//! A zone heater under a thermostat: the heating setpoint in use, with optimum start (Guideline 36, 5.3.2 and 5.4.6). The
//! thermostat of the engine holds it.

use b2b_building::hvac::Actuator;

use super::modes::ZoneGroup;
use super::points::{SiteInput, ZoneInput};
use super::record::Entry;
use super::zone::zone_loops::Reach;
use super::zone::{Zone, ZoneRules};

/// The sequences of a heater.
#[derive(Clone, Debug)]
pub(super) struct Heater {
    bounds: [f64; 2],
    group: ZoneGroup,
    zone: Zone,
}

impl Heater {
    pub(super) fn new(setpoint: &Actuator, rules: ZoneRules) -> Self {
        let rules = ZoneRules { margins: [0.0; 2], ..rules };
        Self { bounds: [setpoint.low, setpoint.high], group: ZoneGroup::default(), zone: Zone::new(rules) }
    }

    /// Forgets everything.
    pub(super) fn reset(&mut self) {
        self.group = ZoneGroup::default();
        self.zone.reset();
    }

    /// Writes the action of a step.
    pub(super) fn act(&mut self, site: SiteInput, input: &ZoneInput, action: &mut [f64], hours: f64) {
        let need = self.zone.observe(input, site, hours);
        let mode = self.group.step(std::iter::once(need));
        self.zone.control(mode, [Reach::up_to(1.0); 2], hours);
        action[0] = self.zone.setpoints().heating.clamp(self.bounds[0], self.bounds[1]);
    }

    /// Returns the zone.
    pub(super) fn zone(&self) -> &Zone {
        &self.zone
    }

    /// Returns the value of an entry of the record.
    pub(super) fn value(&self, entry: Entry) -> f64 {
        match entry {
            Entry::Mode => self.group.mode().number(),
            _ => 0.0,
        }
    }
}
