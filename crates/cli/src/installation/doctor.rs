//! `b2b doctor`: the state of the installation, and the actuator response check.

use anyhow::Result;
use b2b_building::{BuildingType, RunPeriod};
use b2b_climate::weather::PACKAGES;
use b2b_control::Constant;
use b2b_dataset::BuildingName;
use b2b_energyplus::Confinement;
use b2b_energyplus::install::doctor::{Finding, Health, report};
use b2b_energyplus::install::{Cache, Engine};
use b2b_env::{EngineReport, Task};
use serde_json::json;

use crate::arguments::location::Location;
use crate::installation::derived;
use crate::program::prepare::Prepared;
use crate::terminal::exit_code::ExitCode;
use crate::terminal::stdout;

/// Check the installation, or the actuator response of a building
///
/// Verifies the SHA-256 of every cached file. Exits with code 1 if something needs repair, or if an actuator does not
/// follow its commands.
#[derive(clap::Args)]
#[command(
    verbatim_doc_comment,
    after_help = "\
Examples:
  b2b doctor                             check cache, engine, weather files and package client
  b2b doctor OfficeSmall                 also simulate one day of a building
  b2b doctor --authority OfficeSmall     actuator response check: commands against responses
  b2b doctor --authority my.idf --weather my.epw"
)]
pub struct Arguments {
    /// Building type to prepare and simulate for one day
    #[arg(value_name = "TYPE")]
    building_type: Option<BuildingType>,
    /// Check the actuator response of this building (type, dataset id or model file): command every actuator low,
    /// middle and high on a winter and a summer day, and compare the simulated quantity with the command
    #[arg(long, value_name = "BUILDING", conflicts_with = "building_type")]
    authority: Option<BuildingName>,
    #[command(flatten)]
    location: Location,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command. Exit code 1 if a finding is bad.
pub fn doctor(arguments: &Arguments) -> Result<ExitCode> {
    if let Some(building) = &arguments.authority {
        return authority(building, &arguments.location, arguments.json);
    }
    let (cache, installed) = (Cache::from_env()?, Engine::installed_by_user());
    let mut findings = report(&cache, installed.as_deref(), &PACKAGES);
    findings.extend(derived::findings(&cache));
    findings.push(confinement());
    findings.extend(arguments.building_type.map(|each| building(each, &arguments.location, arguments.json)));
    print(&findings, arguments.json)?;
    let bad = findings.iter().any(|finding| finding.health == Health::Bad);
    Ok(if bad { ExitCode::Failure } else { ExitCode::Success })
}

/// Reports how worker processes are confined.
fn confinement() -> Finding {
    let confinement = Confinement::available();
    let health = if confinement == Confinement::Full { Health::Good } else { Health::Absent };
    Finding { about: "workers".into(), health, detail: confinement.to_string() }
}

/// Checks the actuator response of a building. Exit code 1 if an actuator does not respond.
fn authority(building: &BuildingName, location: &Location, json: bool) -> Result<ExitCode> {
    let prepared = Prepared::new(building, location, json)?;
    let report = prepared.authority()?;
    stdout::print_result(json, &report, || report.to_string())?;
    Ok(ExitCode::of(report.failures().next().is_none()))
}

/// Simulates one day of a building.
fn building(building_type: BuildingType, location: &Location, quiet: bool) -> Finding {
    let (health, detail) = match one_day(building_type, location, quiet) {
        Ok(detail) => (Health::Good, detail),
        Err(error) => (Health::Bad, format!("{error:#}")),
    };
    Finding { about: building_type.to_string(), health, detail }
}

fn one_day(building_type: BuildingType, location: &Location, quiet: bool) -> Result<String> {
    let prepared = Prepared::new(&BuildingName::Type(building_type), location, quiet)?;
    let spaces = prepared.spaces("01-01..01-01".parse::<RunPeriod>()?, 12, Task::default())?;
    let EngineReport { warnings, severes, .. } =
        prepared.roll_out(&spaces, &mut Constant::middle(&spaces.action), quiet)?.engine;
    Ok(format!("simulated one day in {}: {warnings} warnings, {severes} severe messages", prepared.place))
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
