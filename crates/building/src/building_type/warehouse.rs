//! A warehouse.

use super::data::{Day, Prototype, TypeData, never};

pub(super) const DATA: TypeData = TypeData {
    name: "Warehouse",
    description: "warehouse, two rooftop units and a unit heater",
    home: "Denver",
    prototype: Some(Prototype {
        file: "ASHRAE901_Warehouse_STD2019_Denver.idf",
        window_to_wall: 0.00707,
        conditioned_floor_area: 4598.252,
        recovers_heat: never,
    }),
    has_air_loops: false,
    day: Day {
        arrival: [6.5, 0.5, 5.0, 9.0],
        departure: [18.0, 0.5, 15.0, 21.0],
        occupied: [18.0, 22.0],
        offset: 4.0,
    },
};
