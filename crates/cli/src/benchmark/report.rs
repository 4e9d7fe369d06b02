//! `b2b benchmark report`: the leaderboard.

use std::path::PathBuf;

use anyhow::{Result, bail};
use b2b_benchmark::entry::{RunResult, read_result};
use b2b_benchmark::{RankBy, leaderboard};

use crate::output_folder::OutputFolder;
use crate::terminal::stdout;

/// Write a leaderboard of results
///
/// Writes one HTML page that needs no network. For every problem it shows a table of the entries, ranked by the
/// interquartile mean of the resolved score or of the paper's score, with confidence intervals, performance profiles,
/// scores by building type, deviations from the target temperature, and the effect of adaptation. Results of modified
/// problems are listed separately.
#[derive(clap::Args)]
#[command(
    verbatim_doc_comment,
    after_help = "\
Examples:
  b2b benchmark report entries/* --out leaderboard.html"
)]
pub struct Arguments {
    /// Result folders
    #[arg(value_name = "FOLDER", required = true)]
    folders: Vec<PathBuf>,
    /// Score that ranks the entries
    #[arg(long, value_enum, default_value_t = Ranking::Resolved)]
    rank_by: Ranking,
    /// HTML file to write
    #[arg(long, value_name = "FILE", default_value = "leaderboard.html", value_parser = crate::arguments::page::path)]
    out: PathBuf,
}

/// A score that ranks entries.
#[derive(Clone, Copy, clap::ValueEnum)]
enum Ranking {
    /// The resolved score: differences below the accuracy of a thermometer count little
    Resolved,
    /// The paper's score: the return divided by the baseline's
    Paper,
}

impl From<Ranking> for RankBy {
    fn from(ranking: Ranking) -> Self {
        match ranking {
            Ranking::Resolved => Self::Resolved,
            Ranking::Paper => Self::Paper,
        }
    }
}

/// Runs the command.
pub fn report(arguments: &Arguments) -> Result<()> {
    let mut results: Vec<(RunResult, _)> = Vec::new();
    for folder in &arguments.folders {
        let (result, stages) = read_result(folder)?;
        result.check_shown(&stages, folder)?;
        let duplicate = results
            .iter()
            .any(|(other, _)| other.name == result.name && other.problem_hash == result.problem_hash);
        if duplicate {
            bail!(
                "two results on {} are named {}; run one of them with another --entry",
                result.problem.name,
                result.name
            );
        }
        results.push((result, stages));
    }
    OutputFolder::write_file(&arguments.out, |file| {
        Ok(leaderboard::write(file, &results, arguments.rank_by.into())?)
    })?;
    stdout::print(&arguments.out.display().to_string())
}
