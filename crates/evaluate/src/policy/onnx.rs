//! Policies in ONNX files, as learning libraries export them.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use b2b_agent::network::MemorySpan;
use b2b_base::digest::sha256;
use b2b_control::Controller;
use b2b_env::ActionSpace;
use b2b_env::Spaces;
use rten::{Dimension, Model, RunError, RunOptions, ThreadPool, ValueOrView};
use rten_tensor::prelude::*;
use rten_tensor::{NdTensorView, Tensor};

use super::action_scale::ActionScale;
use super::interface::{EpisodeContext, Policy, PolicyInterface};
use super::limited::{self, LIMIT, Limited};
use super::onnx_format;
use super::onnx_state::OnnxState;
use crate::error::at;
use crate::panics::catch_panic;
use crate::{Error, Result};

/// A policy in an ONNX file. Its first input is the environment's observation without scaling, float32 [1,
/// observation]; its first output the action, float32 [1, action]. Every further input is a state, which the output of
/// the same number replaces at every step. The states are its memory. If a problem has several episodes in a building,
/// they are kept for `memory_episodes` episodes, a number in the file's metadata; for all without it.
#[derive(Debug)]
pub struct OnnxPolicy {
    path: PathBuf,
    name: String,
    identity: String,
    scale: ActionScale,
    model: Arc<Model>,
    states: Vec<OnnxState>,
    memory: MemorySpan,
}

impl OnnxPolicy {
    /// Reads an ONNX file.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::InvalidOnnx`]; [`Error::InvalidPolicy`] without an input or an output, for a state
    /// without an output or of unknown shape, or for metadata that is not a number of episodes.
    pub fn read(path: &Path, scale: ActionScale) -> Result<Self> {
        let bytes = std::fs::read(path).map_err(at(path))?;
        let identity = format!("onnx {}, actions {scale:?}", sha256(&bytes)).to_lowercase();
        let invalid = |why: String| Error::InvalidOnnx { path: path.to_owned(), why };
        onnx_format::check(&bytes).map_err(invalid)?;
        let load = limited::once(move || guarded(|| Model::load(bytes))).map_err(at(path))?;
        let model = load.unwrap_or_else(|| Err(endless())).map_err(invalid)?;
        let unusable = |why| Error::InvalidPolicy { path: path.to_owned(), why };
        let states = OnnxState::all(&model).map_err(unusable)?;
        let memory = memory_of(&model).map_err(unusable)?;
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Self { path: path.to_owned(), name, identity, scale, model: Arc::new(model), states, memory })
    }

    /// Returns the width of the input, if the model declares it.
    fn input_width(&self) -> Option<usize> {
        match self.model.input_shape(0)?.pop()? {
            Dimension::Fixed(width) => Some(width),
            Dimension::Symbolic(_) => None,
        }
    }

    fn check_observation(&self, spaces: &Spaces, interface: &PolicyInterface) -> Result<()> {
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
        inference: &mut Inference,
        spaces: &Spaces,
        interface: &PolicyInterface,
    ) -> Result<()> {
        let output = inference.run(&vec![0.0; interface.observation.len()]);
        let given = output.map_err(|why| Error::InvalidPolicy { path: self.path.clone(), why })?.len();
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
}

impl Policy for OnnxPolicy {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn identity(&self) -> String {
        self.identity.clone()
    }

    fn observation_width(&self) -> Option<usize> {
        self.input_width()
    }

    fn has_memory(&self) -> bool {
        !self.states.is_empty()
    }

    fn controller(&self, context: EpisodeContext<'_>) -> Result<Box<dyn Controller>> {
        let EpisodeContext { spaces, interface, .. } = context;
        self.check_observation(spaces, interface)?;
        let mut inference = Inference::new(&self.model, &self.states).map_err(at(&self.path))?;
        self.check_action(&mut inference, spaces, interface)?;
        inference.reset();
        Ok(Box::new(OnnxController {
            inference,
            memory: self.memory,
            scale: self.scale,
            space: interface.action.clone(),
            observation: vec![0.0; interface.observation.len()],
        }))
    }
}

/// Returns the episodes that the states of a model span.
///
/// # Errors
/// Why its metadata is not a number of episodes.
fn memory_of(model: &Model) -> std::result::Result<MemorySpan, String> {
    let Some(text) = model.metadata().get(MemorySpan::KEY) else { return Ok(MemorySpan::new(None)) };
    match text.parse::<u32>() {
        Ok(episodes) if episodes > 0 => Ok(MemorySpan::new(Some(episodes))),
        _ => Err(format!("its metadata `{}` is `{text}`; expected a whole number from 1", MemorySpan::KEY)),
    }
}

/// The controller of an ONNX policy in an episode.
struct OnnxController {
    inference: Inference,
    memory: MemorySpan,
    scale: ActionScale,
    space: ActionSpace,
    observation: Vec<f32>,
}

impl Controller for OnnxController {
    fn reset(&mut self) {
        self.inference.reset();
        self.memory.reset();
    }

    /// Keeps the states for as many episodes as the file says.
    fn next_episode(&mut self) {
        if self.memory.next_episode() {
            self.inference.reset();
        }
    }

    fn act(&mut self, observation: &[f64], action: &mut [f64]) {
        for (single, value) in self.observation.iter_mut().zip(observation) {
            *single = *value as f32;
        }
        // The model ran on these shapes before. If it fails now or never ends, the environment reports the NaN action.
        let inferred = self.inference.run(&self.observation).unwrap_or_default();
        action.fill(f64::NAN);
        for (value, inferred) in action.iter_mut().zip(inferred) {
            *value = f64::from(inferred);
        }
        self.scale.to_physical(&self.space, action);
    }
}

/// Runs a model on one dedicated thread, with a time limit. One thread keeps the order of sums the same on any number
/// of cores.
struct Inference(Limited<Option<Vec<f32>>, Output>);

/// The first output of a model, or why it has none.
type Output = std::result::Result<Vec<f32>, String>;

impl Inference {
    fn new(model: &Arc<Model>, states: &[OnnxState]) -> std::io::Result<Self> {
        let (model, thread) = (Arc::clone(model), Arc::new(ThreadPool::with_num_threads(1)));
        let options = RunOptions::default().with_thread_pool(Some(thread));
        let first: Vec<Tensor<f32>> = states.iter().map(OnnxState::first).collect();
        let mut memory = first.clone();
        let run = move |observation: Option<Vec<f32>>| match observation {
            Some(observation) => {
                let action = guarded(|| infer(&model, &options, &observation, &mut memory))?;
                let changed = first.iter().zip(&memory).find(|(first, now)| first.shape() != now.shape());
                changed.map_or(Ok(action), |(first, now)| {
                    Err(format!(
                        "a state of shape {:?} becomes one of shape {:?}",
                        first.shape(),
                        now.shape()
                    ))
                })
            }
            None => {
                memory.clone_from(&first);
                Ok(Vec::new())
            }
        };
        Ok(Self(Limited::new(run)?))
    }

    /// Returns the first output for an observation.
    fn run(&mut self, observation: &[f32]) -> Output {
        self.0.call(Some(observation.to_vec())).unwrap_or_else(|| Err(endless()))
    }

    /// Sets the states to zero.
    fn reset(&mut self) {
        // A network that never ended gives no more actions.
        let _ = self.0.call(None);
    }
}

fn endless() -> String {
    format!("it was not finished within {} s", LIMIT.as_secs())
}

/// Returns the first output of a model for an observation and the states, and replaces these.
fn infer(
    model: &Model,
    options: &RunOptions,
    observation: &[f32],
    states: &mut [Tensor<f32>],
) -> std::result::Result<Vec<f32>, RunError> {
    let input = NdTensorView::from_data([1, observation.len()], observation);
    let values = std::iter::once(ValueOrView::from(input))
        .chain(states.iter().map(|state| ValueOrView::from(state.view())));
    let inputs = model.input_ids().iter().copied().zip(values).collect();
    let mut values = model.run(inputs, &model.output_ids()[..=states.len()], Some(options.clone()))?;
    for (state, value) in states.iter_mut().zip(values.drain(1..)) {
        if let Some(next) = value.into_tensor::<f32>() {
            *state = next;
        }
    }
    Ok(values.swap_remove(0).into_tensor::<f32>().map(|tensor| tensor.to_vec()).unwrap_or_default())
}

/// Runs a function of the ONNX library and turns its panics into errors of one line.
fn guarded<T, E: std::error::Error>(
    run: impl FnOnce() -> std::result::Result<T, E>,
) -> std::result::Result<T, String> {
    let result = catch_panic(run).map_err(|panic| format!("it cannot be run: {panic}"))?;
    result.map_err(|error| error.to_string().replace('\n', " "))
}

#[cfg(test)]
mod tests {
    use b2b_agent::protobuf::{bytes, integer, text};

    use super::*;

    /// Returns a value of shape [1, width].
    fn value(name: &str, width: u64) -> Vec<u8> {
        let shape = [bytes(1, &integer(1, 1)), bytes(1, &integer(1, width))].concat();
        let tensor = [integer(1, 1), bytes(2, &shape)].concat();
        [text(1, name), bytes(2, &bytes(1, &tensor))].concat()
    }

    /// Returns a model of a graph.
    fn model(graph: &[Vec<u8>]) -> Vec<u8> {
        let opset = [text(1, ""), integer(2, 17)].concat();
        [integer(1, 8), bytes(7, &graph.concat()), bytes(8, &opset)].concat()
    }

    /// Returns a model that is a chain of nodes.
    fn chain(nodes: usize) -> Vec<u8> {
        let name = |place: usize| format!("value {place}");
        let node =
            |place| bytes(1, &[text(1, &name(place)), text(2, &name(place + 1)), text(4, "Relu")].concat());
        model(&[
            (0..nodes).flat_map(node).collect(),
            text(2, "chain"),
            bytes(11, &value(&name(0), 2)),
            bytes(12, &value(&name(nodes), 2)),
        ])
    }

    /// Returns a model whose state, of a width, adds up the observations; its action is the sum up to the last step.
    fn sum(width: u64, outputs: &[&str]) -> Vec<u8> {
        let add = [text(1, "sum"), text(1, "observation"), text(2, "next sum"), text(4, "Add")].concat();
        let keep = [text(1, "sum"), text(2, "action"), text(4, "Identity")].concat();
        let mut graph = vec![bytes(1, &add), bytes(1, &keep), text(2, "sum")];
        graph.extend([bytes(11, &value("observation", 2)), bytes(11, &value("sum", width))]);
        graph.extend(outputs.iter().map(|name| bytes(12, &value(name, 2))));
        model(&graph)
    }

    #[test]
    fn a_state_is_kept_from_step_to_step_and_begins_every_episode_with_zeros() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("policy.onnx");
        let read = |bytes: Vec<u8>| {
            std::fs::write(&path, bytes).unwrap();
            OnnxPolicy::read(&path, ActionScale::Physical)
        };
        let policy = read(sum(2, &["action", "next sum"])).unwrap();
        let mut inference = Inference::new(&policy.model, &policy.states).unwrap();
        for _ in 0..2 {
            let actions: Vec<_> = (0..3).map(|_| inference.run(&[1.0, -2.0]).unwrap()).collect();
            assert_eq!(actions, [[0.0, 0.0], [1.0, -2.0], [2.0, -4.0]]);
            inference.reset();
        }
        let said = read(sum(2, &["action"])).unwrap_err().to_string();
        assert!(said.contains("2 inputs and 1 outputs; expected an observation and states"), "{said}");
        let said = read(sum(1 << 40, &["action", "next sum"])).unwrap_err().to_string();
        assert!(said.contains("its state `sum`") && said.contains("more than"), "{said}");
        let wider = read(sum(1, &["action", "next sum"])).unwrap();
        let said = Inference::new(&wider.model, &wider.states).unwrap().run(&[1.0, -2.0]).unwrap_err();
        assert!(said.contains("a state of shape [1, 1] becomes one of shape [1, 2]"), "{said}");
    }

    #[test]
    fn a_chain_of_nodes_runs_on_the_stack_of_a_thread_or_is_rejected() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("policy.onnx");
        let read = |nodes| {
            std::fs::write(&path, chain(nodes)).unwrap();
            OnnxPolicy::read(&path, ActionScale::Rescaled)
        };
        std::thread::scope(|scope| {
            let longest = scope.spawn(|| {
                let policy = read(onnx_format::MOST_NODES).unwrap();
                Inference::new(&policy.model, &[]).unwrap().run(&[1.0, -1.0]).unwrap()
            });
            assert_eq!(longest.join().unwrap(), [1.0, 0.0]);
        });
        for nodes in [onnx_format::MOST_NODES + 1, 50_000] {
            let said = read(nodes).unwrap_err().to_string();
            assert!(said.contains("more than 4000 nodes"), "{said}");
        }
    }

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
