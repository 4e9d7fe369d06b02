//! Suggestions for misspelled commands.

use clap::CommandFactory as _;
use clap::error::{ContextKind, ContextValue, Error, ErrorKind};

use crate::Cli;

/// Adds the most similar command to an error about an unknown one: swapped letters, as in `rnu`, are none of the errors that
/// clap finds.
pub fn add(mut usage: Error) -> Error {
    if usage.kind() != ErrorKind::InvalidSubcommand || usage.get(ContextKind::SuggestedSubcommand).is_some() {
        return usage;
    }
    let Some(ContextValue::String(given)) = usage.get(ContextKind::InvalidSubcommand) else { return usage };
    let command = Cli::command();
    let names = command.get_subcommands().map(clap::Command::get_name);
    let near = names.map(|name| (strsim::damerau_levenshtein(name, given), name)).min();
    if let Some((distance, name)) = near.filter(|(distance, name)| distance * 2 < name.len()) {
        debug_assert!(distance > 0, "it would be known");
        let name = ContextValue::Strings(vec![name.to_owned()]);
        usage.insert(ContextKind::SuggestedSubcommand, name);
    }
    usage
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
}
