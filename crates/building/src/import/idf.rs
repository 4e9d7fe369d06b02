//! Checks of an IDF before the engine reads it.

/// Checks that an IDF is complete: the engine would accept a truncated file as a smaller building.
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
            "it is truncated: its last object does not end in `;` (line {number}, `{code}`). Obtain the complete file"
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
    fn a_truncated_file_is_rejected_with_the_line() {
        for cut in ["Version,25.2;\nZone,\n  Co", "Version,25.2;\nZone, !- x;", "Version,25.2;\nZone"] {
            let said = check(cut.as_bytes()).unwrap_err();
            assert!(said.contains("line ") && said.contains("truncated"), "{said}");
        }
        assert!(check(b"! nothing\n").is_err());
    }
}
