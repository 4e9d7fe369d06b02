//! The documentation shows what the program prints.

mod common;

use common::{b2b, stderr};

/// Lines that are of the machine and the moment.
const PASSING: [&str; 3] = ["  speed ", "  CPU time ", "  energy against the engine's meters "];

/// The block of text that follows a sentence of the documentation.
fn shown(sentence: &str) -> Vec<String> {
    let page = include_str!("../../../docs/cli.md");
    let (_, rest) = page.split_once(sentence).expect("the sentence is there");
    let (_, block) = rest.split_once("```text\n").unwrap();
    lines(block.split_once("```").unwrap().0)
}

fn lines(text: &str) -> Vec<String> {
    let of_the_moment = |line: &&str| PASSING.iter().any(|passing| line.starts_with(passing));
    text.lines().filter(|line| !of_the_moment(line)).map(str::to_owned).collect()
}

fn printed(arguments: &str) -> Vec<String> {
    let folder = tempfile::tempdir().unwrap();
    let output = b2b(folder.path(), arguments);
    assert!(output.status.success(), "{}", stderr(&output));
    lines(std::str::from_utf8(&output.stdout).unwrap())
}

#[test]
fn the_types() {
    assert_eq!(printed("list --sizes"), shown("`b2b list --sizes` prints:"));
}

#[test]
fn a_building() {
    assert_eq!(printed("show OfficeMedium"), shown("`b2b show OfficeMedium` prints:"));
}

#[test]
fn the_main_run() {
    let sentence = "`b2b run OfficeSmall` simulates a winter under the reactive controllers and prints:";
    assert_eq!(printed("run OfficeSmall"), shown(sentence));
}
