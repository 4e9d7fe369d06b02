//! `b2b benchmark list` and `b2b benchmark show`.

use anyhow::Result;
use b2b_benchmark::Problem;
use b2b_benchmark::problem::{Protocol, Side, Subset};
use serde_json::json;

use super::selection::Selection;
use crate::terminal::stdout;
use crate::terminal::table::Table;

/// List the benchmark problems
#[derive(clap::Args)]
pub struct ListArguments {
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Describe a problem: training and test environments, budget, seeds and rules
#[derive(clap::Args)]
pub struct ShowArguments {
    /// Print the problem definition as JSON, with all building ids, changes and its hash
    #[arg(long)]
    json: bool,
    // Last, because its heading applies to all arguments after it.
    #[command(flatten)]
    selection: Selection,
}

/// Runs `list`.
pub fn list(arguments: &ListArguments) -> Result<()> {
    if arguments.json {
        return stdout::print_json(&Problem::all());
    }
    let mut table = Table::new(["problem", "family", "trains on", "tests on", "actuators"]);
    for problem in Problem::all() {
        let (train, test) = (&problem.train, &problem.test);
        let on = |side: &Side, other: &Side| match (
            side.buildings == other.buildings,
            side.tasks == other.tasks,
        ) {
            (true, true) => side.buildings.to_string(),
            (true, false) => match side.tasks.len() {
                1 => format!("{}, 1 task", side.buildings),
                tasks => format!("{}, {tasks} tasks", side.buildings),
            },
            _ => format!("{} {}", side.buildings.ids().len(), types(side)),
        };
        table.row([
            problem.name.clone(),
            problem.family.to_string(),
            on(train, test),
            on(test, train),
            actuators(train, test),
        ]);
    }
    stdout::print(&format!("{}\n\n  `b2b benchmark show NAME` describes a problem", table.text()))
}

/// Runs `show`.
pub fn show(arguments: &ShowArguments) -> Result<()> {
    let problem = arguments.selection.problem()?;
    if arguments.json {
        let ids = |side: &Side| side.buildings.ids().iter().map(ToString::to_string).collect::<Vec<_>>();
        return stdout::print_json(&json!({
            "problem": problem, "hash": problem.hash(), "changes": problem.changes(),
            "train_buildings": ids(&problem.train), "test_buildings": ids(&problem.test),
        }));
    }
    stdout::print(&text(&problem))
}

/// Returns the description of a problem.
fn text(problem: &Problem) -> String {
    let sides = [("training environments", side(&problem.train)), ("test environments", side(&problem.test))];
    let modifications = match problem.changes() {
        None => "custom problem".to_owned(),
        Some(changes) if changes.is_empty() => "none".to_owned(),
        Some(changes) => changes.join(", "),
    };
    let identity = [("modifications", modifications), ("hash", problem.hash())];
    let rows = sides.into_iter().chain(rules(&problem.protocol)).chain(identity);
    let rows: Vec<_> = rows.map(|(name, value)| format!("  {name:<23}{value}")).collect();
    format!(
        "{}, version {}: {}\n\n  {}\n\n{}",
        problem.name,
        problem.version,
        problem.family,
        problem.question,
        rows.join("\n")
    )
}

/// Returns the rules of training and testing.
fn rules(protocol: &Protocol) -> [(&'static str, String); 6] {
    let list = |values: &[u64]| values.iter().map(u64::to_string).collect::<Vec<_>>().join(", ");
    let windows: Vec<_> = protocol.windows.iter().map(ToString::to_string).collect();
    let memory = match protocol.consecutive() {
        [] => String::new(),
        periods => format!("; policies keep their memory over these {} episodes", periods.len()),
    };
    let padding = protocol.observation_width.map(|width| format!("; zero-padded to {width} slots"));
    [
        (
            "training budget",
            format!(
                "{} steps per seed; run period {}",
                thousands(protocol.training_steps),
                protocol.training_period
            ),
        ),
        (
            "test run periods",
            format!("{}; {} steps per hour{memory}", windows.join(", "), protocol.steps_per_hour),
        ),
        ("seeds", list(&protocol.seeds)),
        ("adaptation", format!("scored after {} steps in each test environment", list(&protocol.adaptation))),
        ("generalization gap", format!("sample of training buildings, size {}", protocol.train_sample)),
        (
            "observation",
            format!(
                "building attributes {}; form of houses: {}{}",
                protocol.attributes,
                protocol.observation,
                padding.unwrap_or_default()
            ),
        ),
    ]
}

fn side(side: &Side) -> String {
    let mut text = format!("{}; {}", side.buildings, words(side));
    for size in &side.sizes {
        let [low, high] = size.observation;
        let slots = if low == high { low.to_string() } else { format!("{low} to {high}") };
        text += &format!("; {slots} observation slots, {} actions", size.action);
    }
    if let Some(restriction) = &side.restriction {
        text += &format!("; {restriction}");
    }
    text
}

fn words(side: &Side) -> String {
    side.tasks.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}

fn types(side: &Side) -> String {
    let types: Vec<_> = side.buildings.types().iter().map(ToString::to_string).collect();
    let small = match &side.buildings {
        b2b_benchmark::problem::Buildings::Subset { subset: Subset::TestSmall, .. } => " (small test)",
        _ => "",
    };
    types.join(", ") + small
}

fn actuators(train: &Side, test: &Side) -> String {
    let of = |side: &Side| {
        let numbers: Vec<_> = side.sizes.iter().map(|size| size.action.to_string()).collect();
        numbers.join(", ")
    };
    let (train, test) = (of(train), of(test));
    if train == test { train } else { format!("{train} → {test}") }
}

fn thousands(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_problem_description_fits_a_screen() {
        for problem in Problem::all() {
            let text = text(problem);
            assert!(text.contains(&problem.question) && text.lines().count() < 16, "{text}");
        }
        assert_eq!(thousands(4_000_000), "4,000,000");
    }
}
