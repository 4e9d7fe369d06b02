//! The location and interface of a building, and how its model is read.

use std::ffi::OsString;
use std::path::PathBuf;

use anyhow::{Result, bail};
use b2b_climate::Place;
use b2b_dataset::{Control, Placement};

/// The location and interface of a building, and how its model is read.
#[derive(clap::Args, Default)]
pub struct Location {
    /// Place that supplies weather and climate (`b2b list places`) [default: the building's own]
    #[arg(long, value_name = "NAME", value_parser = find_place, conflicts_with = "weather")]
    place: Option<&'static Place>,
    /// EPW weather file to use instead of a known place
    #[arg(long, value_name = "FILE.epw")]
    weather: Option<PathBuf>,
    /// What the agent sets: `actuators` of the systems, or the heating and cooling `setpoints` of every zone, which the
    /// building's equipment follows [default: actuators]
    #[arg(long, value_name = "INTERFACE")]
    pub control: Option<Control>,
    /// Let a model file run code (FMU, Python) and open files outside its folder; only for models that you trust
    #[arg(long)]
    allow_external: bool,
    /// Size a model file's equipment for its own design days instead of the weather file's
    #[arg(long)]
    keep_design_days: bool,
    /// Convert an old IDF with the Transition programs of this folder (PreProcess/IDFVersionUpdater of an EnergyPlus
    /// installation) instead of b2b's own rules
    #[arg(long, value_name = "PROGRAMS")]
    transition: Option<PathBuf>,
}

fn find_place(name: &str) -> Result<&'static Place> {
    Ok(Place::find(&place_name(name)?)?)
}

/// Returns the name of a place or a region. Errors if it is a weather file.
pub fn place_name(name: &str) -> Result<String> {
    if name.to_lowercase().ends_with(".epw") {
        bail!("`{name}` is a weather file; use `--weather {name}`");
    }
    Ok(name.to_owned())
}

impl Location {
    /// Returns these options as command-line arguments.
    pub fn arguments(&self) -> Vec<OsString> {
        let place = self.place.map(|place| ["--place".into(), place.name.into()]);
        let weather = self.weather.as_ref().map(|path| ["--weather".into(), path.clone().into_os_string()]);
        let external = self.allow_external.then(|| "--allow-external".into());
        let control = self.control.map(|control| ["--control".into(), control.name().into()]);
        let keep = self.keep_design_days.then(|| "--keep-design-days".into());
        let programs =
            self.transition.as_ref().map(|path| ["--transition".into(), path.clone().into_os_string()]);
        let named = place.into_iter().chain(weather).chain(control).chain(programs).flatten();
        named.chain(external).chain(keep).collect()
    }

    /// Returns these options in the form used by the catalog.
    pub fn placement(&self) -> Placement {
        Placement {
            place: self.place,
            weather: self.weather.clone(),
            allow_external: self.allow_external,
            control: self.control.unwrap_or_default(),
            keep_design_days: self.keep_design_days,
            transition: self.transition.clone(),
        }
    }
}
