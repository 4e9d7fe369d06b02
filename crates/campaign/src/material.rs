//! Valid files of every kind that the program reads, written by the program itself, to be damaged by the campaign.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use b2b_energyplus::install::{Engine, Quiet};

use crate::program::Program;

/// Weather of the models.
const WEATHER: &str = "USA_IL_Chicago-OHare.Intl.AP.725300_TMY3.epw";
const TRAINING: &str = "window_days = 1\n[evaluation]\nevery = 1000\ndays = 1\n";

/// A folder with valid files.
pub struct Material {
    folder: PathBuf,
    models: Vec<PathBuf>,
}

impl Material {
    /// Creates the files, which takes about 15 seconds.
    pub fn make(program: &Program, folder: &Path) -> Result<Self> {
        let models = Engine::ensure(&mut Quiet)?.models.context("the engine has no folder of models")?;
        let weather = models.with_file_name("weather").join(WEATHER);
        std::fs::copy(&weather, folder.join("weather.epw")).context("cannot copy the weather file")?;
        std::fs::write(folder.join("train.toml"), TRAINING)?;
        for arguments in [
            "generate SingleFamilyHouse --count 1 --out house",
            "generate Warehouse --count 1 --out warehouse",
            "run SingleFamilyHouse --period 01-01..01-01 --out run",
            "evaluate SingleFamilyHouse-0018 --policy reactive --period 01-01..01-01 --out evaluation",
            "train SingleFamilyHouse --config train.toml --direct --observation raw --period 01-01..01-02 \
             --steps 2000 --environments 2 --out agent",
            "export agent --out agent.onnx",
            "collect offline-v0 SingleFamilyHouse-0018 --policy reactive --period 01-01..01-01 --out .",
        ] {
            program.must(folder, arguments)?;
        }
        Self::open(folder)
    }

    /// Opens a folder with the files.
    pub fn open(folder: &Path) -> Result<Self> {
        let mut models = Vec::new();
        for name in ["house", "warehouse"] {
            for entry in std::fs::read_dir(folder.join(name))? {
                models.push(entry?.path());
            }
        }
        models.retain(|path| path.extension().is_some_and(|extension| extension == "epJSON"));
        models.sort();
        Ok(Self { folder: folder.to_owned(), models })
    }

    /// Returns the path of a file or folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// Returns the content of a file.
    pub fn bytes(&self, name: &str) -> Result<Vec<u8>> {
        let path = self.path(name);
        std::fs::read(&path).with_context(|| format!("cannot read {}", path.display()))
    }

    /// Returns the models.
    pub fn models(&self) -> &[PathBuf] {
        &self.models
    }
}
