//! The detached houses of Québec: shares of a synthetic stock of 548, by variable, some of them by vintage.

use std::collections::BTreeMap;
use std::sync::LazyLock;

/// Rows: variable; vintage or nothing; value; share.
const STOCK: &str = include_str!("../../../data/quebec_detached_stock.csv");

/// Values and their shares, in the order of the table.
pub(crate) type Shares = Vec<(&'static str, f64)>;

/// The shares of a variable over the whole stock or, with `vintage`, among the houses of that vintage.
///
/// # Panics
/// If the embedded table lacks it, which is a mistake in the calling code.
pub(crate) fn shares(variable: &'static str, vintage: &'static str) -> &'static Shares {
    type Table = BTreeMap<(&'static str, &'static str), Shares>;
    static TABLE: LazyLock<Table> = LazyLock::new(|| {
        let mut table = Table::new();
        for line in STOCK.lines().skip(1) {
            let row: Vec<&str> = line.split(';').collect();
            let share = row[3].parse().expect("the embedded table holds numbers");
            table.entry((row[0], row[1])).or_default().push((row[2], share));
        }
        table
    });
    TABLE.get(&(variable, vintage)).expect("the embedded table has the variable")
}

/// The shares of a variable whose values are numbers or ranges of numbers, in ascending order.
pub(crate) fn numbers(variable: &'static str, vintage: &'static str) -> Vec<(f64, f64)> {
    let mut numbers: Vec<_> =
        shares(variable, vintage).iter().map(|(value, share)| (number(value), *share)).collect();
    numbers.sort_by(|a, b| a.0.total_cmp(&b.0));
    numbers
}

/// The share of one value over the whole stock.
pub(crate) fn share(variable: &'static str, value: &str) -> f64 {
    shares(variable, "").iter().filter(|(v, _)| *v == value).map(|(_, share)| share).sum()
}

/// The first number in a text: `[1500 - 2000)` is 1500, `QC_Wall-R14.4, interior` is 14.4.
pub(crate) fn number(text: &str) -> f64 {
    let digits = |c: char| c.is_ascii_digit() || c == '.';
    let from = text.find(|c: char| c.is_ascii_digit()).unwrap_or(text.len());
    let number: String = text[from..].chars().take_while(|c| digits(*c)).collect();
    number.parse().expect("the embedded table has a number there")
}

/// The value at a quantile of weighted values (inverse cumulative share), and the position of `u` within its share, 0
/// to 1.
pub(crate) fn pick<T: Copy>(weighted: &[(T, f64)], u: f64) -> (T, f64) {
    let total: f64 = weighted.iter().map(|(_, weight)| weight).sum();
    let mut rest = u * total;
    for &(value, weight) in weighted {
        if rest < weight {
            return (value, rest / weight);
        }
        rest -= weight;
    }
    (weighted[weighted.len() - 1].0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shares_of_every_variable_add_up_to_one() {
        for line in STOCK.lines().skip(1) {
            let row: Vec<&str> = line.split(';').collect();
            let sum: f64 = shares(row[0], row[1]).iter().map(|(_, share)| share).sum();
            assert!((sum - 1.0).abs() < 1e-3, "{} {}: {sum}", row[0], row[1]);
        }
    }

    #[test]
    fn a_pick_follows_the_weights() {
        let weighted = [('a', 1.0), ('b', 3.0)];
        assert_eq!(pick(&weighted, 0.0), ('a', 0.0));
        assert_eq!(pick(&weighted, 0.25), ('b', 0.0));
        assert_eq!(pick(&weighted, 0.625), ('b', 0.5));
        assert_eq!(pick(&weighted, 1.0), ('b', 1.0));
    }
}
