//! The six building types and the models they start from.

use std::fmt;
use std::path::Path;
use std::str::FromStr;

use b2b_energyplus::Library;
use b2b_energyplus::install::Engine;
use serde::{Deserialize, Serialize};

use crate::climate::Site;
use crate::house::{self, House};
use crate::model::Model;
use crate::{Error, Result};

/// A building type of the benchmark.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum BuildingType {
    /// Detached house, generated from scratch.
    SingleFamilyHouse,
    /// Small office: five zones and an attic, a heat pump each.
    OfficeSmall,
    /// Medium office: fifteen zones on three floors, an air loop a floor.
    OfficeMedium,
    /// Stand-alone shop: four rooftop units and a heated entrance.
    RetailStandalone,
    /// Fast-food restaurant: dining room and kitchen, a rooftop unit each.
    RestaurantFastFood,
    /// Warehouse: office and fine storage with rooftop units, bulk storage with a unit heater.
    Warehouse,
}

impl BuildingType {
    /// Every type, in the order of the paper's table.
    pub const ALL: [Self; 6] = [
        Self::SingleFamilyHouse,
        Self::RestaurantFastFood,
        Self::Warehouse,
        Self::RetailStandalone,
        Self::OfficeSmall,
        Self::OfficeMedium,
    ];

    /// Name, as in building ids.
    pub fn name(self) -> &'static str {
        match self {
            Self::SingleFamilyHouse => "SingleFamilyHouse",
            Self::OfficeSmall => "OfficeSmall",
            Self::OfficeMedium => "OfficeMedium",
            Self::RetailStandalone => "RetailStandalone",
            Self::RestaurantFastFood => "RestaurantFastFood",
            Self::Warehouse => "Warehouse",
        }
    }

    /// One line for people.
    pub fn description(self) -> &'static str {
        match self {
            Self::SingleFamilyHouse => "detached Québec house, ducted heat pump or furnace with cooling",
            Self::OfficeSmall => "small office, a heat pump for each of five zones",
            Self::OfficeMedium => "medium office, three central air loops over fifteen zones",
            Self::RetailStandalone => "shop, four rooftop units and a heated entrance",
            Self::RestaurantFastFood => "fast-food restaurant, rooftop units for dining room and kitchen",
            Self::Warehouse => "warehouse, two rooftop units and a unit heater",
        }
    }

    /// Where its base model stands.
    pub fn home(self) -> &'static str {
        match self {
            Self::SingleFamilyHouse => "Montréal",
            _ => "Denver",
        }
    }

    /// The base model: for the house generated for the site, for the others the [`BuildingType::prototype`].
    ///
    /// # Errors
    /// Those of [`BuildingType::prototype`].
    pub fn base_model(self, engine: &Engine, library: &Library, site: &Site) -> Result<Model> {
        match self {
            Self::SingleFamilyHouse => house::house(&House::default(), site),
            _ => self.prototype(engine, library),
        }
    }

    /// The model that buildings of the type are made from: the ASHRAE 90.1-2019 prototype that ships with the engine;
    /// empty for the house, which is made from nothing.
    ///
    /// # Errors
    /// [`Error::NoStockModels`] when the engine was installed without its models; [`Error::Engine`] when it
    /// cannot convert the file.
    pub fn prototype(self, engine: &Engine, library: &Library) -> Result<Model> {
        if self == Self::SingleFamilyHouse {
            return Ok(Model::default());
        }
        let file = format!("ASHRAE901_{}_STD2019_Denver.idf", self.name());
        let models = engine.models.as_ref().ok_or_else(|| Error::NoStockModels { file: file.clone() })?;
        Model::read(&models.join(file), library)
    }
}

impl fmt::Display for BuildingType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for BuildingType {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        Self::ALL.into_iter().find(|t| t.name().eq_ignore_ascii_case(text)).ok_or_else(|| {
            let near =
                |t: &&Self| strsim::jaro_winkler(&t.name().to_lowercase(), &text.to_lowercase()) > 0.75;
            Error::UnknownType {
                text: text.to_owned(),
                near: Self::ALL.iter().find(near).map(|t| t.name()),
                known: Self::ALL.map(Self::name).join(", "),
            }
        })
    }
}

impl Model {
    /// Reads a model file: epJSON, or IDF through the engine's own converter.
    ///
    /// # Errors
    /// [`Error::Malformed`] and [`Error::Io`] naming the file; [`Error::Engine`] with the engine's words when it
    /// cannot read an IDF.
    pub fn read(path: &Path, library: &Library) -> Result<Self> {
        if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("idf")) {
            return Self::from_epjson(&library.convert_idf(path)?, path);
        }
        let text =
            std::fs::read_to_string(path).map_err(|source| Error::Io { path: path.to_owned(), source })?;
        Self::from_epjson(&text, path)
    }
}
