//! A stand-alone shop.

use super::data::{Day, Prototype, TypeData};

pub(super) const DATA: TypeData = TypeData {
    name: "RetailStandalone",
    description: "shop, four rooftop units and a heated entrance",
    home: "Denver",
    prototype: Some(Prototype {
        file: "ASHRAE901_RetailStandalone_STD2019_Denver.idf",
        window_to_wall: 0.0713,
        conditioned_floor_area: 2293.993,
        // The core: 6 m³/s of supply air, 29 % of it outdoor air.
        recovers_heat: |system| system.starts_with("PSZ-AC:2"),
    }),
    has_air_loops: false,
    day: Day {
        arrival: [9.0, 0.5, 7.0, 11.0],
        departure: [21.0, 0.5, 18.0, 23.0],
        occupied: [20.0, 23.0],
        offset: 3.0,
    },
};
