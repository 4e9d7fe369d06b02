//! The help text of `b2b`: where to start, and the commands by purpose.

use crate::terminal::wrap;

/// Commands by purpose.
const GROUPS: &[(&str, &[&str])] = &[
    ("Simulate", &["run", "compare"]),
    ("Explore buildings", &["list", "show", "view"]),
    ("Your own models", &["import", "edit", "calibrate"]),
    ("Train agents", &["train", "collect", "clone", "export"]),
    ("Evaluate policies", &["evaluate", "score", "benchmark", "experiment"]),
    ("Other programs", &["serve"]),
    ("Dataset and baselines", &["dataset", "generate", "check", "tune", "baseline"]),
    ("Installation and performance", &["setup", "doctor", "bench"]),
];

const START: &str = "\
Start here:
  b2b run OfficeSmall       Simulate a winter: metrics, trajectory, plots
  b2b show OfficeSmall      Describe the building, observation and action
  b2b view OfficeSmall      Draw the building in 3D";

const NOTES: &str = "\
Run `b2b COMMAND --help` for arguments and examples.

EnergyPlus and weather files are downloaded automatically on first use (with pip) into a cache folder.

Environment variables:
  B2B_ENERGYPLUS   folder or library of an EnergyPlus installation to use instead of the downloaded one
  B2B_CACHE        cache folder
  B2B_OFFLINE=1    never download

Exit codes: 0 success, 1 failure, 2 usage error, 130 interrupted.";

/// Sets the help text of a parser.
pub fn add(parser: clap::Command) -> clap::Command {
    let start = wrap::lines(&format!("{START}\n\n{}", commands(&parser)), wrap::help_width());
    parser
        .help_template(format!(
            "{{about}}\n\n{{usage-heading}} {{usage}}\n\n{start}\nOptions:\n{{options}}{{after-help}}"
        ))
        .after_help(NOTES)
}

/// Returns the names of the commands that the help text lists.
#[cfg(test)]
pub fn listed() -> impl Iterator<Item = &'static str> {
    GROUPS.iter().flat_map(|(_, names)| names.iter().copied())
}

/// Returns the commands by purpose, each with its description.
fn commands(parser: &clap::Command) -> String {
    let about = |name: &str| {
        let about = parser.find_subcommand(name).and_then(clap::Command::get_about);
        about.map(ToString::to_string).unwrap_or_default()
    };
    let group = |(title, names): &(&str, &[&str])| {
        let lines: String = names.iter().map(|name| format!("  {name:<11}{}\n", about(name))).collect();
        format!("{title}:\n{lines}\n")
    };
    GROUPS.iter().map(group).collect()
}
