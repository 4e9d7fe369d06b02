//! The building of an evaluation, at its site.

use std::path::Path;

use b2b_base::digest::sha256;
use b2b_building::{Class, Controls};
use b2b_climate::{EpwFile, Place};
use b2b_dataset::{BuildingName, Catalog, Control, Found, Placement};
use b2b_energyplus::install::Progress;

use crate::Result;
use crate::error::at;

/// A building, and its site if not the building's own.
#[derive(Clone, Debug, PartialEq)]
pub struct Subject {
    /// Name of the building.
    pub name: BuildingName,
    /// Site, if it is not the building's own.
    pub placement: Placement,
}

/// The site of a building.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SiteInfo {
    /// Name of the place, or of the weather file.
    pub place: String,
    /// ASHRAE 169 climate zone, such as `5B`: of the place, or derived from the weather file.
    pub climate_zone: String,
}

impl Subject {
    /// A building at its own site.
    pub fn at_home(name: BuildingName) -> Self {
        Self { name, placement: Placement::default() }
    }

    /// Returns the name of the building in results, with its interface if that is not the building's own.
    pub fn label(&self) -> String {
        self.placement.control.name_of(&self.name)
    }

    /// Returns the split, `train` or `test`; empty for a building outside the dataset.
    pub fn split(&self) -> String {
        match self.name {
            BuildingName::Id(id) => b2b_dataset::row(id).split.to_string(),
            BuildingName::Type(_) | BuildingName::Model(_) => String::new(),
        }
    }

    /// Returns the name of the building type; empty for a user's model.
    pub fn building_type(&self) -> &'static str {
        self.name.building_type().map_or("", |building_type| building_type.name())
    }

    /// Returns the class of the building at a site; `None` for a user's model.
    pub fn class(&self, site: &SiteInfo) -> Option<Class> {
        let building_type = self.name.building_type()?;
        Some(Class::new(building_type, Some(&site.climate_zone)))
    }

    /// Returns one word that determines model and weather: an id, a type and a place, or the SHA-256 of files.
    ///
    /// # Errors
    /// [`Error::Io`](crate::Error::Io) for a file that cannot be read.
    pub fn identity(&self) -> Result<String> {
        let what = match &self.name {
            BuildingName::Model(path) => format!("{}#{IMPORT_REVISION}", hash_of_model(path)?),
            BuildingName::Type(_) | BuildingName::Id(_) => self.name.to_string(),
        };
        let interface = match self.placement.control {
            Control::Actuators => String::new(),
            Control::Setpoints => format!("{}#{IMPORT_REVISION}", Controls::SETPOINTS_SUFFIX),
        };
        let identity = match (&self.placement.weather, self.placement.place, &self.name) {
            (Some(weather), _, _) => format!("{what}@{}", hash_of(weather)?),
            (None, Some(place), _) => format!("{what}@{}", place.name),
            (None, None, BuildingName::Type(building_type)) => format!("{what}@{}", building_type.home()),
            (None, None, _) => what,
        };
        let days = if self.placement.keep_design_days { "+own-design-days" } else { "" };
        let programs = match &self.placement.transition {
            Some(folder) => format!("+transition-{}", &digest_of_listing(folder)?[..12]),
            None => String::new(),
        };
        Ok(identity + &interface + days + &programs)
    }

    /// Finds the site of the building.
    ///
    /// # Errors
    /// The errors of [`Catalog::find`]; [`Error::Io`](crate::Error::Io).
    pub fn locate(&self, catalog: &Catalog, progress: &mut dyn Progress) -> Result<SiteInfo> {
        self.site(&catalog.find(&self.name, &self.placement, progress)?)
    }

    /// Returns the site of a found building.
    ///
    /// # Errors
    /// [`Error::Io`](crate::Error::Io) for a weather file that cannot be read.
    pub fn site(&self, found: &Found) -> Result<SiteInfo> {
        let listed = match &self.name {
            _ if self.placement.weather.is_some() => None,
            BuildingName::Id(id) => b2b_dataset::row(*id).building.location().ashrae_zone(),
            _ => Place::find(&found.place).ok().map(|place| place.ashrae_zone),
        };
        let climate_zone = match listed {
            Some(zone) => zone.to_owned(),
            None => EpwFile::open(&found.weather)?.year()?.map(|year| year.zone()).unwrap_or_default(),
        };
        Ok(SiteInfo { place: found.place.clone(), climate_zone })
    }
}

/// Incremented when a change to import, conversion or sizing changes the episodes of users' models, so that older
/// results and baselines are not reused.
const IMPORT_REVISION: u32 = 10;

/// Returns the SHA-256 of a model; if it names other files, a digest of all of them.
fn hash_of_model(path: &Path) -> Result<String> {
    let model = hash_of(path)?;
    let named = b2b_building::import::external::named_in_text(path).map_err(at(path))?;
    if named.is_empty() {
        return Ok(model);
    }
    let hashes = named.iter().map(|file| hash_of(file)).collect::<Result<Vec<_>>>()?;
    Ok(sha256(model + &hashes.concat()))
}

/// Returns a digest of the names and the sizes of the files in a folder.
fn digest_of_listing(folder: &Path) -> Result<String> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(at(folder))? {
        let entry = entry.map_err(at(folder))?;
        let size = entry.metadata().map_err(at(folder))?.len();
        files.push(format!("{}:{size}\n", entry.file_name().display()));
    }
    files.sort();
    Ok(sha256(files.concat()))
}

/// Returns the SHA-256 of a file.
pub fn hash_of(path: &Path) -> Result<String> {
    std::fs::read(path).map(sha256).map_err(at(path))
}

#[cfg(test)]
mod tests {
    use b2b_dataset::Control;

    use super::*;

    #[test]
    fn a_type_at_home_and_at_the_place_of_its_home_are_the_same_building() {
        let mut subject = Subject::at_home("OfficeSmall".parse().unwrap());
        assert_eq!(subject.identity().unwrap(), "OfficeSmall@Denver");
        subject.placement.place = Some(Place::find("Denver").unwrap());
        assert_eq!(subject.identity().unwrap(), "OfficeSmall@Denver");
        subject.placement.control = Control::Setpoints;
        assert_eq!(subject.identity().unwrap(), format!("OfficeSmall@Denver+setpoints#{IMPORT_REVISION}"));
        assert_eq!(Control::split_name(&subject.label()), ("OfficeSmall", Control::Setpoints));
        let id = Subject::at_home("OfficeSmall-42".parse().unwrap());
        assert_eq!(id.identity().unwrap(), "OfficeSmall-0042");
        assert!(["train", "test"].contains(&id.split().as_str()));
    }

    #[test]
    fn the_identity_of_a_model_changes_with_the_programs_that_convert_it() {
        let folder = tempfile::tempdir().unwrap();
        let model = folder.path().join("model.idf");
        std::fs::write(&model, "Version,9.6;").unwrap();
        let with = |version: &str| {
            let programs = folder.path().join(version);
            std::fs::create_dir(&programs).unwrap();
            std::fs::write(programs.join(format!("Transition-{version}")), version).unwrap();
            let mut subject = Subject::at_home(BuildingName::Model(model.clone()));
            subject.placement.transition = Some(programs);
            subject.identity().unwrap()
        };
        assert_ne!(with("V9-6-0-to-V22-1-0"), with("V22-1-0-to-V22-2-0"));
    }

    #[test]
    fn the_identity_of_a_model_changes_with_the_files_that_it_names() {
        let folder = tempfile::tempdir().unwrap();
        let [model, file] = ["model.epJSON", "büro, 2.csv"].map(|name| folder.path().join(name));
        std::fs::write(&model, r#"{"Schedule:File": {"S": {"file_name": "b\u00fcro, 2.csv"}}}"#).unwrap();
        let identity = || Subject::at_home(BuildingName::Model(model.clone())).identity().unwrap();
        assert_eq!(identity(), format!("{}#{IMPORT_REVISION}", hash_of(&model).unwrap()));
        std::fs::write(&file, "1").unwrap();
        let first = identity();
        std::fs::write(&file, "2").unwrap();
        assert!(![&first, &hash_of(&model).unwrap()].contains(&&identity()));
        std::fs::write(&file, "1").unwrap();
        assert_eq!(identity(), first);
    }
}
