//! Files written by users: text with or without a byte order mark, and JSON objects.

use std::path::Path;

use serde::de::DeserializeOwned;

/// Reads a text without the byte order mark that some editors add.
///
/// # Errors
/// Errors from [`std::fs::read_to_string`].
pub fn read(path: &Path) -> std::io::Result<String> {
    let text = std::fs::read_to_string(path)?;
    Ok(match text.strip_prefix('\u{feff}') {
        Some(text) => text.to_owned(),
        None => text,
    })
}

/// Parses a JSON object. A list is an error, although serde accepts one for a struct: `[]` would mean all defaults.
///
/// # Errors
/// The reason why the text is not a JSON object of this type.
pub fn parse_object<T: DeserializeOwned>(text: &str) -> Result<T, String> {
    match text.trim_start().chars().next() {
        Some('{') => serde_json::from_str(text).map_err(|error| error.to_string()),
        Some(other) => Err(format!("expected a JSON object, which begins with `{{`, found `{other}`")),
        None => Err("it is empty; expected a JSON object".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, Default, PartialEq, serde::Deserialize)]
    #[serde(default)]
    struct Options {
        gain: f64,
    }

    #[test]
    fn only_an_object_is_accepted() {
        assert_eq!(parse_object(" {\"gain\": 2}"), Ok(Options { gain: 2.0 }));
        for (text, expected) in [("[]", "found `[`"), ("", "it is empty"), ("{\"gain\": []}", "line 1")] {
            let error = parse_object::<Options>(text).unwrap_err();
            assert!(error.contains(expected), "{error}");
        }
    }

    #[test]
    fn a_byte_order_mark_is_not_part_of_the_text() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("options.json");
        std::fs::write(&path, "\u{feff}{}").unwrap();
        assert_eq!(read(&path).unwrap(), "{}");
    }
}
