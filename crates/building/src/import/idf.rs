//! What can be seen of an IDF before the engine reads it.

/// Whether a text is an IDF to its end: the engine takes a file that was cut off as a smaller building.
pub(super) fn check(bytes: &[u8]) -> Result<(), String> {
    let text = String::from_utf8_lossy(bytes);
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
            "its last object does not end (line {number}, `{code}`): an object ends in `;`, so the file was cut off. \
             Get it whole"
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_and_empty_lines_may_follow_the_last_object() {
        check(b"Version,25.2;\n! the end; really\n\n").unwrap();
        check(b"Zone,\r\n  A; !- Name\r\n").unwrap();
    }

    #[test]
    fn a_file_that_was_cut_off_is_refused_with_the_line() {
        for cut in ["Version,25.2;\nZone,\n  Co", "Version,25.2;\nZone, !- x;", "Version,25.2;\nZone"] {
            let said = check(cut.as_bytes()).unwrap_err();
            assert!(said.contains("line ") && said.contains("cut off"), "{said}");
        }
        assert!(check(b"! nothing\n").is_err());
    }
}
