//! Check of the installation, as data for a command line to print.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

use super::ENGINE_VERSION;
use super::cache::Cache;
use super::client::Client;
use super::engine::{ENGINE, Engine, Source};
use super::error::Error;
use super::package::State;
use super::pinned::Package;

/// Result of a check.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Checked item.
    pub about: String,
    /// State of the item.
    pub health: Health,
    /// Details, and the remedy if the item is bad.
    pub detail: String,
}

/// State of a checked item.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Health {
    /// Present and intact.
    Good,
    /// Missing, and downloaded automatically when needed.
    Absent,
    /// Missing or damaged, and to be repaired by the user.
    Bad,
}

/// Checks the cache, EnergyPlus, the package client and further `packages` (weather), reading every cached file.
/// `installed` is the value of `B2B_ENERGYPLUS`.
pub fn report(cache: &Cache, installed: Option<&Path>, packages: &[&Package]) -> Vec<Finding> {
    let mut findings = vec![cache_folder(cache), engine(cache, installed)];
    findings.push(package(cache, &ENGINE));
    findings.extend(packages.iter().map(|each| package(cache, each)));
    findings.push(client(cache));
    findings
}

fn finding(about: impl Into<String>, health: Health, detail: impl Into<String>) -> Finding {
    Finding { about: about.into(), health, detail: detail.into() }
}

fn cache_folder(cache: &Cache) -> Finding {
    let path = cache.root.display();
    let (health, detail) = match std::fs::metadata(&cache.root) {
        Ok(found) if found.is_dir() => (Health::Good, format!("{path}")),
        Ok(_) => (Health::Bad, format!("{path} is not a folder: remove it or set B2B_CACHE")),
        Err(_) => (Health::Absent, format!("{path} does not exist yet; created when needed")),
    };
    finding("cache folder", health, detail)
}

fn engine(cache: &Cache, installed: Option<&Path>) -> Finding {
    let about = "EnergyPlus";
    match Engine::find_in(cache, installed) {
        // A download repairs neither.
        Err(error) if installed.is_some() || matches!(error, Error::NoWheel { .. }) => {
            finding(about, Health::Bad, error.to_string())
        }
        Err(error) => finding(about, Health::Absent, error.to_string()),
        Ok(engine) => {
            let version = match engine.source {
                Source::Cached => Some(ENGINE_VERSION.to_owned()),
                Source::Installed => installed_version(&engine.root),
            };
            let library = engine.library.display();
            match version {
                Some(version) if version == ENGINE_VERSION => {
                    finding(about, Health::Good, format!("{version}, {library}"))
                }
                Some(version) => finding(
                    about,
                    Health::Bad,
                    format!(
                        "{library} is version {version}; expected {ENGINE_VERSION}: unset B2B_ENERGYPLUS"
                    ),
                ),
                None => finding(about, Health::Good, format!("version unknown, {library}")),
            }
        }
    }
}

/// Returns the version in the first line of `Energy+.idd`, which an installation has next to its library.
fn installed_version(root: &Path) -> Option<String> {
    let mut line = String::new();
    let file = File::open(root.join("Energy+.idd")).ok()?;
    BufReader::new(file).read_line(&mut line).ok()?;
    Some(line.trim().strip_prefix("!IDD_Version ")?.to_owned())
}

fn package(cache: &Cache, package: &Package) -> Finding {
    let (health, detail) = match package.verify(cache) {
        State::Absent => {
            (Health::Absent, "not in the cache; downloaded when needed, or by `b2b setup`".to_owned())
        }
        State::Whole { files, bytes } => (Health::Good, State::verified(files, bytes)),
        State::Damaged(lines) => (Health::Bad, format!("run `b2b setup` to repair it: {}", lines.join("; "))),
    };
    finding(package.to_string(), health, detail)
}

fn client(cache: &Cache) -> Finding {
    let about = "package client";
    match Client::find() {
        Some(_) if cache.offline => finding(about, Health::Good, "not used: B2B_OFFLINE is set"),
        Some(client) => finding(about, Health::Good, client.version),
        None => finding(
            about,
            Health::Bad,
            format!("none of {} works: install Python 3 with pip", Client::candidates()),
        ),
    }
}
