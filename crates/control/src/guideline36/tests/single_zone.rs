//! A room with a unit over a week.

use super::super::parameters::Guideline36UnitaryParameters;
use super::super::points::SiteInput;
use super::super::single_zone::{SingleZone, Unit};
use super::super::zone::ZoneRules;
use super::room::{Room, SPECIFIC_HEAT};
use super::{DAY, STEP, day};

/// Design flow, kg/s.
const DESIGN_FLOW: f64 = 0.6;
/// Heating and cooling capacity, W.
const CAPACITY: [f64; 2] = [15_000.0, 9_000.0];

/// A step of a week.
#[derive(Clone, Copy, Debug)]
struct Moment {
    temperature: f64,
    /// Share of the design flow.
    flow: f64,
    /// Heat and cold of the coils, W.
    coils: [f64; 2],
}

/// A unit with a share of outdoor air in a room under a mean outdoor temperature, °C.
#[derive(Clone, Copy, Debug)]
struct Case {
    outdoor_air: f64,
    mean: f64,
    amplitude: f64,
    /// Gains while people are present, W.
    gains: f64,
}

const JANUARY: Case = Case { outdoor_air: 0.15, mean: -5.0, amplitude: 4.0, gains: 1500.0 };
const JULY: Case = Case { outdoor_air: 0.15, mean: 25.0, amplitude: 5.0, gains: 3000.0 };

fn rules() -> ZoneRules {
    ZoneRules {
        gains: [Guideline36UnitaryParameters::default().gains; 2],
        margins: [0.0; 2],
        optimum_start: 3.0,
        setback: true,
    }
}

fn week(case: Case) -> Vec<Moment> {
    let unit = Unit {
        floor_area: 100.0,
        design_flow: DESIGN_FLOW,
        outdoor_air: case.outdoor_air * DESIGN_FLOW,
        exhaust: 0.0,
        supply: [10.0, 45.0],
        economizer: None,
        heat_pump: None,
    };
    let mut control = SingleZone::new(unit, &Guideline36UnitaryParameters::default(), rules());
    let mut room = Room::new(22.5);
    let mut action = [0.0; 2];
    let run = |step| {
        let outdoor_temperature = day::outdoor(step, case.mean, case.amplitude);
        let site = SiteInput { outdoor_temperature, ..SiteInput::default() };
        let people = day::has_people(step);
        control.act(site, &day::points(step, room.air), &mut action, STEP);
        let [flow, supply] = action;
        let fresh = if people { (case.outdoor_air * DESIGN_FLOW).min(flow) } else { 0.0 };
        let share = if flow > 0.0 { fresh / flow } else { 0.0 };
        let mixed = room.air + share * (outdoor_temperature - room.air);
        let wanted = flow * SPECIFIC_HEAT * (supply - mixed);
        let heat = wanted.clamp(-CAPACITY[1], CAPACITY[0]);
        let delivered = if flow > 0.0 { mixed + heat / (flow * SPECIFIC_HEAT) } else { mixed };
        room.gains = if people { case.gains } else { 0.0 };
        room.blow(outdoor_temperature, 0.0, flow, delivered, STEP);
        Moment { temperature: room.air, flow: flow / DESIGN_FLOW, coils: [heat.max(0.0), (-heat).max(0.0)] }
    };
    (0..7 * DAY).map(run).collect()
}

/// Kelvin-hours outside the band at the ends of steps.
fn discomfort(moments: &[Moment], steps: std::ops::Range<usize>) -> f64 {
    steps
        .map(|step| {
            let (band, temperature) = (day::band(step), moments[step].temperature);
            (band.heating - temperature).max(temperature - band.cooling).max(0.0) * STEP
        })
        .sum()
}

#[test]
fn an_empty_building_in_july_has_no_fan_and_no_heating() {
    let week = week(JULY);
    for (step, moment) in week.iter().enumerate() {
        let (day, hour) = day::time(step);
        let cools_down = day < 5 && (4.0..19.0).contains(&hour);
        assert!(moment.coils[0] < 100.0, "heating of {} W on day {day} at {hour}", moment.coils[0]);
        assert!(cools_down || moment.flow == 0.0, "flow of {} on day {day} at {hour}", moment.flow);
    }
}

/// Optimum start aims at 0.25 K from the setpoint; the loop makes up for the rest in the first hours of the band.
#[test]
fn setback_lets_the_room_cool_and_recovers_before_the_band_changes() {
    let week = week(JANUARY);
    let at = |day: usize, hour: usize| week[day * DAY + hour * 12 - 1];
    for day in 1..5 {
        assert!(at(day, 7).temperature > 20.6, "{} °C at 7:00 on day {day}", at(day, 7).temperature);
        assert!(at(day, 2).temperature < 17.0, "{} °C at 2:00 on day {day}", at(day, 2).temperature);
        assert!(at(day, 2).flow < 0.3, "a flow of {} holds the setback", at(day, 2).flow);
    }
    assert!(discomfort(&week, 0..5 * DAY) < 1.1, "{} K·h", discomfort(&week, 0..5 * DAY));
}

/// The bound is 0.25 K over the first hour and a half of the band on five mornings.
#[test]
fn a_room_is_in_its_band_in_july() {
    let week = week(JULY);
    assert!(discomfort(&week, 0..7 * DAY) < 2.1, "{} K·h", discomfort(&week, 0..7 * DAY));
}

#[test]
fn a_room_is_not_heated_and_cooled_on_the_same_day_of_winter_or_summer() {
    for (case, unwanted) in [(JANUARY, 1), (JULY, 0)] {
        for without_outdoor_air in [false, true] {
            let outdoor_air = if without_outdoor_air { 0.0 } else { case.outdoor_air };
            let week = week(Case { outdoor_air, ..case });
            let sum = |side: usize| week.iter().map(|moment| moment.coils[side]).sum::<f64>();
            assert!(sum(unwanted) < 0.02 * sum(1 - unwanted), "{} of {}", sum(unwanted), sum(1 - unwanted));
        }
    }
}

#[test]
fn the_fan_does_not_chatter() {
    for case in [JANUARY, JULY, Case { outdoor_air: 0.0, ..JANUARY }, Case { outdoor_air: 0.0, ..JULY }] {
        let week = week(case);
        let switches = week.windows(2).filter(|pair| (pair[0].flow > 0.0) != (pair[1].flow > 0.0)).count();
        assert!(switches <= 7 * 12, "{switches} switches in a week of {case:?}");
        let travel: f64 = week.windows(2).map(|pair| (pair[1].flow - pair[0].flow).abs()).sum();
        assert!(travel < 7.0 * 6.0, "the flow travels {travel} strokes in a week of {case:?}");
    }
}

#[test]
fn a_unit_without_outdoor_air_stands_still_in_its_band() {
    let mild = Case { outdoor_air: 0.0, mean: 22.0, amplitude: 2.0, gains: 300.0 };
    assert!(week(mild).iter().all(|moment| moment.flow == 0.0));
}
