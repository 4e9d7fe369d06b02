//! A text table with aligned columns.

use serde_json::{Value, json};

/// Rows under a header. Columns of numbers are right-aligned.
pub struct Table {
    rows: Vec<Vec<String>>,
}

impl Table {
    /// Returns an empty table with these column names.
    pub fn new<const N: usize>(header: [&str; N]) -> Self {
        Self { rows: vec![header.map(str::to_owned).to_vec()] }
    }

    /// Appends a row.
    pub fn row<const N: usize>(&mut self, cells: [String; N]) {
        self.rows.push(cells.to_vec());
    }

    /// Returns one line per row, indented by two spaces.
    pub fn text(&self) -> String {
        let columns: Vec<_> = (0..self.rows[0].len()).map(|column| self.column(column)).collect();
        let line = |row: &Vec<String>| {
            let cells: Vec<_> = row.iter().zip(&columns).map(|(cell, column)| column.pad(cell)).collect();
            format!("  {}", cells.join("  ")).trim_end().to_owned()
        };
        self.rows.iter().map(line).collect::<Vec<_>>().join("\n")
    }

    /// Returns an object with the header and the rows.
    pub fn json(&self) -> Value {
        json!({"header": self.rows[0], "rows": self.rows[1..]})
    }

    fn column(&self, index: usize) -> Column {
        let cells = || self.rows.iter().map(move |row| row[index].as_str());
        Column {
            width: cells().map(|cell| cell.chars().count()).max().unwrap_or(0),
            numbers: cells().skip(1).all(is_number),
        }
    }
}

struct Column {
    width: usize,
    numbers: bool,
}

impl Column {
    fn pad(&self, cell: &str) -> String {
        let width = self.width;
        if self.numbers { format!("{cell:>width$}") } else { format!("{cell:<width$}") }
    }
}

fn is_number(cell: &str) -> bool {
    cell.is_empty() || cell == "–" || cell.trim_end_matches(['×', ' ', '%']).parse::<f64>().is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_right_aligned_and_words_left_aligned() {
        let mut table = Table::new(["zone", "K"]);
        table.row(["Core".into(), "0.5".into()]);
        table.row(["Büro".into(), "12.5".into()]);
        assert_eq!(table.text(), "  zone     K\n  Core   0.5\n  Büro  12.5");
    }
}
