//! The search for a schedule.
//!
//! What a building does on one day hardly depends on the day before, so one episode can try a different point on each
//! of its days. The search begins with a survey: each kind of value alone, the same at all hours, and then together
//! what saved on a day. Rounds refine the best. A round tries mirrored pairs around the best point and estimates from
//! them the slope of every day's objective; then it goes down the slopes by steps of several lengths. The best point
//! tried on a day is its next center. The objective of a day is its cost plus a price on discomfort: the lowest price
//! at which the best days together have no more discomfort than under the guideline, apart from what counts as none.

use b2b_base::random::{standard_normal, stream};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::outcome::{DayUse, EpisodeUse};
use super::response::{Pair, slopes};
use crate::Result;
use crate::search::SAME_DISCOMFORT;

/// Values of the survey, as shares of the lowest and of the highest value.
const SURVEYED: [f64; 2] = [0.5, 1.0];
/// Shares of the values that saved alone, tried together.
const TOGETHER: [f64; 2] = [0.5, 1.0];
/// Deviation of the first pairs, in units of the values.
const FIRST_SPREAD: f64 = 0.25;
/// Factor of the deviation from round to round.
const NARROWING: f64 = 0.85;
/// Largest draw, in deviations.
const WIDEST: f64 = 2.0;
/// Share of the values that a pair varies on a day.
const VARIED: f64 = 0.2;
/// Lengths of the steps down the slopes, in deviations of the pairs.
const LENGTHS: [f64; 3] = [0.3, 1.0, 3.0];
/// Price of discomfort in scores, in days of the guideline's cost per K·h: as in the score at comfort.
const SCORE_PRICE: f64 = b2b_env::OPERATION_WEIGHT / 24.0;
/// Bounds of the price of a round.
const PRICES: [f64; 2] = [0.01, 10.0];
/// Bisections of the logarithm of the price.
const BISECTIONS: usize = 20;
/// Difference of a day's objective that counts as none, in days of the guideline's cost.
const RESOLUTION: f64 = 2e-4;

/// A point of the search: for each day, values in units of their own.
pub(super) type Point = Vec<Vec<f64>>;

/// Runs an episode under each point, and returns the outcomes.
pub(super) type Run<'a> = dyn FnMut(&[Point]) -> Result<Vec<EpisodeUse>> + 'a;

/// Size and seed of a search.
#[derive(Clone, Copy, Debug)]
pub(super) struct Effort {
    /// Number of rounds.
    pub(super) rounds: usize,
    /// Mirrored pairs of a round.
    pub(super) pairs: usize,
    /// Random seed.
    pub(super) seed: u64,
}

impl Effort {
    /// Returns the number of episodes of a search between bounds, in which `parts` may be left out.
    pub(super) fn episodes(self, bounds: &[[f64; 2]], parts: &[Vec<usize>]) -> usize {
        let survey = 1 + surveyed(bounds, parts).count() + TOGETHER.len();
        survey + self.rounds * (1 + 2 * self.pairs + LENGTHS.len()) + 2 + parts.len()
    }
}

/// Result of a search.
#[derive(Clone, Debug)]
pub(super) struct Found {
    pub(super) point: Point,
    pub(super) outcome: EpisodeUse,
    /// The guideline itself.
    pub(super) baseline: EpisodeUse,
    /// Score without each part minus the score.
    pub(super) shares: Vec<f64>,
}

/// A search in progress.
struct ScheduleSearch<'a> {
    bounds: &'a [[f64; 2]],
    random: ChaCha8Rng,
    spread: f64,
    price: f64,
    /// What was tried on each day, the guideline first.
    known: Vec<Vec<Known>>,
    /// The best values of each day.
    center: Point,
    /// Mirrored pairs of the last two rounds by day, without prices.
    tried: Vec<Vec<Tried>>,
    baseline: EpisodeUse,
    best: Best,
}

/// Values of a day, with their latest outcome.
struct Known {
    values: Vec<f64>,
    outcome: DayUse,
}

/// A mirrored pair of a day.
struct Tried {
    difference: Vec<f64>,
    outcomes: [DayUse; 2],
}

/// The best whole episode.
struct Best {
    point: Point,
    outcome: EpisodeUse,
    score: f64,
}

/// Returns the days of a survey, each with the number of the part that it tries.
fn surveyed<'a>(
    bounds: &'a [[f64; 2]],
    parts: &'a [Vec<usize>],
) -> impl Iterator<Item = (usize, Vec<f64>)> + 'a {
    let alone = |part: &'a [usize], end: usize, share: f64| {
        let mut day = vec![0.0; bounds.len()];
        part.iter().for_each(|&index| day[index] = share * bounds[index][end]);
        day
    };
    parts.iter().enumerate().flat_map(move |(number, part)| {
        let values = [0, 1].into_iter().flat_map(|end| SURVEYED.map(|share| (end, share)));
        let days = values.map(move |(end, share)| (number, alone(part, end, share)));
        days.filter(|(_, day)| day.iter().any(|value| *value != 0.0))
    })
}

/// Returns the discomfort that counts as the baseline's, K·h per zone.
fn limit(baseline: &EpisodeUse) -> f64 {
    baseline.discomfort() + SAME_DISCOMFORT * baseline.days.len() as f64
}

/// Returns the cost of an episode relative to the baseline, plus a penalty for more discomfort than the baseline's,
/// priced as in the score at comfort.
pub(super) fn score(outcome: &EpisodeUse, baseline: &EpisodeUse) -> f64 {
    let days = baseline.days.len() as f64;
    let excess = (outcome.discomfort() - limit(baseline)).max(0.0);
    outcome.used() / baseline.used() + SCORE_PRICE * excess / days
}

/// Returns whether an episode has no more discomfort than the baseline.
fn holds(outcome: &EpisodeUse, baseline: &EpisodeUse) -> bool {
    outcome.discomfort() <= limit(baseline)
}

/// Searches for a point with the lowest score at no more discomfort than the baseline. `parts` are sets of positions in
/// a day, each of which is left out where it saves nothing. A baseline that uses nothing cannot be improved.
///
/// # Errors
/// The errors of `run`.
pub(super) fn search(
    bounds: &[[f64; 2]],
    days: usize,
    parts: &[Vec<usize>],
    effort: Effort,
    run: &mut Run<'_>,
) -> Result<Found> {
    let zero = vec![vec![0.0; bounds.len()]; days];
    let baseline = one(run, &zero)?;
    let best = Best { point: zero.clone(), outcome: baseline.clone(), score: 1.0 };
    if baseline.used() <= 0.0 || bounds.is_empty() {
        let shares = vec![0.0; parts.len()];
        return Ok(Found { point: zero, outcome: baseline.clone(), baseline, shares });
    }
    let known =
        |(values, outcome): (&Vec<f64>, &DayUse)| vec![Known { values: values.clone(), outcome: *outcome }];
    let mut search = ScheduleSearch {
        bounds,
        random: stream("foresight", effort.seed, 0),
        spread: FIRST_SPREAD,
        price: SCORE_PRICE,
        known: zero.iter().zip(&baseline.days).map(known).collect(),
        center: zero,
        tried: (0..days).map(|_| Vec::new()).collect(),
        baseline,
        best,
    };
    search.survey(parts, run)?;
    for _ in 0..effort.rounds {
        search.round(effort.pairs, run)?;
    }
    search.run_center(run)?;
    search.without(parts, run)
}

fn one(run: &mut Run<'_>, point: &Point) -> Result<EpisodeUse> {
    Ok(run(std::slice::from_ref(point))?.remove(0))
}

impl ScheduleSearch<'_> {
    /// Tries each part alone, then together those that save on a day.
    fn survey(&mut self, parts: &[Vec<usize>], run: &mut Run<'_>) -> Result<()> {
        let days = self.center.len();
        let (numbers, points): (Vec<usize>, Vec<Point>) =
            surveyed(self.bounds, parts).map(|(part, day)| (part, vec![day; days])).unzip();
        let outcomes = self.run(&points, run)?;
        self.choose(limit(&self.baseline));
        let mut together = vec![vec![0.0; self.bounds.len()]; days];
        for (day, values) in together.iter_mut().enumerate() {
            let objective = |number: usize| self.objective(outcomes[number].days[day]);
            let none = self.objective(self.baseline.days[day]) - RESOLUTION;
            for (part, positions) in parts.iter().enumerate() {
                let of_part = (0..points.len()).filter(|&number| numbers[number] == part);
                let best = of_part.min_by(|&a, &b| objective(a).total_cmp(&objective(b)));
                if let Some(best) = best.filter(|&best| objective(best) < none) {
                    positions.iter().for_each(|&index| values[index] = points[best][day][index]);
                }
            }
        }
        let scaled = |share: f64| -> Point {
            together.iter().map(|day| day.iter().map(|value| share * value).collect()).collect()
        };
        self.run(&TOGETHER.map(scaled), run)?;
        self.choose(limit(&self.baseline));
        Ok(())
    }

    /// Tries pairs and steps, and moves each day to its best.
    fn round(&mut self, pairs: usize, run: &mut Run<'_>) -> Result<()> {
        let allowed = self.run_center(run)?;
        let points: Vec<Point> = (0..pairs).flat_map(|_| self.pair()).collect();
        let outcomes = self.run(&points, run)?;
        self.learn(&points, &outcomes, pairs);
        self.choose(allowed);
        self.run(&self.steps(), run)?;
        self.choose(allowed);
        self.spread *= NARROWING;
        Ok(())
    }

    /// Runs the best values of all days in one episode. Returns the sum of discomfort that the days may have by what is
    /// known of each: less than the limit by what the days add to one another.
    fn run_center(&mut self, run: &mut Run<'_>) -> Result<f64> {
        let center = self.center.clone();
        let outcome = self.run(std::slice::from_ref(&center), run)?.remove(0);
        let limit = limit(&self.baseline);
        Ok(limit - (outcome.discomfort() - limit).max(0.0))
    }

    /// Runs points, remembers their days and keeps the best episode.
    fn run(&mut self, points: &[Point], run: &mut Run<'_>) -> Result<Vec<EpisodeUse>> {
        let outcomes = run(points)?;
        for (point, outcome) in points.iter().zip(&outcomes) {
            self.best.keep(point, outcome, &self.baseline);
            for ((known, values), &outcome) in self.known.iter_mut().zip(point).zip(&outcome.days) {
                match known.iter_mut().find(|known| known.values == *values) {
                    Some(known) => known.outcome = outcome,
                    None => known.push(Known { values: values.clone(), outcome }),
                }
            }
        }
        Ok(outcomes)
    }

    /// Returns a mirrored pair around the center, within the bounds. Each varies a few values.
    fn pair(&mut self) -> [Point; 2] {
        let [mut up, mut down] = [self.center.clone(), self.center.clone()];
        for (up, down) in up.iter_mut().zip(&mut down) {
            for ((up, down), [low, high]) in up.iter_mut().zip(down).zip(self.bounds) {
                if self.random.random::<f64>() < VARIED {
                    let draw = standard_normal(&mut self.random).clamp(-WIDEST, WIDEST) * self.spread;
                    *up = (*up + draw).clamp(*low, *high);
                    *down = (*down - draw).clamp(*low, *high);
                }
            }
        }
        [up, down]
    }

    /// Moves each day to its best under the lowest price at which the days together have no more discomfort than is
    /// allowed.
    fn choose(&mut self, allowed: f64) {
        let [mut low, mut high] = PRICES.map(f64::ln);
        for _ in 0..BISECTIONS {
            self.price = f64::midpoint(low, high).exp();
            let discomfort: f64 = self.known.iter().map(|day| self.best_of(day).outcome.discomfort).sum();
            match discomfort > allowed {
                true => low = self.price.ln(),
                false => high = self.price.ln(),
            }
        }
        self.price = high.exp();
        self.center = self.known.iter().map(|day| self.best_of(day).values.clone()).collect();
    }

    /// Remembers the pairs of this round and of the last.
    fn learn(&mut self, points: &[Point], outcomes: &[EpisodeUse], pairs: usize) {
        for (day, tried) in self.tried.iter_mut().enumerate() {
            let old = tried.len().saturating_sub(pairs);
            tried.drain(..old);
            for (points, outcomes) in points.chunks(2).zip(outcomes.chunks(2)) {
                let [up, down] = [0, 1].map(|side: usize| &points[side][day]);
                let difference = up.iter().zip(down).map(|(up, down)| (up - down) / 2.0).collect();
                let outcomes = [0, 1].map(|side: usize| outcomes[side].days[day]);
                tried.push(Tried { difference, outcomes });
            }
        }
    }

    /// Returns the objective of a day, in days of the guideline's cost.
    fn objective(&self, day: DayUse) -> f64 {
        let mean = self.baseline.used() / self.baseline.days.len() as f64;
        day.used / mean + self.price * day.discomfort
    }

    /// Returns points down the slopes, one for each length.
    fn steps(&self) -> Vec<Point> {
        let pair = |tried: &Tried| {
            let [up, down] = tried.outcomes.map(|day| self.objective(day));
            Pair { difference: tried.difference.clone(), gain: (up - down) / 2.0 }
        };
        let pairs: Vec<Vec<Pair>> = self.tried.iter().map(|tried| tried.iter().map(pair).collect()).collect();
        let slopes = slopes(&pairs);
        let point = |length: &f64| {
            let days = self.center.iter().zip(&slopes);
            days.map(|(center, slope)| self.step(center, slope, length * self.spread)).collect()
        };
        LENGTHS.iter().map(point).collect()
    }

    /// Returns a day's values after a step of this length down its slope.
    fn step(&self, center: &[f64], slope: &[f64], length: f64) -> Vec<f64> {
        let mean_square = slope.iter().map(|slope| slope * slope).sum::<f64>() / slope.len() as f64;
        if mean_square <= 0.0 {
            return center.to_vec();
        }
        let values = center.iter().zip(slope).zip(self.bounds);
        let step = |slope: f64| (slope / mean_square.sqrt()).clamp(-WIDEST, WIDEST) * length;
        values.map(|((center, slope), [low, high])| (center - step(*slope)).clamp(*low, *high)).collect()
    }

    /// Returns the best of what is known of a day; the guideline, unless another is better by [`RESOLUTION`].
    fn best_of<'a>(&self, day: &'a [Known]) -> &'a Known {
        let mut best = (&day[0], self.objective(day[0].outcome) - RESOLUTION);
        for known in &day[1..] {
            let objective = self.objective(known.outcome);
            if objective < best.1 {
                best = (known, objective);
            }
        }
        best.0
    }

    /// Leaves out each part on the days on which it saves nothing, and returns what was found.
    fn without(mut self, parts: &[Vec<usize>], run: &mut Run<'_>) -> Result<Found> {
        let whole = (self.best.point.clone(), self.best.outcome.clone(), self.best.score);
        let without = |part: &Vec<usize>| {
            let mut point = whole.0.clone();
            point.iter_mut().for_each(|day| part.iter().for_each(|&index| day[index] = 0.0));
            point
        };
        let outcomes = run(&parts.iter().map(without).collect::<Vec<_>>())?;
        let shares: Vec<f64> =
            outcomes.iter().map(|outcome| score(outcome, &self.baseline) - whole.2).collect();
        let mut sparse = whole.0.clone();
        for (part, outcome) in parts.iter().zip(&outcomes) {
            for (day, values) in sparse.iter_mut().enumerate() {
                let [with, without] = [&whole.1, outcome].map(|outcome| self.objective(outcome.days[day]));
                if without < with + RESOLUTION {
                    part.iter().for_each(|&index| values[index] = 0.0);
                }
            }
        }
        let outcome = one(run, &sparse)?;
        // As good as the whole, and better than the guideline.
        let bound = (whole.2 + RESOLUTION * parts.len() as f64).min(1.0);
        let as_good = score(&outcome, &self.baseline) < bound;
        if as_good && holds(&outcome, &self.baseline) {
            self.best.point = sparse;
            self.best.outcome = outcome;
        }
        let Best { point, outcome, .. } = self.best;
        Ok(Found { point, outcome, baseline: self.baseline, shares })
    }
}

impl Best {
    /// Keeps an episode if it is better, at no more discomfort than the baseline.
    fn keep(&mut self, point: &Point, outcome: &EpisodeUse, baseline: &EpisodeUse) {
        let score = score(outcome, baseline);
        if score < self.score && holds(outcome, baseline) {
            *self = Self { point: point.clone(), outcome: outcome.clone(), score };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EFFORT: Effort = Effort { rounds: 8, pairs: 4, seed: 0 };
    const BOUNDS: [[f64; 2]; 4] = [[-1.0, 1.0]; 4];

    /// A cost with its lowest value at 0.6 and -0.3, flat in the last value, and discomfort from a value of 0.2 of the
    /// third on, which saves cost.
    fn toy(points: &[Point]) -> Result<Vec<EpisodeUse>> {
        let day = |day: &Vec<f64>| DayUse {
            used: 10.0 + 4.0 * (day[0] - 0.6).powi(2) + 4.0 * (day[1] + 0.3).powi(2) - 2.0 * day[2],
            discomfort: 1.0 + 3.0 * (day[2] - 0.2).max(0.0),
        };
        Ok(points.iter().map(|point| EpisodeUse { days: point.iter().map(day).collect() }).collect())
    }

    fn parts() -> Vec<Vec<usize>> {
        (0..4).map(|index| vec![index]).collect()
    }

    #[test]
    fn the_lowest_cost_at_the_discomfort_of_the_baseline_is_found() {
        let found = search(&BOUNDS, 14, &parts(), EFFORT, &mut toy).unwrap();
        assert!(found.outcome.discomfort() <= limit(&found.baseline), "{}", found.outcome.discomfort());
        // 10 - 0.4 instead of 11.8, where discomfort begins.
        let ratio = found.outcome.used() / found.baseline.used();
        assert!(ratio < 0.84, "{ratio}");
        assert!(found.point.iter().all(|day| day[3] == 0.0), "a value without effect is left out");
        assert!(found.shares[0] > 0.05 && found.shares[3].abs() < 1e-12, "{:?}", found.shares);
    }

    #[test]
    fn a_search_runs_the_episodes_it_announces_and_repeats_with_its_seed() {
        let count = std::cell::Cell::new(0);
        let mut counted = |points: &[Point]| {
            count.set(count.get() + points.len());
            toy(points)
        };
        let first = search(&BOUNDS, 3, &parts(), EFFORT, &mut counted).unwrap();
        assert_eq!(count.get(), EFFORT.episodes(&BOUNDS, &parts()));
        assert_eq!(search(&BOUNDS, 3, &parts(), EFFORT, &mut toy).unwrap().point, first.point);
        let other = search(&BOUNDS, 3, &parts(), Effort { seed: 1, ..EFFORT }, &mut toy).unwrap();
        assert_ne!(other.point, first.point);
    }

    #[test]
    fn what_is_left_without_parts_that_save_little_is_better_than_the_guideline() {
        // The values save little together, and cost a little one at a time.
        let day = |day: &Vec<f64>| DayUse {
            used: 10.0 + if day.iter().all(|value| *value > 0.4) { -0.003 } else { 0.0005 * day[0].abs() },
            discomfort: 1.0,
        };
        let mut slight = |points: &[Point]| {
            Ok(points.iter().map(|point| EpisodeUse { days: point.iter().map(day).collect() }).collect())
        };
        let bounds = [[0.0, 1.0]; 2];
        let parts = [vec![0, 1], vec![1]];
        let found = search(&bounds, 3, &parts, EFFORT, &mut slight).unwrap();
        assert!(found.outcome.used() < found.baseline.used(), "{:?}", found.point);
    }

    #[test]
    fn nothing_is_better_than_a_baseline_that_uses_nothing() {
        let mut free =
            |points: &[Point]| Ok(vec![EpisodeUse { days: vec![DayUse::default(); 2] }; points.len()]);
        let found = search(&BOUNDS, 2, &parts(), EFFORT, &mut free).unwrap();
        assert_eq!((found.point, found.shares), (vec![vec![0.0; 4]; 2], vec![0.0; 4]));
    }
}
