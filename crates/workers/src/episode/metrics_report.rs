//! The metrics that a worker reports at the end of an episode. For a building with many zones, they are too long for
//! its slot and pass through a file.

use std::io;
use std::path::Path;

use crate::region::{LONG_REPORT, Region, Ticket};
use b2b_env::Metrics;

/// Writes metrics to the slot of a worker, or to its file in the pool's folder.
///
/// # Errors
/// Errors of the operating system.
pub(crate) fn write(region: &Region, ticket: Ticket, folder: &Path, metrics: &Metrics) -> io::Result<()> {
    let text = serde_json::to_vec(metrics)?;
    if Region::has_room_for(&text) {
        region.write_report(ticket.slot, &text);
        return Ok(());
    }
    // An empty report refers to the file.
    region.write_report(ticket.slot, &[]);
    std::fs::write(folder.join(ticket.file(LONG_REPORT)), text)
}

/// Reads the metrics in a slot, or in the file of its worker.
///
/// # Errors
/// Errors of the operating system, and invalid metrics.
pub(crate) fn read(region: &Region, slot: u32, folder: &Path) -> io::Result<Metrics> {
    let mut text = region.report(slot);
    if text.is_empty() {
        text = std::fs::read(folder.join(region.ticket(slot).file(LONG_REPORT)))?;
    }
    Ok(serde_json::from_slice(&text)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::episode::episode_options::EpisodeOptions;
    use b2b_env::ControlledZone;

    #[test]
    fn metrics_of_any_number_of_zones_round_trip() {
        let folder = tempfile::tempdir().unwrap();
        let region = Region::new().unwrap();
        region.reserve(0).unwrap();
        for (zones, is_long) in [(3, false), (1000, true)] {
            region.init(0, EpisodeOptions::default());
            // Previous content of the slot.
            region.write_report(0, b"an order");
            let zone = |slot| ControlledZone {
                slot,
                penalize_above_target: true,
                fully_conditioned: true,
                least_people: 0.0,
            };
            let zones: Vec<ControlledZone> = (0..zones).map(zone).collect();
            let metrics = Metrics::new(&zones, 2 * zones.len(), 12, 1.0);
            write(&region, region.ticket(0), folder.path(), &metrics).unwrap();
            assert_eq!(region.report(0).is_empty(), is_long);
            assert_eq!(read(&region, 0, folder.path()).unwrap(), metrics);
        }
    }
}
