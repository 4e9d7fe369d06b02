//! Rows of the dataset's table as Python dictionaries.

use std::collections::BTreeMap;

use b2b_dataset::manifest::{Kind, Manifest};
use pyo3::prelude::*;

/// A cell of the table.
#[derive(Clone, Debug, PartialEq, IntoPyObject)]
pub enum Cell {
    /// Text.
    Text(String),
    /// A decimal number.
    Number(f64),
    /// A whole number.
    Integer(i64),
    /// A Boolean.
    Flag(bool),
}

/// A row: column name to cell; empty cells are absent.
pub type Row = BTreeMap<&'static str, Cell>;

/// Returns the rows of a table.
pub fn rows(table: Manifest) -> Vec<Row> {
    let Manifest { columns, rows } = table;
    let row = |row: Vec<String>| {
        let cells = columns.iter().zip(row).filter(|(_, text)| !text.is_empty());
        cells.map(|(column, text)| (column.name, Cell::new(column.kind, text))).collect()
    };
    rows.into_iter().map(row).collect()
}

impl Cell {
    fn new(kind: Kind, text: String) -> Self {
        let number = match kind {
            Kind::Text => None,
            Kind::Number => text.parse().ok().map(Self::Number),
            Kind::Integer => text.parse().ok().map(Self::Integer),
            Kind::Flag => text.parse().ok().map(Self::Flag),
        };
        number.unwrap_or(Self::Text(text))
    }
}
