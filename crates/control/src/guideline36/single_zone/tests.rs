//! Staging of a unit, with the room as it is at one moment.

use super::super::zone::LoopGains;
use super::*;

const STEP: f64 = 1.0 / 12.0;
const DAY: ZoneInput =
    ZoneInput { temperature: 20.0, heating: 21.0, cooling: 24.0, people: true, next: None };

fn unit(outdoor_air: f64, economizer: Option<f64>) -> SingleZone {
    let unit = Unit {
        floor_area: 100.0,
        design_flow: 0.5,
        outdoor_air,
        exhaust: 0.0,
        supply: [10.0, 45.0],
        economizer,
        heat_pump: None,
    };
    let parameters = Guideline36UnitaryParameters::default();
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
    unit.zone.control(Mode::Occupied, [Reach::up_to(1.0); 2], STEP);
    // From the air of the room behind the fan at a flow of 0.2, to 24 K at the design flow.
    let first = 0.2 * (20.0 + 0.8 * 0.04 - unit.zone.aims().heating);
    for (flow, difference) in [(0.2, -0.9), (0.2, 6.0), (0.2, 11.0), (6.0 / 11.0, 11.0), (1.0, 18.0)] {
        let output = (flow * difference - first) / (24.0 - first);
        let stage = unit.heat(Mode::Occupied, output, 20.0);
        let near = (stage.flow - flow).abs() < 1e-9 && (stage.difference - difference).abs() < 1e-9;
        assert!(near, "{output}: {stage:?}");
    }
}

#[test]
fn the_capacity_is_proportional_to_the_output_of_both_loops_from_idle_coils_on() {
    let mut unit = unit(0.1, Some(24.0));
    unit.zone.observe(&DAY, SiteInput::default(), STEP);
    unit.zone.control(Mode::Occupied, [Reach::up_to(1.0); 2], STEP);
    for outdoor in [-10.0, 5.0, 16.0, 20.0, 35.0] {
        let flow = unit.ventilation_flow(Mode::Occupied, outdoor);
        let [heating, cooling] = [unit.zone.aims().heating, unit.zone.aims().cooling]
            .map(|aim| flow * (unit.neutral(Mode::Occupied, flow, outdoor) - aim));
        for output in (0..=20).map(|share| f64::from(share) / 20.0) {
            let near = |stage: Stage, expected: f64| (stage.capacity() - expected).abs() < 1e-9;
            assert!(near(unit.heat(Mode::Occupied, output, outdoor), heating + output * (24.0 - heating)));
            let most = unit.zone.aims().cooling - 10.0;
            assert!(near(unit.cool(Mode::Occupied, output, outdoor), -cooling + output * (most + cooling)));
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
    for (outdoor, mixed) in [(17.5, 20.0), (0.0, 11.25), (32.0, 27.25)] {
        let [flow, supply] = act(unit(0.05, None), outdoor, between);
        assert!((flow - 0.2).abs() < 1e-9 && (supply - mixed).abs() < 0.1, "{flow} at {supply}");
    }
    assert_eq!(act(unit(0.0, None), 17.5, between)[0], 0.0, "without outdoor air");
    assert_eq!(act(unit(0.05, None), 17.5, ZoneInput { people: false, ..between })[0], 0.0);
}

#[test]
fn cold_outdoor_air_is_diluted_to_10_degrees_before_the_coil_tempers_it() {
    let between = ZoneInput { temperature: 22.5, ..DAY };
    // A tenth of the design flow from -20 to 22.5 °C: with 0.34 of it, 10 °C.
    let [flow, supply] = act(unit(0.05, None), -20.0, between);
    assert!((flow - 0.1 * 42.5 / 12.5).abs() < 1e-9 && (10.0..10.2).contains(&supply), "{flow} at {supply}");
    let [flow, supply] = act(unit(0.15, None), -20.0, between);
    assert!((flow - 0.5).abs() < 1e-9 && supply == 10.0, "at most half of the flow: {flow} at {supply}");
}

#[test]
fn a_running_unit_supplies_what_the_exhaust_fans_of_its_room_take() {
    let under_hood = |input, outdoor| {
        let mut hood = unit(0.2, None);
        hood.unit.exhaust = 0.35;
        act(hood, outdoor, input)
    };
    let between = ZoneInput { temperature: 22.5, ..DAY };
    let flow = |input, outdoor| under_hood(input, outdoor)[0];
    assert_eq!(flow(between, 8.0), 0.7, "between the loops");
    assert_eq!(flow(between, 17.5), 0.4, "in warm weather");
    assert_eq!(flow(ZoneInput { people: false, temperature: 20.95, ..DAY }, 8.0), 0.7, "without people");
    assert_eq!(flow(ZoneInput { people: false, ..between }, 8.0), 0.0, "with neither");
    let supply = under_hood(ZoneInput { people: false, temperature: 24.1, ..DAY }, 16.0)[1];
    assert!(supply <= 16.1, "outdoor air drawn by the hood is not heated: {supply}");
}

#[test]
fn optimum_start_leaves_supplemental_heat_off() {
    let next = Some(super::super::points::NextBand { hours: 1.0, heating: 21.0, cooling: 24.0 });
    let night = ZoneInput { heating: 16.0, cooling: 30.0, people: false, next, temperature: 17.0 };
    let mut heat_pump = unit(0.0, None);
    heat_pump.unit.heat_pump = Some(HeatPump { lift: 15.0, cutoff: -12.0 });
    let capacity = |outdoor: f64| {
        let [flow, supply] = act(heat_pump.clone(), outdoor, night);
        flow * (supply - 21.2)
    };
    assert!((capacity(8.3) - 15.0).abs() < 0.3, "{}", capacity(8.3));
    assert!((capacity(-5.0) - 15.0 * (1.0 - 0.027 * 13.3)).abs() < 0.3, "{}", capacity(-5.0));
    assert!(capacity(-13.0) > 20.0, "without a compressor, there is no other heat: {}", capacity(-13.0));
}
