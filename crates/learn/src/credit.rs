//! Credit assignment: the parts of a reward that each actuator learns from.

use b2b_building::morphology::Owner;
use b2b_env::Spaces;

/// Returns the weight of each part of a reward, of the controlled zones and of energy, in the advantage of each actuator: that of
/// a zone counts for its own actuators and for those of the air handler that serves it, energy for all.
pub(crate) fn credit(spaces: &Spaces) -> Vec<Vec<f32>> {
    let zones: Vec<usize> = spaces.controlled_zones().collect();
    let layouts: Vec<_> = spaces.building.laid_out_systems().map(|(_, layout)| layout).collect();
    let serves = |owner: &Owner, zone: usize| match owner {
        Owner::Zone(own) => *own == zone,
        Owner::AirLoop(system) => layouts[*system].zones.iter().any(|served| served.index == zone),
        Owner::Weather | Owner::Calendar | Owner::Energy => false,
    };
    let row = |owner: &Owner| {
        let zones = zones.iter().map(|zone| f32::from(u8::from(serves(owner, *zone))));
        zones.chain([1.0]).collect()
    };
    spaces.action.owners().iter().map(row).collect()
}
