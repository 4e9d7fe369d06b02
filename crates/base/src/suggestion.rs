//! Suggestions for misspelled names.

/// Minimum similarity of a suggested name.
const SIMILAR: f64 = 0.75;

/// Returns the most similar of some names, quoted; empty if none is similar.
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let similarity = |known: &str| strsim::jaro_winkler(known, name);
    let near = known.into_iter().filter(|known| similarity(known) > SIMILAR);
    let near = near.max_by(|a, b| similarity(a).total_cmp(&similarity(b)));
    near.map_or_else(String::new, |near| format!("`{near}`"))
}

/// Returns ` (did you mean NAME?)`, to follow a wrong name in a message; empty without a similar name.
pub fn did_you_mean(near: &str) -> String {
    if near.is_empty() { String::new() } else { format!(" (did you mean {near}?)") }
}

/// Adds the most similar of the expected keys to serde's message about an unknown one.
pub fn with_suggestion(message: &str) -> String {
    let quoted: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    let Some((unknown, expected)) = quoted.split_first().filter(|_| message.contains("unknown")) else {
        return message.to_owned();
    };
    let near = nearest(unknown, expected.iter().copied());
    if near.is_empty() { message.to_owned() } else { format!("{message}; did you mean {near}?") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_similar_name_is_suggested_and_another_is_not() {
        assert_eq!(nearest("hq-n", ["flat", "hq-m"]), "`hq-m`");
        assert_eq!(nearest("zzz", ["flat", "hq-m"]), "");
        assert_eq!([did_you_mean("`hq-m`").as_str(), &did_you_mean("")], [" (did you mean `hq-m`?)", ""]);
    }

    #[test]
    fn an_unknown_key_gets_the_nearest_of_the_expected() {
        let message = "unknown field `prise`, expected one of `price`, `hours`";
        assert_eq!(with_suggestion(message), format!("{message}; did you mean `price`?"));
        assert_eq!(with_suggestion("missing field `price`"), "missing field `price`");
    }
}
