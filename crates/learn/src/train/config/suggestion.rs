//! Suggestions for misspelled keys.

/// Similarity from which on a name is suggested.
const SIMILAR: f64 = 0.75;

/// Adds the most similar of the expected keys to serde's message about an unknown one.
pub(super) fn with_suggestion(message: &str) -> String {
    let quoted: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    let Some((unknown, expected)) = quoted.split_first().filter(|_| message.contains("unknown")) else {
        return message.to_owned();
    };
    let similarity = |name: &&&str| (strsim::jaro_winkler(unknown, name) * 1e6) as u64;
    match expected.iter().max_by_key(similarity).filter(|best| strsim::jaro_winkler(unknown, best) > SIMILAR)
    {
        Some(best) => format!("{message}; did you mean `{best}`?"),
        None => message.to_owned(),
    }
}
