//! The documentation shows the output of the program.

use crate::program::{b2b, stderr};

/// Lines that vary from run to run.
const VARIABLE: [&str; 3] = ["  speed ", "  CPU time ", "  energy mismatch vs. EnergyPlus meters "];

/// Returns the block of text that follows a sentence of the documentation.
fn shown(sentence: &str) -> Vec<String> {
    let page = include_str!("../../../../docs/cli.md");
    let (_, rest) = page.split_once(sentence).expect("the sentence is there");
    let (_, block) = rest.split_once("```text\n").unwrap();
    lines(block.split_once("```").unwrap().0)
}

fn lines(text: &str) -> Vec<String> {
    let varies = |line: &&str| VARIABLE.iter().any(|prefix| line.starts_with(prefix));
    text.lines().filter(|line| !varies(line)).map(str::to_owned).collect()
}

fn printed(arguments: &str) -> Vec<String> {
    let folder = tempfile::tempdir().unwrap();
    let output = b2b(folder.path(), arguments);
    assert!(output.status.success(), "{}", stderr(&output));
    lines(std::str::from_utf8(&output.stdout).unwrap())
}

#[test]
fn the_list_of_types_is_shown() {
    assert_eq!(printed("list --sizes"), shown("`b2b list --sizes` prints:"));
}

#[test]
fn the_description_of_a_building_is_shown() {
    assert_eq!(printed("show OfficeMedium"), shown("`b2b show OfficeMedium` prints:"));
}

#[test]
fn the_report_of_a_run_is_shown() {
    let sentence =
        "`b2b run OfficeSmall` operates a small office for a winter under Guideline 36 and prints:";
    assert_eq!(printed("run OfficeSmall"), shown(sentence));
}
