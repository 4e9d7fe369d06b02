//! The guideline controller against the buildings' own controls.

use b2b_evaluate::FREE_DISCOMFORT;
use serde_json::{Value, json};

use super::buildings;
use super::figures::Figures;
use crate::definition::Experiment;
use crate::results::Results;

/// The controller that is compared.
pub(super) const GUIDELINE: &str = "guideline36";
/// The controller that it is compared with.
const OWN: &str = "own";
/// Relative difference of energy that counts as equal.
const ENERGY_TOLERANCE: f64 = 0.002;

/// The buildings that were run under both.
pub(super) struct Comparison {
    pairs: Vec<Pair>,
}

/// A building with its figures over all periods, under its own controls and under the guideline.
struct Pair {
    building: String,
    own: Figures,
    guideline: Figures,
    /// The period in which the guideline used most energy beyond the building's own controls, with the difference,
    /// kWh/m².
    energy_period: (String, f64),
    /// The same for discomfort, K·h per zone.
    discomfort_period: (String, f64),
}

impl Comparison {
    pub(super) fn of(experiment: &Experiment, results: &Results) -> Self {
        let mut pairs = Vec::new();
        for building_type in &experiment.types {
            let of = |controller| buildings(experiment, results, controller, building_type.name());
            let owns = of(OWN);
            for (building, guideline) in of(GUIDELINE) {
                let own = owns.iter().find(|(name, _)| *name == building);
                pairs.extend(own.and_then(|(_, own)| Pair::of(building, own, &guideline)));
            }
        }
        Self { pairs }
    }

    /// Returns the number of buildings where the guideline holds, if buildings were run under both.
    pub(super) fn tiles(&self) -> Vec<(String, String)> {
        if self.pairs.is_empty() {
            return Vec::new();
        }
        let holds = self.pairs.iter().filter(|pair| pair.holds()).count();
        let name =
            format!("buildings where {GUIDELINE} needs no more energy than {OWN} at no more discomfort");
        vec![(name, format!("{holds} of {}", self.pairs.len()))]
    }

    /// Returns the table of the buildings where the guideline does not hold, if any.
    pub(super) fn tables(&self) -> Option<Value> {
        let rows: Vec<_> = self.pairs.iter().filter(|pair| !pair.holds()).map(Pair::cells).collect();
        let title = format!(
            "all periods together; energy within {:.1} % and discomfort within {FREE_DISCOMFORT} K·h per zone and day count as equal",
            100.0 * ENERGY_TOLERANCE
        );
        (!rows.is_empty()).then(|| {
            json!({
                "name": format!("Where {GUIDELINE} does not hold against {OWN}"),
                "title": title,
                "header": ["building", "energy, own (kWh/m²)", "energy, guideline36", "discomfort, own (K·h per zone)",
                           "discomfort, guideline36", "most energy beyond own", "most discomfort beyond own"],
                "rows": rows,
            })
        })
    }
}

impl Pair {
    /// Compares the periods that ran under both.
    fn of(building: String, own: &[Figures], guideline: &[Figures]) -> Option<Self> {
        let common = |these: &[Figures], others: &[Figures]| -> Vec<Figures> {
            let ran = |each: &&Figures| others.iter().any(|other| other.period == each.period);
            these.iter().filter(ran).cloned().collect()
        };
        let (own, guideline) = (&common(own, guideline)[..], &common(guideline, own)[..]);
        let worst = |value: fn(&Figures) -> f64| {
            let periods = guideline.iter().filter_map(|theirs| {
                let own = own.iter().find(|own| own.period == theirs.period)?;
                Some((theirs.period.clone(), value(theirs) - value(own)))
            });
            periods.max_by(|(_, a), (_, b)| a.total_cmp(b))
        };
        Some(Self {
            building,
            energy_period: worst(Figures::energy)?,
            discomfort_period: worst(|figures| figures.discomfort)?,
            own: Figures::together(own)?,
            guideline: Figures::together(guideline)?,
        })
    }

    /// Returns whether the guideline needs no more energy at no more discomfort, within the tolerances.
    fn holds(&self) -> bool {
        let energy = self.guideline.energy() <= (1.0 + ENERGY_TOLERANCE) * self.own.energy();
        let free = FREE_DISCOMFORT * self.own.days;
        energy && self.guideline.discomfort <= self.own.discomfort + free
    }

    fn cells(&self) -> Vec<String> {
        let number = |value: f64| format!("{value:.2}");
        let worst = |(period, difference): &(String, f64)| format!("{difference:+.2} in {period}");
        vec![
            self.building.clone(),
            number(self.own.energy()),
            number(self.guideline.energy()),
            number(self.own.discomfort),
            number(self.guideline.discomfort),
            worst(&self.energy_period),
            worst(&self.discomfort_period),
        ]
    }
}
