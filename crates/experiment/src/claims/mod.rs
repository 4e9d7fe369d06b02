//! The paper's claims, judged by results here.
//!
//! Every claim is a quantity with a bound and a margin, and is judged by its interval alone ([`RULE`]). Training runs
//! with fewer steps than the paper's do not count.

mod claim;
mod dynamics;
mod interval;
mod ppo;
mod rewards;
mod select;
mod transfer;
mod weights;

pub use claim::{Judged, RULE, Verdict};

use crate::definition::Experiment;
use crate::results::Results;

/// Returns the paper's claims about an experiment, judged by its results; none if the experiment is not in the paper.
pub fn judge(experiment: &Experiment, results: &Results) -> Vec<Judged> {
    match &experiment.name[..] {
        "ppo" => ppo::judge(results),
        "rewards" => rewards::judge(results),
        "dynamics" => dynamics::judge(results),
        "cross-domain" => transfer::judge(results),
        "weights" => weights::judge(results),
        _ => Vec::new(),
    }
}

/// Returns the claims about all shipped experiments as a Markdown table, each judged by the first results that decide it,
/// and by none if others decide otherwise.
pub fn markdown(all: &[(Experiment, Results)]) -> String {
    let mut text =
        "| experiment | claim of the paper | here | measured | reason |\n|---|---|---|---|---|\n".to_owned();
    for experiment in Experiment::all() {
        let none = Results::none(experiment.budgets().next().expect("every experiment has budgets").clone());
        let own = all.iter().filter(|(other, _)| other.name == experiment.name).map(|(_, results)| results);
        let tables: Vec<Vec<Judged>> =
            own.chain([&none]).map(|results| judge(&experiment, results)).collect();
        for number in 0..tables[0].len() {
            let of_claim = || tables.iter().map(|table| &table[number]);
            let with = |verdict| of_claim().find(|judged| judged.verdict == verdict);
            let [holds, fails] = [Verdict::Holds, Verdict::Fails].map(with);
            let told = holds.or(fails).or_else(|| with(Verdict::Unknown)).unwrap_or(&tables[0][number]);
            let mut told = told.clone();
            if let (Some(_), Some(other)) = (holds, fails) {
                told.verdict = Verdict::Unknown;
                told.reason += &format!("; results in another folder say otherwise: {}", other.measured);
            }
            let Judged { claim, verdict, measured, reason } = told;
            text += &format!("| `{}` | {claim} | {verdict} | {measured} | {reason} |\n", experiment.name);
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use b2b_env::Term;

    use super::*;
    use crate::folder::Folder;

    fn root() -> PathBuf {
        PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
    }

    /// Returns shipped results.
    fn shipped(name: &str) -> (Experiment, Results) {
        let (folder, experiment, budget) = Folder::open(&root().join("results").join(name)).unwrap();
        let results = Results::read(&folder, &experiment, &budget).unwrap();
        (experiment, results)
    }

    fn verdicts(experiment: &Experiment, results: &Results) -> Vec<Verdict> {
        judge(experiment, results).iter().map(|judged| judged.verdict).collect()
    }

    /// Gives the training runs the paper's number of steps, and each agent's episodes the scores of a function.
    fn pretend(results: &mut Results, score: impl Fn(&str, &str) -> f64) {
        for (number, done) in results.done.iter_mut().enumerate() {
            done.steps = 5_000_000;
            for row in &mut done.rows {
                // No two trainings score exactly the same.
                let score = score(&done.agent, &row.info.building_type) * (1.0 + 1e-5 * number as f64);
                let scored = row.outcome.as_mut().unwrap();
                (scored.score, scored.resolved_score) = (Some(score), Some(score));
            }
        }
    }

    /// Gives specialists the houses that the generalists are tested in, which the quick budget does not do.
    fn in_the_same_houses(results: &mut Results) {
        let of = |name: &str| results.of(name).map(|(_, row)| row.info.building.clone()).collect::<Vec<_>>();
        let houses = of("generalist");
        let specialists = results.done.iter_mut().filter(|done| done.agent == "specialist");
        for (done, house) in specialists.zip(houses) {
            done.rows[0].info.building = house;
        }
    }

    #[test]
    fn trainings_with_few_steps_do_not_count() {
        for name in ["ppo", "dynamics", "weights"] {
            let (experiment, results) = shipped(name);
            assert!(
                verdicts(&experiment, &results).iter().all(|verdict| *verdict == Verdict::NoResults),
                "{name}"
            );
        }
    }

    #[test]
    fn claims_about_scores_follow_the_scores() {
        let (experiment, mut results) = shipped("ppo");
        pretend(&mut results, |_, building_type| if building_type == "RetailStandalone" { 2.0 } else { 0.3 });
        use Verdict::{Fails, Holds, Unknown};
        // The second to last is about rows of all types, the last about energy.
        let found = verdicts(&experiment, &results);
        assert_eq!(found[..10], [Holds, Fails, Holds, Holds, Fails, Holds, Fails, Fails, Holds, Fails]);
        // Some agents of short trainings are degenerate.
        assert_eq!(found[10..], [Fails, Fails]);
        pretend(&mut results, |_, _| 1.0);
        assert_eq!(verdicts(&experiment, &results)[..10], [Unknown; 10]);
        // Rows that are missing cannot hold, and one that is there can fail.
        results.done.retain(|done| done.rows.iter().all(|row| row.info.task == "constant"));
        pretend(&mut results, |_, building_type| if building_type == "Warehouse" { 0.3 } else { 2.0 });
        assert_eq!(verdicts(&experiment, &results)[8..], [Unknown, Fails, Unknown, Verdict::NoResults]);

        let (experiment, mut results) = shipped("dynamics");
        in_the_same_houses(&mut results);
        let by = |order: [&'static str; 3]| {
            move |agent: &str, _: &str| {
                0.5 + 0.2 * order.iter().position(|name| *name == agent).unwrap_or(0) as f64
            }
        };
        pretend(&mut results, by(["specialist", "parameterized", "generalist"]));
        assert_eq!(verdicts(&experiment, &results)[..3], [Holds; 3]);
        pretend(&mut results, by(["generalist", "parameterized", "specialist"]));
        assert_eq!(verdicts(&experiment, &results)[..3], [Fails; 3]);
    }

    #[test]
    fn claims_about_energy_follow_the_energy() {
        let (experiment, mut results) = shipped("weights");
        pretend(&mut results, |_, _| 1.0);
        for (number, done) in results.done.iter_mut().enumerate() {
            for row in &mut done.rows {
                let is_high = row.info.task.ends_with("energy5");
                let scored = row.outcome.as_mut().unwrap();
                let baseline = scored.baseline_energy.unwrap();
                let other = 1.0 + 1e-5 * number as f64;
                let electricity = other * if is_high { 0.1 * baseline } else { baseline };
                scored.metrics.terms.set(Term::Gas, 0.0);
                scored.metrics.terms.set(Term::Electricity, electricity);
                scored.metrics.rms_deviation = other * if is_high { 4.0 } else { 1.0 };
            }
        }
        use Verdict::{Fails, Holds};
        assert_eq!(verdicts(&experiment, &results), [Holds, Holds, Fails, Holds]);
    }

    #[test]
    fn every_claim_has_a_row_judged_by_the_shipped_results() {
        let mut names: Vec<_> = std::fs::read_dir(root().join("results"))
            .unwrap()
            .map(|entry| entry.unwrap().file_name())
            .collect();
        names.sort();
        let folders = names.iter().filter_map(|name| name.to_str()).filter(|name| !name.contains('.'));
        let all: Vec<(Experiment, Results)> = folders.map(shipped).collect();
        assert!(all.len() > 9);
        for (experiment, results) in &all {
            assert!(results.missing.is_empty() && !results.done.is_empty(), "{}", experiment.name);
        }
        let text = markdown(&all);
        let rows =
            |name: &str| text.lines().filter(|line| line.starts_with(&format!("| `{name}` |"))).count();
        assert_eq!(["ppo", "rewards", "dynamics", "cross-domain", "weights"].map(rows), [12, 2, 7, 2, 4]);
        assert_eq!(text.lines().count(), 2 + 27);
        // Only `cross-domain` is there with the paper's steps, and the reactive controllers are not trained.
        let told = text.lines().skip(2).filter(|line| !line.contains("no results yet"));
        let told: Vec<&str> = told.map(|line| line.split('`').nth(1).unwrap()).collect();
        assert_eq!(told, ["rewards", "rewards", "cross-domain", "cross-domain"]);
    }
}
