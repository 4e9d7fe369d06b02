//! A unit of a single zone (Guideline 36, 5.18.4 for air handlers, 5.22 for fan coils): staging of supply air
//! temperature and flow.
//!
//! A loop output asks for a share of the unit's capacity. Capacity is staged: the supply air temperature at minimum
//! flow, then the flow, then the supply air temperature to its limit. The guideline gives every stage a fixed share of
//! the loop; here the shares follow from the capacities, so that the loop has the same gain everywhere. Its second
//! heating stage is flow: a heat pump is more efficient with more air of a lower temperature, and supplemental heat
//! starts only when the supply air must be hotter than the compressor can make it. That last stage, which the guideline
//! does not have, is for the cold climates that it is not written for. Optimum start is limited to what the compressor
//! gives, or to the stages before the last, and begins earlier instead: recovery by supplemental heat takes three times
//! the energy.
//!
//! With an economizer and outdoor air cool enough, cooling raises the flow of outdoor air (MedSpeed) ahead of the coil.
//!
//! While people are present, the fan of a unit with outdoor air runs at the flow that brings it in. Between the loops
//! both coils are off: the setpoint is the temperature that the mixed air has. The loops begin there, so that outdoor
//! air is heated or cooled only as far as the zone needs it, and a coil never works against its loop. (The guideline
//! holds supply air of 21 to 24 °C between the loops.) Where outdoor air would make the supply air colder than 10 °C,
//! the fan recirculates more, up to half of its design flow, before the coil tempers it. Without outdoor air or without
//! people, the fan is off between the loops (DeadbandSpeed 0).
//!
//! In a room with exhaust fans, the unit supplies what they take while its fan runs in cold weather: the rest would
//! infiltrate. Whether they run is not known. They draw outdoor air even through a closed damper; it must not be heated
//! while the zone cools.

mod staging;
#[cfg(test)]
mod tests;

use b2b_building::hvac::{Actuator, HeatPump, Packaged};

use super::modes::{Mode, ZoneGroup};
use super::parameters::Guideline36UnitaryParameters;
use super::points::{SiteInput, ZoneInput};
use super::record::Entry;
use super::supervision::Shift;
use super::zone::zone_loops::Reach;
use super::zone::{Zone, ZoneRules};
use staging::{Stage, staged};

/// Temperature rise across the fan at its design flow, K.
const FAN_RISE: f64 = 0.8;
/// Highest outdoor temperature for economizing in humid and in other climates, °C (MaxDPT).
const ECONOMIZER_LIMIT: [f64; 2] = [17.0, 24.0];
/// Outdoor temperatures relative to the zone at which MedSpeed is lowest and highest, K.
const MEDIUM: [f64; 2] = [0.5, -6.0];

/// Outdoor temperature at which heat pumps are rated, °C (AHRI 210/240).
const RATED_OUTDOOR: f64 = 8.3;
/// Change of a compressor's heating capacity with the outdoor temperature, 1/K, in the engine's example curves.
const COMPRESSOR_SLOPE: f64 = 0.027;
/// Lowest temperature of supply air that no coil tempers, °C (5.6.5).
const LEAST_SUPPLY: f64 = 10.0;
/// Largest flow of recirculation ahead of tempering, as a share of the design flow.
const RECIRCULATION: f64 = 0.5;
/// Outdoor temperatures between which the unit makes up for none and for all of the exhaust, °C. In warm weather, air
/// that infiltrates takes less energy than a faster fan.
const MAKE_UP: [f64; 2] = [15.0, 10.0];
/// Minimum flow of a running fan, as a share of the design flow.
const LEAST_FLOW: f64 = 0.05;
/// Lowest limit of the heating loop.
const LEAST_LIMIT: f64 = 0.1;

/// Number of the action of the supply air flow.
const FLOW: usize = 0;
/// Number of the action of the supply air temperature.
const SUPPLY_TEMPERATURE: usize = 1;

/// Largest gain of the heating loop for a design flow of 1 kg/s per square meter of floor, kg/(s m² K). The air of a
/// dining room is replaced in 4 min by the flow of its unit, and follows the supply air within a step: at 0.25/K,
/// heating and cooling at full capacity alternate.
const STABLE_GAIN: f64 = 0.0017;
/// Largest gain of the cooling loop over the largest of the heating loop: full cooling is less than full heating by
/// about this factor.
const COOLING_SHARE: f64 = 1.7;

/// A unit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Unit {
    /// Floor area of its zone, m².
    pub(super) floor_area: f64,
    /// Design flow, kg/s.
    pub(super) design_flow: f64,
    /// Design minimum of outdoor air, kg/s, at most the design flow.
    pub(super) outdoor_air: f64,
    /// Design flow of exhaust fans in its zone, kg/s, at most the design flow.
    pub(super) exhaust: f64,
    /// Bounds of the supply air temperature, °C.
    pub(super) supply: [f64; 2],
    /// Highest outdoor temperature for economizing, °C; none without an economizer.
    pub(super) economizer: Option<f64>,
    /// Its compressor, if that heats.
    pub(super) heat_pump: Option<HeatPump>,
}

impl Unit {
    pub(super) fn new(
        [flow, supply_temperature]: [&Actuator; 2],
        floor_area: f64,
        outdoor_air: f64,
        packaged: Packaged,
        climate_zone: Option<&str>,
    ) -> Self {
        let humid = climate_zone.is_some_and(|zone| zone.ends_with('A'));
        Self {
            floor_area,
            design_flow: flow.high,
            outdoor_air: outdoor_air.clamp(0.0, flow.high),
            exhaust: packaged.exhaust.clamp(0.0, flow.high),
            supply: [supply_temperature.low, supply_temperature.high],
            heat_pump: packaged.heat_pump,
            economizer: packaged.economizer.then_some(ECONOMIZER_LIMIT[usize::from(!humid)]),
        }
    }
}

/// The sequences of a unit.
#[derive(Clone, Debug)]
pub(super) struct SingleZone {
    unit: Unit,
    parameters: Guideline36UnitaryParameters,
    group: ZoneGroup,
    zone: Zone,
    setpoint: f64,
    shifts: UnitShifts,
}

/// Shifts of the parameters ([`Shift`]).
#[derive(Clone, Copy, Debug, Default)]
struct UnitShifts {
    minimum_flow: f64,
    heating_temperature: f64,
    cooling_temperature: f64,
}

impl SingleZone {
    pub(super) fn new(unit: Unit, parameters: &Guideline36UnitaryParameters, rules: ZoneRules) -> Self {
        let [heating, cooling] = rules.gains;
        let stable = STABLE_GAIN * unit.floor_area / unit.design_flow;
        let gains = [heating.at_most(stable), cooling.at_most(COOLING_SHARE * stable)];
        let rules =
            ZoneRules { margins: [parameters.heating_margin, parameters.cooling_margin], gains, ..rules };
        let parameters = parameters.clone();
        Self {
            unit,
            parameters,
            group: ZoneGroup::default(),
            zone: Zone::new(rules),
            setpoint: 20.0,
            shifts: UnitShifts::default(),
        }
    }

    /// Forgets everything but its own shifts.
    pub(super) fn reset(&mut self) {
        self.group = ZoneGroup::default();
        self.zone.reset();
    }

    /// Writes the action of a step.
    pub(super) fn act(&mut self, site: SiteInput, input: &ZoneInput, action: &mut [f64], hours: f64) {
        let need = self.zone.observe(input, site, hours);
        let mode = self.group.step(std::iter::once(need));
        let outdoor = site.outdoor_temperature;
        let outputs = self.zone.control(mode, self.reaches(mode, outdoor), hours);
        let aims = self.zone.aims();
        let (flow, supply) = if outputs.heating > 0.0 {
            let Stage { flow, difference } = self.heat(mode, outputs.heating, outdoor);
            (flow, aims.heating + difference)
        } else if outputs.cooling > 0.0 {
            let Stage { flow, difference } = self.cool(mode, outputs.cooling, outdoor);
            (flow, aims.cooling - difference)
        } else {
            let flow = self.ventilation_flow(mode, outdoor);
            (flow, self.neutral(mode, flow, outdoor))
        };
        self.setpoint = supply.clamp(self.unit.supply[0], self.unit.supply[1]);
        action[FLOW] = (flow * self.unit.design_flow).max(self.outdoor_air(mode));
        action[SUPPLY_TEMPERATURE] = self.setpoint;
    }

    /// Returns the minimum of outdoor air in a mode, kg/s.
    fn outdoor_air(&self, mode: Mode) -> f64 {
        if mode == Mode::Occupied { self.unit.outdoor_air } else { 0.0 }
    }

    /// Returns the flow that brings in outdoor air, as a share of the design flow: 0 without people or outdoor air.
    fn ventilation_flow(&self, mode: Mode, outdoor: f64) -> f64 {
        match self.outdoor_air(mode) {
            outdoor_air if outdoor_air > 0.0 => self.running_flow(outdoor_air, outdoor),
            _ => 0.0,
        }
    }

    /// Returns the minimum flow while a loop is on.
    fn least_flow(&self, mode: Mode, outdoor: f64) -> f64 {
        self.running_flow(self.outdoor_air(mode), outdoor)
    }

    /// Returns the minimum flow of a running fan with a flow of outdoor air (kg/s), as a share of the design flow.
    fn running_flow(&self, outdoor_air: f64, outdoor: f64) -> f64 {
        let Unit { design_flow, exhaust, .. } = self.unit;
        let make_up = exhaust * ((MAKE_UP[0] - outdoor) / (MAKE_UP[0] - MAKE_UP[1])).clamp(0.0, 1.0);
        let least = (outdoor_air.max(make_up) / design_flow).max(self.minimum_flow());
        let temperature = self.zone.need().temperature;
        let (cools, room) = (temperature - outdoor, temperature - LEAST_SUPPLY);
        let untempered = if room > 0.0 { outdoor_air / design_flow * cools / room } else { 0.0 };
        untempered.min(RECIRCULATION).max(least)
    }

    /// Returns the minimum flow without outdoor air, as a share of the design flow.
    fn minimum_flow(&self) -> f64 {
        (self.parameters.min_flow + self.shifts.minimum_flow).clamp(LEAST_FLOW, 1.0)
    }

    /// Returns the highest supply air temperature above the heating setpoint, K.
    fn highest_lift(&self) -> f64 {
        (self.unit.supply[1] - self.zone.setpoints().heating).max(0.0)
    }

    /// Returns the reaches of the loops. During optimum start, heating reaches what the compressor gives above its
    /// cutoff, or without one the stages before the last.
    fn reaches(&self, mode: Mode, outdoor: f64) -> [Reach; 2] {
        let flow = self.least_flow(mode, outdoor);
        let aims = self.zone.aims_in(mode);
        let full = [self.highest_lift(), aims.cooling - self.unit.supply[0]].map(|most| most.max(1.0));
        let first = [
            flow * (self.neutral(mode, flow, outdoor) - aims.heating),
            flow * (aims.cooling - self.coldest(mode, flow, outdoor)),
        ];
        let idle = |side: usize| (first[side] / full[side]).min(0.0);
        let limit = match self.preheating_capacity(outdoor) {
            Some(capacity) => ((capacity - first[0]) / (full[0] - first[0])).clamp(LEAST_LIMIT, 1.0),
            None => 1.0,
        };
        [Reach { idle: idle(0), limit }, Reach { idle: idle(1), limit: 1.0 }]
    }

    /// Returns the capacity to which optimum start is limited, K; `None` without a limit.
    fn preheating_capacity(&self, outdoor: f64) -> Option<f64> {
        if !self.zone.preheats() {
            return None;
        }
        match self.unit.heat_pump {
            Some(HeatPump { cutoff, .. }) if outdoor < cutoff => None,
            Some(HeatPump { lift, .. }) => Some(lift * (1.0 + COMPRESSOR_SLOPE * (outdoor - RATED_OUTDOOR))),
            None => Some(self.parameters.heating_flow * self.parameters.heating_lift),
        }
    }

    /// Returns flow and lift above the aim for an output of the heating loop.
    fn heat(&self, mode: Mode, output: f64, outdoor: f64) -> Stage {
        let least = self.least_flow(mode, outdoor);
        let most = self.highest_lift();
        let first = (self.neutral(mode, least, outdoor) - self.zone.aims().heating).min(most);
        let lift = match self.unit.heat_pump {
            Some(_) => self.parameters.heat_pump_lift,
            None => self.parameters.heating_lift,
        };
        let lift = (lift + self.shifts.heating_temperature).min(most).max(first);
        let flow = self.parameters.heating_flow.max(least);
        staged(
            output,
            [
                Stage { flow: least, difference: first },
                Stage { flow: least, difference: lift },
                Stage { flow, difference: lift },
                Stage { flow, difference: most },
                Stage { flow: 1.0, difference: most },
            ],
        )
    }

    /// Returns flow and drop below the aim for an output of the cooling loop.
    fn cool(&self, mode: Mode, output: f64, outdoor: f64) -> Stage {
        let least = self.least_flow(mode, outdoor);
        let aim = self.zone.aims().cooling;
        let most = (aim - self.unit.supply[0]).max(0.0);
        let first = (aim - self.coldest(mode, least, outdoor)).min(most);
        let supply = self.parameters.cooling_temperature + self.shifts.cooling_temperature;
        let drop = (aim - supply).min(most).max(first);
        let medium = self.medium_flow(least, outdoor);
        let free = if medium > least { (aim - outdoor - FAN_RISE).min(drop).max(first) } else { drop };
        staged(
            output,
            [
                Stage { flow: least, difference: first },
                Stage { flow: least, difference: free },
                Stage { flow: medium, difference: free },
                Stage { flow: medium, difference: drop },
                Stage { flow: 1.0, difference: drop },
                Stage { flow: 1.0, difference: most },
            ],
        )
    }

    /// Returns the flow up to which outdoor air alone cools (MedSpeed): the minimum without an economizer.
    fn medium_flow(&self, least: f64, outdoor: f64) -> f64 {
        let Some(limit) = self.unit.economizer else { return least };
        let temperature = self.zone.need().temperature;
        let (warm, cold) = ((temperature + MEDIUM[0]).min(limit), (temperature + MEDIUM[1]).min(limit - 1.0));
        least + (1.0 - least) * ((warm - outdoor) / (warm - cold)).clamp(0.0, 1.0)
    }

    /// Returns the temperature of the mixed air behind the fan, °C, but at least [`LEAST_SUPPLY`]: the setpoint with
    /// which both coils are off.
    fn neutral(&self, mode: Mode, flow: f64, outdoor: f64) -> f64 {
        self.mixed(self.outdoor_air(mode), flow, outdoor)
    }

    /// Returns the same if the exhaust fans may draw cold outdoor air, °C.
    fn coldest(&self, mode: Mode, flow: f64, outdoor: f64) -> f64 {
        let drawn = self.unit.exhaust.min(self.unit.outdoor_air).max(self.outdoor_air(mode));
        self.neutral(mode, flow, outdoor).min(self.mixed(drawn, flow, outdoor))
    }

    /// Returns the temperature of air mixed with a flow of outdoor air (kg/s), behind the fan, °C; at least
    /// [`LEAST_SUPPLY`].
    fn mixed(&self, outdoor_air: f64, flow: f64, outdoor: f64) -> f64 {
        let temperature = self.zone.need().temperature;
        let supply = flow * self.unit.design_flow;
        let share = if supply > 0.0 { (outdoor_air / supply).min(1.0) } else { 0.0 };
        let mixed = temperature + share * (outdoor - temperature) + FAN_RISE * flow * flow;
        mixed.max(LEAST_SUPPLY)
    }

    /// Shifts a choice of the unit.
    pub(super) fn shift(&mut self, shift: Shift, value: f64) {
        match shift {
            Shift::MinimumFlow => self.shifts.minimum_flow = value,
            Shift::HeatingTemperature => self.shifts.heating_temperature = value,
            Shift::CoolingTemperature => self.shifts.cooling_temperature = value,
            _ => (),
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
            Entry::SupplyTemperature => self.setpoint,
            Entry::MinimumOutdoorAir => self.outdoor_air(self.group.mode()),
            _ => 0.0,
        }
    }
}
