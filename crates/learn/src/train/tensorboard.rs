//! Event files that TensorBoard reads: scalars by step.
//!
//! A file is a sequence of records: length, its checksum, an `Event` message and its checksum. Messages are protocol buffers, of
//! which three fields are used (TensorFlow's `event.proto` and `summary.proto`).

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use crate::error::{Result, at};

/// Writes an event file.
pub(super) struct EventFile {
    path: PathBuf,
    file: File,
}

impl EventFile {
    /// Begins an event file in a folder.
    pub(super) fn create(folder: &Path) -> Result<Self> {
        std::fs::create_dir_all(folder).map_err(at(folder))?;
        let path = folder.join(format!("events.out.tfevents.{}.b2b", now() as u64));
        let file = File::create(&path).map_err(at(&path))?;
        let mut events = Self { path, file };
        let mut version = Vec::new();
        bytes_field(3, b"brain.Event:2", &mut version);
        events.write(0, &version)?;
        Ok(events)
    }

    /// Adds scalars at a step.
    pub(super) fn scalars(&mut self, step: u64, scalars: &[(&str, f64)]) -> Result<()> {
        let mut summary = Vec::new();
        for (tag, value) in scalars.iter().filter(|(_, value)| value.is_finite()) {
            let mut scalar = Vec::new();
            bytes_field(1, tag.as_bytes(), &mut scalar);
            key(2, FOUR_BYTES, &mut scalar);
            scalar.extend((*value as f32).to_le_bytes());
            bytes_field(1, &scalar, &mut summary);
        }
        let mut what = Vec::new();
        bytes_field(5, &summary, &mut what);
        self.write(step, &what)
    }

    /// Writes an event: wall time, step, and the field that says what it is of.
    fn write(&mut self, step: u64, what: &[u8]) -> Result<()> {
        let mut event = Vec::new();
        key(1, EIGHT_BYTES, &mut event);
        event.extend(now().to_le_bytes());
        key(2, VARINT, &mut event);
        varint(step, &mut event);
        event.extend_from_slice(what);
        let length = (event.len() as u64).to_le_bytes();
        let record = [&length[..], &checksum(&length), &event, &checksum(&event)].concat();
        self.file.write_all(&record).map_err(at(&self.path))
    }
}

/// Seconds since 1970.
fn now() -> f64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |time| time.as_secs_f64())
}

/// Wire types of protocol buffers.
const VARINT: u64 = 0;
const EIGHT_BYTES: u64 = 1;
const BYTES: u64 = 2;
const FOUR_BYTES: u64 = 5;

fn key(field: u64, wire_type: u64, out: &mut Vec<u8>) {
    varint(field << 3 | wire_type, out);
}

fn varint(mut value: u64, out: &mut Vec<u8>) {
    while value >= 0x80 {
        out.push(value as u8 | 0x80);
        value >>= 7;
    }
    out.push(value as u8);
}

fn bytes_field(field: u64, bytes: &[u8], out: &mut Vec<u8>) {
    key(field, BYTES, out);
    varint(bytes.len() as u64, out);
    out.extend_from_slice(bytes);
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
    fn numbers_are_written_as_protocol_buffers_have_them() {
        let mut out = Vec::new();
        varint(300, &mut out);
        assert_eq!(out, [0xac, 0x02]);
        out.clear();
        bytes_field(1, b"a", &mut out);
        assert_eq!(out, [0x0a, 1, b'a']);
    }

    #[test]
    fn a_file_is_made_of_records_with_checksums() {
        let folder = tempfile::tempdir().unwrap();
        let mut events = EventFile::create(folder.path()).unwrap();
        events.scalars(7, &[("score", 0.5), ("none", f64::NAN)]).unwrap();
        let bytes = std::fs::read(&events.path).unwrap();
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
