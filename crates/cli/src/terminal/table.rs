//! A text table with aligned columns.

use serde_json::{Value, json};

use crate::terminal::wrap;

/// Returns how many decimals show at least two digits of a value, between `least` and 6, so that the small energy of a
/// mild day is not shown as 0.
pub fn decimals(value: f64, least: usize) -> usize {
    let needed = if value == 0.0 { 0.0 } else { 1.0 - value.abs().log10().floor() };
    // The conversion saturates, and NaN is 0.
    (needed as usize).clamp(least, 6)
}

/// Rows under a header. Columns of numbers are right-aligned.
pub struct Table {
    rows: Vec<Vec<String>>,
}

impl Table {
    /// Returns an empty table with these column names.
    pub fn new<const N: usize>(header: [&str; N]) -> Self {
        Self::with_header(header.map(str::to_owned).to_vec())
    }

    /// Returns an empty table whose number of columns is not known at compile time.
    pub fn with_header(header: Vec<String>) -> Self {
        Self { rows: vec![header] }
    }

    /// Appends a row with as many cells as the header.
    pub fn push(&mut self, cells: Vec<String>) {
        debug_assert_eq!(cells.len(), self.rows[0].len());
        self.rows.push(cells);
    }

    /// Appends a row.
    pub fn row<const N: usize>(&mut self, cells: [String; N]) {
        self.push(cells.to_vec());
    }

    /// Returns one line per row, indented by two spaces. On a narrow terminal, cells are wrapped, and columns that
    /// still do not fit follow in another table below.
    pub fn text(&self) -> String {
        self.within(wrap::width().unwrap_or(usize::MAX))
    }

    fn within(&self, width: usize) -> String {
        let columns: Vec<_> = (0..self.rows[0].len()).map(|column| self.column(column)).collect();
        let mut parts = vec![];
        let mut rest = &columns[..];
        while let Some((next, others)) = rest.split_first() {
            // Every further table repeats the first column.
            let mut part = if parts.is_empty() { vec![*next] } else { vec![columns[0], *next] };
            let room = |part: &[Column], column: &Column| {
                let taken: usize = part.iter().chain([column]).map(|column| column.min_width + GAP).sum();
                taken <= width
            };
            let more = others.iter().take_while(|column| {
                let fits = room(&part, column);
                part.extend(fits.then_some(**column));
                fits
            });
            rest = &others[more.count()..];
            shrink(&mut part, width);
            parts.push(self.lines(&part));
        }
        parts.join("\n\n")
    }

    fn lines(&self, columns: &[Column]) -> String {
        let row = |row: &Vec<String>| {
            let cells: Vec<_> = columns.iter().map(|column| column.broken(&row[column.index])).collect();
            let height = cells.iter().map(Vec::len).max().unwrap_or(0);
            let line = |line: usize| {
                let cells = columns.iter().zip(&cells);
                let cells =
                    cells.map(|(column, lines)| column.pad(lines.get(line).map_or("", String::as_str)));
                format!("  {}", cells.collect::<Vec<_>>().join("  ")).trim_end().to_owned()
            };
            (0..height).map(line).collect::<Vec<_>>().join("\n")
        };
        self.rows.iter().map(row).collect::<Vec<_>>().join("\n")
    }

    /// Returns an object with the header and the rows.
    pub fn json(&self) -> Value {
        json!({"header": self.rows[0], "rows": self.rows[1..]})
    }

    fn column(&self, index: usize) -> Column {
        let cells = || self.rows.iter().map(move |row| row[index].as_str());
        let longest = |lengths: &mut dyn Iterator<Item = usize>| lengths.max().unwrap_or(0);
        Column {
            index,
            width: longest(&mut cells().map(|cell| cell.chars().count())),
            min_width: longest(
                &mut cells().flat_map(|cell| cell.split(' ').map(|word| word.chars().count())),
            ),
            numbers: cells().skip(1).all(is_number),
        }
    }
}

/// Spaces before a column.
const GAP: usize = 2;

/// Narrows the widest columns, down to their longest words, until all fit.
fn shrink(columns: &mut [Column], width: usize) {
    while columns.iter().map(|column| column.width + GAP).sum::<usize>() > width {
        let narrowable = columns.iter_mut().filter(|column| column.width > column.min_width);
        let Some(widest) = narrowable.max_by_key(|column| column.width) else { return };
        widest.width -= 1;
    }
}

#[derive(Clone, Copy)]
struct Column {
    /// Index in the table.
    index: usize,
    width: usize,
    /// Length of the longest word.
    min_width: usize,
    numbers: bool,
}

impl Column {
    /// Returns the lines of a wrapped cell.
    fn broken(&self, cell: &str) -> Vec<String> {
        wrap::lines(cell, self.width).lines().map(str::to_owned).collect()
    }

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
    fn small_values_have_two_digits() {
        for (value, least, expected) in
            [(0.686, 3, 3), (0.000_24, 3, 5), (6.25, 2, 2), (0.0, 2, 2), (1e-12, 2, 6), (f64::NAN, 2, 2)]
        {
            assert_eq!(decimals(value, least), expected, "{value}");
        }
    }

    #[test]
    fn numbers_are_right_aligned_and_words_left_aligned() {
        let mut table = Table::new(["zone", "K"]);
        table.row(["Core".into(), "0.5".into()]);
        table.row(["Büro".into(), "12.5".into()]);
        assert_eq!(table.within(80), "  zone     K\n  Core   0.5\n  Büro  12.5");
    }

    #[test]
    fn a_narrow_terminal_breaks_words_and_then_the_table() {
        let mut table = Table::new(["zone", "floor area (m²)", "equipment"]);
        table.row(["Core".into(), "149.7".into(), "heating and cooling".into()]);
        let broken = table.within(26);
        assert!(broken.lines().all(|line| line.chars().count() <= 26), "{broken}");
        assert!(broken.lines().count() > 2 && broken.matches("zone").count() == 1, "{broken}");
        let parts = table.within(17);
        assert_eq!(parts.matches("zone").count(), 2, "{parts}");
        assert!(parts.lines().all(|line| line.chars().count() <= 17), "{parts}");
    }
}
