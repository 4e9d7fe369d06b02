//! `b2b dataset`: the content of the dataset.

mod manifest_file;
mod ranges;

use std::path::PathBuf;

use anyhow::Result;

use crate::output_folder::OutputFolder;
use crate::stdout;

/// Export the table of the dataset, or print the ranges of its parameters
#[derive(clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(clap::Subcommand)]
enum Command {
    Manifest(ManifestArguments),
    /// Print the range of every parameter by type and climate zone, next to the building code; houses by vintage
    #[command(after_help = "\
U-values are in W/(m²·K), with the requirement of ASHRAE 90.1 in parentheses. The infiltration multiplies that of
the prototype. The units of house parameters are in crates/dataset/data/README.md.")]
    Ranges,
}

/// Write the table of all 6,000 buildings: place, split and every parameter
///
/// Writes v1.csv and v1.parquet with the same content. The same version of b2b always writes the same files.
#[derive(clap::Args)]
#[command(
    verbatim_doc_comment,
    after_help = "\
Columns that do not apply to a type are empty. For houses, place is a region of Québec. Units are in the
metadata of the Parquet file and in crates/dataset/data/README.md.

Examples:
  b2b dataset manifest --out ."
)]
struct ManifestArguments {
    /// Output folder
    #[arg(long, value_name = "FOLDER")]
    out: PathBuf,
}

/// Runs the command.
pub fn dataset(arguments: &Arguments) -> Result<()> {
    let arguments = match &arguments.command {
        Command::Manifest(arguments) => arguments,
        Command::Ranges => return stdout::print(&ranges::text()?),
    };
    let folder = OutputFolder::stage(&arguments.out)?;
    let manifest = b2b_dataset::manifest(b2b_dataset::all());
    let names = manifest_file::write(&folder, b2b_dataset::GENERATOR_VERSION, &manifest)?;
    let files = folder.destinations(&names.each_ref().map(String::as_str));
    folder.keep()?;
    let files: Vec<_> = files.iter().map(|file| file.display().to_string()).collect();
    stdout::print(&files.join("\n"))
}
