//! Colors and layout that both plots of the page share.

use plotly::Layout;
use plotly::color::{Rgb, Rgba};
use plotly::common::Font;

/// Colors of the first zones.
const PALETTE: [[u8; 3]; 10] = [
    [37, 99, 235],
    [228, 87, 46],
    [15, 157, 118],
    [147, 51, 234],
    [211, 155, 0],
    [8, 145, 178],
    [219, 39, 119],
    [101, 128, 15],
    [124, 92, 62],
    [91, 107, 140],
];

/// Returns the color of a zone by its index.
pub fn color(number: usize) -> Rgb {
    let [red, green, blue] = PALETTE.get(number).copied().unwrap_or_else(|| {
        // Golden-angle steps around the color wheel, as in the page of `b2b run`.
        let hue = (number as f64 * 137.5) % 360.0;
        let channel = |shift: f64| {
            let angle = ((hue + shift) / 60.0) % 6.0;
            let level = (2.0 - (angle - 2.0).abs()).clamp(0.0, 1.0);
            (90.0 + level * 130.0) as u8
        };
        [channel(120.0), channel(0.0), channel(240.0)]
    });
    Rgb::new(red, green, blue)
}

/// Returns a layout with a transparent background and the font of the page.
pub fn page_layout(layout: Layout) -> Layout {
    let clear = || Rgba::new(0, 0, 0, 0.0);
    layout
        .paper_background_color(clear())
        .plot_background_color(clear())
        .font(Font::new().family("system-ui, sans-serif").size(12).color(Rgb::new(120, 128, 140)))
        .auto_size(true)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighboring_zones_differ_in_color() {
        let colors: Vec<_> = (0..40).map(|zone| serde_json::to_string(&color(zone)).unwrap()).collect();
        assert!(colors.windows(2).all(|pair| pair[0] != pair[1]));
    }
}
