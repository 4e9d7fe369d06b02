//! The contents of an experiment's folder.

mod job_folder;
mod job_result;
mod results_folder;

pub use job_folder::{CONFIG, ENTRY, EVALUATION, EVALUATION_LAST, JobFolder, MEASURED, State};
pub use job_result::{Evaluated, JobResult, read_rows, test_rows};
pub use results_folder::Folder;
