//! The engine's output files of an episode, in a folder chosen by the user.

use std::path::Path;

use b2b_building::{Model, PreparedBuilding};
use serde_json::json;

use super::engine::{OUTDOOR, ZONE_TEMPERATURE};
use super::{Env, episode_model, meters, write_model};
use crate::{Error, Result};

/// The files of `OutputControl:Files` that are written; `eplusout.err` always is.
const FILES: [&str; 10] = ["eso", "mtr", "eio", "tabular", "sqlite", "bnd", "rdd", "mdd", "end", "shd"];

impl Env {
    /// Makes the engine write its output files to `folder` and keeps them: `eplusout.err`, `.eio`, `.eso`, `.mtr`,
    /// `.sql`, `.rdd`, `.mdd`, the summary `eplustbl.htm`, and the model as it ran. Time series have zone temperatures,
    /// weather and the quantities driven by actuators, for every step. Every episode overwrites the files; they are
    /// complete when the episode is over or the environment is dropped. The trajectory is unchanged, but steps are
    /// slower.
    ///
    /// # Errors
    /// [`Error::Io`] when the folder or the model in it cannot be written.
    pub fn keep_engine_output(mut self, folder: &Path) -> Result<Self> {
        let folder =
            std::path::absolute(folder).map_err(|source| Error::Io { path: folder.to_owned(), source })?;
        std::fs::create_dir_all(&folder).map_err(|source| Error::Io { path: folder.clone(), source })?;
        let mut model = episode_model(&self.spaces.building, &self.spaces.episode, &self.meters);
        request(&mut model, &self.spaces.building);
        write_model(&folder, &model)?;
        self.meter_file = folder.join(meters::METER_FILE);
        self.folder = folder;
        self._temporary = None;
        Ok(self)
    }
}

/// Makes the engine write [`FILES`].
fn request(model: &mut Model, building: &PreparedBuilding) {
    for name in model.names("OutputControl:Files") {
        if let Some(files) = model.get_mut("OutputControl:Files", &name) {
            files.extend(FILES.map(|file| (format!("output_{file}"), json!("Yes"))));
        }
    }
    let effects = building.actuators().map(|actuator| actuator.effect.name.as_str());
    let mut variables: Vec<&str> = effects.chain(OUTDOOR).chain([ZONE_TEMPERATURE]).collect();
    variables.sort_unstable();
    variables.dedup();
    for name in variables {
        let fields = json!({"key_value": "*", "variable_name": name, "reporting_frequency": "Timestep"});
        model.insert("Output:Variable", name, fields);
    }
    model.insert("Output:VariableDictionary", "dictionary", json!({"key_field": "regular"}));
    model.insert("Output:SQLite", "tables", json!({"option_type": "SimpleAndTabular"}));
    let summary = json!({"reports": [{"report_name": "AllSummary"}]});
    model.insert("Output:Table:SummaryReports", "summary", summary);
    model.insert("OutputControl:Table:Style", "style", json!({"column_separator": "HTML"}));
}
