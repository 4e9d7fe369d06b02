//! `b2b evaluate compare`: several evaluations on one page.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use b2b_evaluate::read_rows;
use b2b_evaluate::report::{Compared, write_comparison};

use crate::output_folder::OutputFolder;
use crate::terminal::exit_code::ExitCode;
use crate::terminal::stdout;

/// Compare evaluations of the same episodes on one page
///
/// Writes one HTML page that needs no network: the distributions of step rewards, RMS deviations, and energy versus
/// comfort of every policy.
#[derive(clap::Args)]
#[command(
    verbatim_doc_comment,
    after_help = "\
Examples:
  b2b evaluate --policy reactive --type OfficeSmall --out reactive
  b2b evaluate --policy ppo.onnx --type OfficeSmall --out ppo
  b2b evaluate compare reactive ppo --out comparison.html"
)]
pub struct Arguments {
    /// Output folders of `b2b evaluate`
    #[arg(value_name = "FOLDER", required = true, num_args = 2..)]
    folders: Vec<PathBuf>,
    /// HTML file to write
    #[arg(long, value_name = "FILE", default_value = "comparison.html", value_parser = crate::arguments::page::path)]
    out: PathBuf,
}

/// Runs the command.
pub fn compare(arguments: &Arguments) -> Result<ExitCode> {
    let all = arguments.folders.iter().map(|folder| read(folder)).collect::<Result<Vec<_>>>()?;
    OutputFolder::write_file(&arguments.out, |file| Ok(write_comparison(file, &all)?))?;
    stdout::print(&arguments.out.display().to_string())?;
    Ok(ExitCode::Success)
}

/// Reads the episodes of an evaluation, which is named after its folder.
fn read(folder: &Path) -> Result<Compared> {
    if !folder.join("episodes.parquet").is_file() {
        bail!("{} is not the folder of a finished `b2b evaluate`", folder.display());
    }
    let rows = read_rows(folder).with_context(|| format!("cannot read {}", folder.display()))?;
    let name = folder.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    Ok(Compared { name, rows })
}
