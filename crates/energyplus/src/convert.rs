//! Conversion of IDF to epJSON by EnergyPlus itself.

use std::path::Path;

use crate::confinement::confined;
use crate::coroutine::{EngineRun, Outcome, Stops};
use crate::simulation::path_text;
use crate::{Error, Library, Result};
use b2b_base::scratch::temporary_folder;

impl Library {
    /// Converts an IDF file and returns its epJSON text. Runs in a thread confined as by [`confine`](crate::confine).
    ///
    /// # Errors
    /// [`Error::MissingFile`] if the file does not exist; [`Error::Engine`] with the messages of EnergyPlus if it
    /// cannot read the file.
    pub fn convert_idf(&self, idf: &Path) -> Result<String> {
        if !idf.is_file() {
            return Err(Error::MissingFile { what: "model", path: idf.to_owned() });
        }
        match &self.host {
            Some(host) => host.convert_idf(idf),
            None => confined(None, || self.convert(idf)),
        }
    }

    fn convert(&self, idf: &Path) -> Result<String> {
        let folder = temporary_folder("b2b-")?;
        let arguments =
            ["energyplus", "-c", "--convert-only", "-d", path_text(folder.path())?, path_text(idf)?];
        let mut run = EngineRun::new(self, &arguments, &[], Stops { warmup_steps: false, every: 0 })?;
        let code = loop {
            if let Outcome::Returned(code) = run.resume() {
                break code;
            }
        };
        let stem = idf.file_stem().unwrap_or_default().to_string_lossy();
        let converted = folder.path().join(format!("{stem}.epJSON"));
        match std::fs::read_to_string(&converted) {
            Ok(text) if code == 0 => Ok(text),
            _ => Err(Error::Engine { code, model: idf.to_owned(), messages: run.messages() }),
        }
    }
}
