//! `b2b dataset`: what the dataset holds.

use std::path::PathBuf;

use anyhow::Result;

use crate::output_folder::OutputFolder;
use crate::{manifest_file, ranges, stdout};

/// Tell what the dataset of 6,000 buildings holds
#[derive(clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    what: What,
}

#[derive(clap::Subcommand)]
enum What {
    Manifest(ManifestArguments),
    /// Print what each parameter ranges over: by type and climate zone beside what the code asks, and for houses
    /// by vintage
    #[command(after_help = "\
U in W/m²K. Walls and roofs follow one parameter, envelope: a multiplier of what ASHRAE 90.1 asks for.
infiltration multiplies the prototype's. Units of houses are in the documentation.")]
    Ranges,
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
    let arguments = match &arguments.what {
        What::Manifest(arguments) => arguments,
        What::Ranges => return stdout::print(&ranges::text()?),
    };
    let folder = OutputFolder::stage(&arguments.out)?;
    let manifest = b2b_dataset::manifest(b2b_dataset::all());
    let names = manifest_file::write(&folder, b2b_dataset::GENERATOR_VERSION, &manifest)?;
    let files = folder.destinations(&names.each_ref().map(String::as_str));
    folder.keep()?;
    let files: Vec<_> = files.iter().map(|file| file.display().to_string()).collect();
    stdout::print(&files.join("\n"))
}
