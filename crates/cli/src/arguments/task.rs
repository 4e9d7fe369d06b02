//! Parsing of tasks on the command line.

use std::path::Path;

use b2b_env::Task;

/// Parses a task from its short form, or reads it from a JSON file.
pub fn parse(text: &str) -> b2b_env::Result<Task> {
    let path = Path::new(text);
    if path.extension().is_some_and(|extension| extension == "json") {
        Task::read(path)
    } else {
        text.parse()
    }
}
