//! The bootstrap of scores, which draws what another experiment would draw: buildings and trained agents.
//!
//! 1. Buildings are drawn within their type, each with all of its scores: those under other tasks, in other run
//!    periods and of other seeds are no further buildings. Types with one or two buildings, which would hardly vary,
//!    are drawn together.
//! 2. The seeds of an agent are drawn once for all of its buildings. The seeds of one that acts in a single building
//!    are part of that building's scores, and are drawn only if there is no other building to draw.

use std::collections::{BTreeMap, BTreeSet};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::evaluation::EpisodeInfo;
use crate::statistics::{CONFIDENCE, DRAWS, FEWEST, Interval, quantile};

/// A score with what it shares with others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample<'a> {
    /// Building type.
    pub building_type: &'a str,
    /// The building.
    pub building: &'a str,
    /// Task and run period. Scores in the same building and case are averaged and count as one.
    pub case: [&'a str; 2],
    /// The agent, the same for all of its seeds.
    pub agent: &'a str,
    /// Seed of the agent.
    pub seed: u64,
    /// The score, or another quantity.
    pub score: f64,
}

impl<'a> Sample<'a> {
    /// Returns the score of an episode whose agent is the only one.
    pub fn of(info: &'a EpisodeInfo, score: f64) -> Self {
        let EpisodeInfo { building_type, building, task, period, seed, .. } = info;
        Self { building_type, building, case: [task, period], agent: "", seed: *seed, score }
    }

    /// Returns the sample as one of a mean over all tasks and run periods.
    pub fn of_building(self) -> Self {
        Self { case: [""; 2], ..self }
    }
}

/// Lists of samples as they are drawn.
pub(crate) struct Design<'a> {
    lists: usize,
    /// Buildings that are drawn among each other.
    strata: Vec<Vec<usize>>,
    /// The cases of each building.
    buildings: Vec<Vec<Case<'a>>>,
    /// The agents whose seeds are drawn, as lists of runs.
    agents: Vec<Vec<usize>>,
    /// Equal weights of the runs.
    equal: Vec<f64>,
}

/// Scores in a list that are averaged, each with its run: the number of its agent and seed.
struct Case<'a> {
    list: usize,
    name: [&'a str; 2],
    scores: Vec<(usize, f64)>,
}

/// The runs of an agent, and the buildings that it acts in.
#[derive(Default)]
struct Agent {
    runs: BTreeSet<usize>,
    buildings: BTreeSet<usize>,
}

impl<'a> Design<'a> {
    pub(crate) fn of(lists: &[&[Sample<'a>]]) -> Self {
        let (mut known, mut runs) = (Vec::new(), Vec::new());
        let mut buildings: Vec<Vec<Case<'a>>> = Vec::new();
        let mut agents: BTreeMap<&str, Agent> = BTreeMap::new();
        let samples =
            lists.iter().enumerate().flat_map(|(list, own)| own.iter().map(move |each| (list, each)));
        for (list, sample) in samples {
            let building = number(&mut known, (sample.building_type, sample.building));
            let run = number(&mut runs, (sample.agent, sample.seed));
            buildings.resize_with(known.len(), Vec::new);
            let cases = &mut buildings[building];
            match cases.iter_mut().rev().find(|case| (case.list, case.name) == (list, sample.case)) {
                Some(case) => case.scores.push((run, sample.score)),
                None => cases.push(Case { list, name: sample.case, scores: vec![(run, sample.score)] }),
            }
            let agent = agents.entry(sample.agent).or_default();
            agent.runs.insert(run);
            agent.buildings.insert(building);
        }
        let strata = strata(&known, &buildings);
        let agents = agents.into_values().filter(|agent| agent.is_drawn(&strata));
        let agents = agents.map(|agent| agent.runs.into_iter().collect()).collect();
        Self { lists: lists.len(), strata, buildings, agents, equal: vec![1.0; runs.len()] }
    }

    /// Returns the mean of each case, by list.
    pub(crate) fn means(&self) -> Vec<Vec<f64>> {
        let mut means = vec![Vec::new(); self.lists];
        (0..self.buildings.len()).for_each(|building| self.add(building, &self.equal, &mut means));
        means
    }

    /// Returns measures of the means, which are given by list in the order of the buildings, with their intervals;
    /// `None` if a list is empty. The intervals are always the same.
    pub(crate) fn intervals(&self, measure: impl Fn(&mut [Vec<f64>]) -> Vec<f64>) -> Option<Vec<Interval>> {
        let mut means = self.means();
        if means.iter().any(Vec::is_empty) {
            return None;
        }
        let values = measure(&mut means);
        let mut random = ChaCha8Rng::seed_from_u64(0);
        let mut drawn = vec![Vec::with_capacity(DRAWS); values.len()];
        for _ in 0..DRAWS {
            means.iter_mut().for_each(Vec::clear);
            self.draw(&mut random, &mut means);
            for (drawn, value) in drawn.iter_mut().zip(measure(&mut means)) {
                drawn.push(value);
            }
        }
        let tail = (1.0 - CONFIDENCE) / 2.0;
        let interval = |(mut drawn, value): (Vec<f64>, f64)| {
            drawn.sort_by(f64::total_cmp);
            Interval { value, low: quantile(&drawn, tail), high: quantile(&drawn, 1.0 - tail) }
        };
        Some(drawn.into_iter().zip(values).map(interval).collect())
    }

    /// Adds the means of a resample.
    fn draw(&self, random: &mut ChaCha8Rng, means: &mut [Vec<f64>]) {
        let mut weights = self.equal.clone();
        for runs in &self.agents {
            runs.iter().for_each(|run| weights[*run] = 0.0);
            runs.iter().for_each(|_| weights[runs[random.random_range(0..runs.len())]] += 1.0);
        }
        for stratum in &self.strata {
            for _ in stratum {
                self.add(stratum[random.random_range(0..stratum.len())], &weights, means);
            }
        }
    }

    /// Adds the means of a building's cases under weights of the runs. A case without any of the drawn runs, because
    /// episodes were lost, counts with all of its scores.
    fn add(&self, building: usize, weights: &[f64], means: &mut [Vec<f64>]) {
        for Case { list, scores, .. } in &self.buildings[building] {
            let is_drawn = scores.iter().any(|(run, _)| weights[*run] > 0.0);
            let weights = if is_drawn { weights } else { &self.equal };
            // An infinite score with weight 0 would not be a number.
            let drawn = scores.iter().filter(|(run, _)| weights[*run] > 0.0);
            let (sum, total) = drawn.fold((0.0, 0.0), |(sum, total), (run, score)| {
                (sum + weights[*run] * score, total + weights[*run])
            });
            means[*list].push(sum / total);
        }
    }
}

impl Agent {
    /// Returns whether its seeds are drawn: unless they vary with a building that is drawn among several.
    fn is_drawn(&self, strata: &[Vec<usize>]) -> bool {
        let is_alone = || strata.iter().any(|all| all.len() == 1 && self.buildings.contains(&all[0]));
        self.runs.len() > 1 && (self.buildings.len() > 1 || is_alone())
    }
}

/// Groups buildings by type and by the lists that they are in, in order of first appearance; types with fewer than
/// [`FEWEST`] buildings together.
fn strata(known: &[(&str, &str)], buildings: &[Vec<Case<'_>>]) -> Vec<Vec<usize>> {
    let lists = |cases: &Vec<Case<'_>>| cases.iter().fold(0_u8, |lists, case| lists | 1 << case.list);
    let all: Vec<(&str, u8)> = known
        .iter()
        .zip(buildings)
        .map(|((building_type, _), cases)| (*building_type, lists(cases)))
        .collect();
    let (mut keys, mut strata) = (Vec::new(), Vec::<Vec<usize>>::new());
    for (building, key) in all.iter().enumerate() {
        let is_few = all.iter().filter(|other| *other == key).count() < FEWEST;
        let stratum = number(&mut keys, if is_few { (None, key.1) } else { (Some(key.0), key.1) });
        strata.resize_with(keys.len(), Vec::new);
        strata[stratum].push(building);
    }
    strata
}

/// Returns the position of a key, which is added if it is new. Equal keys are mostly adjacent.
fn number<K: PartialEq>(keys: &mut Vec<K>, key: K) -> usize {
    keys.iter().rposition(|known| *known == key).unwrap_or_else(|| {
        keys.push(key);
        keys.len() - 1
    })
}
