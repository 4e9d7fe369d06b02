//! The text report of a task with comfort bands: cost, energy, discomfort and peak first, then the bill.

use b2b_env::BillPart;

use super::summary::Summary;
use crate::terminal::table::{Table, decimals};

impl Summary {
    /// Returns the names and values of an episode's results.
    pub(super) fn operation_metrics(&self) -> Vec<(&'static str, String)> {
        let metrics = &self.metrics;
        let digits = |value: Option<f64>, least: usize| {
            let value = value.unwrap_or(f64::NAN);
            format!("{value:.*}", decimals(value, least))
        };
        vec![
            ("cost", format!("{} {}", digits(metrics.cost_tot, 3), self.cost_unit())),
            ("HVAC energy", format!("{} kWh/m²", digits(metrics.ener_tot, 2))),
            ("HVAC energy by end use", self.end_uses_text()),
            ("thermal discomfort", format!("{:.1} K·h per zone", metrics.tdis_tot.unwrap_or(f64::NAN))),
            (
                match self.steps_per_hour {
                    1 => "peak electric demand, 60 min",
                    2 => "peak electric demand, 30 min",
                    _ => "peak electric demand, 15 min",
                },
                format!("{:.1} W/m²", 1000.0 * metrics.pele_tot.unwrap_or_default()),
            ),
            ("too cold, too warm while occupied", self.occupied_text()),
            ("emissions", format!("{} kg CO₂/m²", digits(metrics.emis_tot, 2))),
            ("return", self.return_text("discomfort")),
            ("actuator travel", self.travel_text()),
            ("outdoor air per person", self.outdoor_air_text()),
        ]
    }

    /// Returns the bill as a table, followed by an empty line; an empty text if there is no bill.
    pub(super) fn bill_text(&self) -> String {
        if self.bill.is_empty() {
            return String::new();
        }
        let currency = self.currency.as_deref().unwrap_or_default();
        format!("{}\n\n", bill_table(&self.bill, currency).text())
    }

    /// Returns a table of the zones with their degree-hours and hours outside the band.
    pub(super) fn band_table(&self) -> String {
        let beyond = format!("more than {} K outside", self.task_definition.comfort_band);
        let columns =
            ["zone".to_owned(), "equipment".to_owned(), format!("{beyond} (K·h)"), format!("{beyond} (h)")];
        let mut table = Table::with_header(columns.to_vec());
        for zone in &self.zones {
            table.row([
                zone.name.clone(),
                zone.equipment().to_owned(),
                format!("{:.1}", zone.discomfort_k_h),
                format!("{:.1}", zone.hours_outside_band),
            ]);
        }
        table.text()
    }
}

fn bill_table(bill: &[BillPart], currency: &str) -> Table {
    let total: f64 = bill.iter().map(|part| part.cost).sum();
    let mut table = Table::with_header(vec![
        "bill of the building".to_owned(),
        "quantity".to_owned(),
        format!("cost ({currency})"),
        "share (%)".to_owned(),
    ]);
    for BillPart { name, quantity, unit, cost } in bill {
        let share = if total > 0.0 { format!("{:.0}", 100.0 * cost / total) } else { "–".to_owned() };
        table.row([name.clone(), format!("{quantity:.0} {unit}"), format!("{cost:.2}"), share]);
    }
    table.row(["total".to_owned(), String::new(), format!("{total:.2}"), String::new()]);
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parts_of_a_bill_have_their_shares_and_sum() {
        let part = |name: &str, unit: &str, cost| BillPart {
            name: name.into(),
            quantity: 100.0,
            unit: unit.into(),
            cost,
        };
        let text = bill_table(&[part("peak", "kWh", 30.0), part("demand", "kW", 10.0)], "CAD").text();
        let lines: Vec<&str> = text.lines().map(str::trim).collect();
        assert!(lines[0].contains("cost (CAD)"), "{text}");
        assert!(lines[1].starts_with("peak") && lines[1].ends_with("75"), "{text}");
        assert!(lines[3].starts_with("total") && lines[3].contains("40.00"), "{text}");
    }
}
