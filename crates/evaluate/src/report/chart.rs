//! Parts of charts that all reports share.

use serde_json::{Value, json};

use crate::evaluation::EpisodeInfo;

/// Colors of series.
const PALETTE: [&str; 8] =
    ["#2563eb", "#e4572e", "#0f9d76", "#9333ea", "#d39b00", "#0891b2", "#db2777", "#65800f"];
/// Ratio of the largest to the smallest value above which an axis becomes logarithmic.
const WIDE: f64 = 20.0;
/// The ratio above which a logarithmic axis is labeled at powers of ten only.
const DECADES: f64 = 100.0;
/// Power of ten from which labels have an exponent.
const LONG: i32 = 5;

/// Minimum number of values for a violin.
const FEW: usize = 10;

/// A chart in a report.
#[derive(Clone, Debug)]
pub struct Chart {
    /// Title.
    pub title: String,
    /// How to read it.
    pub note: String,
    /// Height, pixels.
    pub height: u32,
    /// Whether it takes the whole width of the page.
    pub wide: bool,
    /// Plotly's traces.
    pub data: Value,
    /// Plotly's layout.
    pub layout: Value,
}

impl Chart {
    /// Returns the chart as the page reads it.
    pub fn json(mut self) -> Value {
        self.layout["height"] = self.height.into();
        let Self { title, note, wide, data, layout, .. } = self;
        json!({"title": title, "note": note, "wide": wide, "data": data, "layout": layout})
    }
}

/// Returns the color of a series by its number.
pub fn color(series: usize) -> &'static str {
    PALETTE[series % PALETTE.len()]
}

/// Returns a dashed horizontal line across the chart.
pub fn horizontal_line(value: f64) -> Value {
    json!({"type": "line", "xref": "paper", "x0": 0, "x1": 1, "y0": value, "y1": value,
           "line": {"dash": "dash", "width": 1.3, "color": "#b45309"}})
}

/// Returns whether episodes have different tasks.
pub fn has_several_tasks<'a>(mut episodes: impl Iterator<Item = &'a EpisodeInfo>) -> bool {
    let first = episodes.next();
    first.is_some_and(|first| episodes.any(|other| other.task != first.task))
}

/// Returns the range of values.
pub fn range(values: &[f64]) -> (f64, f64) {
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    (low, values.iter().copied().fold(f64::NEG_INFINITY, f64::max))
}

/// Returns a dashed vertical line across the chart.
pub fn vertical_line(value: f64) -> Value {
    json!({"type": "line", "yref": "paper", "y0": 0, "y1": 1, "x0": value, "x1": value,
           "line": {"dash": "dash", "width": 1.3, "color": "#b45309"}})
}

/// Makes an axis logarithmic if the range of its values is wide; returns whether it is.
pub fn make_logarithmic(axis: &mut Value, (low, high): (f64, f64)) -> bool {
    let wide = low > 0.0 && high / low > WIDE;
    if wide {
        label_logarithmic(axis, (low, high));
    }
    wide
}

/// Makes an axis logarithmic, with numbers written out as labels: at powers of ten, and at 2 and 5 times these where
/// there is room. By default, plotly writes a 2 and a 5 between any two powers.
pub fn label_logarithmic(axis: &mut Value, (low, high): (f64, f64)) {
    let decades = low.log10().floor() as i32..=high.log10().ceil() as i32;
    let factors = if high / low > DECADES { &[1][..] } else { &[1, 2, 5] };
    let labels: Vec<String> = decades
        .flat_map(|decade| {
            factors.iter().map(move |factor| match format!("{factor}e{decade}") {
                text if decade.abs() >= LONG => text,
                text => text.parse::<f64>().map_or(text, |value| value.to_string()),
            })
        })
        .collect();
    axis["type"] = "log".into();
    axis["tickvals"] = labels.iter().map(|label| label.parse::<f64>().unwrap_or_default()).collect();
    axis["ticktext"] = labels.into();
}

/// Returns a violin with a point per value, or the points alone if they are too few for a distribution.
pub(super) fn distribution(name: &str, values: &[f64], texts: &[String], color: &str) -> Value {
    let mut trace = json!({
        "y": values, "x0": name, "name": name, "jitter": 0.4, "pointpos": 0, "text": texts, "hoveron": "points",
        "hovertemplate": "%{text}<extra></extra>", "marker": {"size": 5, "opacity": 0.75, "color": color},
        "line": {"color": color, "width": 1.2}, "width": 0.85, "showlegend": false,
    });
    if values.len() < FEW {
        trace["type"] = "box".into();
        trace["boxpoints"] = "all".into();
        trace["line"]["width"] = 0.into();
        trace["fillcolor"] = "rgba(0,0,0,0)".into();
    } else {
        trace["type"] = "violin".into();
        trace["points"] = "all".into();
        trace["spanmode"] = "hard".into();
    }
    trace
}

/// Returns a diamond at a mean, over the violin of its values.
pub fn mean_diamond(name: &str, values: &[f64], color: &str) -> Value {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    json!({
        "type": "scatter", "mode": "markers", "x": [name], "y": [mean], "showlegend": false,
        "hovertemplate": "mean %{y:.2f} K<extra></extra>",
        "marker": {"symbol": "diamond", "size": 11, "color": color, "line": {"width": 1.5, "color": "#fff"}},
    })
}

/// Names an episode in two lines, for hover labels.
pub(super) fn hover_name(info: &EpisodeInfo) -> String {
    let EpisodeInfo { building, place, climate_zone, task, period, seed, .. } = info;
    format!("{building} in {place} ({climate_zone})<br>{task}, {period}, seed {seed}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_values_are_drawn_without_a_violin() {
        let kind = |count: usize| {
            distribution("a", &vec![1.0; count], &vec![String::new(); count], "#000")["type"].clone()
        };
        assert_eq!([kind(3), kind(FEW)], ["box", "violin"]);
    }

    #[test]
    fn a_wide_axis_is_logarithmic() {
        for (range, labels) in [
            ((1.0, 10.0), Value::Null),
            ((0.5, 25.0), json!(["0.1", "0.2", "0.5", "1", "2", "5", "10", "20", "50", "100", "200", "500"])),
            ((1.0, 50_000.0), json!(["1", "10", "100", "1000", "10000", "1e5"])),
        ] {
            let mut axis = json!({});
            assert_eq!(make_logarithmic(&mut axis, range), !labels.is_null());
            assert_eq!(axis["ticktext"], labels);
            let different: std::collections::BTreeSet<_> =
                axis["ticktext"].as_array().into_iter().flatten().map(Value::to_string).collect();
            assert_eq!(different.len(), labels.as_array().map_or(0, Vec::len), "no label twice");
        }
        let mut axis = json!({});
        make_logarithmic(&mut axis, (0.5, 25.0));
        assert_eq!(axis["tickvals"][1], json!(0.2));
    }
}
