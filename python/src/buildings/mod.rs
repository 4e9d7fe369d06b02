//! Buildings as Python classes: found, generated, changed and calibrated.

pub(crate) mod calibration;
pub(crate) mod catalog;
pub(crate) mod edit;
pub(crate) mod generator;
pub(crate) mod table;
