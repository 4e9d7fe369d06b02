//! The shape of a house: a rectangular block under a gable roof whose ridge runs along the long side.
//!
//! x runs east, y north, z up, from the south-west corner at grade. Every polygon is counter-clockwise seen from
//! outside its zone and starts at its upper left corner.

use super::{Foundation, House};

/// Floor to ceiling of every level, m (median of the stock survey).
const STOREY_HEIGHT: f64 = 2.44;
/// Basement wall above grade, m (engineering judgement; NBC 9.15.4.6 asks for at least 0.15).
const FOUNDATION_ABOVE_GRADE: f64 = 0.4;
/// Joists under a floor between storeys, m; they rest on the sill (engineering judgement).
const JOISTS: f64 = 0.25;
/// Rise over run of the roof (engineering judgement).
const ROOF_PITCH: f64 = 5.0 / 12.0;

/// A corner: x, y, z in m.
pub type Point = [f64; 3];

/// The dimensions of a house, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geometry {
    /// Long side of the footprint.
    pub length: f64,
    /// Short side of the footprint.
    pub width: f64,
    /// Level of the lowest floor; negative under grade.
    pub floor: f64,
    /// Level where the foundation ends and the walls begin.
    pub sill: f64,
    /// Level of the top ceiling.
    pub ceiling: f64,
    /// Level of the ridge.
    pub ridge: f64,
    /// Levels that are heated, the basement included.
    pub levels: u32,
}

/// A side of the house, named by where it faces before the house is turned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Long side, y = 0.
    South,
    /// Short side, x = length.
    East,
    /// Long side, y = width.
    North,
    /// Short side, x = 0.
    West,
}

impl Side {
    /// Every side.
    pub const ALL: [Self; 4] = [Self::South, Self::East, Self::North, Self::West];

    /// Its name in the model.
    pub fn name(self) -> &'static str {
        match self {
            Self::South => "South",
            Self::East => "East",
            Self::North => "North",
            Self::West => "West",
        }
    }
}

impl Geometry {
    /// The dimensions that the parameters ask for.
    pub fn new(house: &House) -> Self {
        let (basement, sill) = match house.foundation {
            Foundation::Basement => (1, FOUNDATION_ABOVE_GRADE),
            Foundation::Slab => (0, 0.0),
        };
        let levels = house.storeys + basement;
        let footprint = house.floor_area / f64::from(levels);
        let width = (footprint / house.aspect).sqrt();
        let ceiling = sill + STOREY_HEIGHT * f64::from(house.storeys);
        Self {
            length: width * house.aspect,
            width,
            floor: sill - STOREY_HEIGHT * f64::from(basement),
            sill,
            ceiling,
            ridge: ceiling + ROOF_PITCH * width / 2.0,
            levels,
        }
    }

    /// Area of the ground that the house covers, m².
    pub fn footprint(&self) -> f64 {
        self.length * self.width
    }

    /// Perimeter of the footprint, m.
    pub fn perimeter(&self) -> f64 {
        2.0 * (self.length + self.width)
    }

    /// Area of the walls above the foundation, windows included, m².
    pub fn wall_area(&self) -> f64 {
        self.perimeter() * (self.ceiling - self.sill)
    }

    /// Depth of the lowest floor under grade, m.
    pub fn depth(&self) -> f64 {
        -self.floor
    }

    /// Levels of the floors between storeys, from below.
    pub fn storey_floors(&self) -> impl Iterator<Item = f64> {
        let floor = self.floor + JOISTS;
        (1..self.levels).map(move |level| floor + STOREY_HEIGHT * f64::from(level))
    }

    /// Volume of the heated zone, m³.
    pub fn living_volume(&self) -> f64 {
        self.footprint() * (self.ceiling - self.floor)
    }

    /// Volume of the attic, m³.
    pub fn attic_volume(&self) -> f64 {
        self.footprint() * (self.ridge - self.ceiling) / 2.0
    }

    /// The wall of a side between two levels.
    pub fn wall(&self, side: Side, bottom: f64, top: f64) -> Vec<Point> {
        let ([x0, y0], [x1, y1]) = self.ends(side);
        vec![[x0, y0, top], [x0, y0, bottom], [x1, y1, bottom], [x1, y1, top]]
    }

    /// A window in the middle of a wall that covers `fraction` of it.
    pub fn window(&self, side: Side, fraction: f64) -> Vec<Point> {
        let wall = self.wall(side, self.sill, self.ceiling);
        let centre: Point =
            std::array::from_fn(|i| wall.iter().map(|p| p[i]).sum::<f64>() / wall.len() as f64);
        let scale = fraction.sqrt();
        wall.iter().map(|p| std::array::from_fn(|i| centre[i] + scale * (p[i] - centre[i]))).collect()
    }

    /// A horizontal polygon that faces down.
    pub fn facing_down(&self, z: f64) -> Vec<Point> {
        let (l, w) = (self.length, self.width);
        vec![[0.0, 0.0, z], [0.0, w, z], [l, w, z], [l, 0.0, z]]
    }

    /// A horizontal polygon that faces up.
    pub fn facing_up(&self, z: f64) -> Vec<Point> {
        let (l, w) = (self.length, self.width);
        vec![[0.0, w, z], [0.0, 0.0, z], [l, 0.0, z], [l, w, z]]
    }

    /// What closes the attic on a side: a slope over a long side, a gable over a short one.
    pub fn roof(&self, side: Side) -> Vec<Point> {
        let ([x0, y0], [x1, y1]) = self.ends(side);
        let (eave, ridge, middle) = (self.ceiling, self.ridge, self.width / 2.0);
        match side {
            Side::South | Side::North => {
                vec![[x0, middle, ridge], [x0, y0, eave], [x1, y1, eave], [x1, middle, ridge]]
            }
            Side::East | Side::West => {
                vec![[x0, middle, ridge], [x0, y0, eave], [x1, y1, eave]]
            }
        }
    }

    /// The lower corners of a side, left and right seen from outside.
    fn ends(&self, side: Side) -> ([f64; 2], [f64; 2]) {
        let (l, w) = (self.length, self.width);
        match side {
            Side::South => ([0.0, 0.0], [l, 0.0]),
            Side::East => ([l, 0.0], [l, w]),
            Side::North => ([l, w], [0.0, w]),
            Side::West => ([0.0, w], [0.0, 0.0]),
        }
    }
}
