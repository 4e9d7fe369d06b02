//! Suggestions for misspelled words.

use clap::CommandFactory as _;
use clap::builder::StyledStr;
use clap::error::{ContextKind, ContextValue, Error, ErrorKind};

use crate::Cli;

/// Adds a tip to an error about the arguments.
pub fn add(usage: Error) -> Error {
    match usage.kind() {
        ErrorKind::InvalidSubcommand => add_command(usage),
        ErrorKind::ValueValidation | ErrorKind::UnknownArgument => add_comparison(usage),
        _ => usage,
    }
}

/// The standard library's messages on text that cannot be parsed, and what is expected instead.
const TYPES: [(&str, &str); 5] = [
    ("invalid float literal", "expected a number"),
    ("cannot parse float from empty string", "expected a number"),
    ("invalid digit found in string", "expected a whole number"),
    ("cannot parse integer from empty string", "expected a whole number"),
    ("invalid IP address syntax", "expected an IP address, such as 127.0.0.1"),
];

/// Returns a message in which the standard library's parse errors are replaced by what is expected.
pub fn in_words(message: &str) -> String {
    TYPES.iter().fold(message.to_owned(), |text, (said, expected)| text.replace(said, expected))
}

/// Adds a tip on comparing controllers if a controller's name is parsed as a building, as in `--policy hold off`.
fn add_comparison(mut usage: Error) -> Error {
    let given =
        [ContextKind::InvalidValue, ContextKind::InvalidArg].into_iter().find_map(|kind| usage.get(kind));
    let names: Vec<&str> = match given {
        Some(ContextValue::String(value)) => vec![value],
        Some(ContextValue::Strings(values)) => values.iter().map(String::as_str).collect(),
        _ => return usage,
    };
    if let Some(kind) = names.into_iter().find_map(b2b_control::kind) {
        let tip = format!(
            "`{}` is a controller, and a command runs one; give each its own --out, then use `b2b compare` or `b2b evaluate compare`",
            kind.name()
        );
        usage.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![StyledStr::from(tip)]));
    }
    usage
}

/// Adds the most similar command to an error about an unknown one, because clap does not recognize swapped letters, as
/// in `rnu`.
fn add_command(mut usage: Error) -> Error {
    if usage.get(ContextKind::SuggestedSubcommand).is_some() {
        return usage;
    }
    let Some(ContextValue::String(given)) = usage.get(ContextKind::InvalidSubcommand) else { return usage };
    let command = Cli::command();
    if let Some(name) = nearest(given, command.get_subcommands().map(clap::Command::get_name)) {
        let name = ContextValue::Strings(vec![name.to_owned()]);
        usage.insert(ContextKind::SuggestedSubcommand, name);
    }
    usage
}

/// Returns `did you mean NAME? ` with the most similar of the known names, to come before what is expected; empty if
/// none is similar.
pub fn near<'a>(given: &str, known: impl Iterator<Item = &'a str>) -> String {
    nearest(given, known).map_or_else(String::new, |name| format!("did you mean {name}? "))
}

/// Returns the most similar of the known names, if more than half of its letters are right.
fn nearest<'a>(given: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let near = known.map(|name| (strsim::damerau_levenshtein(name, given), name)).min();
    near.filter(|(distance, name)| distance * 2 < name.len()).map(|(_, name)| name)
}

#[cfg(test)]
mod tests {
    use clap::Parser as _;

    use super::*;

    #[test]
    fn a_misspelled_command_gets_the_nearest() {
        let said = |word: &str| add(Cli::try_parse_from(["b2b", word]).err().unwrap()).to_string();
        for (word, near) in [("rnu", "run"), ("evalute", "evaluate"), ("lits", "list"), ("dcotor", "doctor")]
        {
            assert!(said(word).contains(&format!("'{near}'")), "{}", said(word));
        }
        assert!(!said("zzz").contains("tip"), "{}", said("zzz"));
    }

    #[test]
    fn a_misspelled_name_gets_the_nearest() {
        let near = |given| near(given, ["default", "tuned"].into_iter());
        assert_eq!(near("tund"), "did you mean tuned? ");
        assert_eq!(near("mine"), "");
    }
}
