//! Generated buildings as functions of their type, location and parameters.

use std::path::PathBuf;

use b2b_building::description::Origin;
use b2b_building::{BuildingType, Class, Model};
use b2b_climate::{Location, Site};
use b2b_energyplus::install::{Cache, Progress};

use crate::Result;
use crate::commercial::{self, CommercialParameters};
use crate::house::{self, HouseSample};

/// A generated building: its type, its location and its parameters.
#[derive(Clone, Debug, PartialEq)]
pub enum Building {
    /// One of the five commercial types.
    Commercial {
        /// Its type.
        building_type: BuildingType,
        /// Its location.
        location: Location,
        /// Its parameters.
        parameters: CommercialParameters,
    },
    /// A house.
    House(HouseSample),
}

impl Building {
    /// Returns its type.
    pub fn building_type(&self) -> BuildingType {
        match self {
            Self::Commercial { building_type, .. } => *building_type,
            Self::House(_) => BuildingType::SingleFamilyHouse,
        }
    }

    /// Returns its class.
    pub fn class(&self) -> Class {
        Class::new(self.building_type(), self.location().ashrae_zone())
    }

    /// Returns its location.
    pub fn location(&self) -> &Location {
        match self {
            Self::Commercial { location, .. } => location,
            Self::House(sample) => &sample.location,
        }
    }

    /// Returns the properties of the building that its model does not contain.
    pub fn origin(&self) -> Origin {
        match self {
            Self::Commercial { location, .. } => Origin::commercial(location.ashrae_zone()),
            Self::House(sample) => Origin {
                year: Some(sample.year),
                vintage: Some(sample.vintage.name().to_owned()),
                climate_zone: None,
            },
        }
    }

    /// Returns the name of the place, or of the region of a house.
    pub fn place(&self) -> &str {
        self.location().name()
    }

    /// Returns the weather file; downloads or generates it when it is not in the cache.
    ///
    /// # Errors
    /// The errors of [`Location::weather`].
    pub fn weather(&self, cache: &Cache, progress: &mut dyn Progress) -> Result<PathBuf> {
        Ok(self.location().weather(cache, progress)?)
    }

    /// Generates its model, before sizing. `prototype` is [`crate::archetype::prototype`] of the type, and `site` is
    /// read from the weather file.
    ///
    /// The same arguments give the same bytes.
    ///
    /// # Errors
    /// [`crate::Error::Parameter`] naming the parameter out of bounds; the errors of [`commercial::generate_in_zone`].
    pub fn model(&self, prototype: &Model, site: &Site) -> Result<Model> {
        match self {
            Self::Commercial { building_type, location, parameters } => {
                let zone = location.ashrae_zone().unwrap_or_default();
                commercial::generate_in_zone(prototype, *building_type, zone, site, parameters)
            }
            Self::House(sample) => house::house(&sample.house, site),
        }
    }
}
