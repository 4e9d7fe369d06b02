//! `b2b generate`: buildings of the dataset, or any others, as epJSON files.

use std::collections::HashSet;
use std::path::PathBuf;
use std::sync::Arc;

use anyhow::{Context, Result, bail};
use b2b_building::BuildingType;
use b2b_climate::WeatherFile;
use b2b_dataset::manifest::{Manifest, of_buildings};
use b2b_dataset::{Building, Catalog, Places, Row, Setting};
use b2b_energyplus::install::{Cache, Quiet};
use rayon::prelude::*;
use serde_json::json;

use crate::model_folder::{MANIFEST, ModelFolder};
use crate::progress::{Download, counter};
use crate::{interrupt, prepare, stdout};

/// Generate buildings as EnergyPlus models
///
/// Writes an epJSON file a building, before sizing, and manifest.csv with the parameters of each. Files
/// that are there already are kept when the manifest says that they are the same building: an interrupted
/// generation goes on where it was.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// Building type (`b2b list`); every type of the dataset by default
    #[arg(value_name = "TYPE", required_unless_present = "dataset")]
    building_type: Option<BuildingType>,
    /// How many buildings
    #[arg(long, default_value_t = 10, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    count: u32,
    /// Seed of the Latin hypercube that the parameters come from
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Places that share the buildings equally; for houses, regions of Québec [default: the 16 places in the United
    /// States; every region by its share of the houses]
    #[arg(long = "place", value_name = "NAME", num_args = 1..)]
    places: Vec<String>,
    /// Weather files of other places that share the buildings equally
    #[arg(long, value_name = "FILE.epw", num_args = 1.., conflicts_with = "places")]
    weather: Vec<PathBuf>,
    /// Climate zone of ASHRAE 169 of the weather files, such as 5A [default: as their hours tell]
    #[arg(long, value_name = "ZONE", requires = "weather")]
    zone: Option<String>,
    /// Parameters that are fixed or drawn from a narrower range, by their names in the manifest
    #[arg(long = "set", value_name = "NAME=VALUE|LOW..HIGH", num_args = 1..)]
    settings: Vec<Setting>,
    /// Buildings of a dataset instead
    #[arg(long, value_enum, value_name = "VERSION", conflicts_with_all = ["count", "seed", "places", "weather", "settings"])]
    dataset: Option<Version>,
    /// Part of the dataset
    #[arg(long, value_enum, requires = "dataset")]
    split: Option<Part>,
    /// Folder for the files
    #[arg(long, value_name = "FOLDER")]
    out: PathBuf,
    /// Buildings at a time [default: one for each core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    jobs: Option<u32>,
    /// Print one JSON object instead of a line for people
    #[arg(long)]
    json: bool,
}

const EXAMPLES: &str = "\
Examples:
  b2b generate Warehouse --count 100 --seed 7 --place Miami --place 'Great Falls' --out warehouses
  b2b generate SingleFamilyHouse --count 50 --place Estrie --out houses
  b2b generate OfficeSmall --set window_to_wall=0.3 infiltration=0.5..1 --out offices
  b2b generate SingleFamilyHouse --set year=1946..1970 foundation=slab --out bungalows
  b2b generate Warehouse --weather Oslo.epw --out oslo     any place, by its weather file
  b2b generate --dataset v1 --out v1                       all 6,000
  b2b generate OfficeSmall --dataset v1 --split test --out v1

--set takes numbers within what the climate allows (`b2b dataset ranges` shows what the dataset has). What is
not set is drawn as in the dataset; of a house, a range takes the place of what the stock has.

The climate zone of a weather file, which decides what the code asks of an envelope, follows from its
degree-days and its humidity; --zone says another. Design days come from its header, or from its hours.

The same arguments give the same bytes.";

/// A dataset.
#[derive(Clone, Copy, clap::ValueEnum)]
enum Version {
    /// 1,000 buildings of each of the six types
    V1,
}

/// A part of a dataset.
#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Part {
    /// Every building
    All,
    /// Nine tenths of every place, to learn on
    Train,
    /// The other tenth, to test on
    Test,
    /// Eight of the test a type, one for each climate zone
    #[value(name = "test_small")]
    TestSmall,
}

impl Part {
    /// Whether a building belongs to it.
    pub fn has(self, row: &Row) -> bool {
        match self {
            Self::All => true,
            Self::Train => row.split == b2b_dataset::Split::Train,
            Self::Test => row.split == b2b_dataset::Split::Test,
            Self::TestSmall => row.test_small,
        }
    }
}

/// Buildings with their names, and the table of them.
struct Wanted {
    buildings: Vec<(String, Building)>,
    manifest: Manifest,
}

/// Runs the command.
pub fn generate(arguments: &Arguments) -> Result<()> {
    let wanted = arguments.wanted()?;
    let folder = ModelFolder::open(&arguments.out, &wanted.manifest)?;
    let missing: Vec<_> = wanted.buildings.iter().filter(|(name, _)| !folder.holds(name)).collect();
    let catalog = Catalog::open(&mut Download::new(arguments.json))?;
    fetch_weather(missing.iter().map(|(_, building)| building), arguments.json)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(arguments.jobs.unwrap_or(0) as usize).build()?;
    let bar = counter(missing.len(), "buildings", arguments.json);
    let done = pool.install(|| {
        missing.par_iter().try_for_each(|(name, building)| {
            interrupt::check()?;
            let generated = catalog.generate(building, &mut Quiet);
            let (model, _) = generated.with_context(|| format!("{name} cannot be generated"))?;
            folder.write(name, &model.to_epjson())?;
            bar.inc(1);
            anyhow::Ok(())
        })
    });
    bar.finish_and_clear();
    if interrupt::requested() {
        bail!(
            "interrupted after {} of {} buildings: the same command goes on",
            bar.position(),
            missing.len()
        );
    }
    done?;
    arguments.report(wanted.buildings.len(), missing.len())
}

impl Arguments {
    fn wanted(&self) -> Result<Wanted> {
        match (self.dataset, self.building_type) {
            (None, Some(building_type)) => self.sample(building_type),
            _ => Ok(self.of_dataset()),
        }
    }

    fn of_dataset(&self) -> Wanted {
        let of_type = |row: &&Row| self.building_type.is_none_or(|wanted| wanted == row.id.building_type());
        let of_part = |row: &&Row| self.split.is_none_or(|part| part.has(row));
        let rows: Vec<_> = b2b_dataset::all().filter(of_type).filter(of_part).collect();
        Wanted {
            buildings: rows.iter().map(|row| (row.id.to_string(), row.building.clone())).collect(),
            manifest: b2b_dataset::manifest(rows).with_weather(),
        }
    }

    /// The seed is in the name: no name of the dataset, and none of another seed.
    fn sample(&self, building_type: BuildingType) -> Result<Wanted> {
        let places = self.places(building_type)?;
        let buildings =
            b2b_dataset::sample(building_type, self.count as usize, self.seed, &places, &self.settings)?;
        let name = |number| format!("{building_type}-seed{}-{number:04}", self.seed);
        let buildings: Vec<_> = (1..).map(name).zip(buildings).collect();
        let manifest = of_buildings(buildings.iter().map(|(name, building)| (name.as_str(), building)));
        Ok(Wanted { buildings, manifest })
    }

    /// Reads the weather files, and tells what is taken from their hours.
    fn places(&self, building_type: BuildingType) -> Result<Places> {
        if self.weather.is_empty() {
            return Ok(match self.places.as_slice() {
                [] => Places::All,
                names => Places::Named(names.to_vec()),
            });
        }
        let commercial = building_type != BuildingType::SingleFamilyHouse;
        if self.zone.is_some() && !commercial {
            bail!("--zone has no meaning for houses: what they are made of follows from their year");
        }
        let read = |path: &PathBuf| {
            let file = WeatherFile::read(path, self.zone.as_deref())?;
            if commercial && self.zone.is_none() {
                eprintln!(
                    "{}: climate zone {} ({}); --zone says another",
                    file.name, file.ashrae_zone, file.year
                );
            }
            if let Some(note) = prepare::design_day_note(&file.site) {
                eprintln!("{}: {note}", file.name);
            }
            anyhow::Ok(Arc::new(file))
        };
        Ok(Places::Files(self.weather.iter().map(read).collect::<Result<_>>()?))
    }

    fn report(&self, all: usize, written: usize) -> Result<()> {
        let (folder, kept) = (self.out.display(), all - written);
        if self.json {
            let manifest = self.out.join(MANIFEST);
            return stdout::print_json(&json!({"written": written, "kept": kept, "manifest": manifest}));
        }
        stdout::print(&format!("{written} buildings written to {folder}, {kept} were there; see {MANIFEST}"))
    }
}

/// Fetches the weather that is not in the cache.
pub fn fetch_weather<'a>(buildings: impl Iterator<Item = &'a Building>, quiet: bool) -> Result<()> {
    let (mut download, cache) = (Download::new(quiet), Cache::from_env()?);
    let mut fetched = HashSet::new();
    for building in buildings.filter(|building| fetched.insert(building.place().to_owned())) {
        interrupt::check()?;
        building.weather(&cache, &mut download)?;
    }
    Ok(())
}
