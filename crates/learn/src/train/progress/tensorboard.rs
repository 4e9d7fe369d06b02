//! Event files that TensorBoard reads: scalars by step.
//!
//! A file is a sequence of records: length, its checksum, an `Event` message and its checksum. Messages are protocol
//! buffers (TensorFlow's `event.proto` and `summary.proto`).

use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

use b2b_agent::protobuf::{bytes, double, integer, single, text};

use super::journal::Journal;
use crate::error::{Result, at};

/// Writes an event file.
pub(super) struct EventFile {
    journal: Journal,
}

impl EventFile {
    /// Creates an event file in a folder, or continues the file created in the same second.
    pub(super) fn create(folder: &Path) -> Result<Self> {
        std::fs::create_dir_all(folder).map_err(at(folder))?;
        let path = folder.join(format!("events.out.tfevents.{}.b2b", now() as u64));
        let mut events = Self { journal: Journal::open(&path)? };
        if events.journal.is_empty() {
            events.write(0, &text(3, "brain.Event:2"))?;
        }
        Ok(events)
    }

    /// Adds scalars at a step.
    pub(super) fn scalars(&mut self, step: u64, scalars: &[(&str, f64)]) -> Result<()> {
        let finite = scalars.iter().filter(|(_, value)| value.is_finite());
        let scalar =
            |(tag, value): &(&str, f64)| bytes(1, &[text(1, tag), single(2, *value as f32)].concat());
        let summary: Vec<u8> = finite.flat_map(scalar).collect();
        self.write(step, &bytes(5, &summary))
    }

    /// Writes an event: wall time, step, and the field with its content.
    fn write(&mut self, step: u64, what: &[u8]) -> Result<()> {
        let event = [double(1, now()), integer(2, step), what.to_vec()].concat();
        let length = (event.len() as u64).to_le_bytes();
        let record = [&length[..], &checksum(&length), &event, &checksum(&event)].concat();
        self.journal.append(&record)
    }
}

/// Seconds since 1970.
fn now() -> f64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |time| time.as_secs_f64())
}

/// The masked CRC-32C of TFRecord.
fn checksum(bytes: &[u8]) -> [u8; 4] {
    let crc = crc32c::crc32c(bytes);
    crc.rotate_right(15).wrapping_add(0xa282_ead8).to_le_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_made_of_records_with_checksums() {
        let folder = tempfile::tempdir().unwrap();
        let mut events = EventFile::create(folder.path()).unwrap();
        events.scalars(7, &[("score", 0.5), ("none", f64::NAN)]).unwrap();
        let file = std::fs::read_dir(folder.path()).unwrap().next().unwrap().unwrap();
        let bytes = std::fs::read(file.path()).unwrap();
        let mut rest = &bytes[..];
        let mut records = Vec::new();
        while !rest.is_empty() {
            let length = u64::from_le_bytes(rest[..8].try_into().unwrap()) as usize;
            assert_eq!(rest[8..12], checksum(&rest[..8]));
            let event = &rest[12..12 + length];
            assert_eq!(rest[12 + length..16 + length], checksum(event));
            records.push(event.to_vec());
            rest = &rest[16 + length..];
        }
        assert_eq!(records.len(), 2);
        let contains = |text: &[u8]| records[1].windows(text.len()).any(|part| part == text);
        assert!(contains(b"score") && !contains(b"none") && contains(&0.5f32.to_le_bytes()));
    }
}
