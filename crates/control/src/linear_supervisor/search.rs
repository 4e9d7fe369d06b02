//! The search for the weights of a rule in many buildings at a time.
//!
//! A day hardly depends on the day before, so that an episode tries other weights on each of its days. Around the best
//! rule so far, every round draws mirrored pairs of weights for the days of some episodes, in buildings and periods
//! that differ from round to round. All days so far, each compared with the same day under the guideline, give two
//! response surfaces: of the logarithm of cost, in which a day weighs by its share of the episode, so that every
//! building counts alike, and of discomfort. The next rule has the lowest cost near the last one at which discomfort is
//! the guideline's. Setpoints have no weights: schedules found with foresight do not move them.

use std::path::Path;

use b2b_base::random::{standard_normal, stream};
use b2b_workers::{Episode, RolloutMemory};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use super::surface::{Surface, lowest};
use super::{Rule, Weights};
use crate::foresight::{Days, EpisodeUse};
use crate::guideline36::{Guideline36, Guideline36Parameters, Shift};
use crate::kind::KindDescription;
use crate::parameter_set::to_json;
use crate::search::record_file::RecordFile;
use crate::{Error, Result};

/// Deviation of the first draws, as a share of the limits.
const FIRST_SPREAD: f64 = 0.3;
/// Factor of the deviation from round to round.
const NARROWING: f64 = 0.85;
/// Largest draw, in deviations.
const WIDEST: f64 = 2.0;
/// Largest weight.
const LARGEST: f64 = 1.5;
/// Largest change of a weight by a round, in deviations of its draws.
const REACH: f64 = 1.5;
/// Saving that justifies moving a weight by a deviation of its draws, as a share of the cost, so that noise moves
/// little.
const SIGNIFICANT: f64 = 0.01;
/// Share of an episode's mean day that is added to costs before their ratio, because days off cost nothing.
const LEAST: f64 = 0.05;
/// Bounds of the price of discomfort, as a share of the cost per K·h of a day.
const PRICES: [f64; 2] = [0.003, 10.0];
/// Bisections of the logarithm of the price.
const BISECTIONS: usize = 12;
/// Weights are rounded to thousandths.
const PER_UNIT: f64 = 1000.0;

/// Options of the search for weights.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WeightSearchOptions {
    /// Number of rounds.
    pub rounds: usize,
    /// Episodes of a round, each in another building or period.
    pub episodes: usize,
    /// Mirrored pairs of an episode, which runs once more under the guideline.
    pub pairs: usize,
    /// Random seed.
    pub seed: u64,
}

impl Default for WeightSearchOptions {
    fn default() -> Self {
        Self { rounds: 4, episodes: 8, pairs: 2, seed: 0 }
    }
}

/// An episode under the guideline and under rules.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TriedEpisode {
    /// Names of the shifts that the building has.
    pub shifts: Vec<String>,
    /// The outcome under the guideline, and then of every list of rules.
    pub outcomes: Vec<EpisodeUse>,
}

/// The result of a round.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Round {
    /// Cost relative to the guideline's minus 1, on the response surface.
    pub cost: f64,
    /// Discomfort minus the guideline's, on the response surface, K·h per zone and day.
    pub discomfort: f64,
    /// The rule.
    pub rule: Rule,
}

/// The result of a search.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TunedWeights {
    /// Options of the search.
    pub options: WeightSearchOptions,
    /// The rounds. The last one's rule is the result.
    pub rounds: Vec<Round>,
}

/// Runs an episode under the guideline, and under each list of rules by day.
///
/// # Errors
/// The errors of [`Episode`].
pub fn run(episode: &mut Episode, tried: &[Vec<Rule>]) -> Result<TriedEpisode> {
    let spaces = std::sync::Arc::clone(b2b_env::Environment::spaces(episode));
    let guideline = Guideline36::new(&spaces, &Guideline36Parameters::default());
    let mut shifts: Vec<String> = Vec::new();
    for point in guideline.supervisory_points() {
        let name = point.shift.described().0;
        if shifts.iter().all(|known| known != name) {
            shifts.push(name.to_owned());
        }
    }
    let mut memory = RolloutMemory::new(episode.workers());
    let mut simulate = |rules: &[Rule]| {
        let name = "linear-supervisor".to_owned();
        let controller = KindDescription { name, seed: 0, values: to_json(&rules) }.to_order();
        let mut days = Days::new(spaces.episode.steps_per_hour);
        let metrics = episode.rollout(&controller, &mut memory, &mut days)?;
        Ok(days.outcome(&metrics))
    };
    let nothing = [Rule::default()];
    let all = std::iter::once(&nothing[..]).chain(tried.iter().map(Vec::as_slice));
    Ok(TriedEpisode { shifts, outcomes: all.map(&mut simulate).collect::<Result<_>>()? })
}

/// Runs the episodes of a round: its number, and for each episode the lists of rules by day.
pub type Tries<'a, E> = dyn FnMut(usize, &[Vec<Vec<Rule>>]) -> std::result::Result<Vec<TriedEpisode>, E> + 'a;

/// Searches for a rule in episodes of a number of days. With a record (a file and what the search depends on), an
/// interrupted search resumes.
///
/// # Errors
/// [`Error::OtherTuning`] for the record of another search; [`Error::Io`]; the errors of `tries`.
pub fn tune<E: From<Error>>(
    options: WeightSearchOptions,
    days: usize,
    record: Option<(&Path, &serde_json::Value)>,
    tries: &mut Tries<'_, E>,
) -> std::result::Result<TunedWeights, E> {
    // More rounds continue a search.
    let depends_on = WeightSearchOptions { rounds: 0, ..options };
    let opened = record.map(|(path, head)| RecordFile::open(path, &(head, depends_on))).transpose()?;
    let (mut file, lines) = opened.map_or((None, Vec::new()), |(file, lines)| (Some(file), lines));
    let mut known = lines.into_iter();
    let mut search = WeightSearch::new(options, days);
    let mut rounds = Vec::new();
    for round in 0..options.rounds {
        let draws: Vec<Vec<Draws>> = (0..options.episodes).map(|_| search.draws()).collect();
        let rules = |days: &Draws| days.iter().map(|day| rule(day)).collect::<Vec<Rule>>();
        let sites: Vec<TriedEpisode> = match (known.next(), &mut file) {
            (Some(line), Some(file)) => {
                serde_json::from_str(&line).map_err(|error| file.other(error.to_string()))?
            }
            (_, file) => {
                let sites = tries(
                    round,
                    &draws.iter().map(|all| all.iter().map(rules).collect()).collect::<Vec<_>>(),
                )?;
                file.as_mut().map_or(Ok(()), |file| file.push(&sites))?;
                sites
            }
        };
        draws.iter().zip(&sites).for_each(|(draws, site)| search.learn(draws, site));
        rounds.push(search.improve());
    }
    Ok(TunedWeights { options, rounds })
}

/// The weights of all shifts on each day.
type Draws = Vec<Vec<f64>>;

/// The shifts with weights, in order.
fn shifts() -> Vec<Shift> {
    [Shift::AIR_LOOP, Shift::UNIT, &[Shift::Start]].concat()
}

/// Returns the rule of weights.
fn rule(weights: &[f64]) -> Rule {
    let named = shifts().into_iter().zip(weights.chunks(Weights::COUNT)).map(|(shift, own)| {
        let [constant, cold, heating, cooling] = [0, 1, 2, 3].map(|at: usize| own[at]);
        (shift.described().0.to_owned(), Weights { constant, cold, heating, cooling })
    });
    Rule(named.filter(|(_, own)| *own != Weights::default()).collect())
}

/// A day under a rule, compared with the same day under the guideline.
struct Sample {
    weights: Vec<f64>,
    /// Logarithm of the ratio of costs, and the day's share of the guideline's mean day.
    cost: [f64; 2],
    /// Difference, K·h per zone, and a weight of 1.
    discomfort: [f64; 2],
}

/// A search in progress.
struct WeightSearch {
    options: WeightSearchOptions,
    days: usize,
    random: ChaCha8Rng,
    spread: f64,
    center: Vec<f64>,
    samples: Vec<Sample>,
}

impl WeightSearch {
    fn new(options: WeightSearchOptions, days: usize) -> Self {
        let random = stream("linear supervisor", options.seed, 0);
        let center = vec![0.0; shifts().len() * Weights::COUNT];
        Self { options, days, random, spread: FIRST_SPREAD, center, samples: Vec::new() }
    }

    /// Returns the weights of the mirrored pairs of an episode.
    fn draws(&mut self) -> Vec<Draws> {
        let Self { options, days, random, spread, center, .. } = self;
        let mut all = Vec::new();
        for _ in 0..options.pairs {
            let mut draw = |_: &f64| standard_normal(random).clamp(-WIDEST, WIDEST) * *spread;
            let draws: Draws = (0..*days).map(|_| center.iter().map(&mut draw).collect()).collect();
            for sign in [1.0, -1.0] {
                let moved = |day: &Vec<f64>| {
                    let weights = center.iter().zip(day).map(|(center, draw)| center + sign * draw);
                    weights.map(|weight| weight.clamp(-LARGEST, LARGEST)).collect()
                };
                all.push(draws.iter().map(moved).collect());
            }
        }
        all
    }

    /// Compares the days of an episode with the guideline's. Weights of shifts that the building does not have count as
    /// 0.
    fn learn(&mut self, draws: &[Draws], site: &TriedEpisode) {
        let [guideline, tried @ ..] = &site.outcomes[..] else { return };
        let mean = guideline.used() / guideline.days.len() as f64;
        if mean <= 0.0 {
            return;
        }
        let has = |shift: &Shift| site.shifts.iter().any(|name| name == shift.described().0);
        let present: Vec<bool> = shifts().iter().flat_map(|shift| [has(shift); Weights::COUNT]).collect();
        for (days, outcome) in draws.iter().zip(tried) {
            for ((weights, day), base) in days.iter().zip(&outcome.days).zip(&guideline.days) {
                let own = weights.iter().zip(&present).map(|(weight, has)| if *has { *weight } else { 0.0 });
                let least = LEAST * mean;
                self.samples.push(Sample {
                    weights: own.collect(),
                    cost: [((day.used + least) / (base.used + least)).ln(), base.used / mean],
                    discomfort: [day.discomfort - base.discomfort, 1.0],
                });
            }
        }
    }

    /// Moves the center to the lowest cost near it at which discomfort is at most the guideline's.
    fn improve(&mut self) -> Round {
        let points: Vec<&[f64]> = self.samples.iter().map(|sample| &sample.weights[..]).collect();
        let fit = |value: fn(&Sample) -> [f64; 2]| {
            let values: Vec<[f64; 2]> = self.samples.iter().map(value).collect();
            Surface::fit(&points, &values, Weights::COUNT)
        };
        let (cost, discomfort) = (fit(|sample| sample.cost), fit(|sample| sample.discomfort));
        let is_used = |at: usize| self.samples.iter().any(|sample| sample.weights[at] != 0.0);
        let reach = REACH * self.spread;
        let bounds: Vec<[f64; 2]> = self
            .center
            .iter()
            .enumerate()
            .map(|(at, center)| match is_used(at) {
                true => [(center - reach).max(-LARGEST), (center + reach).min(LARGEST)],
                false => [0.0, 0.0],
            })
            .collect();
        let effort = |(own, center): (&f64, &f64)| SIGNIFICANT * (own - center).abs() / self.spread;
        let best = |price: f64| {
            lowest(&self.center, &bounds, &|point| {
                let moves: f64 = point.iter().zip(&self.center).map(effort).sum();
                cost.at(point) + price * discomfort.at(point) + moves
            })
        };
        let [mut low, mut high] = PRICES.map(f64::ln);
        for _ in 0..BISECTIONS {
            let middle = f64::midpoint(low, high);
            match discomfort.at(&best(middle.exp())) > 0.0 {
                true => low = middle,
                false => high = middle,
            }
        }
        let found = best(high.exp());
        self.center = found.into_iter().map(|weight| (weight * PER_UNIT).round() / PER_UNIT + 0.0).collect();
        self.spread *= NARROWING;
        Round {
            cost: cost.at(&self.center).exp_m1(),
            discomfort: discomfort.at(&self.center),
            rule: rule(&self.center),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::foresight::DayUse;

    /// A day of a building in which warmer supply air saves up to a weight of 0.5, and an earlier start costs energy
    /// and adds comfort.
    fn day(rule: Option<&Rule>) -> DayUse {
        let own = |name: &str| rule.and_then(|rule| rule.0.get(name)).copied().unwrap_or_default().constant;
        let (supply, start) = (own("supply air temperature shift"), own("earlier start"));
        DayUse {
            used: (supply * supply - supply + 0.2 * start).exp(),
            discomfort: 1.0 + 0.4 * supply - 0.4 * start,
        }
    }

    #[test]
    fn a_search_finds_what_saves_at_the_discomfort_of_the_guideline_and_continues_from_its_record() {
        let mut calls = 0;
        let mut tries = |_: usize, episodes: &[Vec<Vec<Rule>>]| {
            calls += 1;
            let site = |tried: &Vec<Vec<Rule>>| {
                let outcome =
                    |rules: &Vec<Rule>| EpisodeUse { days: rules.iter().map(|own| day(Some(own))).collect() };
                let guideline = EpisodeUse { days: vec![day(None); 14] };
                TriedEpisode {
                    shifts: ["supply air temperature shift", "earlier start"].map(str::to_owned).into(),
                    outcomes: std::iter::once(guideline).chain(tried.iter().map(outcome)).collect(),
                }
            };
            Ok::<_, Error>(episodes.iter().map(site).collect())
        };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("search.jsonl");
        let head = serde_json::json!("a building");
        let options = WeightSearchOptions { rounds: 4, episodes: 6, ..WeightSearchOptions::default() };
        let found = tune(options, 14, Some((&path, &head)), &mut tries).unwrap();
        let Round { rule, cost, discomfort } = &found.rounds[3];
        // Lowest x² - x + 0.2 y with x <= y: at x = y = 0.4, or a little less where moves must pay.
        for name in ["supply air temperature shift", "earlier start"] {
            let Weights { constant, cold, heating, cooling } = rule.0[name];
            assert!((0.25..0.45).contains(&constant), "{rule:?}");
            assert_eq!([cold, heating, cooling], [0.0; 3], "{rule:?}");
        }
        assert!(discomfort.abs() < 0.02 && (-0.16..-0.1).contains(cost), "{cost} {discomfort}");
        assert!(rule.0.keys().all(|name| name != "minimum flow shift"), "{rule:?}");
        let fewer = WeightSearchOptions { rounds: 3, ..options };
        let continued = tune(fewer, 14, Some((&path, &head)), &mut tries).unwrap();
        assert_eq!(continued.rounds, found.rounds[..3]);
        assert_eq!(calls, 4);
    }
}
