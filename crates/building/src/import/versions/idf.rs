//! Text of an IDF.

use std::fmt::Write as _;

use super::document::{Body, Document, Object};

/// Returns the objects of an IDF, without its comments.
///
/// # Errors
/// A sentence about macros, which the engine does not read either.
pub fn parse(text: &str) -> Result<Document, String> {
    let mut objects = Vec::new();
    let mut values: Vec<String> = Vec::new();
    let mut value = String::new();
    for (number, line) in (1..).zip(text.lines()) {
        let code = line.split('!').next().unwrap_or_default();
        if code.trim_start().starts_with("##") {
            return Err(macros(number, code.trim()));
        }
        for character in code.chars() {
            if !matches!(character, ',' | ';') {
                value.push(character);
                continue;
            }
            values.push(value.trim().to_owned());
            value.clear();
            if character == ';' {
                objects.extend(object(std::mem::take(&mut values)));
            }
        }
        value.push(' ');
    }
    Ok(Document { objects })
}

fn object(mut values: Vec<String>) -> Option<Object> {
    let class = values.remove(0);
    (!class.is_empty()).then_some(Object { class, body: Body::Positions(values) })
}

fn macros(number: usize, line: &str) -> String {
    format!(
        "it has macros (line {number}, `{line}`), which EnergyPlus expands before it reads a model: run EPMacro of an \
         EnergyPlus installation on it, and import its output"
    )
}

/// Returns the text of an IDF.
pub fn write(document: &Document) -> String {
    let mut text = String::new();
    for object in &document.objects {
        if let Body::Positions(values) = &object.body {
            text.push_str(&object.class);
            for value in values {
                let _ = write!(text, ",\n  {value}");
            }
            text.push_str(";\n\n");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn objects_keep_their_blank_fields_and_lose_their_comments() {
        let text =
            "Version,9.4; ! first\n! Zone,Not one;\nZone,\n  Core  zone, !- Name, or so; \n  ,\n  0;\n;";
        let document = parse(text).unwrap();
        assert_eq!(document.version().as_deref(), Some("9.4"));
        let Body::Positions(values) = &document.objects[1].body else { panic!("positions") };
        assert_eq!(values, &["Core  zone", "", "0"]);
        assert_eq!(parse(&write(&document)).unwrap(), document);
    }

    #[test]
    fn macros_are_named_with_their_line() {
        let said = parse("Version,9.4;\n  ##include walls.imf\n").unwrap_err();
        assert!(said.contains("line 2") && said.contains("##include walls.imf"), "{said}");
    }
}
