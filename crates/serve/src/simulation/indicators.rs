//! The key performance indicators of a test, from the end of its warm-up on.

use b2b_building::Carrier;
use b2b_env::{Amounts, CarbonDioxide, Kpis, Pair, Spaces, Target, Term, ZoneAir, ZoneStep};
use b2b_tariff::{Bill, Moment};
use serde_json::{Value, json};

use crate::subject::{AllPrices, DAYS, PriceScenario};

/// A controlled zone.
#[derive(Clone, Copy, Debug)]
struct ZoneSlots {
    temperature: usize,
    target: Target,
    carbon_dioxide: Option<usize>,
}

/// Running sums over a test.
#[derive(Debug)]
pub(super) struct Indicators {
    zones: Vec<ZoneSlots>,
    /// Setpoints of each zone for the next step.
    asked: Vec<Pair>,
    steps: Vec<ZoneStep>,
    kpis: Kpis,
    /// Wh/m² and g/m².
    energy: f64,
    emissions: f64,
    /// Currency/m² in each price scenario, with its bill.
    costs: [f64; 3],
    bills: [Bill; 3],
    /// m².
    floor_area: f64,
    /// Length of a control step, h.
    hours: f64,
}

impl Indicators {
    /// Begins with an observation on a day of the year.
    pub fn begin(spaces: &Spaces, observation: &[f64], day_of_year: u32) -> Self {
        let zones = spaces.controlled_zones().enumerate();
        let zones = zones.map(|(controlled, zone)| ZoneSlots {
            temperature: zone,
            target: spaces.observation.target(controlled),
            carbon_dioxide: spaces.observation.zone_air(ZoneAir::CarbonDioxide, controlled),
        });
        let mut begun = Self {
            zones: zones.collect(),
            asked: Vec::new(),
            steps: Vec::new(),
            kpis: Kpis::default(),
            energy: 0.0,
            emissions: 0.0,
            costs: [0.0; 3],
            bills: [Bill::new(day_of_year, DAYS); 3],
            floor_area: spaces.building.conditioned_floor_area,
            hours: 1.0 / f64::from(spaces.episode.steps_per_hour),
        };
        begun.ask(observation);
        begun.look(observation);
        let kpis = Kpis::begin(begun.steps.iter().map(|zone| zone.temperature).collect());
        let air = begun.steps.iter().filter_map(|zone| zone.carbon_dioxide).collect();
        begun.kpis = match spaces.episode.task.carbon_dioxide {
            Some(CarbonDioxide { limit, .. }) => kpis.with_carbon_dioxide(limit, air),
            None => kpis,
        };
        begun
    }

    /// Adds a step that began at a moment, with the observation at its end.
    pub fn add(&mut self, began: Moment, observation: &[f64], terms: &Amounts, prices: &AllPrices) {
        self.look(observation);
        let [electricity, gas] = [terms[Term::Electricity], terms[Term::Gas]];
        self.kpis.add(&self.steps, [electricity, gas, 0.0], self.hours);
        self.energy += terms[Term::Energy];
        self.emissions += terms[Term::Emissions];
        let mut energy = [0.0; Carrier::ALL.len()];
        for (carrier, used) in [(Carrier::Electricity, electricity), (Carrier::Gas, gas)] {
            energy[carrier as usize] = used.max(0.0) * self.floor_area / 1000.0;
        }
        for (scenario, (cost, bill)) in
            PriceScenario::ALL.into_iter().zip(self.costs.iter_mut().zip(&mut self.bills))
        {
            *cost += bill.step(prices.of(scenario), began, &energy, self.hours).total() / self.floor_area;
        }
        self.ask(observation);
    }

    /// Keeps the setpoints for the next step.
    fn ask(&mut self, observation: &[f64]) {
        self.asked.clear();
        self.asked.extend(self.zones.iter().map(|zone| zone.target.pair_of(observation, true)));
    }

    /// Compares the temperatures with the setpoints.
    fn look(&mut self, observation: &[f64]) {
        self.steps.clear();
        self.steps.extend(self.zones.iter().zip(&self.asked).map(|(zone, pair)| ZoneStep {
            pair: *pair,
            carbon_dioxide: zone.carbon_dioxide.map(|slot| observation[slot]),
            ..ZoneStep::with_target(observation[zone.temperature], pair.middle(), false, true)
        }));
    }

    /// Returns the indicators in a price scenario. `time_ratio`: computing time of the client for each second of a
    /// step.
    pub fn payload(&self, scenario: PriceScenario, time_ratio: Option<f64>) -> Value {
        json!({
            "tdis_tot": self.kpis.discomfort(self.zones.len()),
            "idis_tot": self.kpis.bad_air(self.zones.len()),
            "ener_tot": self.energy / 1000.0,
            "cost_tot": self.costs[scenario as usize],
            "emis_tot": self.emissions / 1000.0,
            "pele_tot": self.kpis.peak(0),
            "pgas_tot": self.kpis.peak(1),
            "pdih_tot": self.kpis.peak(2),
            "time_rat": time_ratio,
        })
    }
}
