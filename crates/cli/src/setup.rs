//! `b2b setup`: fetches and repairs what runs need.

use anyhow::Result;
use b2b_climate::weather::PACKAGES;
use b2b_energyplus::install::{Cache, ENGINE, Engine, Package};

use crate::progress::Download;
use crate::stdout;

/// Fetch EnergyPlus and weather, and repair what is damaged
///
/// Runs fetch what they need by themselves; this is for machines that will be offline, and for a
/// cache that `b2b doctor` finds damaged.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  b2b setup          EnergyPlus with its models and the weather that comes with it
  b2b setup --all    the weather of every place too")]
pub struct Arguments {
    /// Weather of every place too
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
    if Engine::installed_by_user().is_some() {
        lines.push(format!("✓ B2B_ENERGYPLUS is set: {}", Engine::find()?.library.display()));
    }
    stdout::print(&lines.join("\n"))
}

/// The engine's package is needed even when the user has an engine: it carries models and weather.
fn packages(all: bool) -> Vec<&'static Package> {
    let weather = PACKAGES.into_iter().filter(|_| all);
    std::iter::once(&ENGINE).chain(weather).collect()
}
