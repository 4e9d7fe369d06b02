//! The lists in docs/tasks.md match the code, and the example in CONTRIBUTING.md is a file.
//!
//! `B2B_RECORD_DOCS=1 cargo test --release -p b2b-env docs` writes the lists.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use super::Resource;
use crate::EpisodeMetrics;

#[test]
fn the_page_of_tasks_lists_the_resources_and_the_metrics() {
    let path = repository().join("docs/tasks.md");
    let page = std::fs::read_to_string(&path).unwrap();
    let expected = with_table(&with_table(&page, &resources()), &metrics());
    if std::env::var_os("B2B_RECORD_DOCS").is_some() {
        std::fs::write(&path, &expected).unwrap();
    }
    let remedy = "run `B2B_RECORD_DOCS=1 cargo test --release -p b2b-env docs`";
    assert!(std::fs::read_to_string(&path).unwrap() == expected, "docs/tasks.md is out of date: {remedy}");
}

fn resources() -> String {
    let mut table = String::from("| resource | penalty = weight W / scale × |\n|---|---|\n");
    for penalty in Resource::ALL.map(Resource::penalty) {
        writeln!(table, "| `{}W` | {} |", penalty.word, penalty.doc).unwrap();
    }
    table
}

fn metrics() -> String {
    let mut table = String::from("| metric | unit | meaning |\n|---|---|---|\n");
    for column in EpisodeMetrics::columns() {
        writeln!(table, "| `{}` | {} | {} |", column.name, column.unit, column.doc.trim()).unwrap();
    }
    table
}

/// Returns a page with the table that has the same header replaced.
fn with_table(page: &str, table: &str) -> String {
    let header = table.lines().next().unwrap();
    let begin = page.find(header).unwrap_or_else(|| panic!("docs/tasks.md has no table `{header}`"));
    let end = page[begin..].find("\n\n").map_or(page.len(), |length| begin + length + 1);
    format!("{}{table}{}", &page[..begin], &page[end..])
}

#[test]
fn the_example_of_a_term_is_the_file_that_it_names() {
    let page = std::fs::read_to_string(repository().join("CONTRIBUTING.md")).unwrap();
    let section = page.split("## Add a reward term").nth(1).unwrap();
    let code = section.split("```rust,ignore\n").nth(1).and_then(|rest| rest.split("   ```").next()).unwrap();
    let code: Vec<&str> = code.lines().map(|line| line.strip_prefix("   ").unwrap_or(line)).collect();
    assert_eq!(code.join("\n").trim(), include_str!("cost.rs").trim());
}

/// A term and a metric that no other file mentions.
#[test]
fn a_term_and_a_metric_are_two_files_each() {
    let term = files_with(&["peak_gas", "PeakGas"]);
    assert_eq!(term, ["crates/env/src/terms/mod.rs", "crates/env/src/terms/peak.rs"]);
    let metric = files_with(&["zones_never_near_target"]);
    assert_eq!(metric, ["crates/env/src/metrics/episode_metrics.rs", "crates/env/src/metrics/mod.rs"]);
}

/// Returns the source files of the product with any of the words, relative to the repository.
fn files_with(words: &[&str]) -> Vec<String> {
    let mut found = Vec::new();
    for folder in ["crates", "python/src", "python/building2building"] {
        search(&repository().join(folder), words, &mut found);
    }
    found.sort();
    found
}

fn search(folder: &Path, words: &[&str], found: &mut Vec<String>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let is_test = path.ends_with("tests") || path.ends_with("terms/docs.rs");
        let is_code =
            ["rs", "py", "js", "html"].iter().any(|end| path.extension().is_some_and(|own| own == *end));
        if path.is_dir() && !is_test {
            search(&path, words, found);
        } else if is_code && !is_test {
            let text = std::fs::read_to_string(&path).unwrap();
            if words.iter().any(|word| text.contains(word)) {
                let relative = path.strip_prefix(repository()).unwrap();
                found.push(relative.to_string_lossy().into_owned());
            }
        }
    }
}

fn repository() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).parent().unwrap().parent().unwrap().to_owned()
}
