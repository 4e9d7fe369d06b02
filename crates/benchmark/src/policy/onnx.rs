//! A policy in an ONNX file, as learning libraries export them.

use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use b2b_control::Controller;
use b2b_env::ActionSpace;
use b2b_env::Spaces;
use serde::{Deserialize, Serialize};
use tract_onnx::prelude::*;
use tract_onnx::tract_hir::internal::{DimLike, Factoid, format_err};

use super::{Beginning, Interface, Policy};
use crate::error::at;
use crate::subject::hex;
use crate::{Error, Result};

/// What the numbers that a policy gives mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ActionScale {
    /// -1 is the lowest and 1 the highest value of an actuator; what is beyond is cut off.
    #[default]
    Rescaled,
    /// Physical units; what is out of bounds is cut off by the environment, and counted.
    Physical,
}

/// A policy in an ONNX file: takes one float32 array [1, observation], as the environment has it and without any
/// scaling of its own, and gives one float32 array [1, action]. Of several outputs the first counts.
#[derive(Debug)]
pub struct OnnxPolicy {
    path: PathBuf,
    name: String,
    identity: String,
    scale: ActionScale,
    model: InferenceModel,
    /// The last that was made: buildings of one type share their shapes.
    made: Mutex<Option<(usize, Arc<TypedRunnableModel>)>>,
}

impl OnnxPolicy {
    /// Reads a file.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::NoOnnx`]; [`Error::NoPolicy`] for another number of inputs, or none of float32.
    pub fn read(path: &Path, scale: ActionScale) -> Result<Self> {
        let bytes = std::fs::read(path).map_err(at(path))?;
        let no_onnx = |why: String| Error::NoOnnx { path: path.to_owned(), why };
        let model = tract_onnx::onnx().model_for_read(&mut Cursor::new(&bytes));
        let model = model.map_err(|error| no_onnx(words(&error)))?;
        if model.nodes().is_empty() {
            return Err(no_onnx("there is no graph in it".into()));
        }
        let inputs = model.input_outlets().map_err(|error| no_onnx(words(&error)))?.len();
        let outputs = model.output_outlets().map_err(|error| no_onnx(words(&error)))?.len();
        if inputs != 1 || outputs == 0 {
            let why = format!("it has {inputs} inputs and {outputs} outputs");
            return Err(Error::NoPolicy { path: path.to_owned(), why });
        }
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let identity = format!("onnx {}, actions {scale:?}", hex(&bytes)).to_lowercase();
        Ok(Self { path: path.to_owned(), name, identity, scale, model, made: Mutex::default() })
    }

    /// Numbers that it takes, if it says so.
    fn width(&self) -> Option<usize> {
        let fact = self.model.input_fact(0).ok()?;
        let dimensions = fact.shape.dims().count();
        let last = fact.shape.dims().nth(dimensions.checked_sub(1)?)?.concretize()?;
        last.to_usize().ok()
    }

    /// The model for an observation of so many numbers.
    fn for_width(&self, width: usize) -> Result<Arc<TypedRunnableModel>> {
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((known, model)) = &*made
            && *known == width
        {
            return Ok(Arc::clone(model));
        }
        let make = || -> TractResult<_> {
            let input = InferenceFact::dt_shape(f32::datum_type(), tvec!(1, width));
            self.model.clone().with_input_fact(0, input)?.into_optimized()?.into_runnable()
        };
        let model =
            make().map_err(|error| Error::NoPolicy { path: self.path.clone(), why: words(&error) })?;
        *made = Some((width, Arc::clone(&model)));
        Ok(model)
    }

    fn check_observation(&self, spaces: &Spaces, interface: &Interface) -> Result<()> {
        let slots = &interface.observation;
        match self.width() {
            Some(given) if given != slots.len() => Err(Error::ObservationShape {
                policy: self.path.display().to_string(),
                given,
                building: spaces.building.name.clone(),
                task: spaces.episode.task.to_string(),
                slots: slots.clone(),
            }),
            _ => Ok(()),
        }
    }

    /// Tries the model once.
    fn check_action(
        &self,
        model: &Arc<TypedRunnableModel>,
        spaces: &Spaces,
        interface: &Interface,
    ) -> Result<()> {
        let given = self.infer(model, &vec![0.0; interface.observation.len()])?.len();
        if given == interface.action.len() {
            return Ok(());
        }
        Err(Error::ActionShape {
            policy: self.path.display().to_string(),
            given,
            building: spaces.building.name.clone(),
            slots: interface.action.names().to_vec(),
        })
    }

    fn infer(&self, model: &Arc<TypedRunnableModel>, observation: &[f32]) -> Result<Vec<f32>> {
        infer(model, observation)
            .map_err(|error| Error::NoPolicy { path: self.path.clone(), why: words(&error) })
    }
}

impl Policy for OnnxPolicy {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn identity(&self) -> String {
        self.identity.clone()
    }

    fn controller(&self, beginning: Beginning<'_>) -> Result<Box<dyn Controller>> {
        let Beginning { spaces, interface, .. } = beginning;
        self.check_observation(spaces, interface)?;
        let model = self.for_width(interface.observation.len())?;
        self.check_action(&model, spaces, interface)?;
        Ok(Box::new(OnnxController {
            model,
            scale: self.scale,
            space: interface.action.clone(),
            observation: vec![0.0; interface.observation.len()],
        }))
    }
}

/// An ONNX policy in an episode.
struct OnnxController {
    model: Arc<TypedRunnableModel>,
    scale: ActionScale,
    space: ActionSpace,
    observation: Vec<f32>,
}

impl Controller for OnnxController {
    fn reset(&mut self) {}

    fn act(&mut self, observation: &[f64], action: &mut [f64]) {
        for (single, value) in self.observation.iter_mut().zip(observation) {
            *single = *value as f32;
        }
        // It was tried on these shapes; if it fails all the same, the environment names the action that is no number.
        let given = infer(&self.model, &self.observation).unwrap_or_default();
        action.fill(f64::NAN);
        for (index, (value, given)) in action.iter_mut().zip(given).enumerate() {
            let (low, high) = (self.space.low()[index], self.space.high()[index]);
            *value = self.scale.value(f64::from(given), low, high);
        }
    }
}

impl ActionScale {
    /// The value of an actuator, in its unit, for a number of the policy.
    fn value(self, given: f64, low: f64, high: f64) -> f64 {
        match self {
            Self::Physical => given,
            Self::Rescaled => b2b_env::rescale(given.clamp(-1.0, 1.0), low, high),
        }
    }
}

fn infer(model: &Arc<TypedRunnableModel>, observation: &[f32]) -> TractResult<Vec<f32>> {
    let input = Tensor::from_shape(&[1, observation.len()], observation)?;
    let outputs = model.run(tvec!(input.into_tvalue()))?;
    let output = outputs.first().ok_or_else(|| format_err!("it gives nothing"))?;
    Ok(output.to_plain_array_view::<f32>()?.iter().copied().collect())
}

/// An error of the library, with what caused it, in one line.
fn words(error: &TractError) -> String {
    let all: Vec<String> = error.chain().map(|cause| cause.to_string().replace('\n', " ")).collect();
    all.join(": ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn minus_one_and_one_are_the_bounds_and_nothing_is_beyond() {
        let value = |given| ActionScale::Rescaled.value(given, 10.0, 30.0);
        assert_eq!([-1.0, 0.0, 1.0, 7.0].map(value), [10.0, 20.0, 30.0, 30.0]);
        assert!(value(f64::NAN).is_nan(), "the environment refuses it by name");
        assert_eq!(ActionScale::Physical.value(7.0, 10.0, 30.0), 7.0);
    }

    #[test]
    fn a_file_that_is_no_model_is_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("policy.onnx");
        for bytes in [&b"this is no model"[..], b"", b"{\"a\": 1}"] {
            std::fs::write(&path, bytes).unwrap();
            let said = OnnxPolicy::read(&path, ActionScale::Rescaled).unwrap_err().to_string();
            assert!(said.contains("policy.onnx is no ONNX model"), "{said}");
        }
        let said = OnnxPolicy::read(&folder.path().join("none.onnx"), ActionScale::Rescaled).unwrap_err();
        assert!(said.to_string().contains("none.onnx"), "{said}");
    }
}
