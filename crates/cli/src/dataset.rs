//! `b2b dataset`: what the dataset holds.

use std::path::PathBuf;

use anyhow::Result;
use b2b_building::dataset;

use crate::output_folder::OutputFolder;
use crate::{manifest_file, stdout};

/// Tell what the dataset of 6,000 buildings holds
#[derive(clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    what: What,
}

#[derive(clap::Subcommand)]
enum What {
    Manifest(ManifestArguments),
}

/// Write the table of all buildings: place, split and every parameter
///
/// Writes v1.csv and v1.parquet, with the same content. The same version of b2b writes the same bytes.
#[derive(clap::Args)]
#[command(after_help = "\
Columns that have nothing to say of a type are empty. place is a region of Québec for houses. Units are
in the Parquet file and in the documentation.

Examples:
  b2b dataset manifest --out .")]
struct ManifestArguments {
    /// Folder for the two files
    #[arg(long, value_name = "FOLDER")]
    out: PathBuf,
}

/// Runs the command.
pub fn dataset(arguments: &Arguments) -> Result<()> {
    let What::Manifest(arguments) = &arguments.what;
    let folder = OutputFolder::stage(&arguments.out)?;
    let manifest = dataset::manifest(dataset::all());
    let names = manifest_file::write(&folder, dataset::GENERATOR_VERSION, &manifest)?;
    let files = folder.destinations(&names.each_ref().map(String::as_str));
    folder.keep()?;
    let files: Vec<_> = files.iter().map(|file| file.display().to_string()).collect();
    stdout::print(&files.join("\n"))
}
