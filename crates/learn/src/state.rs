//! Saved states of learners: named tensors, as bytes in the safetensors format. Values are kept bit for bit.

use std::collections::{BTreeMap, HashMap};

use safetensors::tensor::{Dtype, TensorView};
use safetensors::{SafeTensors, serialize};

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

    /// Returns the expected number of integers.
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
        self.to_bytes_with(None)
    }

    /// Returns the bytes of the state with metadata.
    pub(crate) fn to_bytes_with(&self, metadata: Option<HashMap<String, String>>) -> Vec<u8> {
        let bytes: Vec<Vec<u8>> = self.tensors.values().map(Values::to_bytes).collect();
        let views = self.tensors.iter().zip(&bytes).map(|((name, values), bytes)| {
            let view = TensorView::new(values.dtype(), vec![values.len()], bytes);
            (name, view.expect("the bytes have the length of the values"))
        });
        serialize(views, metadata).expect("names and numbers always serialize")
    }

    /// Reads the bytes of a state.
    ///
    /// # Errors
    /// When the bytes are not a state of a learner.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let read = SafeTensors::deserialize(bytes).map_err(|error| Error::State(error.to_string()))?;
        let values = |(name, view): (String, TensorView<'_>)| Ok((name, Values::read(&view)?));
        Ok(Self { tensors: read.tensors().into_iter().map(values).collect::<Result<_>>()? })
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

    fn dtype(&self) -> Dtype {
        match self {
            Self::F32(_) => Dtype::F32,
            Self::F64(_) => Dtype::F64,
            Self::U64(_) => Dtype::U64,
        }
    }

    fn to_bytes(&self) -> Vec<u8> {
        match self {
            Self::F32(values) => values.iter().flat_map(|value| value.to_le_bytes()).collect(),
            Self::F64(values) => values.iter().flat_map(|value| value.to_le_bytes()).collect(),
            Self::U64(values) => values.iter().flat_map(|value| value.to_le_bytes()).collect(),
        }
    }

    fn read(view: &TensorView<'_>) -> Result<Self> {
        let (four, eight) = (view.data().as_chunks::<4>().0.iter(), view.data().as_chunks::<8>().0.iter());
        match view.dtype() {
            Dtype::F32 => Ok(Self::F32(four.map(|value| f32::from_le_bytes(*value)).collect())),
            Dtype::F64 => Ok(Self::F64(eight.map(|value| f64::from_le_bytes(*value)).collect())),
            Dtype::U64 => Ok(Self::U64(eight.map(|value| u64::from_le_bytes(*value)).collect())),
            other => Err(Error::State(format!("unknown type `{other}`; expected F32, F64 or U64"))),
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
