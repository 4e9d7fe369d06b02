//! Lines of the header of an EPW file.

use std::path::{Path, PathBuf};

use crate::{Error, Result};

/// The header of an EPW file.
pub(crate) struct Header<'a> {
    pub text: &'a str,
    pub path: &'a Path,
}

impl<'a> Header<'a> {
    /// Returns the line with a title.
    ///
    /// # Errors
    /// [`Error::Malformed`] without such a line.
    pub fn line(&self, title: &'a str) -> Result<Line<'a>> {
        let line = |text: &'a str| Line {
            title,
            fields: text.split(',').map(str::trim).collect(),
            path: self.path.to_owned(),
        };
        self.text
            .lines()
            .take(8)
            .map(line)
            .find(|line| line.fields[0].eq_ignore_ascii_case(title))
            .ok_or_else(|| Error::Malformed {
                path: self.path.to_owned(),
                why: format!("no {title} line: not an EPW file, or truncated"),
            })
    }
}

/// The fields of one header line, or of a part of it.
pub(crate) struct Line<'a> {
    title: &'a str,
    fields: Vec<&'a str>,
    path: PathBuf,
}

impl<'a> Line<'a> {
    /// Returns an error about this line.
    pub fn malformed(&self, why: String) -> Error {
        Error::Malformed { path: self.path.clone(), why: format!("{}: {why}", self.title) }
    }

    /// Returns a field.
    pub fn text(&self, index: usize) -> Result<&'a str> {
        self.fields
            .get(index)
            .copied()
            .ok_or_else(|| self.malformed(format!("truncated: no field {}", index + 1)))
    }

    /// Returns a field that is a finite number.
    pub fn number(&self, index: usize) -> Result<f64> {
        let text = self.text(index)?;
        text.parse()
            .ok()
            .filter(|value: &f64| value.is_finite())
            .ok_or_else(|| self.malformed(format!("field {} is `{text}`; expected a number", index + 1)))
    }

    /// Returns a field that is a number within ± a bound.
    pub fn within(&self, index: usize, bound: f64) -> Result<f64> {
        let value = self.number(index)?;
        if value.abs() <= bound {
            Ok(value)
        } else {
            Err(self.malformed(format!("field {} is {value}; expected a number within ±{bound}", index + 1)))
        }
    }

    /// Returns a field that is a month.
    pub fn month(&self, index: usize) -> Result<u32> {
        let text = self.text(index)?;
        text.parse()
            .ok()
            .filter(|month| (1..=12).contains(month))
            .ok_or_else(|| self.malformed(format!("`{text}` is not a month from 1 to 12")))
    }

    /// Returns the fields that follow a word in the line.
    pub fn after(&self, word: &str) -> Result<Self> {
        let start = self
            .fields
            .iter()
            .position(|field| field.eq_ignore_ascii_case(word))
            .ok_or_else(|| self.malformed(format!("no {word} part")))?;
        Ok(Self { title: self.title, fields: self.fields[start + 1..].to_vec(), path: self.path.clone() })
    }
}
