//! A fast-food restaurant.

use super::data::{Day, Prototype, TypeData, never};

pub(super) const DATA: TypeData = TypeData {
    name: "RestaurantFastFood",
    description: "fast-food restaurant, rooftop units for dining room and kitchen",
    home: "Denver",
    prototype: Some(Prototype {
        file: "ASHRAE901_RestaurantFastFood_STD2019_Denver.idf",
        window_to_wall: 0.1400,
        conditioned_floor_area: 232.343,
        recovers_heat: never,
    }),
    has_air_loops: false,
    day: Day {
        arrival: [9.0, 0.5, 7.0, 11.0],
        departure: [23.0, 0.5, 20.0, 24.0],
        occupied: [20.0, 23.0],
        offset: 3.0,
    },
};
