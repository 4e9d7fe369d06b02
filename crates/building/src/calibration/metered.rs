//! Tables of metered energy.

use std::path::Path;

use super::Fuel;
use crate::{Error, Result, user_file};

/// Column of the months.
const MONTH: &str = "month";

/// Metered energy of a whole building by month.
#[derive(Clone, Debug, PartialEq)]
pub struct Metered {
    /// The months, 1 to 12, in the order of the table.
    pub months: Vec<usize>,
    /// Energy of each metered fuel in these months, kWh.
    pub fuels: Vec<(Fuel, Vec<f64>)>,
}

impl Metered {
    /// Reads a CSV file with the columns `month` (1 to 12), `electricity_kwh` and `gas_kwh`; one fuel may be missing.
    ///
    /// # Errors
    /// [`Error::Metered`] naming the line and the remedy; [`Error::Io`].
    pub fn read(path: &Path) -> Result<Self> {
        let text = user_file::read(path).map_err(|source| Error::Io { path: path.to_owned(), source })?;
        Self::parse(&text).map_err(|(line, why)| Error::Metered { path: path.to_owned(), line, why })
    }

    /// Returns the number of metered values.
    pub fn len(&self) -> usize {
        self.months.len() * self.fuels.len()
    }

    /// Returns whether there are no values.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    fn parse(text: &str) -> std::result::Result<Self, (usize, String)> {
        let mut lines = (1..).zip(text.lines()).filter(|(_, line)| !line.trim().is_empty());
        let (first, header) = lines.next().ok_or((1, format!("it is empty; expected {}", expected())))?;
        let columns: Vec<String> = cells(header).map(str::to_ascii_lowercase).collect();
        let fuels = fuels_of(&columns).map_err(|why| (first, why))?;
        let mut metered =
            Self { months: Vec::new(), fuels: fuels.iter().map(|f| (*f, Vec::new())).collect() };
        for (line, text) in lines {
            metered.add(&columns, text).map_err(|why| (line, why))?;
        }
        if metered.months.len() < 2 {
            return Err((first, "it has fewer than two months; add a row for each metered month".into()));
        }
        for (fuel, values) in &metered.fuels {
            if values.iter().sum::<f64>() <= 0.0 {
                let why = format!("the column {} is zero; remove it", fuel.column());
                return Err((first, why));
            }
        }
        Ok(metered)
    }

    /// Adds a row.
    fn add(&mut self, columns: &[String], text: &str) -> std::result::Result<(), String> {
        let row: Vec<_> = cells(text).collect();
        if row.len() != columns.len() {
            return Err(format!("it has {} cells; expected {}", row.len(), columns.len()));
        }
        let cell =
            |column: &str| columns.iter().zip(&row).find(|(name, _)| *name == column).map(|(_, cell)| *cell);
        let month = cell(MONTH).unwrap_or_default();
        // A table with a missing month has its months as decimals in pandas.
        let month = month.trim_end_matches(".0").parse().ok().filter(|month| (1..=12).contains(month));
        let month = month.ok_or_else(|| {
            format!("month `{}` is not a whole number from 1 to 12", cell(MONTH).unwrap_or_default())
        })?;
        if self.months.contains(&month) {
            return Err(format!("month {month} is repeated; keep one row of each month"));
        }
        for (fuel, values) in &mut self.fuels {
            let text = cell(fuel.column()).unwrap_or_default();
            let value = text.parse().ok().filter(|value: &f64| value.is_finite() && *value >= 0.0);
            values.push(value.ok_or_else(|| {
                format!(
                    "{} `{text}` is not an energy in kWh; give a number of at least 0, or remove the row",
                    fuel.column()
                )
            })?);
        }
        self.months.push(month);
        Ok(())
    }
}

fn cells(line: &str) -> impl Iterator<Item = &str> {
    line.split(',').map(|cell| cell.trim().trim_matches('"'))
}

fn expected() -> String {
    let fuels = Fuel::ALL.map(Fuel::column).join(" and ");
    format!("the columns {MONTH} and at least one of {fuels}, separated by commas")
}

/// Returns the fuels among the columns.
fn fuels_of(columns: &[String]) -> std::result::Result<Vec<Fuel>, String> {
    let is_known = |name: &str| name == MONTH || Fuel::ALL.iter().any(|fuel| fuel.column() == name);
    if let Some(unknown) = columns.iter().find(|name| !is_known(name)) {
        return Err(format!("unknown column `{unknown}`; expected {}", expected()));
    }
    if let Some(repeated) = columns.iter().enumerate().find(|(i, name)| columns[..*i].contains(name)) {
        return Err(format!("the column `{}` is repeated; keep one", repeated.1));
    }
    let fuels: Vec<_> = Fuel::ALL.into_iter().filter(|f| columns.iter().any(|c| c == f.column())).collect();
    if fuels.is_empty() || !columns.iter().any(|name| name == MONTH) {
        return Err(format!("a column is missing; expected {}", expected()));
    }
    Ok(fuels)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_come_in_any_order_and_one_fuel_is_enough() {
        let metered = Metered::parse("Gas_kWh, month\n10,2\n\n20.5,1.0\n").unwrap();
        assert_eq!((metered.months, metered.fuels), (vec![2, 1], vec![(Fuel::Gas, vec![10.0, 20.5])]));
    }

    #[test]
    fn a_bad_table_is_reported_with_the_line_and_the_remedy() {
        for (text, line, words) in [
            ("", 1, "empty"),
            ("month;gas_kwh\n", 1, "separated by commas"),
            ("month,oil_kwh\n", 1, "`oil_kwh`"),
            ("month\n1\n", 1, "missing"),
            ("month,gas_kwh\n1,5\n\n13,6\n", 4, "`13`"),
            ("month,gas_kwh\n1,5\n1,6\n", 3, "repeated"),
            ("month,gas_kwh\n1,5\n2\n", 3, "expected 2"),
            ("month,gas_kwh\n1,5\n2,none\n", 3, "`none`"),
            ("month,gas_kwh\n1,5\n2,-1\n", 3, "at least 0"),
            ("month,gas_kwh\n1,5\n", 1, "two months"),
            ("month,gas_kwh,electricity_kwh\n1,0,2\n2,0,1", 1, "gas_kwh is zero"),
        ] {
            let (at, why) = Metered::parse(text).unwrap_err();
            assert!(at == line && why.contains(words), "{text:?}: line {at}: {why}");
        }
    }
}
