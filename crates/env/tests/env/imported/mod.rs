//! A user's building as an environment.

mod calendar;
mod room_unit;
mod terminals;
mod weather;

use crate::case::{Case, energy_is_the_engines, random_episode};
use b2b_building::{Carrier, Conditioning};
use b2b_energyplus::Level;
use b2b_env::{Env, Term};

const CHICAGO: &str = "USA_IL_Chicago-OHare.Intl.AP.725300_TMY3.epw";

#[test]
fn a_hotel_is_driven_by_actuators_and_its_guest_rooms_by_their_packaged_units() {
    let case = Case::imported("RefBldgSmallHotelNew2004_Chicago.idf", CHICAGO);
    let of_kind = |id: &'static str| case.building.laid_out_systems().filter(move |(s, _)| s.kind().id == id);
    assert_eq!(["unitary", "heating_only", "room_unit"].map(|id| of_kind(id).count()), [12, 13, 35]);
    let mut env = case.env("01-08..01-08");
    let trajectory = random_episode(&mut env, 1);
    assert_eq!(env.message_count(Level::Severe), 0);
    for (system, layout) in of_kind("room_unit") {
        let temperatures: Vec<f64> = trajectory.observed(layout.zones[0].index).collect();
        let name = system.name();
        assert!(temperatures.iter().all(|t| (12.0..34.0).contains(t)), "{name}: {temperatures:?}");
    }
    let driven = case.building.zones.iter().filter(|zone| zone.conditioning != Conditioning::None).count();
    assert_eq!(env.metrics().zones.len(), driven);
    let meters = env.engine_meters().unwrap();
    assert!((env.metrics().total(Term::Electricity) / meters[0] - 1.0).abs() < 1e-9);
}

#[test]
fn the_gas_of_boilers_and_the_electricity_of_chillers_and_pumps_count() {
    let case = Case::imported("RefBldgLargeOfficeNew2004_Chicago.idf", CHICAGO);
    let used = |period: &str| {
        let mut env = case.env(period);
        random_episode(&mut env, 1);
        energy_is_the_engines(&env);
        energy_is_the_sum_of_its_end_uses(&env);
        [Term::Electricity, Term::Gas].map(|term| env.metrics().total(term))
    };
    let ([january_electricity, january_gas], [july_electricity, _]) =
        (used("01-08..01-08"), used("07-09..07-09"));
    assert!(january_gas > 5.0 * january_electricity, "{january_gas} Wh/m² of gas in January");
    assert!(july_electricity > 2.0 * january_electricity, "{july_electricity} Wh/m² of electricity in July");
}

#[test]
fn fuel_oil_counts_as_much_energy_as_gas_at_its_own_price() {
    let with_fuel = |fuel: &str| {
        let case = Case::imported_after("RefBldgSmallOfficeNew2004_Chicago.idf", CHICAGO, |model| {
            for (_, _, coil) in model.objects_mut().filter(|(class, ..)| *class == "Coil:Heating:Fuel") {
                coil.insert("fuel_type".into(), fuel.into());
            }
        });
        let mut env = case.env("01-08..01-08");
        random_episode(&mut env, 1);
        let carriers: Vec<_> = case.building.carriers().collect();
        (carriers, env.metrics().clone(), env.engine_meters().unwrap())
    };
    let (_, gas, _) = with_fuel("NaturalGas");
    let (carriers, oil, meters) = with_fuel("FuelOilNo2");
    assert_eq!(carriers, [Carrier::Electricity, Carrier::Gas, Carrier::FuelOil]);
    assert!(
        oil.total(Term::Gas) > 100.0 && (oil.total(Term::Gas) / meters[1] - 1.0).abs() < 1e-9,
        "{} Wh/m²",
        oil.total(Term::Gas)
    );
    assert!(
        (oil.total(Term::Gas) / gas.total(Term::Gas) - 1.0).abs() < 1e-12,
        "{} Wh/m² of oil, {} of gas",
        oil.total(Term::Gas),
        gas.total(Term::Gas)
    );
    let per_kwh = (oil.total(Term::Cost) - gas.total(Term::Cost)) / (oil.total(Term::Gas) / 1000.0);
    assert!((per_kwh - (0.10 - 0.0365)).abs() < 1e-9, "{per_kwh} more per kWh");
}

#[test]
fn energy_of_an_imported_model_is_the_sum_of_its_end_uses() {
    let case = Case::imported("RefBldgSmallOfficeNew2004_Chicago.idf", CHICAGO);
    for period in ["01-08..01-08", "07-09..07-09"] {
        let mut env = case.env(period);
        random_episode(&mut env, 1);
        energy_is_the_sum_of_its_end_uses(&env);
    }
}

fn energy_is_the_sum_of_its_end_uses(env: &Env) {
    let metrics = env.metrics();
    let sum: f64 = Term::END_USES.into_iter().map(|term| metrics.total(term)).sum();
    let energy = metrics.total(Term::Energy);
    assert!(sum > 0.0 && (energy - sum).abs() < 1e-6 * energy, "{energy} and {sum}");
}
