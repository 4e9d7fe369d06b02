//! Wrapping of text to the width of the terminal.

use std::io::IsTerminal;

/// Width of help texts without a terminal.
const HELP_WIDTH: usize = 80;

/// Maximum width of help texts: longer lines are hard to read.
const WIDEST_HELP: usize = 100;

/// Minimum width of a description next to its term.
const NARROWEST_COLUMN: usize = 30;

/// Returns the width of the terminal that standard output is connected to, else the environment variable `COLUMNS`;
/// `None` if there is no limit, as in a file or a pipe.
pub fn width() -> Option<usize> {
    let terminal = std::io::stdout().is_terminal().then(terminal_size::terminal_size).flatten();
    let columns = || std::env::var("COLUMNS").ok()?.parse().ok().filter(|columns| *columns > 0);
    terminal.map(|(terminal_size::Width(columns), _)| columns.into()).or_else(columns)
}

/// Returns a message for standard error, wrapped at the width of the terminal if there is one, because a terminal
/// breaks lines within words.
pub fn message(text: &str) -> String {
    let terminal = || terminal_size::terminal_size_of(std::io::stderr()).map(|(width, _)| width.0.into());
    let columns = || std::env::var("COLUMNS").ok()?.parse().ok().filter(|columns| *columns > 0);
    let width: Option<usize> = std::io::stderr().is_terminal().then(terminal).flatten().or_else(columns);
    match width {
        Some(width) => lines(text.trim_end(), width),
        None => text.trim_end().to_owned(),
    }
}

/// Returns the width of help texts.
pub fn help_width() -> usize {
    width().unwrap_or(HELP_WIDTH).min(WIDEST_HELP)
}

/// Returns a parser whose help fits the terminal.
pub fn help(parser: clap::Command) -> clap::Command {
    let width = help_width();
    fit(parser.term_width(width), width)
}

fn fit(command: clap::Command, width: usize) -> clap::Command {
    let text = |given: Option<&clap::builder::StyledStr>| given.map(|text| reflow(&text.to_string(), width));
    let (about, after) = (text(command.get_long_about()), text(command.get_after_help()));
    let command = match about {
        Some(about) => command.long_about(about),
        None => command,
    };
    let command = match after {
        Some(after) => command.after_help(after),
        None => command,
    };
    command.mut_subcommands(|each| fit(each, width))
}

/// Joins the lines of each paragraph and description, and wraps them again at `width`.
fn reflow(text: &str, width: usize) -> String {
    let mut joined: Vec<String> = Vec::new();
    for line in text.lines() {
        let indent = indent_of(line);
        let continues = |above: &String| match indent {
            0 => !line.is_empty() && !above.is_empty() && indent_of(above) == 0 && !above.ends_with(':'),
            _ => indent > 4 && description_of(above) == Some(indent),
        };
        match joined.last_mut().filter(|above| continues(above)) {
            Some(above) => {
                above.push(' ');
                above.push_str(line.trim_start());
            }
            None => joined.push(line.to_owned()),
        }
    }
    lines(&joined.join("\n"), width)
}

/// Wraps lines longer than `width` between words. Continuation lines are indented like the description; commands are
/// continued with a backslash, so that they can be copied.
pub fn lines(text: &str, width: usize) -> String {
    text.lines().map(|line| broken(line, width)).collect::<Vec<_>>().join("\n")
}

fn broken(line: &str, width: usize) -> String {
    if length(line) <= width {
        return line.to_owned();
    }
    let indent = indent_of(line);
    let is_command = line.trim_start().starts_with("b2b ");
    let description = description_of(line);
    // The comment of a command, and a description without room beside its term, move to the next line.
    let parts =
        description.map(|at| line.split_at(line.char_indices().nth(at).map_or(line.len(), |(byte, _)| byte)));
    let goes_below = |(term, text): &(&str, &str)| {
        let longest = text.split(' ').map(length).max().unwrap_or(0);
        is_command || length(term) + longest.max(NARROWEST_COLUMN) > width
    };
    if let Some((term, description)) = parts.filter(goes_below) {
        let below = format!("{}{description}", " ".repeat(indent + 4));
        return format!("{}\n{}", broken(term.trim_end(), width), broken(&below, width));
    }
    let (hanging, end) = match description {
        Some(at) => (at, ""),
        None if is_command => (indent + 4, " \\"),
        None => (indent, ""),
    };
    let mut done = String::new();
    let mut current = line[..line.len() - line.trim_start().len()].to_owned();
    for (index, word) in split(line.trim_start(), is_command).enumerate() {
        if index > 0 && length(&current) + length(word.trim_end()) + end.len() > width {
            done += &format!("{}{end}\n", current.trim_end());
            current = " ".repeat(hanging);
        }
        current += word;
    }
    done + current.trim_end()
}

/// Splits a line where it may be broken: between words, or before the options of a command. Each part keeps the spaces
/// after it.
fn split(text: &str, is_command: bool) -> impl Iterator<Item = &str> {
    let mut rest = text;
    std::iter::from_fn(move || {
        let separator = if is_command { " --" } else { " " };
        let end = rest.find(separator).unwrap_or(rest.len());
        let gap = rest[end..].len() - rest[end..].trim_start().len();
        let (first, others) = rest.split_at(end + gap);
        rest = others;
        (!first.is_empty()).then_some(first)
    })
}

/// Returns the column of the description in a line such as `  --json    Print JSON`.
fn description_of(line: &str) -> Option<usize> {
    let text = line.trim_start();
    let gap = text.find("  ")?;
    let behind = text[gap..].trim_start();
    (indent_of(line) > 0 && !behind.is_empty()).then(|| length(line) - length(behind))
}

fn indent_of(line: &str) -> usize {
    line.len() - line.trim_start().len()
}

fn length(text: &str) -> usize {
    text.chars().count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_description_is_broken_under_itself() {
        let line = "  climate   ASHRAE zone 5B, 3369 heating degree days, 1593 cooling";
        let expected = "  climate   ASHRAE zone 5B, 3369 heating\n            degree days, 1593 cooling";
        assert_eq!(lines(line, 44), expected);
    }

    #[test]
    fn a_command_is_continued_so_that_it_can_be_copied() {
        let line = "  b2b run OfficeSmall --task constant --out x    every step";
        assert_eq!(
            lines(line, 32),
            "  b2b run OfficeSmall \\\n      --task constant --out x\n      every step"
        );
    }

    #[test]
    fn paragraphs_and_descriptions_are_joined_before_they_are_broken() {
        let text = "One line\nand another.\n\nList:\n  term    what it\n          means";
        assert_eq!(reflow(text, 80), "One line and another.\n\nList:\n  term    what it means");
    }
}
