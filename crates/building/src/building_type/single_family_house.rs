//! A detached house, generated from its parameters.

use super::data::{Day, TypeData};

pub(super) const DATA: TypeData = TypeData {
    name: "SingleFamilyHouse",
    description: "detached Québec house, ducted heat pump or furnace with cooling",
    home: "Montréal",
    prototype: None,
    has_air_loops: false,
    day: Day {
        arrival: [7.0, 1.0, 5.0, 10.0],
        departure: [22.0, 1.0, 19.0, 24.0],
        occupied: [20.0, 23.0],
        offset: 3.0,
    },
};
