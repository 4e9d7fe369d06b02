//! `b2b dataset`: the content of the dataset.

mod explore;
mod manifest_file;
mod ranges;

use std::io::Write;
use std::path::PathBuf;

use anyhow::Result;

use crate::output_folder::OutputFolder;
use crate::terminal::stdout;

/// Explore the dataset, export its table, or print the ranges of its parameters
#[derive(clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(clap::Subcommand)]
enum Command {
    Explore(ExploreArguments),
    Manifest(ManifestArguments),
    /// Print the range of every parameter by type and climate zone, next to the building code; houses by vintage
    #[command(after_help = "\
U-values are in W/(m²·K), with the requirement of ASHRAE 90.1 in parentheses. The infiltration is a factor on
the prototype's. The units of house parameters are in crates/dataset/data/README.md.")]
    Ranges,
}

/// Write a page on which all 6,000 buildings can be filtered, plotted and sorted
///
/// The page has filters by type, place, climate zone, split and parameters, a scatter plot of two parameters, a table
/// and, for each building, all of its parameters and the commands that view and run it. It opens in any browser,
/// without a network.
#[derive(clap::Args)]
#[command(
    verbatim_doc_comment,
    after_help = "\
Examples:
  b2b dataset explore
  b2b dataset explore --out buildings.html"
)]
struct ExploreArguments {
    /// HTML file to write, or the folder for dataset.html
    #[arg(long, value_name = "FILE", default_value = "b2b-out/dataset.html", value_parser = explore::file)]
    out: PathBuf,
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
        Command::Explore(arguments) => return explore(arguments),
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

fn explore(arguments: &ExploreArguments) -> Result<()> {
    let page = explore::page(&b2b_dataset::manifest(b2b_dataset::all()));
    OutputFolder::write_file(&arguments.out, |file| Ok(file.write_all(page.as_bytes())?))?;
    stdout::print(&arguments.out.display().to_string())
}
