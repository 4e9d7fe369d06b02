//! `b2b clone`: an agent that imitates the policies of a dataset.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use anyhow::{Context as _, Result, bail};
use b2b_agent::{Agent, ObservationForm, ObservationOptions};
use b2b_base::new_folders::NewFolders;
use b2b_building::{BuildingType, Period, PreparedBuilding};
use b2b_climate::Place;
use b2b_dataset::{Catalog, Control, Placement};
use b2b_energyplus::install::Quiet;
use b2b_env::{EpisodeConfig, Spaces, Task};
use b2b_learn::Error;
use b2b_learn::offline::{
    CloneConfig, Cloned, Contents, Dataset, EpisodeMetadata, ModelReading, clone_policy,
};
use serde_json::json;

use crate::terminal::progress::{Download, counter};
use crate::terminal::{interrupt, stdout};
use crate::{output_folder, program};

/// Train an agent to imitate the policies of a dataset (behavior cloning)
///
/// Fits the actions of a dataset written by `b2b collect`, minimizing the mean squared error. The output folder is an
/// agent, as from `b2b train`: `b2b evaluate --policy FOLDER` scores it.
#[derive(clap::Args)]
#[command(verbatim_doc_comment, after_help = EXAMPLES)]
pub struct Arguments {
    /// Folder of the dataset
    #[arg(value_name = "DATASET")]
    dataset: PathBuf,
    /// Building type to learn, in a corpus of several
    #[arg(long = "type", value_name = "TYPE")]
    building_type: Option<BuildingType>,
    /// Task to learn, in a corpus of several
    #[arg(long, value_name = "TASK", value_parser = Task::from_text)]
    task: Option<Task>,
    /// What the agent observes: raw, roles or features
    #[arg(long, value_name = "FORM", default_value = "raw")]
    observation: ObservationForm,
    /// Let the agent observe attributes of the building, too
    #[arg(long)]
    attributes: bool,
    /// Widths of the hidden layers
    #[arg(long, value_name = "N", num_args = 1.., default_values_t = [256, 256])]
    hidden: Vec<usize>,
    /// Number of gradient updates
    #[arg(long, value_name = "N", default_value_t = 5000, value_parser = clap::value_parser!(u32).range(1..))]
    updates: u32,
    /// Number of recorded steps per update
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..))]
    batch_size: u32,
    /// Initial learning rate, which decreases linearly to 0
    #[arg(long, value_name = "RATE", default_value_t = 1e-3)]
    learning_rate: f64,
    /// Random seed
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Output folder of the agent
    #[arg(long, value_name = "FOLDER")]
    out: PathBuf,
    /// Print one JSON object instead of the text report
    #[arg(long)]
    json: bool,
}

const EXAMPLES: &str = "\
Examples:
  b2b collect b2b/office-small-v0 OfficeSmall-0042 --task occupancy --out datasets
  b2b clone datasets/b2b/office-small-v0 --out runs/clone
  b2b evaluate OfficeSmall-0042 --policy runs/clone --task occupancy --out evaluated
  b2b clone datasets/b2b/corpus-quick-v0 --type OfficeSmall --task occupancy --observation features --out runs/clone";

/// Runs the command.
pub fn clone(arguments: &Arguments) -> Result<()> {
    check(arguments)?;
    let created = NewFolders::create(&arguments.out)
        .with_context(|| format!("cannot create --out {}", arguments.out.display()))?;
    let _lock = output_folder::lock(&arguments.out)?;
    let dataset = Dataset::open(&arguments.dataset)?;
    let catalog = program::catalog(&mut Download::new(arguments.json))?;
    let config = CloneConfig {
        building_type: arguments.building_type.map(|it| it.to_string()),
        task: arguments.task.as_ref().map(Task::to_text),
        observation: ObservationOptions {
            attributes: arguments.attributes,
            ..ObservationOptions::from(arguments.observation)
        },
        hidden: arguments.hidden.clone(),
        updates: arguments.updates as usize,
        batch_size: arguments.batch_size as usize,
        learning_rate: arguments.learning_rate,
        seed: arguments.seed,
    };
    let mut buildings =
        Buildings { catalog: &catalog, contents: &dataset.contents, prepared: HashMap::new() };
    let bar = counter(config.updates, "updates", arguments.json);
    let cloned = clone_policy(&dataset, &config, &mut |episode| buildings.spaces(episode), &mut |updates| {
        bar.set_position(updates as u64);
        !interrupt::requested()
    })?;
    bar.finish_and_clear();
    let Cloned { info, actor, errors: [error, held_out] } = cloned;
    let summary = json!({
        "out": arguments.out,
        "steps": info.training.steps,
        "error": error,
        "held_out_error": held_out,
    });
    Agent::write(&arguments.out, info, &actor)?;
    created.keep();
    stdout::print_result(arguments.json, &summary, || {
        format!(
            "RMS error of actions, relative to half their range: {:.1} % (held-out steps: {:.1} %)\n\n  {}",
            100.0 * error,
            100.0 * held_out,
            arguments.out.display()
        )
    })
}

fn check(arguments: &Arguments) -> Result<()> {
    if !(arguments.learning_rate > 0.0 && arguments.learning_rate.is_finite()) {
        bail!("--learning-rate is {}; expected a number above 0", arguments.learning_rate);
    }
    if arguments.hidden.contains(&0) {
        bail!("--hidden has a layer of width 0; expected widths from 1 on");
    }
    if arguments.out.exists() {
        bail!("--out {} exists; remove it or choose another folder", arguments.out.display());
    }
    Ok(())
}

/// Building with its interface, place, weather file, and how a model file was read.
type Key = (String, Option<String>, Option<PathBuf>, ModelReading);

/// The buildings of a dataset, each of which is prepared once.
struct Buildings<'a> {
    catalog: &'a Catalog,
    contents: &'a Contents,
    prepared: HashMap<Key, (Arc<PreparedBuilding>, PathBuf)>,
}

impl Buildings<'_> {
    fn spaces(&mut self, episode: &EpisodeMetadata) -> b2b_learn::Result<Arc<Spaces>> {
        let EpisodeMetadata { building, place, weather, reading, .. } = episode;
        let invalid = |error: &dyn std::fmt::Display| Error::Invalid(error.to_string());
        let key = (building.clone(), place.clone(), weather.clone(), reading.clone());
        if !self.prepared.contains_key(&key) {
            let place = place.as_deref().map(Place::find).transpose().map_err(|error| invalid(&error))?;
            let (name, control) = Control::split_name(building);
            let ModelReading { keep_design_days, transition } = reading.clone();
            let weather = weather.clone();
            let placement =
                Placement { place, weather, control, keep_design_days, transition, ..Placement::default() };
            let found = self.catalog.find(&name.parse()?, &placement, &mut Quiet)?;
            let weather = found.weather.clone();
            let prepared = found.prepare(self.catalog.library()).map_err(|error| invalid(&error))?;
            self.prepared.insert(key.clone(), (Arc::new(prepared), weather));
        }
        let (building, weather) = &self.prepared[&key];
        let Contents { task, period, steps_per_hour, .. } = self.contents;
        let task = episode.corpus.as_ref().map_or(task, |of| &of.task);
        let period = episode.period.as_ref().unwrap_or(period);
        let days = period.parse::<Period>().and_then(|period| period.in_weather(weather));
        let config = EpisodeConfig {
            weather: weather.clone(),
            period: days.map_err(|error| invalid(&error))?,
            steps_per_hour: *steps_per_hour,
            task: Task::from_text(task)?,
        };
        Ok(Arc::new(Spaces::new(Arc::clone(building), config)))
    }
}
