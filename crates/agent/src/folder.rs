//! The folder of an agent: `agent.json` and `weights.safetensors`.

use std::path::Path;

use b2b_base::aside;
use b2b_base::digest::sha256;
use b2b_base::seal;
use b2b_building::morphology::NodeType;
use safetensors::tensor::{Dtype, TensorView};
use safetensors::{SafeTensors, serialize};

use crate::error::at;
use crate::info::{AgentInfo, FORMAT};
use crate::network::graph::NodeWidths;
use crate::network::recurrent::GATES;
use crate::network::{Actor, Distribution, Recurrent, Shape, Tensor};
use crate::{Error, Result};

/// The file that describes an agent.
pub const INFO: &str = "agent.json";
/// The file of its weights.
const WEIGHTS: &str = "weights.safetensors";
/// The files of an agent.
pub const FILES: [&str; 2] = [INFO, WEIGHTS];

/// The format of descriptions that do not state their own SHA-256.
const UNSEALED: u32 = 1;
/// The text before a description's own SHA-256.
const SEAL: &str = "\"sha256\": \"";

/// The contents of an agent's folder.
pub(crate) struct Contents {
    pub(crate) info: AgentInfo,
    pub(crate) actor: Actor,
    pub(crate) sha256: String,
}

/// Reads a folder.
pub(crate) fn read(path: &Path) -> Result<Contents> {
    let damaged = |why: String| Error::Damaged { path: path.to_owned(), why };
    let not_an_agent = |why: String| Error::NotAnAgent { path: path.to_owned(), why };
    let text = std::fs::read(path.join(INFO)).map_err(|error| not_an_agent(format!("{INFO}: {error}")))?;
    let format: Format =
        serde_json::from_slice(&text).map_err(|error| damaged(format!("{INFO}: {error}")))?;
    match format.format {
        UNSEALED => (),
        FORMAT if seal::is_intact(&text, SEAL) == Some(true) => (),
        FORMAT => {
            return Err(damaged(format!("{INFO} was changed: it does not have the hash that it states")));
        }
        other => {
            let why = format!("its format is {other}, this version reads formats {UNSEALED} and {FORMAT}");
            return Err(not_an_agent(why));
        }
    }
    let info: AgentInfo =
        serde_json::from_slice(&text).map_err(|error| damaged(format!("{INFO}: {error}")))?;
    let bytes = std::fs::read(path.join(WEIGHTS)).map_err(|error| damaged(format!("{WEIGHTS}: {error}")))?;
    if sha256(&bytes) != info.weights {
        return Err(damaged(format!("{WEIGHTS} does not have the hash that {INFO} states")));
    }
    let actor = actor(&info, &bytes).map_err(damaged)?;
    let sha256 = sha256([&text[..], &bytes].concat());
    Ok(Contents { info, actor, sha256 })
}

/// The part of [`INFO`] common to all versions of the format.
#[derive(serde::Deserialize)]
struct Format {
    format: u32,
}

/// A description with its own SHA-256.
#[derive(serde::Serialize)]
struct SealedInfo<'a> {
    #[serde(flatten)]
    info: &'a AgentInfo,
    sha256: String,
}

/// Writes both files under temporary names, then moves them into place: the weights before the description that states
/// their hash.
pub(crate) fn write(path: &Path, mut info: AgentInfo, actor: &Actor) -> Result<()> {
    std::fs::create_dir_all(path).map_err(at(path))?;
    let bytes = weights(actor);
    info.weights = sha256(&bytes);
    let text = description(&info);
    // A description whose hash does not match its weights counts as damaged, so both files are complete before either
    // is replaced.
    let (weights, description) = (path.join(WEIGHTS), path.join(INFO));
    let new_weights = aside::write(&weights, &bytes).map_err(at(&weights))?;
    let new_description = aside::write(&description, &text).map_err(at(&description))?;
    aside::put(new_weights, &weights).map_err(at(&weights))?;
    aside::put(new_description, &description).map_err(at(&description))
}

/// Returns the bytes of a description.
fn description(info: &AgentInfo) -> Vec<u8> {
    let info = SealedInfo { info, sha256: seal::open() };
    let mut text = serde_json::to_vec_pretty(&info).expect("plain data always serializes");
    assert!(seal::set(&mut text, SEAL), "it has an open seal");
    text
}

/// Returns the bytes of a weights file: the named tensors of an actor, f32.
fn weights(actor: &Actor) -> Vec<u8> {
    let bytes =
        |tensor: Tensor| (name(&tensor), tensor.sizes, little_endian(&actor.parameters[tensor.place]));
    let tensors: Vec<(String, Vec<usize>, Vec<u8>)> = actor.shape.tensors().into_iter().map(bytes).collect();
    let views = tensors.iter().map(|(name, shape, bytes)| {
        let view = TensorView::new(Dtype::F32, shape.clone(), bytes);
        (name.clone(), view.expect("the bytes match the shape"))
    });
    serialize(views, None).expect("tensors of one type always serialize")
}

/// Returns the actor with the weights of a file.
fn actor(info: &AgentInfo, bytes: &[u8]) -> std::result::Result<Actor, String> {
    let tensors = SafeTensors::deserialize(bytes).map_err(|error| format!("{WEIGHTS}: {error}"))?;
    let shape = info.network.clone();
    if !fits(&shape, &tensors, bytes.len() / size_of::<f32>()) {
        return Err(format!("{INFO}: its network is larger than {WEIGHTS}"));
    }
    check_shape(info).map_err(|why| format!("{INFO}: {why}"))?;
    let mut parameters = vec![0.0; shape.parameters()];
    for expected in shape.tensors() {
        let name = name(&expected);
        let tensor = tensors.tensor(&name).map_err(|error| format!("{WEIGHTS}: {error}"))?;
        if tensor.shape() != expected.sizes || tensor.dtype() != Dtype::F32 {
            let (found, expected) = (tensor.shape(), expected.sizes);
            return Err(format!("{WEIGHTS}: {name} has the shape {found:?}, expected {expected:?}"));
        }
        let values = parameters[expected.place].iter_mut();
        for (value, bytes) in values.zip(tensor.data().chunks_exact(4)) {
            *value = f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
        }
    }
    let actor = Actor { shape, parameters, distribution: info.distribution.clone() };
    match actor.parameters.iter().position(|value| !value.is_finite()) {
        Some(_) => Err(format!("{WEIGHTS} has a value that is not finite")),
        None => Ok(actor),
    }
}

/// Returns whether a file has a value for every parameter of a network. Compares the sizes first, because a product of
/// absurd sizes overflows.
fn fits(shape: &Shape, tensors: &SafeTensors<'_>, values: usize) -> bool {
    let fit = |sizes: &[usize]| sizes.iter().all(|&size| size <= values);
    let sizes_fit = match shape {
        Shape::Mlp(mlp) => fit(&mlp.widths),
        Shape::Recurrent(network) => fit(&network.encoder.widths) && fit(&network.head.widths),
        Shape::Graph(network) => {
            let of_nodes = |node: &NodeWidths| fit(&[node.features, node.outputs]);
            fit(&[network.embedding, network.heads, network.feed_forward, network.memory])
                && network.types.iter().all(of_nodes)
                && network.layers <= tensors.len()
        }
    };
    sizes_fit && shape.parameters() <= values
}

/// Checks that the network has the widths of the observation and the actuators.
fn check_shape(info: &AgentInfo) -> std::result::Result<(), &'static str> {
    let halves = if matches!(info.distribution, Distribution::Gaussian { .. }) { 1 } else { 2 };
    let widths = (info.slots.len(), info.actuators.len() * halves);
    let log_stds = match &info.distribution {
        Distribution::Gaussian { log_std } => log_std.len(),
        _ => info.actuators.len(),
    };
    let found = match &info.network {
        Shape::Mlp(mlp) if mlp.widths.len() < 2 => return Err("its network has no layers"),
        Shape::Mlp(mlp) => (mlp.inputs(), mlp.outputs()),
        Shape::Recurrent(Recurrent { encoder, head }) => match (&encoder.widths[..], &head.widths[..]) {
            ([inputs, .., gates], [state, .., outputs]) if *gates == GATES * state => (*inputs, *outputs),
            _ => return Err("the outputs of its encoder are not three times the width of its state"),
        },
        // An agent saved before a node type was added has fewer.
        Shape::Graph(network) if network.types.len() > NodeType::ALL.len() => {
            return Err("its network has more node types than this version");
        }
        Shape::Graph(network) if network.heads == 0 || !network.embedding.is_multiple_of(network.heads) => {
            return Err("the embedding of its network is not divisible by its number of heads");
        }
        Shape::Graph(network) => {
            let sum = |width: fn(&NodeWidths) -> usize| network.types.iter().map(width).sum();
            (sum(|node| node.features), sum(|node| node.outputs))
        }
    };
    if found != widths || log_stds != info.actuators.len() {
        return Err("the widths of the network do not match the observation and the actuators");
    }
    Ok(())
}

fn name(tensor: &Tensor) -> String {
    format!("actor.{}", tensor.name)
}

fn little_endian(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}
