//! `b2b generate`: buildings of the dataset, or new ones, as epJSON files.

mod model_folder;

use std::path::PathBuf;
use std::sync::Arc;

use anyhow::{Context, Result, bail};
use b2b_base::parallel;
use b2b_building::BuildingType;
use b2b_climate::WeatherFile;
use b2b_dataset::manifest::{Manifest, of_buildings};
use b2b_dataset::{Building, Places, Row, Setting};
use b2b_energyplus::install::Quiet;
use serde_json::json;

use crate::arguments::buildings::Split;
use crate::arguments::jobs::Jobs;
use crate::arguments::location::place_name;
use crate::program::{self, weather};
use crate::terminal::progress::{Download, counter};
use crate::terminal::{interrupt, stdout};
use model_folder::{MANIFEST, ModelFolder};

/// Generate buildings as EnergyPlus models
///
/// Writes one epJSON file per building, before sizing, and manifest.csv with the parameters of all buildings. The same
/// command resumes an interrupted generation; a folder with another building of the same name is an error.
#[derive(clap::Args)]
#[command(verbatim_doc_comment, after_help = EXAMPLES)]
pub struct Arguments {
    /// Building type (`b2b list`); optional with --dataset
    #[arg(value_name = "TYPE", required_unless_present = "dataset")]
    building_type: Option<BuildingType>,
    /// Number of buildings
    #[arg(long, default_value_t = 10, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    count: u32,
    /// Random seed of the Latin hypercube that samples the parameters
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Place, may be repeated: each has an equal share of the buildings; for houses, regions of Québec [default: the 16
    /// places in the United States; the 15 regions, in proportion to their numbers of houses]
    #[arg(long = "place", value_name = "NAME", value_parser = place_name)]
    places: Vec<String>,
    /// EPW weather file of another place, may be repeated: each has an equal share of the buildings
    #[arg(long, value_name = "FILE.epw", conflicts_with = "places")]
    weather: Vec<PathBuf>,
    /// ASHRAE 169 climate zone of the weather files, such as 5A [default: derived from their hourly data]
    #[arg(long, value_name = "ZONE", requires = "weather")]
    zone: Option<String>,
    /// Parameter to fix or to draw from a narrower range, by its name in the manifest; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE|LOW..HIGH")]
    settings: Vec<Setting>,
    /// Write buildings of this dataset instead of new ones
    #[arg(long, value_enum, value_name = "VERSION", conflicts_with_all = ["count", "seed", "places", "weather", "settings"])]
    dataset: Option<Version>,
    /// Subset of the dataset [default: all]
    #[arg(long, value_enum, requires = "dataset")]
    split: Option<Split>,
    /// Output folder
    #[arg(long, value_name = "FOLDER")]
    out: PathBuf,
    #[command(flatten)]
    jobs: Jobs,
    /// Print one JSON object instead of a line of text
    #[arg(long)]
    json: bool,
}

const EXAMPLES: &str = "\
Examples:
  b2b generate Warehouse --count 100 --seed 7 --place Miami --place 'Great Falls' --out warehouses
  b2b generate SingleFamilyHouse --count 50 --place Estrie --out houses
  b2b generate OfficeSmall --set window_to_wall=0.3 --set infiltration=0.5..1 --out offices
  b2b generate SingleFamilyHouse --set year=1946..1970 --set foundation=slab --out bungalows
  b2b generate SingleFamilyHouse --set heat_pump_cop=none --set heater=fuel --out furnaces
  b2b generate Warehouse --weather Oslo.epw --out oslo     any place with a weather file
  b2b generate --dataset v1 --out v1                       all 6,000 buildings, 1.5 GB
  b2b generate OfficeSmall --dataset v1 --split test --out v1

--set accepts values within the limits of the climate zone (`b2b dataset ranges` prints the ranges in the dataset).
Parameters that are not set are sampled as in the dataset. For houses, a range replaces the distribution of the
housing stock.

The climate zone of a weather file determines the envelope that the building code requires. It is derived from
degree-days and relative humidity unless --zone sets it. Design days are taken from the header of the file or, if
there are none, from its hourly data.

The same arguments always write the same files.";

/// The version of a dataset.
#[derive(Clone, Copy, clap::ValueEnum)]
enum Version {
    /// 1,000 buildings of each of the six types
    V1,
}

/// Buildings with their names and their manifest.
struct Selection {
    buildings: Vec<(String, Building)>,
    manifest: Manifest,
}

/// Runs the command.
pub fn generate(arguments: &Arguments) -> Result<()> {
    let selection = arguments.selection()?;
    let folder = ModelFolder::open(&arguments.out, &selection.manifest)?;
    let missing: Vec<_> = selection.buildings.iter().filter(|(name, _)| !folder.contains(name)).collect();
    let catalog = program::catalog(&mut Download::new(arguments.json))?;
    weather::fetch(missing.iter().map(|(_, building)| building), arguments.json)?;
    let bar = counter(missing.len(), "buildings", arguments.json);
    let done = parallel::map(arguments.jobs.count()?, &missing, |(name, building)| {
        interrupt::check()?;
        let generated = catalog.generate(building, &mut Quiet);
        let (mut model, _) = generated.with_context(|| format!("cannot generate {name}"))?;
        model.name_house(name);
        folder.write(name, &model.to_epjson())?;
        bar.inc(1);
        anyhow::Ok(())
    });
    bar.finish_and_clear();
    if interrupt::requested() {
        bail!(
            "interrupted after {} of {} buildings; run the same command again to resume",
            bar.position(),
            missing.len()
        );
    }
    done?;
    arguments.report(selection.buildings.len(), missing.len())
}

impl Arguments {
    fn selection(&self) -> Result<Selection> {
        match (self.dataset, self.building_type) {
            (None, Some(building_type)) => self.sample(building_type),
            _ => Ok(self.of_dataset()),
        }
    }

    fn of_dataset(&self) -> Selection {
        let of_type = |row: &&Row| {
            self.building_type.is_none_or(|building_type| building_type == row.id.building_type())
        };
        let of_split = |row: &&Row| self.split.is_none_or(|split| split.contains(row));
        let rows: Vec<_> = b2b_dataset::all().filter(of_type).filter(of_split).collect();
        Selection {
            buildings: rows.iter().map(|row| (row.id.to_string(), row.building.clone())).collect(),
            manifest: b2b_dataset::manifest(rows).with_weather(),
        }
    }

    /// Samples new buildings. Their names contain the seed, which distinguishes them from the dataset's buildings and
    /// from other seeds' buildings.
    fn sample(&self, building_type: BuildingType) -> Result<Selection> {
        let places = self.places(building_type)?;
        let buildings =
            b2b_dataset::sample(building_type, self.count as usize, self.seed, &places, &self.settings)?;
        let name = |number| format!("{building_type}-seed{}-{number:04}", self.seed);
        let buildings: Vec<_> = (1..).map(name).zip(buildings).collect();
        let manifest = of_buildings(buildings.iter().map(|(name, building)| (name.as_str(), building)));
        Ok(Selection { buildings, manifest })
    }

    /// Reads the weather files, and reports what is derived from their hourly data.
    fn places(&self, building_type: BuildingType) -> Result<Places> {
        if self.weather.is_empty() {
            if self.zone.is_some() {
                bail!("--zone is of weather files, and places have their own; remove it, or pass --weather");
            }
            return Ok(match self.places.as_slice() {
                [] => Places::All,
                names => Places::Named(names.to_vec()),
            });
        }
        let commercial = !building_type.is_house();
        if self.zone.is_some() && !commercial {
            bail!("--zone does not apply to houses: their construction follows from their year");
        }
        let read = |path: &PathBuf| {
            let file = WeatherFile::read(path, self.zone.as_deref())?;
            if commercial && self.zone.is_none() {
                eprintln!(
                    "{}: climate zone {} ({}); set another with --zone",
                    file.name, file.ashrae_zone, file.year
                );
            }
            if let Some(note) = weather::design_day_note(&file.site) {
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
        stdout::print(&format!(
            "{written} buildings written to {folder}, {kept} existing ones kept; parameters are in {MANIFEST}"
        ))
    }
}
