//! The roles of zones in generated houses.

/// The role of a zone in a house.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ZoneRole {
    /// The heated zone: every story and a heated basement.
    Living,
    /// The vented zone under the roof.
    Attic,
    /// The vented zone under the floor.
    Crawlspace,
    /// The unheated garage.
    Garage,
}

impl ZoneRole {
    /// Every role, in the order of a house's zones.
    pub const ALL: [Self; 4] = [Self::Living, Self::Attic, Self::Crawlspace, Self::Garage];

    /// Returns the name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Living => "living",
            Self::Attic => "attic",
            Self::Crawlspace => "crawlspace",
            Self::Garage => "garage",
        }
    }

    /// Returns the role of a zone of the generator's houses, by its name.
    pub fn of_zone(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|role| role.name().eq_ignore_ascii_case(name))
    }
}
