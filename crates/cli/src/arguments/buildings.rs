//! Groups of buildings: by name, or by split, type and climate zone of the dataset.

use anyhow::{Result, bail};
use b2b_building::{BuildingType, Class};
use b2b_dataset::BuildingName;
use b2b_dataset::{BuildingId, Row};
use serde::Deserialize;

/// A subset of the dataset.
#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Split {
    /// All 6,000 buildings
    All,
    /// Training split: 90 % of the buildings of each location
    Train,
    /// Test split: the other 10 %
    Test,
    /// Eight test buildings of each type, one per climate zone (houses: eight of the test split)
    #[value(name = "test_small")]
    TestSmall,
}

impl Split {
    /// Returns whether a building belongs to the split.
    pub fn contains(self, row: &Row) -> bool {
        match self {
            Self::All => true,
            Self::Train => row.split == b2b_dataset::Split::Train,
            Self::Test => row.split == b2b_dataset::Split::Test,
            Self::TestSmall => row.test_small,
        }
    }
}

/// Buildings of any kind, by name or as a subset of the dataset.
#[derive(clap::Args)]
pub struct Buildings {
    /// Buildings to use instead of a dataset split: ids such as OfficeSmall-0042, building types or model files
    #[arg(value_name = "BUILDING", conflicts_with_all = ["split", "types", "zones"])]
    names: Vec<BuildingName>,
    #[command(flatten)]
    subset: Subset,
}

impl Buildings {
    /// Returns the names of the buildings. Errors if there are none.
    pub fn names(&self) -> Result<Vec<BuildingName>> {
        if !self.names.is_empty() {
            return Ok(self.names.clone());
        }
        Ok(self.subset.ids()?.into_iter().map(BuildingName::Id).collect())
    }
}

/// Buildings of the dataset, by id or as a subset.
#[derive(clap::Args)]
pub struct DatasetBuildings {
    /// Buildings to use instead of a dataset split, such as OfficeSmall-0042
    #[arg(value_name = "ID", conflicts_with_all = ["split", "types", "zones"])]
    ids: Vec<BuildingId>,
    #[command(flatten)]
    subset: Subset,
}

impl DatasetBuildings {
    /// Returns the ids of the buildings. Errors if there are none.
    pub fn ids(&self) -> Result<Vec<BuildingId>> {
        if self.ids.is_empty() { self.subset.ids() } else { Ok(self.ids.clone()) }
    }
}

/// A split of the dataset, restricted to building types and climate zones.
#[derive(clap::Args)]
struct Subset {
    /// Subset of the dataset
    #[arg(long, value_enum, default_value = "test_small")]
    split: Split,
    #[command(flatten)]
    classes: Classes,
}

impl Subset {
    fn ids(&self) -> Result<Vec<BuildingId>> {
        let selected = |row: &&Row| self.split.contains(row) && self.classes.contains(row.building.class());
        let ids: Vec<_> = b2b_dataset::all().filter(selected).map(|row| row.id).collect();
        if ids.is_empty() {
            bail!("the split has no buildings of these types and climate zones");
        }
        Ok(ids)
    }
}

/// Building types and climate zones.
#[derive(clap::Args, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Classes {
    /// Building types [default: all six]
    #[arg(long = "type", value_name = "TYPE", num_args = 1..)]
    types: Vec<BuildingType>,
    /// ASHRAE 169 thermal climate zones, 1 to 8 [default: all]; houses have none and are not filtered
    #[arg(long = "zone", value_name = "ZONE", num_args = 1.., value_parser = clap::value_parser!(u8).range(1..=8))]
    zones: Vec<u8>,
}

impl Classes {
    /// Returns the selected classes of the dataset. Errors if there are none.
    pub fn list(&self) -> Result<Vec<Class>> {
        let classes: Vec<_> = Class::all().filter(|class| self.contains(*class)).collect();
        if classes.is_empty() {
            bail!("the dataset has no building of these types and climate zones");
        }
        Ok(classes)
    }

    fn contains(&self, class: Class) -> bool {
        (self.types.is_empty() || self.types.contains(&class.building_type))
            && class.climate_zone.is_none_or(|zone| self.zones.is_empty() || self.zones.contains(&zone))
    }
}
