//! What docs/trust.md states about the sources, and the pinned actions of the workflows.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

#[test]
fn every_action_of_a_workflow_is_pinned_by_its_commit() {
    let mut pinned = 0;
    for entry in std::fs::read_dir(repository().join(".github/workflows")).unwrap() {
        let path = entry.unwrap().path();
        let text = std::fs::read_to_string(&path).unwrap();
        for action in
            text.lines().filter_map(|line| line.trim().trim_start_matches("- ").strip_prefix("uses: "))
        {
            let (_, commit) = action.split_once('@').unwrap();
            let (commit, version) = commit.split_once(" # v").unwrap_or((commit, ""));
            let is_commit = commit.len() == 40 && commit.chars().all(|digit| digit.is_ascii_hexdigit());
            assert!(is_commit && !version.is_empty(), "{}: {action}", path.display());
            pinned += 1;
        }
    }
    assert!(pinned > 10, "{pinned} actions");
}

/// Returns the Rust files of a folder.
fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

/// Returns the crates with their modules that may have unsafe code, outside tests, such as `learn: nn/product`.
fn modules_with_unsafe_code() -> BTreeSet<String> {
    let mut modules = BTreeSet::new();
    for entry in std::fs::read_dir(repository().join("crates")).unwrap() {
        let path = entry.unwrap().path();
        let manifest = std::fs::read_to_string(path.join("Cargo.toml")).unwrap();
        assert!(manifest.contains("[lints]\nworkspace = true"), "{} has lints of its own", path.display());
        let mut files = Vec::new();
        sources(&path.join("src"), &mut files);
        for file in files {
            let text = std::fs::read_to_string(&file).unwrap();
            let product = text.split("#[cfg(test)]").next().unwrap();
            if product.contains("allow(unsafe_code") {
                let name = path.file_name().unwrap().to_string_lossy().into_owned();
                let module = file.strip_prefix(path.join("src")).unwrap().with_extension("");
                let module = module.display().to_string();
                modules.insert(format!("{name}: {}", module.trim_end_matches("/mod")));
            }
        }
    }
    modules
}

#[test]
fn the_page_lists_the_modules_with_unsafe_code() {
    let page = include_str!("../../../../docs/trust.md");
    let (_, section) = page.split_once("## Memory safety").unwrap();
    let (section, _) = section.split_once("\n## ").unwrap();
    let mut listed = BTreeSet::new();
    for row in section.lines().filter(|line| line.starts_with("| `")) {
        let quoted: Vec<&str> = row.split('|').nth(1).unwrap().split('`').skip(1).step_by(2).collect();
        listed.extend(quoted[1..].iter().map(|module| format!("{}: {module}", quoted[0])));
    }
    assert_eq!(modules_with_unsafe_code(), listed);
    let manifest = std::fs::read_to_string(repository().join("Cargo.toml")).unwrap();
    assert!(manifest.contains("unsafe_code = \"deny\""));
}
