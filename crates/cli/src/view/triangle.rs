//! Triangulation of planar polygons in space.

use b2b_building::shape::Point;
use b2b_building::zone::area_vector;

/// Triangulates a planar polygon without holes by ear clipping, and returns the indices of the triangles' corners. The
/// polygon may have either orientation. A degenerate polygon gives degenerate triangles.
pub fn triangles(corners: &[Point]) -> Vec<[usize; 3]> {
    let plane = project(corners);
    let cross = |a: usize, b: usize, c: usize| {
        let ([ax, ay], [bx, by], [cx, cy]) = (plane[a], plane[b], plane[c]);
        (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    };
    let mut left: Vec<usize> = (0..corners.len()).collect();
    let mut cut = Vec::with_capacity(corners.len().saturating_sub(2));
    while left.len() > 3 {
        let count = left.len();
        let at = |index: usize| left[index % count];
        let is_ear = |index: &usize| {
            let [a, b, c] = [at(index + count - 1), at(*index), at(index + 1)];
            let mut others = left.iter().filter(|other| ![a, b, c].contains(other));
            let inside = |p: usize| cross(a, b, p) > 0.0 && cross(b, c, p) > 0.0 && cross(c, a, p) > 0.0;
            cross(a, b, c) > 0.0 && !others.any(|other| inside(*other))
        };
        // A remainder without ears is degenerate: any corner can be cut.
        let ear = (0..count).find(is_ear).unwrap_or(0);
        cut.push([at(ear + count - 1), at(ear), at(ear + 1)]);
        left.remove(ear);
    }
    if let [a, b, c] = left[..] {
        cut.push([a, b, c]);
    }
    cut
}

/// Projects the polygon, counterclockwise, onto the coordinate plane in which its area is largest.
fn project(corners: &[Point]) -> Vec<[f64; 2]> {
    let normal = area_vector(corners);
    let axis = (0..3).max_by(|a, b| normal[*a].abs().total_cmp(&normal[*b].abs())).unwrap_or(2);
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let (u, v) = if normal[axis] < 0.0 { (v, u) } else { (u, v) };
    corners.iter().map(|corner| [corner[u], corner[v]]).collect()
}

#[cfg(test)]
mod tests {
    use b2b_building::zone::polygon_area;

    use super::*;

    fn area(corners: &[Point]) -> f64 {
        triangles(corners).into_iter().map(|triangle| polygon_area(&triangle.map(|c| corners[c]))).sum()
    }

    /// An L-shaped polygon on the x axis, tilted over y.
    const L: [Point; 6] = [
        [0.0, 0.0, 0.0],
        [4.0, 0.0, 0.0],
        [4.0, 1.0, 1.0],
        [1.0, 1.0, 1.0],
        [1.0, 3.0, 3.0],
        [0.0, 3.0, 3.0],
    ];

    #[test]
    fn triangles_cover_a_concave_polygon() {
        for turn in 0..6 {
            let mut corners = L;
            corners.rotate_left(turn);
            assert_eq!(triangles(&corners).len(), 4);
            assert!((area(&corners) - polygon_area(&L)).abs() < 1e-12, "{turn}");
            corners.reverse();
            assert!((area(&corners) - polygon_area(&L)).abs() < 1e-12, "{turn} reversed");
        }
    }

    #[test]
    fn collinear_corners_are_triangulated() {
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0]];
        assert_eq!(triangles(&corners).len(), 3);
        assert!((area(&corners) - 4.0).abs() < 1e-12);
        assert_eq!(triangles(&[[0.0; 3]; 4]).len(), 2);
    }
}
