//! A heater, or a zone whose equipment follows the setpoints of its thermostat: the setpoints in use by mode, with
//! optimum start (Guideline 36, 5.3.2 and 5.4.6). The engine's equipment holds them.

use b2b_building::hvac::Actuator;

use super::modes::ZoneGroup;
use super::points::{SiteInput, ZoneInput};
use super::record::Entry;
use super::zone::zone_loops::Reach;
use super::zone::{Zone, ZoneRules};

/// The sequences of a thermostat.
#[derive(Clone, Debug)]
pub(super) struct Thermostat {
    /// Bounds of the heating setpoint.
    heating: [f64; 2],
    /// Bounds of the cooling setpoint; `None` for a heater and a zone that nothing cools.
    cooling: Option<[f64; 2]>,
    group: ZoneGroup,
    zone: Zone,
}

impl Thermostat {
    pub(super) fn new(heating: &Actuator, cooling: Option<&Actuator>, rules: ZoneRules) -> Self {
        let bounds = |actuator: &Actuator| [actuator.low, actuator.high];
        Self {
            heating: bounds(heating),
            cooling: cooling.map(bounds),
            group: ZoneGroup::default(),
            zone: Zone::new(ZoneRules { margins: [0.0; 2], ..rules }),
        }
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
        let setpoints = self.zone.setpoints();
        action[0] = setpoints.heating.clamp(self.heating[0], self.heating[1]);
        if let Some([low, high]) = self.cooling {
            action[1] = setpoints.cooling.clamp(low, high);
        }
    }

    /// Returns the zone, to shift its choices.
    pub(super) fn zone_mut(&mut self) -> &mut Zone {
        &mut self.zone
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
