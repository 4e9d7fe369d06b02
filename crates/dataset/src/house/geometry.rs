//! The shape of a house: a rectangular block under a gable roof whose ridge runs along the long side.
//!
//! x runs east, y north, z up, from the south-west corner at grade. Every polygon is counter-clockwise seen from
//! outside its zone and starts at its upper left corner.

use super::parameters::{Foundation, House};

/// Floor to ceiling of every level, m (median of the stock survey).
const STOREY_HEIGHT: f64 = 2.44;
/// Basement wall above grade, m (engineering judgment; NBC 9.15.4.6 asks for at least 0.15).
const FOUNDATION_ABOVE_GRADE: f64 = 0.4;
/// Depth of a crawlspace under grade, m: together with the part above grade, a little over half of the 1.8 m that
/// distinguishes a basement in the stock survey (engineering judgment).
const CRAWLSPACE_DEPTH: f64 = 0.6;
/// Width of a garage for one car, m (engineering judgment); it is as deep as the house.
const GARAGE_WIDTH: f64 = 4.0;
/// Joists under a floor between storeys, m; they rest on the sill (engineering judgment).
const JOISTS: f64 = 0.25;
/// Rise over run of the roof (engineering judgment).
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
    /// Number of heated levels, including the basement.
    pub levels: u32,
    /// Level of the soil in the crawlspace, if there is one.
    pub crawlspace: Option<f64>,
    /// Whether there is a garage on the east side.
    pub garage: bool,
}

/// A side of the house, named by its direction before rotation.
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
    /// Computes the dimensions from the parameters.
    pub fn new(house: &House) -> Self {
        let (basement, sill, crawlspace) = match house.foundation {
            Foundation::Basement => (1, FOUNDATION_ABOVE_GRADE, None),
            Foundation::Slab => (0, 0.0, None),
            Foundation::Crawlspace => (0, FOUNDATION_ABOVE_GRADE, Some(-CRAWLSPACE_DEPTH)),
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
            crawlspace,
            garage: house.garage,
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

    /// Length of a side, m.
    pub fn length_of(&self, side: Side) -> f64 {
        match side {
            Side::South | Side::North => self.length,
            Side::East | Side::West => self.width,
        }
    }

    /// Returns whether the garage is on a side.
    pub fn has_garage(&self, side: Side) -> bool {
        self.garage && side == Side::East
    }

    /// Perimeter without the garage side, m.
    pub fn exposed_perimeter(&self) -> f64 {
        Side::ALL.iter().filter(|side| !self.has_garage(**side)).map(|side| self.length_of(*side)).sum()
    }

    /// Bottom and top of the outdoor wall of a side, if any.
    pub fn outer_wall(&self, side: Side) -> Option<[f64; 2]> {
        let bottom = if self.has_garage(side) { self.garage_top() } else { self.sill };
        (self.ceiling - bottom > 0.01).then_some([bottom, self.ceiling])
    }

    /// Area of the outer walls above the foundation, windows included, m².
    pub fn wall_area(&self) -> f64 {
        let area = |side: &Side| {
            self.outer_wall(*side).map_or(0.0, |[bottom, top]| (top - bottom) * self.length_of(*side))
        };
        Side::ALL.iter().map(area).sum()
    }

    /// Level of the garage's roof: the top of the first storey.
    pub fn garage_top(&self) -> f64 {
        self.sill + STOREY_HEIGHT
    }

    /// The garage as a separate block; its west side is the house's east side.
    pub fn garage_block(&self) -> Block {
        Block { west: self.length, east: self.length + GARAGE_WIDTH, width: self.width }
    }

    fn block(&self) -> Block {
        Block { west: 0.0, east: self.length, width: self.width }
    }

    /// Depth of the basement floor under grade, m; 0 without a basement.
    pub fn depth(&self) -> f64 {
        (-self.floor).max(0.0)
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

    /// Volume of the crawlspace, m³.
    pub fn crawlspace_volume(&self) -> f64 {
        self.crawlspace.map_or(0.0, |soil| self.footprint() * (self.sill - soil))
    }

    /// Volume of the garage, m³.
    pub fn garage_volume(&self) -> f64 {
        GARAGE_WIDTH * self.width * self.garage_top()
    }

    /// Volume of the attic, m³.
    pub fn attic_volume(&self) -> f64 {
        self.footprint() * (self.ridge - self.ceiling) / 2.0
    }

    /// The wall of a side between two levels.
    pub fn wall(&self, side: Side, bottom: f64, top: f64) -> Vec<Point> {
        self.block().wall(side, bottom, top)
    }

    /// A window in the middle of the outer wall of a side, if any, that covers `fraction` of it.
    pub fn window(&self, side: Side, fraction: f64) -> Option<Vec<Point>> {
        let [bottom, top] = self.outer_wall(side)?;
        let wall = self.wall(side, bottom, top);
        let center: Point =
            std::array::from_fn(|i| wall.iter().map(|p| p[i]).sum::<f64>() / wall.len() as f64);
        let scale = fraction.sqrt();
        let corner = |p: &Point| std::array::from_fn(|i| center[i] + scale * (p[i] - center[i]));
        Some(wall.iter().map(corner).collect())
    }

    /// A horizontal polygon that faces down.
    pub fn facing_down(&self, z: f64) -> Vec<Point> {
        self.block().facing_down(z)
    }

    /// A horizontal polygon that faces up.
    pub fn facing_up(&self, z: f64) -> Vec<Point> {
        self.block().facing_up(z)
    }

    /// The enclosure of the attic on a side: a slope over a long side, a gable over a short one.
    pub fn roof(&self, side: Side) -> Vec<Point> {
        let ([x0, y0], [x1, y1]) = self.block().ends(side);
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
}

/// A rectangle on the ground, from y = 0 north, m.
#[derive(Clone, Copy, Debug)]
pub struct Block {
    west: f64,
    east: f64,
    width: f64,
}

impl Block {
    /// The wall of a side between two levels.
    pub fn wall(&self, side: Side, bottom: f64, top: f64) -> Vec<Point> {
        let ([x0, y0], [x1, y1]) = self.ends(side);
        vec![[x0, y0, top], [x0, y0, bottom], [x1, y1, bottom], [x1, y1, top]]
    }

    /// A horizontal polygon that faces down.
    pub fn facing_down(&self, z: f64) -> Vec<Point> {
        let Self { west, east, width } = *self;
        vec![[west, 0.0, z], [west, width, z], [east, width, z], [east, 0.0, z]]
    }

    /// A horizontal polygon that faces up.
    pub fn facing_up(&self, z: f64) -> Vec<Point> {
        let Self { west, east, width } = *self;
        vec![[west, width, z], [west, 0.0, z], [east, 0.0, z], [east, width, z]]
    }

    /// Area, m².
    pub fn area(&self) -> f64 {
        (self.east - self.west) * self.width
    }

    /// Perimeter without the west side, m.
    pub fn perimeter_but_west(&self) -> f64 {
        2.0 * (self.east - self.west) + self.width
    }

    /// The lower corners of a side, left and right seen from outside.
    fn ends(&self, side: Side) -> ([f64; 2], [f64; 2]) {
        let Self { west, east, width } = *self;
        match side {
            Side::South => ([west, 0.0], [east, 0.0]),
            Side::East => ([east, 0.0], [east, width]),
            Side::North => ([east, width], [west, width]),
            Side::West => ([west, width], [west, 0.0]),
        }
    }
}
