//! The text of a model file, and checks of it before the engine reads it.

/// Returns the text of a model without a byte order mark, and a warning if it is not UTF-8: it is then read as Latin-1.
pub(super) fn decode(bytes: &[u8]) -> (String, Option<String>) {
    match std::str::from_utf8(bytes) {
        Ok(text) => (text.strip_prefix('\u{feff}').unwrap_or(text).to_owned(), None),
        Err(error) => {
            let line = 1 + bytes[..error.valid_up_to()].iter().filter(|byte| **byte == b'\n').count();
            let warning = format!("the file is not UTF-8 (line {line}); it was read as Latin-1");
            (bytes.iter().map(|byte| char::from(*byte)).collect(), Some(warning))
        }
    }
}

/// Checks that an IDF is complete: the engine would accept a truncated file as a smaller building.
pub(super) fn check(text: &str) -> Result<(), String> {
    let mut last = None;
    for (number, line) in (1..).zip(text.lines()) {
        let code = line.split('!').next().unwrap_or_default().trim();
        if !code.is_empty() {
            last = Some((number, code));
        }
    }
    match last {
        None => Err("it is empty".into()),
        Some((_, code)) if code.ends_with(';') => Ok(()),
        Some((number, code)) => Err(format!(
            "it is truncated: its last object does not end in `;` (line {number}, `{code}`). Obtain the complete file"
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_and_empty_lines_may_follow_the_last_object() {
        check("Version,25.2;\n! the end; really\n\n").unwrap();
        check("Zone,\r\n  A; !- Name\r\n").unwrap();
    }

    #[test]
    fn latin_1_is_read_with_a_warning_and_utf_8_without() {
        let (text, warning) = decode(b"Version,25.2;\nZone,B\xfcro;\n");
        assert!(text.contains("Büro") && warning.unwrap().contains("line 2"));
        assert_eq!(decode("\u{feff}Zone,Büro;".as_bytes()), ("Zone,Büro;".to_owned(), None));
    }

    #[test]
    fn a_truncated_file_is_rejected_with_the_line() {
        for cut in ["Version,25.2;\nZone,\n  Co", "Version,25.2;\nZone, !- x;", "Version,25.2;\nZone"] {
            let said = check(cut).unwrap_err();
            assert!(said.contains("line ") && said.contains("truncated"), "{said}");
        }
        assert!(check("! nothing\n").is_err());
    }
}
