//! Weather files: downloads in advance, and notes for the user.

use std::collections::HashSet;
use std::path::Path;

use anyhow::Result;
use b2b_building::RunPeriod;
use b2b_climate::Site;
use b2b_dataset::Building;
use b2b_energyplus::install::Cache;

use crate::terminal::interrupt;
use crate::terminal::progress::Download;

/// Downloads or generates the weather of buildings that is not in the cache.
pub fn fetch<'a>(buildings: impl Iterator<Item = &'a Building>, quiet: bool) -> Result<()> {
    let (mut download, cache) = (Download::new(quiet), Cache::from_env()?);
    let mut fetched = HashSet::new();
    for building in buildings.filter(|building| fetched.insert(building.place().to_owned())) {
        interrupt::check()?;
        building.weather(&cache, &mut download)?;
    }
    Ok(())
}

/// Returns a note if a weather file has days of a part of a year only.
pub fn part_of_year_note(weather: &Path) -> Result<Option<String>> {
    Ok(RunPeriod::of_part(weather)?.map(|days| {
        format!(
            "the file has only days of {days}: degree-days count these alone, and the climate zone is unknown"
        )
    }))
}

/// Returns a note if equipment is not sized for design conditions given in the file.
pub fn design_day_note(site: &Site) -> Option<String> {
    site.sized_by_hours.then(|| {
        format!(
            "the file has no design conditions; equipment is sized for the 99.6 % and 0.4 % percentiles of its hourly \
             temperatures, {:.1} and {:.1} °C",
            site.heating.dry_bulb, site.cooling.dry_bulb
        )
    })
}
