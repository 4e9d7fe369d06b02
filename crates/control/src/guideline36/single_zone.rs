//! A unit of a single zone (Guideline 36, 5.18.4 for air handlers, 5.22 for fan coils): staging of supply air temperature
//! and flow.
//!
//! A loop output asks for a share of the unit's capacity. Capacity is staged: the supply air temperature at minimum flow,
//! then the flow, then the supply air temperature to its limit. The guideline gives every stage a fixed share of the loop;
//! here the shares follow from the capacities, so that the loop has the same gain everywhere. Its second heating stage is
//! flow: a heat pump is more efficient with more air of a lower temperature, and supplemental heat starts only when the
//! supply air must be hotter than the compressor can make it. That last stage, which the guideline does not have, is for
//! the cold climates that it is not written for. Optimum start is limited to what the compressor gives, or to the stages
//! before the last, and begins earlier instead: recovery by supplemental heat takes three times the energy.
//!
//! With an economizer and outdoor air cool enough, cooling raises the flow of outdoor air (MedSpeed) ahead of the coil.
//!
//! While people are present, the fan of a unit with outdoor air runs at the flow that brings it in. Between the loops both
//! coils are off: the setpoint is the temperature that the mixed air has, within limits that keep the zone in its band.
//! Without outdoor air or without people, the fan is off between the loops (DeadbandSpeed 0).

use b2b_building::hvac::Actuator;

use super::modes::{Mode, ZoneGroup};
use super::parameters::UnitaryParameters;
use super::points::{SiteInput, ZoneInput};
use super::record::Entry;
use super::zone::{Zone, ZoneRules};

/// Temperature rise across the fan at its design flow, K.
const FAN_RISE: f64 = 0.8;
/// Highest outdoor temperature for economizing in humid and in other climates, °C (MaxDPT).
const ECONOMIZER_LIMIT: [f64; 2] = [17.0, 24.0];
/// Outdoor temperatures relative to the zone at which MedSpeed is lowest and highest, K.
const MEDIUM: [f64; 2] = [0.5, -6.0];

/// Outdoor temperature at which heat pumps are rated, °C (AHRI 210/240).
const RATED_OUTDOOR: f64 = 8.3;
/// Change of a compressor's heating capacity with the outdoor temperature, 1/K: that of the engine's example curves.
const COMPRESSOR_SLOPE: f64 = 0.027;
/// Least limit of the heating loop.
const LEAST_LIMIT: f64 = 0.1;

/// Number of the action of the supply air flow.
const FLOW: usize = 0;
/// Number of the action of the supply air temperature.
const SUPPLY_TEMPERATURE: usize = 1;

/// Largest gain of the heating loop for a design flow of 1 kg/s per square meter of floor, kg/(s m² K). The air of a dining
/// room is replaced in 4 min by the flow of its unit, and follows the supply air within a step: at 0.25/K, heating and cooling
/// at full capacity alternate.
const STABLE_GAIN: f64 = 0.0017;
/// Largest gain of the cooling loop over the largest of the heating loop: full cooling is about so much less than full heating.
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
    /// Bounds of the supply air temperature, °C.
    pub(super) supply: [f64; 2],
    /// Highest outdoor temperature for economizing, °C; none without an economizer.
    pub(super) economizer: Option<f64>,
}

impl Unit {
    pub(super) fn new(
        [flow, supply_temperature]: [&Actuator; 2],
        floor_area: f64,
        outdoor_air: f64,
        economizes: bool,
        climate_zone: Option<&str>,
    ) -> Self {
        let humid = climate_zone.is_some_and(|zone| zone.ends_with('A'));
        Self {
            floor_area,
            design_flow: flow.high,
            outdoor_air: outdoor_air.clamp(0.0, flow.high),
            supply: [supply_temperature.low, supply_temperature.high],
            economizer: economizes.then_some(ECONOMIZER_LIMIT[usize::from(!humid)]),
        }
    }
}

/// The sequences of a unit.
#[derive(Clone, Debug)]
pub(super) struct SingleZone {
    unit: Unit,
    parameters: UnitaryParameters,
    group: ZoneGroup,
    zone: Zone,
    setpoint: f64,
}

/// A point of staging: flow, as a share of the design flow, and temperature difference, K. Their product is the capacity.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Stage {
    flow: f64,
    difference: f64,
}

impl SingleZone {
    pub(super) fn new(unit: Unit, parameters: &UnitaryParameters, rules: ZoneRules) -> Self {
        let [heating, cooling] = rules.gains;
        let stable = STABLE_GAIN * unit.floor_area / unit.design_flow;
        let gains = [heating.at_most(stable), cooling.at_most(COOLING_SHARE * stable)];
        let rules = ZoneRules { margins: [parameters.margin; 2], gains, ..rules };
        let parameters = parameters.clone();
        Self { unit, parameters, group: ZoneGroup::default(), zone: Zone::new(rules), setpoint: 20.0 }
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
        let outdoor = site.outdoor_temperature;
        let outputs = self.zone.control(mode, self.heating_limit(outdoor), hours);
        let stage = match () {
            () if outputs.heating > 0.0 => self.heat(mode, outputs.heating),
            () if outputs.cooling > 0.0 => self.cool(mode, outputs.cooling, outdoor),
            () => Stage { flow: self.ventilation_flow(mode), difference: 0.0 },
        };
        let aims = self.zone.aims();
        self.setpoint = match () {
            () if outputs.heating > 0.0 => aims.heating + stage.difference,
            () => self.neutral(mode, stage.flow, outdoor).min(aims.cooling - stage.difference),
        };
        self.setpoint = self.setpoint.clamp(self.unit.supply[0], self.unit.supply[1]);
        action[FLOW] = (stage.flow * self.unit.design_flow).max(self.outdoor_air(mode));
        action[SUPPLY_TEMPERATURE] = self.setpoint;
    }

    /// Returns the minimum of outdoor air in a mode, kg/s.
    fn outdoor_air(&self, mode: Mode) -> f64 {
        if mode == Mode::Occupied { self.unit.outdoor_air } else { 0.0 }
    }

    /// Returns the flow that brings in outdoor air, as a share of the design flow: 0 without people or outdoor air.
    fn ventilation_flow(&self, mode: Mode) -> f64 {
        match self.outdoor_air(mode) {
            outdoor_air if outdoor_air > 0.0 => {
                (outdoor_air / self.unit.design_flow).max(self.parameters.min_flow)
            }
            _ => 0.0,
        }
    }

    /// Returns the least flow while a loop is on.
    fn least_flow(&self, mode: Mode) -> f64 {
        self.ventilation_flow(mode).max(self.parameters.min_flow)
    }

    /// Returns the highest supply air temperature above the heating setpoint, K.
    fn highest_lift(&self) -> f64 {
        (self.unit.supply[1] - self.zone.setpoints().heating).max(0.0)
    }

    /// Returns the limit of the heating loop: during optimum start, what the compressor gives, or without one the stages before
    /// the last.
    fn heating_limit(&self, outdoor: f64) -> f64 {
        let UnitaryParameters { compressor_lift, compressor_cutoff, heating_flow, heating_lift, .. } =
            self.parameters;
        let capacity = match compressor_lift > 0.0 {
            true if outdoor < compressor_cutoff => return 1.0,
            true => compressor_lift * (1.0 + COMPRESSOR_SLOPE * (outdoor - RATED_OUTDOOR)),
            false => heating_flow * heating_lift,
        };
        match self.zone.preheats() {
            true => (capacity / self.highest_lift().max(1.0)).clamp(LEAST_LIMIT, 1.0),
            false => 1.0,
        }
    }

    /// Returns flow and lift above the aim for an output of the heating loop.
    fn heat(&self, mode: Mode, output: f64) -> Stage {
        let least = self.least_flow(mode);
        let most = self.highest_lift();
        let lift = self.parameters.heating_lift.min(most);
        let flow = self.parameters.heating_flow.max(least);
        staged(
            output * most,
            [
                Stage { flow: least, difference: 0.0 },
                Stage { flow: least, difference: lift },
                Stage { flow, difference: lift },
                Stage { flow, difference: most },
                Stage { flow: 1.0, difference: most },
            ],
        )
    }

    /// Returns flow and drop below the aim for an output of the cooling loop.
    fn cool(&self, mode: Mode, output: f64, outdoor: f64) -> Stage {
        let least = self.least_flow(mode);
        let aim = self.zone.aims().cooling;
        let most = (aim - self.unit.supply[0]).max(0.0);
        let drop = (aim - self.parameters.cooling_temperature).clamp(0.0, most);
        let medium = self.medium_flow(least, outdoor);
        let free = if medium > least { (aim - outdoor - FAN_RISE).clamp(0.0, drop) } else { drop };
        staged(
            output * most,
            [
                Stage { flow: least, difference: 0.0 },
                Stage { flow: least, difference: free },
                Stage { flow: medium, difference: free },
                Stage { flow: medium, difference: drop },
                Stage { flow: 1.0, difference: drop },
                Stage { flow: 1.0, difference: most },
            ],
        )
    }

    /// Returns the flow up to which outdoor air alone cools (MedSpeed): the least without an economizer.
    fn medium_flow(&self, least: f64, outdoor: f64) -> f64 {
        let Some(limit) = self.unit.economizer else { return least };
        let temperature = self.zone.need().temperature;
        let (warm, cold) = ((temperature + MEDIUM[0]).min(limit), (temperature + MEDIUM[1]).min(limit - 1.0));
        least + (1.0 - least) * ((warm - outdoor) / (warm - cold)).clamp(0.0, 1.0)
    }

    /// Returns the setpoint with which both coils are off, °C: the temperature of the mixed air behind the fan. Its limits
    /// let air in from colder the warmer the zone is in its band, and from warmer the colder it is.
    fn neutral(&self, mode: Mode, flow: f64, outdoor: f64) -> f64 {
        let temperature = self.zone.need().temperature;
        let supply = flow * self.unit.design_flow;
        let share = if supply > 0.0 { (self.outdoor_air(mode) / supply).min(1.0) } else { 0.0 };
        let mixed = temperature + share * (outdoor - temperature) + FAN_RISE * flow * flow;
        let aims = self.zone.aims();
        let position = ((temperature - aims.heating) / (aims.cooling - aims.heating)).clamp(0.0, 1.0);
        let position = if position.is_nan() { 0.0 } else { position };
        let between =
            |cold: f64, warm: f64| if position > 0.0 { cold + position * (warm - cold) } else { cold };
        let lowest = between(aims.heating, self.parameters.cooling_temperature.min(aims.heating));
        let highest = between(aims.heating + self.parameters.heating_lift, aims.cooling);
        mixed.clamp(lowest, highest.max(lowest))
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

/// Returns the point of staging at a capacity, K. From stage to stage either the flow or the difference grows.
fn staged<const STAGES: usize>(capacity: f64, stages: [Stage; STAGES]) -> Stage {
    for pair in stages.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        if capacity <= to.flow * to.difference {
            return match from.flow == to.flow {
                true => Stage { flow: from.flow, difference: capacity / from.flow },
                false => Stage { flow: capacity / from.difference, difference: from.difference },
            };
        }
    }
    stages[STAGES - 1]
}

#[cfg(test)]
mod tests {
    use super::super::zone::LoopGains;
    use super::*;

    const STEP: f64 = 1.0 / 12.0;
    const DAY: ZoneInput =
        ZoneInput { temperature: 20.0, heating: 21.0, cooling: 24.0, people: true, next: None };

    fn unit(outdoor_air: f64, economizer: Option<f64>) -> SingleZone {
        let unit =
            Unit { floor_area: 100.0, design_flow: 0.5, outdoor_air, supply: [10.0, 45.0], economizer };
        let parameters = UnitaryParameters::default();
        let gains = [LoopGains::UNIT; 2];
        let rules = ZoneRules { gains, margins: [0.0; 2], optimum_start: 3.0, setback: true };
        SingleZone::new(unit, &parameters, rules)
    }

    /// Returns the action, as a share of the design flow and °C, of a new unit.
    fn act(mut unit: SingleZone, outdoor_temperature: f64, input: ZoneInput) -> [f64; 2] {
        let mut action = [0.0; 2];
        unit.act(SiteInput { outdoor_temperature, ..SiteInput::default() }, &input, &mut action, STEP);
        [action[0] / 0.5, action[1]]
    }

    #[test]
    fn temperature_rises_at_minimum_flow_then_flow_then_temperature_again() {
        let mut unit = unit(0.0, None);
        unit.zone.observe(&DAY, SiteInput::default(), STEP);
        // Full heating is 24 K at the design flow; 11 K at a flow of 0.2 are 9 %, at the design flow 46 %.
        for (output, flow, difference) in
            [(0.05, 0.2, 6.0), (2.2 / 24.0, 0.2, 11.0), (0.25, 6.0 / 11.0, 11.0), (0.75, 1.0, 18.0)]
        {
            let stage = unit.heat(Mode::Occupied, output);
            let near = (stage.flow - flow).abs() < 1e-9 && (stage.difference - difference).abs() < 1e-9;
            assert!(near, "{output}: {stage:?}");
        }
    }

    #[test]
    fn the_capacity_is_proportional_to_the_output_of_both_loops() {
        let mut unit = unit(0.1, Some(24.0));
        unit.zone.observe(&DAY, SiteInput::default(), STEP);
        unit.zone.control(Mode::Occupied, 1.0, STEP);
        for outdoor in [5.0, 16.0, 20.0, 35.0] {
            for output in (1..=20).map(|share| f64::from(share) / 20.0) {
                let capacity = |stage: Stage| stage.flow * stage.difference;
                assert!((capacity(unit.heat(Mode::Occupied, output)) - 24.0 * output).abs() < 1e-9);
                let most = unit.zone.aims().cooling - 10.0;
                assert!((capacity(unit.cool(Mode::Occupied, output, outdoor)) - most * output).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn with_an_economizer_cool_outdoor_air_raises_the_flow_before_the_coil_works() {
        let warm = ZoneInput { temperature: 25.0, ..DAY };
        let [flow, supply] = act(unit(0.1, Some(24.0)), 17.0, warm);
        assert!(flow > 0.8 && supply >= 17.0, "free cooling: {flow} at {supply}");
        let [flow, supply] = act(unit(0.1, None), 17.0, warm);
        assert!(flow < 0.6 && supply == 13.0, "without an economizer: {flow} at {supply}");
    }

    #[test]
    fn between_the_loops_the_unit_supplies_the_air_that_it_mixes_or_stands_still() {
        let between = ZoneInput { temperature: 22.5, ..DAY };
        // Half outdoor air: the minimum flow is 0.2, of which 0.1 is outdoor air.
        let [flow, supply] = act(unit(0.05, None), 17.5, between);
        assert!((flow - 0.2).abs() < 1e-9 && (supply - 20.0).abs() < 0.1, "{flow} at {supply}");
        let [_, supply] = act(unit(0.05, None), -20.0, between);
        assert!((16.0..18.0).contains(&supply), "cold outdoor air is tempered: {supply}");
        assert_eq!(act(unit(0.0, None), 17.5, between)[0], 0.0, "without outdoor air");
        assert_eq!(act(unit(0.05, None), 17.5, ZoneInput { people: false, ..between })[0], 0.0);
    }

    #[test]
    fn optimum_start_leaves_supplemental_heat_off() {
        let next = Some(super::super::points::NextBand { hours: 1.0, heating: 21.0, cooling: 24.0 });
        let night = ZoneInput { heating: 16.0, cooling: 30.0, people: false, next, temperature: 17.0 };
        let mut heat_pump = unit(0.0, None);
        (heat_pump.parameters.compressor_lift, heat_pump.parameters.compressor_cutoff) = (15.0, -12.0);
        let capacity = |outdoor: f64| {
            let [flow, supply] = act(heat_pump.clone(), outdoor, night);
            flow * (supply - 21.2)
        };
        assert!((capacity(8.3) - 15.0).abs() < 0.3, "{}", capacity(8.3));
        assert!((capacity(-5.0) - 15.0 * (1.0 - 0.027 * 13.3)).abs() < 0.3, "{}", capacity(-5.0));
        assert!(capacity(-13.0) > 20.0, "without a compressor, there is no other heat: {}", capacity(-13.0));
    }
}
