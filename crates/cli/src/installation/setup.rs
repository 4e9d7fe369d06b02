//! `b2b setup`: download and repair of the engine and the weather files.

use anyhow::Result;
use b2b_climate::weather::PACKAGES;
use b2b_energyplus::install::{Cache, ENGINE, Engine, Package};

use crate::installation::derived;
use crate::terminal::progress::Download;
use crate::terminal::stdout;

/// Download EnergyPlus and weather files, and repair damaged ones
///
/// Other commands download automatically what they need. Use this to prepare a machine for offline work, or to repair a
/// cache that `b2b doctor` reports as damaged.
#[derive(clap::Args)]
#[command(
    verbatim_doc_comment,
    after_help = "\
Examples:
  b2b setup          EnergyPlus with its models and weather files
  b2b setup --all    also the weather of every place"
)]
pub struct Arguments {
    /// Also download the weather of every place
    #[arg(long)]
    all: bool,
}

/// Runs the command.
pub fn setup(arguments: &Arguments) -> Result<()> {
    let cache = Cache::from_env()?;
    let mut lines = Vec::new();
    for package in packages(arguments.all) {
        let installed = package.repair(&cache, &mut Download::new(false))?;
        lines.push(format!("✓ {package} in {}", installed.root.display()));
    }
    lines.extend(derived::remove_damaged(&cache)?);
    if Engine::installed_by_user().is_some() {
        lines.push(format!("✓ B2B_ENERGYPLUS: using {}", Engine::find()?.library.display()));
    }
    stdout::print(&lines.join("\n"))
}

/// Returns the packages to install. The engine's package is needed even with a user's own engine, for its models and
/// weather files.
fn packages(all: bool) -> Vec<&'static Package> {
    let weather = PACKAGES.into_iter().filter(|_| all);
    std::iter::once(&ENGINE).chain(weather).collect()
}
