//! Indices of the columns of an EPW row.

pub(crate) const DRY_BULB: usize = 6;
pub(crate) const DEW_POINT: usize = 7;
pub(crate) const HUMIDITY: usize = 8;
pub(crate) const PRESSURE: usize = 9;
pub(crate) const EXTRATERRESTRIAL_HORIZONTAL: usize = 10;
pub(crate) const EXTRATERRESTRIAL_NORMAL: usize = 11;
pub(crate) const INFRARED: usize = 12;
pub(crate) const GLOBAL: usize = 13;
pub(crate) const BEAM: usize = 14;
pub(crate) const DIFFUSE: usize = 15;
pub(crate) const ILLUMINANCE: std::ops::RangeInclusive<usize> = 16..=18;
pub(crate) const ZENITH_LUMINANCE: usize = 19;
pub(crate) const WIND: usize = 21;
pub(crate) const COVER: usize = 23;
