//! The building in 3D: a mesh per zone with its windows and doors, in the building's own coordinates.

use anyhow::Result;
use b2b_building::description::Description;
use b2b_building::opening::Opening;
use b2b_building::shape::{Face, OutsideBoundary, Point, Shape};
use b2b_building::zone::area_vector;
use b2b_building::{Conditioning, PreparedBuilding};
use plotly::color::{Color, NamedColor, Rgb, Rgba};
use plotly::common::{HoverInfo, Label, Line, Mode};
use plotly::layout::{
    AspectMode, AspectRatio, Axis, Camera, CameraCenter, DragMode3D, Eye, LayoutScene, Margin, Up,
};
use plotly::traces::mesh3d::{Lighting, Mesh3D};
use plotly::{Layout, Plot, Scatter3D};

use super::style::{color, page_layout};
use super::triangle::triangles;

/// Offset of windows and doors from their wall, as a fraction of the plan size.
const IN_FRONT: f64 = 0.002;
const GLASS: &str = "#7dc4f0";
/// Margin of the ground around the building, as a fraction of the plan size.
const GROUND: f64 = 0.12;
/// Margin of the scene around the building, as a fraction of the plan size.
const MARGIN: f64 = 0.24;
/// Diagonal of the scene, in camera units.
const DIAGONAL: f64 = 2.2;
const DOOR: &str = "#78553c";

/// Triangles with a hover text at each corner.
#[derive(Default)]
struct Mesh {
    points: Vec<Point>,
    triangles: Vec<[usize; 3]>,
    texts: Vec<String>,
}

impl Mesh {
    fn add(&mut self, corners: &[Point], text: &str) {
        let first = self.points.len();
        self.points.extend(corners);
        self.texts.extend(corners.iter().map(|_| text.to_owned()));
        self.triangles.extend(triangles(corners).into_iter().map(|corner| corner.map(|c| first + c)));
    }

    fn trace(self, name: &str, color: impl Color, opacity: f64) -> Box<Mesh3D<f64, f64, f64>> {
        let axis = |axis: usize| self.points.iter().map(|point| point[axis]).collect::<Vec<_>>();
        let corner = |corner: usize| Some(self.triangles.iter().map(|t| t[corner]).collect::<Vec<_>>());
        Mesh3D::new(axis(0), axis(1), axis(2), corner(0), corner(1), corner(2))
            .name(name)
            .color(color)
            .opacity(opacity)
            .flat_shading(true)
            .lighting(Lighting::new().ambient(0.72).diffuse(0.45).specular(0.05))
            .hover_info(HoverInfo::Text)
            .hover_text_array(self.texts)
    }
}

/// Returns the plot.
pub fn plot(building: &PreparedBuilding, description: &Description) -> Result<Plot> {
    let shape = building.shape()?;
    let mut plot = Plot::new();
    for zone in 0..shape.zones.len() {
        draw_zone(&mut plot, building, description, &shape, zone);
    }
    draw_ground(&mut plot, &shape);
    draw_north(&mut plot, &shape);
    plot.set_layout(layout(shape.extent()));
    Ok(plot)
}

fn draw_zone(
    plot: &mut Plot,
    building: &PreparedBuilding,
    description: &Description,
    shape: &Shape,
    zone: usize,
) {
    let name = &shape.zones[zone];
    let front = front(&shape.extent());
    let (mut opaque, mut glass, mut doors) = (Mesh::default(), Mesh::default(), Mesh::default());
    let mut edges = Edges::default();
    for face in shape.faces.iter().filter(|face| face.zone == zone) {
        opaque.add(&face.corners, &face_text(building, shape, face));
        edges.add(&face.corners);
        for opening in &face.openings {
            let mesh = if opening.is_glass { &mut glass } else { &mut doors };
            let text = opening_text(building, face, opening);
            // On both sides, because the model does not always define which side is outside.
            for side in [front, -front] {
                mesh.add(&moved(&opening.corners, &face.corners, side), &text);
            }
        }
    }
    let conditioned = description.zones[zone].conditioning != Conditioning::None;
    let tint = if conditioned { color(zone) } else { Rgb::new(188, 190, 188) };
    plot.add_trace(opaque.trace(name, tint, 1.0).legend_group(name).show_legend(true));
    for (mesh, tint) in [(glass, GLASS), (doors, DOOR)] {
        if !mesh.points.is_empty() {
            plot.add_trace(mesh.trace(name, tint, 1.0).legend_group(name).show_legend(false));
        }
    }
    plot.add_trace(edges.trace(name).legend_group(name));
}

/// Outlines of polygons, separated by gaps.
#[derive(Default)]
struct Edges([Vec<Option<f64>>; 3]);

impl Edges {
    fn add(&mut self, corners: &[Point]) {
        for (axis, values) in self.0.iter_mut().enumerate() {
            values.extend(corners.iter().chain(corners.first()).map(|corner| Some(corner[axis])));
            values.push(None);
        }
    }

    fn trace(self, name: &str) -> Box<Scatter3D<Option<f64>, Option<f64>, Option<f64>>> {
        let [x, y, z] = self.0;
        Scatter3D::new(x, y, z)
            .name(name)
            .mode(Mode::Lines)
            .line(Line::new().color(Rgba::new(30, 34, 40, 0.55)).width(2.0))
            .hover_info(HoverInfo::Skip)
            .show_legend(false)
    }
}

/// Returns a polygon shifted by a distance along the normal of another.
fn moved(corners: &[Point], along: &[Point], distance: f64) -> Vec<Point> {
    let normal = area_vector(along);
    let length = normal.iter().map(|n| n * n).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
    let shift = normal.map(|n| n / length * distance);
    corners.iter().map(|corner| std::array::from_fn(|axis| corner[axis] + shift[axis])).collect()
}

fn face_text(building: &PreparedBuilding, shape: &Shape, face: &Face) -> String {
    let beyond = match face.outside_boundary {
        OutsideBoundary::Outdoors => "outdoors".to_owned(),
        OutsideBoundary::Ground => "ground".to_owned(),
        OutsideBoundary::Zone(zone) => shape.zones[zone].clone(),
        OutsideBoundary::Other => "adiabatic".to_owned(),
    };
    format!(
        "<b>{}</b><br>{}, {:.1} m²<br>adjacent to: {beyond}<br>{}",
        face.name,
        shape.zones[face.zone],
        face.area(),
        construction_text(building, &face.construction),
    )
}

fn opening_text(building: &PreparedBuilding, face: &Face, opening: &Opening) -> String {
    format!(
        "<b>{}</b><br>{} in {}, {:.1} m²<br>{}",
        opening.name,
        if opening.is_glass { "glass" } else { "door" },
        face.name,
        opening.area(),
        construction_text(building, &opening.construction),
    )
}

fn construction_text(building: &PreparedBuilding, construction: &str) -> String {
    match building.construction_u(construction) {
        Some(u) => format!("{construction}, U {u:.2} W/(m²·K)"),
        None => construction.to_owned(),
    }
}

/// Draws the ground plane, if the building has parts above and below it.
fn draw_ground(plot: &mut Plot, shape: &Shape) {
    let [low, high] = shape.extent();
    if low[2] > -0.1 || high[2] < 0.1 {
        return;
    }
    let margin = GROUND * plan_size(&shape.extent());
    let (west, east) = (low[0] - margin, high[0] + margin);
    let (south, north) = (low[1] - margin, high[1] + margin);
    let mut ground = Mesh::default();
    let corners = [[west, south, 0.0], [east, south, 0.0], [east, north, 0.0], [west, north, 0.0]];
    ground.add(&corners, "ground level");
    plot.add_trace(ground.trace("ground", "#8a9a6b", 0.35).show_legend(true));
}

/// Draws an arrow to true north on the ground beside the building.
fn draw_north(plot: &mut Plot, shape: &Shape) {
    let [low, high] = shape.extent();
    let size = plan_size(&[low, high]);
    let ground = low[2].max(0.0).min(high[2]);
    let (sin, cos) = shape.north_axis.to_radians().sin_cos();
    let middle = [low[0] - 0.5 * MARGIN * size, low[1] - 0.3 * MARGIN * size];
    // Converts positions across and along the arrow to the building's coordinates.
    let at = |across: f64, along: f64| {
        let (across, along) = (across * size, along * size);
        [middle[0] + across * cos - along * sin, middle[1] + across * sin + along * cos]
    };
    let line = [at(0.0, -0.07), at(0.0, 0.07), at(-0.02, 0.03), at(0.0, 0.07), at(0.02, 0.03)];
    let axis = |axis: usize| line.iter().map(|point| point[axis]).collect::<Vec<_>>();
    plot.add_trace(
        Scatter3D::new(axis(0), axis(1), vec![ground; line.len()])
            .name("north")
            .mode(Mode::Lines)
            .line(Line::new().color(NamedColor::Crimson).width(6.0))
            .hover_info(HoverInfo::Skip)
            .show_legend(false),
    );
    let [x, y] = at(0.0, 0.10);
    plot.add_trace(
        Scatter3D::new(vec![x], vec![y], vec![ground])
            .name("north")
            .mode(Mode::Text)
            .text_array(vec!["N"])
            .hover_info(HoverInfo::Skip)
            .show_legend(false),
    );
}

/// Returns the offset of windows and doors from their wall, m.
fn front(extent: &[Point; 2]) -> f64 {
    IN_FRONT * plan_size(extent)
}

/// Returns the longer side of the plan, m.
fn plan_size([low, high]: &[Point; 2]) -> f64 {
    (high[0] - low[0]).max(high[1] - low[1])
}

/// Returns a layout with equal scales along all axes.
fn layout(extent: [Point; 2]) -> Layout {
    let margin = MARGIN * plan_size(&extent);
    let [low, high] = extent;
    // Objects at the edge of a range would be clipped.
    let edge = 2.0 * front(&extent);
    let ranges: [[f64; 2]; 3] = [
        [low[0] - margin, high[0] + margin],
        [low[1] - margin, high[1] + margin],
        [low[2] - edge, high[2] + edge],
    ];
    let lengths = ranges.map(|[from, to]| (to - from).max(1e-3));
    let diagonal = lengths.iter().map(|length| length * length).sum::<f64>().sqrt();
    let [x, y, z] = lengths.map(|length| length / diagonal * DIAGONAL);
    let hidden = |[from, to]: [f64; 2]| Axis::new().visible(false).range(vec![from, to]);
    let scene = LayoutScene::new()
        .x_axis(hidden(ranges[0]))
        .y_axis(hidden(ranges[1]))
        .z_axis(hidden(ranges[2]))
        .aspect_mode(AspectMode::Manual)
        .aspect_ratio(AspectRatio::new().x(x).y(y).z(z))
        .drag_mode(DragMode3D::Turntable)
        .camera(
            Camera::new()
                .eye(Eye::from((-1.0, -1.5, 0.95)))
                .up(Up::from((0.0, 0.0, 1.0)))
                .center(CameraCenter::from((0.0, 0.0, 0.0))),
        );
    page_layout(Layout::new())
        .scene(scene)
        .margin(Margin::new().left(0).right(0).top(0).bottom(0))
        .hover_label(Label::new().align("left"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_is_drawn_in_front_of_its_wall() {
        let wall = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 0.0, 3.0], [0.0, 0.0, 3.0]];
        assert_eq!(moved(&[[1.0, 0.0, 1.0]], &wall, 0.5), [[1.0, -0.5, 1.0]]);
    }
}
