//! States of recurrent networks in ONNX files.

use rten::{Dimension, Model};
use rten_tensor::Tensor;

/// Maximum number of values of a state. Policies have hundreds.
const MOST_VALUES: usize = 1 << 20;

/// What a network keeps from one step to the next, float32. It begins with zeros.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct OnnxState {
    /// Extents of its dimensions; one that the file does not fix is the batch, 1.
    shape: Vec<usize>,
}

impl OnnxState {
    /// Returns the states of a model: its inputs after the observation, in order.
    ///
    /// # Errors
    /// Why a policy cannot have the inputs and outputs of the model.
    pub(super) fn all(model: &Model) -> Result<Vec<Self>, String> {
        let (inputs, outputs) = (model.input_ids().len(), model.output_ids().len());
        if inputs == 0 || outputs < inputs {
            return Err(format!(
                "it has {inputs} inputs and {outputs} outputs; expected an observation and states, an action and the \
                 next states"
            ));
        }
        (1..inputs).map(|number| Self::of(model, number)).collect()
    }

    /// Returns the state of an input.
    fn of(model: &Model, number: usize) -> Result<Self, String> {
        let name = model.node_info(model.input_ids()[number]);
        let name = name.and_then(|node| node.name().map(str::to_owned)).unwrap_or_default();
        let shape = |dimensions: Option<Vec<Dimension>>| {
            let dimensions = dimensions?;
            let free = |dimension: &&Dimension| matches!(dimension, Dimension::Symbolic(_));
            let extent = |dimension: &Dimension| match dimension {
                Dimension::Fixed(extent) => *extent,
                Dimension::Symbolic(_) => 1,
            };
            (dimensions.iter().filter(free).count() <= 1).then(|| dimensions.iter().map(extent).collect())
        };
        let shape: Vec<usize> = shape(model.input_shape(number)).ok_or_else(|| {
            format!("the shape of its state `{name}` is unknown; export it with fixed dimensions")
        })?;
        let values = shape.iter().try_fold(1_usize, |values, extent| values.checked_mul(*extent));
        if values.is_none_or(|values| values > MOST_VALUES) {
            return Err(format!("its state `{name}` of shape {shape:?} has more than {MOST_VALUES} values"));
        }
        Ok(Self { shape })
    }

    /// Returns the state at the beginning of an episode.
    pub(super) fn first(&self) -> Tensor<f32> {
        Tensor::zeros(&self.shape)
    }
}
