//! Policies in ONNX files, as learning libraries export them.

use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use b2b_control::Controller;
use b2b_energyplus::digest::sha256;
use b2b_env::ActionSpace;
use b2b_env::Spaces;
use tract_onnx::prelude::*;
use tract_onnx::tract_hir::internal::{DimLike, Factoid, format_err};

use super::action_scale::ActionScale;
use super::interface::{EpisodeContext, Interface, Policy};
use crate::error::at;
use crate::{Error, Result};

/// A policy in an ONNX file. Takes one float32 array [1, observation], the environment's observation without scaling,
/// and returns one float32 array [1, action]; of several outputs the first is used.
#[derive(Debug)]
pub struct OnnxPolicy {
    path: PathBuf,
    name: String,
    identity: String,
    scale: ActionScale,
    model: InferenceModel,
    /// The last optimized model with its width: buildings of one type share their shapes.
    optimized: Mutex<Option<(usize, Arc<TypedRunnableModel>)>>,
}

impl OnnxPolicy {
    /// Reads an ONNX file.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::InvalidOnnx`]; [`Error::InvalidPolicy`] unless there is one input and at least one output.
    pub fn read(path: &Path, scale: ActionScale) -> Result<Self> {
        let bytes = std::fs::read(path).map_err(at(path))?;
        let invalid = |why: String| Error::InvalidOnnx { path: path.to_owned(), why };
        let model = tract_onnx::onnx().model_for_read(&mut Cursor::new(&bytes));
        let model = model.map_err(|error| invalid(chain(&error)))?;
        if model.nodes().is_empty() {
            return Err(invalid("it contains no graph".into()));
        }
        let inputs = model.input_outlets().map_err(|error| invalid(chain(&error)))?.len();
        let outputs = model.output_outlets().map_err(|error| invalid(chain(&error)))?.len();
        if inputs != 1 || outputs == 0 {
            let why = format!("it has {inputs} inputs and {outputs} outputs");
            return Err(Error::InvalidPolicy { path: path.to_owned(), why });
        }
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let identity = format!("onnx {}, actions {scale:?}", sha256(&bytes)).to_lowercase();
        Ok(Self { path: path.to_owned(), name, identity, scale, model, optimized: Mutex::default() })
    }

    /// Returns the width of the input, if the model declares it.
    fn input_width(&self) -> Option<usize> {
        let fact = self.model.input_fact(0).ok()?;
        let dimensions = fact.shape.dims().count();
        let last = fact.shape.dims().nth(dimensions.checked_sub(1)?)?.concretize()?;
        last.to_usize().ok()
    }

    /// Returns the model for observations of `width` values.
    fn for_width(&self, width: usize) -> Result<Arc<TypedRunnableModel>> {
        let mut optimized = self.optimized.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((known, model)) = &*optimized
            && *known == width
        {
            return Ok(Arc::clone(model));
        }
        let optimize = || -> TractResult<_> {
            let input = InferenceFact::dt_shape(f32::datum_type(), tvec!(1, width));
            self.model.clone().with_input_fact(0, input)?.into_optimized()?.into_runnable()
        };
        let model = optimize()
            .map_err(|error| Error::InvalidPolicy { path: self.path.clone(), why: chain(&error) })?;
        *optimized = Some((width, Arc::clone(&model)));
        Ok(model)
    }

    fn check_observation(&self, spaces: &Spaces, interface: &Interface) -> Result<()> {
        let slots = &interface.observation;
        match self.input_width() {
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

    /// Runs the model once and checks the width of its output.
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
            .map_err(|error| Error::InvalidPolicy { path: self.path.clone(), why: chain(&error) })
    }
}

impl Policy for OnnxPolicy {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn identity(&self) -> String {
        self.identity.clone()
    }

    fn controller(&self, context: EpisodeContext<'_>) -> Result<Box<dyn Controller>> {
        let EpisodeContext { spaces, interface, .. } = context;
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

/// The controller of an ONNX policy in an episode.
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
        // The model ran on these shapes before; if it fails now, the environment names the action that is not a number.
        let inferred = infer(&self.model, &self.observation).unwrap_or_default();
        action.fill(f64::NAN);
        for (value, inferred) in action.iter_mut().zip(inferred) {
            *value = f64::from(inferred);
        }
        self.scale.to_physical(&self.space, action);
    }
}

fn infer(model: &Arc<TypedRunnableModel>, observation: &[f32]) -> TractResult<Vec<f32>> {
    let input = Tensor::from_shape(&[1, observation.len()], observation)?;
    let outputs = model.run(tvec!(input.into_tvalue()))?;
    let output = outputs.first().ok_or_else(|| format_err!("the model has no output"))?;
    Ok(output.to_plain_array_view::<f32>()?.iter().copied().collect())
}

/// Formats an error with its causes in one line.
fn chain(error: &TractError) -> String {
    let all: Vec<String> = error.chain().map(|cause| cause.to_string().replace('\n', " ")).collect();
    all.join(": ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_without_a_model_is_an_error_that_names_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("policy.onnx");
        for bytes in [&b"this is no model"[..], b"", b"{\"a\": 1}"] {
            std::fs::write(&path, bytes).unwrap();
            let said = OnnxPolicy::read(&path, ActionScale::Rescaled).unwrap_err().to_string();
            assert!(said.contains("policy.onnx is not a valid ONNX model"), "{said}");
        }
        let said = OnnxPolicy::read(&folder.path().join("none.onnx"), ActionScale::Rescaled).unwrap_err();
        assert!(said.to_string().contains("none.onnx"), "{said}");
    }
}
