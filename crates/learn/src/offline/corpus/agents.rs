//! Training of the agents of a corpus.

use std::fs::{remove_dir_all, rename};
use std::path::Path;
use std::time::Duration;

use b2b_agent::INFO;

use super::definition::Definition;
use super::history::{AGENTS, Stage};
use super::writer::Writer;
use crate::error::at;
use crate::train::{STAGES, TrainConfig, acquire};
use crate::{Error, Result};

/// Trains the agents of a corpus that are not there yet, one after the other. `train` carries out a configuration in a
/// folder, where it continues an interrupted run. Waits for another process that is training them.
///
/// # Errors
/// [`Error::Invalid`](crate::Error::Invalid) for an unknown corpus or a folder that holds something else;
/// [`Error::Interrupted`](crate::Error::Interrupted); [`Error::Io`](crate::Error::Io); errors of `train`.
pub fn train_agents(
    name: &str,
    corpus: &Path,
    interrupted: fn() -> bool,
    train: &mut dyn FnMut(&TrainConfig, &Path) -> Result<()>,
) -> Result<()> {
    let definition = Definition::named(name)?;
    if definition.histories.is_empty() {
        return Ok(());
    }
    Writer::open(corpus, &definition)?;
    let folder = corpus.join(AGENTS);
    let _lock = acquire(&folder, Duration::MAX, interrupted)?;
    for (history, building_type) in definition.trainings() {
        let place = |stage: Stage<'_>| stage.folder(corpus, building_type);
        let left: Vec<_> = history.all_stages().filter(|stage| !place(*stage).join(INFO).exists()).collect();
        if left.is_empty() {
            continue;
        }
        let run = folder.join(format!(".b2b-unfinished-{building_type}-{}", history.name));
        train(&history.config(building_type)?, &run)?;
        let kept = |stage: &Stage<'_>| run.join(STAGES).join(stage.number.to_string());
        if let Some(lost) = left.iter().map(kept).find(|kept| !kept.join(INFO).exists()) {
            // An agent that could not be written is a warning of the run, which is done and would not write it again.
            remove_dir_all(&run).map_err(at(&run))?;
            return Err(Error::Invalid(format!(
                "the training could not keep {}; free disk space and run the command again",
                lost.display()
            )));
        }
        for stage in left {
            rename(kept(&stage), place(stage)).map_err(at(&kept(&stage)))?;
        }
        remove_dir_all(&run).map_err(at(&run))?;
    }
    Ok(())
}
