//! `b2b evaluate compare`: several evaluations on one page.

use std::collections::BTreeSet;
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
    let names = names(&arguments.folders);
    let all = arguments.folders.iter().zip(names).map(|(folder, name)| read(folder, name));
    let all = all.collect::<Result<Vec<_>>>()?;
    OutputFolder::write_file(&arguments.out, |file| Ok(write_comparison(file, &all)?))?;
    stdout::print(&arguments.out.display().to_string())?;
    Ok(ExitCode::Success)
}

/// Returns the names of evaluations: the shortest ends of their paths that differ.
fn names(folders: &[PathBuf]) -> Vec<String> {
    let whole = |folder: &PathBuf| folder.canonicalize().unwrap_or_else(|_| folder.clone());
    let paths: Vec<Vec<String>> = folders
        .iter()
        .map(|folder| whole(folder).iter().map(|part| part.to_string_lossy().into_owned()).collect())
        .collect();
    let end = |path: &[String], length: usize| path[path.len().saturating_sub(length)..].join("/");
    let longest = paths.iter().map(Vec::len).max().unwrap_or(1);
    let ends = |length: usize| paths.iter().map(|path| end(path, length)).collect::<Vec<_>>();
    let differ = |names: &[String]| names.iter().collect::<BTreeSet<_>>().len() == names.len();
    (1..longest).map(ends).find(|names| differ(names)).unwrap_or_else(|| ends(longest))
}

/// Reads the episodes of an evaluation.
fn read(folder: &Path, name: String) -> Result<Compared> {
    if !folder.join("episodes.parquet").is_file() {
        bail!("{} is not the folder of a finished `b2b evaluate`", folder.display());
    }
    let rows = read_rows(folder).with_context(|| format!("cannot read {}", folder.display()))?;
    Ok(Compared { name, rows })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn evaluations_have_names_that_differ() {
        let names = |folders: &[&str]| names(&folders.iter().map(PathBuf::from).collect::<Vec<_>>());
        assert_eq!(names(&["none/reactive", "none/ppo"]), ["reactive", "ppo"]);
        assert_eq!(names(&["none/a/evaluation", "none/b/evaluation"]), ["a/evaluation", "b/evaluation"]);
        assert_eq!(names(&["none/a", "none/a"]), ["none/a", "none/a"], "twice the same");
    }
}
