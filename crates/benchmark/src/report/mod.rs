//! `report.html`: an evaluation to look at, in one file that needs no network.
//!
//! The drawings are plotly's, whose script the `plotly` crate embeds; they are made here as plotly's own JSON, and
//! `report.html` is the page around them.

mod drawing;
pub mod leaderboard;

use std::io::Write;

use plotly::Plot;
use serde_json::{Value, json};

use crate::evaluation::{Deviations, Finished, Hours, Row};
use crate::results::{Group, Results, Summary, Window};
use crate::statistics::Interval;

const PAGE: &str = include_str!("report.html");
/// Episodes that are drawn hour by hour.
const WORST: usize = 4;

/// An episode of those drawn hour by hour.
pub(crate) struct Worst<'a> {
    pub(crate) row: &'a Row,
    pub(crate) hours: Hours,
}

/// The deviations of a type's episodes, each as heavy as the others.
pub(crate) struct TypeDeviations {
    pub(crate) name: String,
    /// Share of each bin.
    pub(crate) shares: Vec<f64>,
}

/// Writes the page. `read` gives what was kept of an episode, by its number.
///
/// # Errors
/// What the file says.
pub fn write(
    file: &mut impl Write,
    results: &Results,
    summary: &Summary,
    read: &dyn Fn(usize) -> Option<Finished>,
) -> std::io::Result<()> {
    let worst = worst(results, read);
    let data = json!({
        "title": format!("{} on {} episodes", summary.policy, summary.episodes),
        "tiles": tiles(summary),
        "tables": summary.windows.iter().map(table).collect::<Vec<_>>(),
        "lost": summary.lost.iter().map(|lost| format!("{}, {}, {}, seed {}: {}", lost.building, lost.task, lost.period, lost.seed, lost.why)).collect::<Vec<_>>(),
        "drawings": drawing::all(results, &deviations(results, read), &worst),
        "footer": footer(summary),
    });
    write_page(file, &data)
}

/// The page with its data.
fn write_page(file: &mut impl Write, data: &Value) -> std::io::Result<()> {
    // `<` would let a name end the script element.
    let data = data.to_string().replace('<', "\\u003c");
    file.write_all(PAGE.replace("{{PLOTLY}}", &plotly_script()).replace("{{DATA}}", &data).as_bytes())
}

/// The element with plotly's script. The one for formulas that comes with it is left out: there are none.
fn plotly_script() -> String {
    const END: &str = "</script>";
    let scripts = Plot::offline_js_sources();
    let end = scripts.find(END).map_or(scripts.len(), |at| at + END.len());
    scripts[..end].to_owned()
}

/// The episodes furthest above the baseline; without scores, those furthest from target.
fn worst<'a>(results: &'a Results, read: &dyn Fn(usize) -> Option<Finished>) -> Vec<Worst<'a>> {
    let badness = |row: &Row| (row.score.unwrap_or(0.0), row.record.rms_deviation);
    let mut ran: Vec<_> = results.rows.iter().enumerate().filter(|(_, row)| row.lost.is_none()).collect();
    ran.sort_by(|(_, a), (_, b)| {
        let ((a, a_rms), (b, b_rms)) = (badness(a), badness(b));
        b.total_cmp(&a).then(b_rms.total_cmp(&a_rms))
    });
    let with_hours =
        |(number, row): (usize, &'a Row)| read(number).map(|finished| Worst { row, hours: finished.hours });
    ran.into_iter().take(WORST).filter_map(with_hours).collect()
}

fn deviations(results: &Results, read: &dyn Fn(usize) -> Option<Finished>) -> Vec<TypeDeviations> {
    let mut types: Vec<TypeDeviations> = Vec::new();
    for (number, row) in results.rows.iter().enumerate() {
        let Some(Finished { deviations: Deviations { counts }, .. }) = read(number) else { continue };
        let total = counts.iter().sum::<u64>() as f64;
        if total == 0.0 {
            continue;
        }
        let name = &row.record.building_type;
        let index = types.iter().position(|each| each.name == *name).unwrap_or_else(|| {
            types.push(TypeDeviations { name: name.clone(), shares: vec![0.0; counts.len()] });
            types.len() - 1
        });
        for (share, count) in types[index].shares.iter_mut().zip(counts) {
            *share += count as f64 / total;
        }
    }
    types
}

/// A word and a number each.
fn tiles(summary: &Summary) -> Value {
    let mut tiles = Vec::new();
    for Window { task, period, all, .. } in &summary.windows {
        let which = if summary.windows.len() > 1 { format!(" · {task}, {period}") } else { String::new() };
        if let Some(scores) = &all.scores {
            tiles.push(json!([
                format!("interquartile mean of the scores{which}"),
                interval(scores.interquartile_mean)
            ]));
            let share = format!("{:.0} %", 100.0 * scores.beats_baseline.value);
            tiles.push(json!([format!("beat the reactive controllers{which}"), share]));
        }
        tiles.push(json!([format!("RMS deviation, mean{which}"), format!("{:.2} K", all.rms_deviation_k)]));
        let energy = format!("{:.1} kWh/m²", all.energy_wh_m2 / 1000.0);
        tiles.push(json!([format!("HVAC energy, mean{which}"), energy]));
    }
    tiles.into()
}

fn table(window: &Window) -> Value {
    let row = |group: &Group| {
        let scores = group.scores.as_ref();
        let of = |interval_of: fn(&crate::statistics::Aggregate) -> Interval| {
            scores.map_or("–".to_owned(), |scores| interval(interval_of(scores)))
        };
        json!([
            group.name,
            scores.map_or(0, |scores| scores.episodes).to_string(),
            of(|scores| scores.interquartile_mean),
            of(|scores| scores.median),
            of(|scores| scores.mean),
            scores.map_or("–".into(), |scores| format!("{:.0} %", 100.0 * scores.beats_baseline.value)),
            format!("{:.2}", group.rms_deviation_k),
            format!("{:.2}", group.energy_wh_m2 / 1000.0),
            format!("{:.1}", group.daily_travel),
        ])
    };
    let groups = window.types.iter().chain((window.types.len() > 1).then_some(&window.all));
    json!({
        "title": format!("{}, task {}", window.period, window.task),
        "header": ["type", "episodes", "interquartile mean", "median", "mean", "beat 1", "RMS, K", "energy, kWh/m²",
                   "travel, 1/d"],
        "rows": groups.map(row).collect::<Vec<_>>(),
    })
}

/// A value with its interval.
fn interval(interval: Interval) -> String {
    let Interval { value, low, high } = interval;
    if low == high { format!("{value:.3}") } else { format!("{value:.3} [{low:.3}, {high:.3}]") }
}

fn footer(summary: &Summary) -> String {
    let versions = &summary.versions;
    format!(
        "Scores are returns over those of the reactive controllers for the same building, task and days: lower is better. \
         In brackets: 95 % intervals of a bootstrap over episodes, stratified by type. \
         building2building {}, buildings {}, EnergyPlus {}, controllers {}.",
        versions.package, versions.generator, versions.engine, versions.controllers
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_loads_nothing_from_elsewhere() {
        for mark in ["{{DATA}}", "{{PLOTLY}}"] {
            assert_eq!(PAGE.matches(mark).count(), 1);
        }
        for word in ["http://", "https://", "src=", "@import", "<link"] {
            assert!(!PAGE.contains(word), "{word}");
        }
        let script = plotly_script();
        assert!(script.starts_with("<script") && script.matches("</script>").count() == 1);
    }
}
