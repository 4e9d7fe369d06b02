//! `b2b doctor`: what is installed and whether it is whole.

use std::process::ExitCode;

use anyhow::Result;
use b2b_building::{BuildingType, RunPeriod};
use b2b_climate::weather::PACKAGES;
use b2b_dataset::BuildingName;
use b2b_energyplus::Level;
use b2b_energyplus::install::doctor::{Finding, Health, report};
use b2b_energyplus::install::{Cache, Engine};
use b2b_env::{Task, authority};
use serde_json::json;

use crate::prepare::{Location, Prepared};
use crate::stdout;
use b2b_control::{Constant, Controller};

/// Tell what is installed and whether it is whole
///
/// Every cached file is read and compared with its SHA-256. Exits with 1 when something has to be
/// put right.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  b2b doctor                 the cache, the engine, the weather, the package client
  b2b doctor OfficeSmall     and one simulated day of that building
  b2b doctor --authority OfficeSmall     what each of its actuators is told, and what it then does
  b2b doctor --authority my.idf --weather my.epw")]
pub struct Arguments {
    /// Building type to try out: prepare it and run one day
    #[arg(value_name = "TYPE")]
    building_type: Option<BuildingType>,
    /// Drive every actuator of this building (a type, an id, a model file) low, middle and high in a winter
    /// and a summer day, and compare the physical quantity with the command; exits with 1 when one does
    /// not obey
    #[arg(long, value_name = "BUILDING", conflicts_with = "building_type")]
    authority: Option<BuildingName>,
    #[command(flatten)]
    location: Location,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command; exit code 1 when a finding is bad.
pub fn doctor(arguments: &Arguments) -> Result<ExitCode> {
    if let Some(building) = &arguments.authority {
        return authority(building, &arguments.location, arguments.json);
    }
    let installed = Engine::installed_by_user();
    let mut findings = report(&Cache::from_env()?, installed.as_deref(), &PACKAGES);
    findings.extend(arguments.building_type.map(|each| building(each, arguments.json)));
    print(&findings, arguments.json)?;
    let bad = findings.iter().any(|finding| finding.health == Health::Bad);
    Ok(if bad { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}

/// Measures what the actuators of a building do; exit code 1 when one does not obey.
fn authority(building: &BuildingName, location: &Location, json: bool) -> Result<ExitCode> {
    let prepared = Prepared::new(building, location, json)?;
    let report = authority::measure(&prepared.library, &prepared.building, &prepared.weather)?;
    if json {
        stdout::print_json(&report)?;
    } else {
        stdout::print(&report.to_string())?;
    }
    Ok(if report.failures().next().is_none() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Tries a building out.
fn building(building_type: BuildingType, quiet: bool) -> Finding {
    let (health, detail) = match one_day(building_type, quiet) {
        Ok(detail) => (Health::Good, detail),
        Err(error) => (Health::Bad, format!("{error:#}")),
    };
    Finding { about: building_type.to_string(), health, detail }
}

fn one_day(building_type: BuildingType, quiet: bool) -> Result<String> {
    let prepared = Prepared::new(&BuildingName::Type(building_type), &Location::default(), quiet)?;
    let mut env = prepared.env("01-01..01-01".parse::<RunPeriod>()?, 12, Task::default())?;
    let mut controller = Constant::middle(env.action_space());
    let mut action = vec![0.0; env.action_space().len()];
    controller.act(env.reset()?, &mut action);
    while !env.step(&action)?.truncated {}
    let [warnings, severes] = [Level::Warning, Level::Severe].map(|level| env.message_count(level));
    Ok(format!("one day in {} ran, {warnings} warnings, {severes} severe", prepared.place))
}

fn print(findings: &[Finding], json: bool) -> Result<()> {
    if json {
        let finding = |finding: &Finding| {
            let health = format!("{:?}", finding.health).to_lowercase();
            json!({"about": finding.about, "health": health, "detail": finding.detail})
        };
        return stdout::print_json(&findings.iter().map(finding).collect::<Vec<_>>());
    }
    let width = findings.iter().map(|finding| finding.about.chars().count()).max().unwrap_or(0);
    let line = |finding: &Finding| {
        let mark = match finding.health {
            Health::Good => '✓',
            Health::Absent => '–',
            Health::Bad => '✗',
        };
        format!("{mark} {:<width$}  {}", finding.about, finding.detail)
    };
    stdout::print(&findings.iter().map(line).collect::<Vec<_>>().join("\n"))
}
