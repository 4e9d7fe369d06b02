//! A small office.

use super::data::{OFFICE_DAY, Prototype, TypeData, never};

pub(super) const DATA: TypeData = TypeData {
    name: "OfficeSmall",
    description: "small office, a heat pump for each of five zones",
    home: "Denver",
    prototype: Some(Prototype {
        file: "ASHRAE901_OfficeSmall_STD2019_Denver.idf",
        window_to_wall: 0.2120,
        conditioned_floor_area: 511.157,
        recovers_heat: never,
    }),
    has_air_loops: false,
    day: OFFICE_DAY,
};
