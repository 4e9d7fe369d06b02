//! Demand limiting (Guideline 36, 5.3.2.6 and 5.3.2.7): levels that widen the band of a zone.

use super::super::setpoints::Setpoints;

/// Widening of both setpoints by level, K. Levels are not cumulative.
const OFFSETS: [f64; 4] = [0.0, 0.5, 1.0, 2.0];

/// Level of demand limiting, 0 (none) to 3. The designer decides what sets it: a tariff, a demand limit or a utility
/// signal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DemandLevel(u8);

impl DemandLevel {
    /// No limiting.
    pub const NONE: Self = Self(0);

    /// Returns a level; `None` above 3.
    pub fn new(level: u8) -> Option<Self> {
        (usize::from(level) < OFFSETS.len()).then_some(Self(level))
    }

    /// Returns a band widened by the level.
    pub(in super::super) fn widen(self, band: Setpoints) -> Setpoints {
        let offset = OFFSETS[usize::from(self.0)];
        Setpoints { heating: band.heating - offset, cooling: band.cooling + offset }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_levels_widen_the_band_by_a_half_one_and_two_kelvin() {
        let band = Setpoints { heating: 21.0, cooling: 24.0 };
        let widened = |level| DemandLevel::new(level).map(|level| level.widen(band));
        let pair = |heating, cooling| Some(Setpoints { heating, cooling });
        assert_eq!(
            [0, 1, 2, 3].map(widened),
            [pair(21.0, 24.0), pair(20.5, 24.5), pair(20.0, 25.0), pair(19.0, 26.0),]
        );
        assert_eq!(widened(4), None);
    }

    #[test]
    fn a_zone_without_cooling_stays_without() {
        let band = Setpoints { heating: 18.0, cooling: f64::INFINITY };
        assert_eq!(DemandLevel(3).widen(band), Setpoints { heating: 16.0, cooling: f64::INFINITY });
    }
}
