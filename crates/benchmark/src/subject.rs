//! A building as a policy is judged on it.

use std::path::Path;

use b2b_building::Class;
use b2b_climate::{ClimateYear, Place};
use b2b_dataset::{BuildingName, Catalog, Found, Placement};
use b2b_energyplus::install::Progress;
use sha2::{Digest, Sha256};

use crate::error::at;
use crate::{Error, Result};

/// A building, and where it stands if not at home.
#[derive(Clone, Debug, PartialEq)]
pub struct Subject {
    /// What it is called.
    pub name: BuildingName,
    /// Where it stands.
    pub placement: Placement,
}

/// What is known of a building's place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Surroundings {
    /// Name of the place, or of the weather file.
    pub place: String,
    /// Climate zone of ASHRAE 169, such as `5B`: of the place, or by the weather file.
    pub climate_zone: String,
}

impl Subject {
    /// A building at home.
    pub fn at_home(name: BuildingName) -> Self {
        Self { name, placement: Placement::default() }
    }

    /// `train` or `test`; nothing for what is not of the dataset.
    pub fn split(&self) -> String {
        match self.name {
            BuildingName::Id(id) => b2b_dataset::row(id).split.to_string(),
            BuildingName::Type(_) | BuildingName::Model(_) => String::new(),
        }
    }

    /// Name of its type; nothing for a model of a user's own.
    pub fn building_type(&self) -> &'static str {
        self.name.building_type().map_or("", |building_type| building_type.name())
    }

    /// What it is of, in its surroundings; `None` for a model of a user's own.
    pub fn class(&self, surroundings: &Surroundings) -> Option<Class> {
        let building_type = self.name.building_type()?;
        Some(Class::new(building_type, Some(&surroundings.climate_zone)))
    }

    /// What its model and its weather are functions of, in one word: an id, a type and a place, or the SHA-256 of files.
    ///
    /// # Errors
    /// [`Error::Io`] for a file that cannot be read.
    pub fn identity(&self) -> Result<String> {
        let what = match &self.name {
            BuildingName::Model(path) => hash_of(path)?,
            BuildingName::Type(_) | BuildingName::Id(_) => self.name.to_string(),
        };
        Ok(match (&self.placement.weather, self.placement.place, &self.name) {
            (Some(weather), _, _) => format!("{what}@{}", hash_of(weather)?),
            (None, Some(place), _) => format!("{what}@{}", place.name),
            (None, None, BuildingName::Type(building_type)) => format!("{what}@{}", building_type.home()),
            (None, None, _) => what,
        })
    }

    /// Where it stands.
    ///
    /// # Errors
    /// Those of [`Catalog::find`]; [`Error::Io`].
    pub fn locate(&self, catalog: &Catalog, progress: &mut dyn Progress) -> Result<Surroundings> {
        self.surroundings(&catalog.find(&self.name, &self.placement, progress)?)
    }

    /// The place of a building that was found.
    pub(crate) fn surroundings(&self, found: &Found) -> Result<Surroundings> {
        let listed = match &self.name {
            BuildingName::Id(id) => b2b_dataset::row(*id).building.location().ashrae_zone(),
            _ if self.placement.weather.is_some() => None,
            _ => Place::find(&found.place).ok().map(|place| place.ashrae_zone),
        };
        let climate_zone = match listed {
            Some(zone) => zone.to_owned(),
            None => {
                let bytes = std::fs::read(&found.weather).map_err(at(&found.weather))?;
                let year = ClimateYear::from_epw(&String::from_utf8_lossy(&bytes));
                year.map(|year| year.zone()).unwrap_or_default()
            }
        };
        Ok(Surroundings { place: found.place.clone(), climate_zone })
    }
}

/// SHA-256 of a file.
pub(crate) fn hash_of(path: &Path) -> Result<String> {
    let bytes = std::fs::read(path).map_err(|source| Error::Io { path: path.to_owned(), source })?;
    Ok(hex(&bytes))
}

/// SHA-256 in hexadecimal.
pub(crate) fn hex(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_type_at_home_and_at_the_place_of_its_home_are_the_same_building() {
        let mut subject = Subject::at_home("OfficeSmall".parse().unwrap());
        assert_eq!(subject.identity().unwrap(), "OfficeSmall@Denver");
        subject.placement.place = Some(Place::find("Denver").unwrap());
        assert_eq!(subject.identity().unwrap(), "OfficeSmall@Denver");
        let id = Subject::at_home("OfficeSmall-42".parse().unwrap());
        assert_eq!(id.identity().unwrap(), "OfficeSmall-0042");
        assert!(["train", "test"].contains(&id.split().as_str()));
    }
}
