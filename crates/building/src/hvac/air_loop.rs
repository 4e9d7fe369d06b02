//! Central air loops: supply temperature, outdoor air, dampers, reheat.
use super::AirLoop;
use crate::{Model, Result};
/// TODO
pub fn make_controllable(_model: &mut Model, _air_loop: &str, _air_density: f64) -> Result<AirLoop> {
    todo!()
}
