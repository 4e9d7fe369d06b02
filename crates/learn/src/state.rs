//! Saved states of learners: named tensors, as bytes in the safetensors format.
//!
//! The format is the length of a header as 8 little-endian bytes, the header in JSON, and the values, little-endian. Values are
//! kept bit for bit.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};

/// Values of a tensor.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Single precision.
    F32(Vec<f32>),
    /// Double precision.
    F64(Vec<f64>),
    /// Whole numbers.
    U64(Vec<u64>),
}

/// Named tensors of one dimension.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    tensors: BTreeMap<String, Values>,
}

/// The header of a tensor.
#[derive(Serialize, Deserialize)]
struct Entry {
    dtype: String,
    shape: Vec<usize>,
    data_offsets: [usize; 2],
}

/// Length of the length of the header in bytes.
const PREFIX: usize = 8;

impl State {
    /// Adds values in single precision.
    pub fn put_f32(&mut self, name: &str, values: &[f32]) {
        self.tensors.insert(name.into(), Values::F32(values.into()));
    }

    /// Adds values in double precision.
    pub fn put_f64(&mut self, name: &str, values: &[f64]) {
        self.tensors.insert(name.into(), Values::F64(values.into()));
    }

    /// Adds whole numbers.
    pub fn put_u64(&mut self, name: &str, values: &[u64]) {
        self.tensors.insert(name.into(), Values::U64(values.into()));
    }

    /// Adds all tensors of another state, each under `part.name`.
    pub fn put_all(&mut self, part: &str, other: &Self) {
        let named = other.tensors.iter().map(|(name, values)| (format!("{part}.{name}"), values.clone()));
        self.tensors.extend(named);
    }

    /// Returns the tensors that were added under `part`.
    pub fn part(&self, part: &str) -> Self {
        let prefix = format!("{part}.");
        let own = |(name, values): (&String, &Values)| {
            Some((name.strip_prefix(&prefix)?.to_owned(), values.clone()))
        };
        Self { tensors: self.tensors.iter().filter_map(own).collect() }
    }

    /// Returns the tensors by name.
    pub fn tensors(&self) -> &BTreeMap<String, Values> {
        &self.tensors
    }

    /// Copies values in single precision.
    ///
    /// # Errors
    /// When there is no such tensor of this type and length.
    pub fn read_f32(&self, name: &str, values: &mut [f32]) -> Result<()> {
        match self.tensors.get(name) {
            Some(Values::F32(saved)) if saved.len() == values.len() => values.copy_from_slice(saved),
            _ => return Err(missing(name, "f32", values.len())),
        }
        Ok(())
    }

    /// Copies values in double precision.
    ///
    /// # Errors
    /// When there is no such tensor of this type and length.
    pub fn read_f64(&self, name: &str, values: &mut [f64]) -> Result<()> {
        match self.tensors.get(name) {
            Some(Values::F64(saved)) if saved.len() == values.len() => values.copy_from_slice(saved),
            _ => return Err(missing(name, "f64", values.len())),
        }
        Ok(())
    }

    /// Returns whole numbers.
    ///
    /// # Errors
    /// When there is no such tensor of this type and length.
    pub fn read_u64<const COUNT: usize>(&self, name: &str) -> Result<[u64; COUNT]> {
        match self.tensors.get(name) {
            Some(Values::U64(saved)) => saved.as_slice().try_into().map_err(|_| missing(name, "u64", COUNT)),
            _ => Err(missing(name, "u64", COUNT)),
        }
    }

    /// Returns whole numbers, as many as expected.
    ///
    /// # Errors
    /// When there is no such tensor of this type and length.
    pub fn values_u64(&self, name: &str, count: usize) -> Result<Vec<u64>> {
        match self.tensors.get(name) {
            Some(Values::U64(saved)) if saved.len() == count => Ok(saved.clone()),
            _ => Err(missing(name, "u64", count)),
        }
    }

    /// Returns values in single precision, however many there are.
    ///
    /// # Errors
    /// When there is no such tensor of this type.
    pub fn values_f32(&self, name: &str) -> Result<Vec<f32>> {
        match self.tensors.get(name) {
            Some(Values::F32(saved)) => Ok(saved.clone()),
            _ => Err(Error::Tensor { name: name.into(), expected: "f32".into() }),
        }
    }

    /// Returns the bytes of the state.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut entries = BTreeMap::new();
        let mut data = Vec::new();
        // Values of eight bytes are first, so that all are aligned.
        for size in [8, 4] {
            for (name, values) in self.tensors.iter().filter(|(_, values)| values.size() == size) {
                let start = data.len();
                values.write(&mut data);
                let (dtype, shape) = (values.dtype().into(), vec![values.len()]);
                entries.insert(name, Entry { dtype, shape, data_offsets: [start, data.len()] });
            }
        }
        let mut header = serde_json::to_vec(&entries).expect("names and numbers are JSON");
        header.resize(header.len().next_multiple_of(8), b' ');
        let length = (header.len() as u64).to_le_bytes();
        [length.as_slice(), &header, &data].concat()
    }

    /// Reads the bytes of a state.
    ///
    /// # Errors
    /// When the bytes are not a state of a learner.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let cut = || Error::State("it ends too early".into());
        let (length, rest) = bytes.split_first_chunk::<PREFIX>().ok_or_else(cut)?;
        let length = usize::try_from(u64::from_le_bytes(*length)).map_err(|_| cut())?;
        let (header, data) = rest.split_at_checked(length).ok_or_else(cut)?;
        let entries: BTreeMap<String, Entry> =
            serde_json::from_slice(header).map_err(|error| Error::State(error.to_string()))?;
        let read = |(name, entry): (String, Entry)| {
            let values = data.get(entry.data_offsets[0]..entry.data_offsets[1]).ok_or_else(cut)?;
            Ok((name, Values::read(&entry.dtype, values)?))
        };
        Ok(Self { tensors: entries.into_iter().map(read).collect::<Result<_>>()? })
    }
}

impl Values {
    /// Returns the number of values.
    #[expect(clippy::len_without_is_empty, reason = "the number of values, not of a collection")]
    pub fn len(&self) -> usize {
        match self {
            Self::F32(values) => values.len(),
            Self::F64(values) => values.len(),
            Self::U64(values) => values.len(),
        }
    }

    fn dtype(&self) -> &'static str {
        match self {
            Self::F32(_) => "F32",
            Self::F64(_) => "F64",
            Self::U64(_) => "U64",
        }
    }

    fn size(&self) -> usize {
        if matches!(self, Self::F32(_)) { 4 } else { 8 }
    }

    fn write(&self, bytes: &mut Vec<u8>) {
        match self {
            Self::F32(values) => values.iter().for_each(|value| bytes.extend(value.to_le_bytes())),
            Self::F64(values) => values.iter().for_each(|value| bytes.extend(value.to_le_bytes())),
            Self::U64(values) => values.iter().for_each(|value| bytes.extend(value.to_le_bytes())),
        }
    }

    fn read(dtype: &str, bytes: &[u8]) -> Result<Self> {
        let (four, eight) = (bytes.as_chunks::<4>().0.iter(), bytes.as_chunks::<8>().0.iter());
        match dtype {
            "F32" => Ok(Self::F32(four.map(|value| f32::from_le_bytes(*value)).collect())),
            "F64" => Ok(Self::F64(eight.map(|value| f64::from_le_bytes(*value)).collect())),
            "U64" => Ok(Self::U64(eight.map(|value| u64::from_le_bytes(*value)).collect())),
            _ => Err(Error::State(format!("unknown type `{dtype}`; expected F32, F64 or U64"))),
        }
    }
}

fn missing(name: &str, dtype: &str, length: usize) -> Error {
    Error::Tensor { name: name.into(), expected: format!("{length} {dtype}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_keep_every_bit() {
        let mut state = State::default();
        state.put_f32("a", &[1.5, f32::MIN_POSITIVE / 2.0, -0.0]);
        state.put_f64("b", &[std::f64::consts::PI]);
        state.put_u64("c", &[u64::MAX, 3]);
        let read = State::from_bytes(&state.to_bytes()).unwrap();
        assert_eq!(read, state);
        assert_eq!(read.read_u64::<2>("c").unwrap(), [u64::MAX, 3]);
        let error = read.read_f32("a", &mut [0.0; 2]).unwrap_err().to_string();
        assert!(error.contains("no tensor `a` of 2 f32"), "{error}");
    }

    #[test]
    fn other_bytes_are_an_error() {
        for bytes in [&[][..], &[1; 20], &[0, 1, 2]] {
            assert!(State::from_bytes(bytes).is_err());
        }
    }
}
