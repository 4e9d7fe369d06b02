//! The morphology as nodes and links: weather, calendar and energy at the top, zones at their positions in the plans of
//! the levels, which are drawn one above another, and air loops beside the zones they serve.

use b2b_building::Morphology;
use b2b_building::description::Description;
use b2b_building::morphology::{Edge, EdgeKind, NodeType, Owner};
use plotly::color::{Rgb, Rgba};
use plotly::common::{HoverInfo, Label, Line, Marker, MarkerSymbol, Mode, Position};
use plotly::layout::{Axis, HoverMode, Legend, Margin};
use plotly::{Layout, Plot, Scatter};

use super::style::page_layout;

/// Largest difference of floor height within a level, as a fraction of the building's height.
const LEVEL: f64 = 0.04;
/// Distance between levels.
const RISE: f64 = 1.0;
/// Depth of a plan.
const DEPTH: f64 = 0.62;
/// Slant of a plan to the right.
const LEAN: f64 = 0.35;

/// Returns the plot.
pub fn plot(morphology: &Morphology, description: &Description) -> Plot {
    let positions = positions(morphology, description);
    let mut plot = Plot::new();
    for kind in [EdgeKind::Adjacent, EdgeKind::Serves] {
        draw_edges(&mut plot, morphology, &positions, kind);
    }
    for node_type in NodeType::ALL {
        draw_nodes(&mut plot, morphology, &positions, node_type);
    }
    plot.set_layout(layout(&positions));
    plot
}

type Place = [f64; 2];

/// Returns the position of each node.
fn positions(morphology: &Morphology, description: &Description) -> Vec<Place> {
    let levels = levels(description);
    let of_zone = |zone: usize| -> Place {
        let [x, y, _] = description.zones[zone].center;
        [x + LEAN * y, levels[zone] as f64 * RISE + DEPTH * y]
    };
    let top = levels.iter().max().map_or(0.0, |level| *level as f64) * RISE + DEPTH + 0.55;
    let nodes = morphology.nodes.iter();
    nodes
        .map(|node| match node.owner {
            Owner::Weather => [0.1, top],
            Owner::Calendar => [0.5 + LEAN / 2.0, top],
            Owner::Energy => [0.9 + LEAN, top],
            Owner::Zone(zone) => of_zone(zone),
            Owner::AirLoop(system) => {
                let served = &description.systems[system].zones;
                let heights = served.iter().map(|zone| of_zone(*zone)[1]);
                [-0.45, heights.sum::<f64>() / served.len().max(1) as f64]
            }
        })
        .collect()
}

/// Returns the number of levels.
pub fn level_count(description: &Description) -> usize {
    levels(description).into_iter().max().map_or(0, |highest| highest + 1)
}

/// Returns the level of each zone, counted from below, by the height of its floor.
fn levels(description: &Description) -> Vec<usize> {
    let floor = |zone: usize| description.zones[zone].center[2] - description.zones[zone].extent[2] / 2.0;
    let mut floors: Vec<f64> = (0..description.zones.len()).map(floor).collect();
    floors.sort_by(f64::total_cmp);
    floors.dedup_by(|next, kept| *next - *kept < LEVEL);
    let level = |zone: usize| floors.iter().filter(|start| **start <= floor(zone)).count().saturating_sub(1);
    (0..description.zones.len()).map(level).collect()
}

fn draw_edges(plot: &mut Plot, morphology: &Morphology, positions: &[Place], kind: EdgeKind) {
    let edges: Vec<&Edge> = morphology.edges.iter().filter(|edge| edge.kind == kind).collect();
    if edges.is_empty() {
        return;
    }
    let (mut x, mut y) = (Vec::new(), Vec::new());
    let (mut middle_x, mut middle_y, mut texts) = (Vec::new(), Vec::new(), Vec::new());
    for edge in edges {
        let (from, to) = (positions[edge.from], positions[edge.to]);
        x.extend([Some(from[0]), Some(to[0]), None]);
        y.extend([Some(from[1]), Some(to[1]), None]);
        middle_x.push((from[0] + to[0]) / 2.0);
        middle_y.push((from[1] + to[1]) / 2.0);
        let [from, to] = [edge.from, edge.to].map(|node| &morphology.nodes[node].name);
        texts.push(match kind {
            EdgeKind::Adjacent => format!("{from} and {to} share {:.1} m²", edge.attribute),
            _ => format!("{from} serves and controls {to}, {:.2} kg/s", edge.attribute),
        });
    }
    let (name, color, width) = match kind {
        EdgeKind::Adjacent => ("adjacent", Rgba::new(130, 138, 150, 0.55), 1.5),
        _ => ("serves and controls", Rgba::new(8, 145, 178, 0.8), 2.0),
    };
    plot.add_trace(
        Scatter::new(x, y)
            .name(name)
            .legend_group(name)
            .mode(Mode::Lines)
            .line(Line::new().color(color).width(width))
            .hover_info(HoverInfo::Skip),
    );
    plot.add_trace(
        Scatter::new(middle_x, middle_y)
            .name(name)
            .legend_group(name)
            .mode(Mode::Markers)
            .marker(Marker::new().size(9).color(color).opacity(0.35))
            .hover_info(HoverInfo::Text)
            .hover_text_array(texts)
            .show_legend(false),
    );
}

fn draw_nodes(plot: &mut Plot, morphology: &Morphology, positions: &[Place], node_type: NodeType) {
    let nodes: Vec<usize> =
        (0..morphology.nodes.len()).filter(|node| morphology.nodes[*node].node_type == node_type).collect();
    if nodes.is_empty() {
        return;
    }
    let (symbol, color) = style(node_type);
    let name = |node: &usize| morphology.nodes[*node].name.clone();
    plot.add_trace(
        Scatter::new(
            nodes.iter().map(|node| positions[*node][0]).collect(),
            nodes.iter().map(|node| positions[*node][1]).collect(),
        )
        .name(node_type.name())
        .mode(Mode::MarkersText)
        .marker(Marker::new().size(19).symbol(symbol).color(color))
        .text_array(nodes.iter().map(name).collect())
        .text_position(Position::BottomCenter)
        .hover_info(HoverInfo::Text)
        .hover_text_array(nodes.iter().map(|node| text(morphology, *node)).collect()),
    );
}

fn style(node_type: NodeType) -> (MarkerSymbol, Rgb) {
    match node_type {
        NodeType::Weather => (MarkerSymbol::Star, Rgb::new(211, 155, 0)),
        NodeType::Calendar => (MarkerSymbol::Hexagon, Rgb::new(147, 51, 234)),
        NodeType::Energy => (MarkerSymbol::Diamond, Rgb::new(228, 87, 46)),
        NodeType::AirLoop => (MarkerSymbol::Square, Rgb::new(8, 145, 178)),
        NodeType::UnitaryZone => (MarkerSymbol::Circle, Rgb::new(37, 99, 235)),
        NodeType::VavZone => (MarkerSymbol::Circle, Rgb::new(15, 157, 118)),
        NodeType::HeatingOnlyZone => (MarkerSymbol::Circle, Rgb::new(219, 39, 119)),
        NodeType::UncontrolledZone => (MarkerSymbol::Circle, Rgb::new(165, 170, 178)),
        NodeType::SetpointZone => (MarkerSymbol::Circle, Rgb::new(190, 110, 30)),
        NodeType::FollowingZone => (MarkerSymbol::Circle, Rgb::new(130, 165, 240)),
        NodeType::DamperZone => (MarkerSymbol::Circle, Rgb::new(82, 196, 160)),
    }
}

/// Returns the hover text of a node: type, attributes, observation and action.
fn text(morphology: &Morphology, node: usize) -> String {
    let node = &morphology.nodes[node];
    let mut lines = vec![format!("<b>{}</b>, {}", node.name, node.node_type.name())];
    for (slot, value) in node.node_type.attributes().iter().zip(&node.attributes) {
        let unit = if slot.unit == "1" { "" } else { slot.unit };
        lines.push(format!("{} {} {unit}", words(&slot.quantity), rounded(*value)));
    }
    let observation: Vec<_> = node.node_type.observation().iter().map(|slot| words(&slot.quantity)).collect();
    let action: Vec<_> = node.node_type.action().iter().map(|slot| words(&slot.quantity)).collect();
    for (what, slots) in [("observation:", observation), ("action:", action)] {
        if !slots.is_empty() {
            lines.push(format!("<i>{what}</i> {}", slots.join(", ")));
        }
    }
    lines.join("<br>")
}

/// Returns the JSON name of a quantity with spaces between its words.
fn words(quantity: &impl serde::Serialize) -> String {
    let name = serde_json::json!(quantity);
    name.as_str().unwrap_or_default().replace('_', " ")
}

/// Formats a number with two decimals below 10, one below 100, and none above.
fn rounded(value: f64) -> String {
    match value.abs() {
        size if size >= 100.0 || value == 0.0 => format!("{value:.0}"),
        size if size >= 10.0 => format!("{value:.1}"),
        _ => format!("{value:.2}"),
    }
}

fn layout(positions: &[Place]) -> Layout {
    let range = |axis: usize, margin: f64| {
        let (low, high) = positions
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p[axis]), h.max(p[axis])));
        vec![low - margin, high + margin]
    };
    let axis = |range| Axis::new().visible(false).range(range);
    page_layout(Layout::new())
        .x_axis(axis(range(0, 0.3)))
        .y_axis(axis(range(1, 0.3)))
        .hover_mode(HoverMode::Closest)
        .hover_label(Label::new().align("left"))
        .legend(Legend::new().item_sizing(plotly::layout::ItemSizing::Constant))
        .margin(Margin::new().left(0).right(0).top(0).bottom(0))
}
