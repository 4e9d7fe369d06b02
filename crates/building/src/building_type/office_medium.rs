//! A medium office.

use super::data::{OFFICE_DAY, Prototype, TypeData};

pub(super) const DATA: TypeData = TypeData {
    name: "OfficeMedium",
    description: "medium office, three central air loops over fifteen zones",
    home: "Denver",
    prototype: Some(Prototype {
        file: "ASHRAE901_OfficeMedium_STD2019_Denver.idf",
        window_to_wall: 0.3300,
        conditioned_floor_area: 4982.186,
        // Each floor: 4 m³/s of supply air, 19 % of it outdoor air.
        recovers_heat: |_| true,
    }),
    has_air_loops: true,
    day: OFFICE_DAY,
};
