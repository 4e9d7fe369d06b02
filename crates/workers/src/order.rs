//! The protocol: the orders of an owner and the replies of its workers, as JSON.
//!
//! A worker is started with one order in a file, `{"order": "convert", "of": {…}}`:
//!
//! - `episode` turns the worker into an environment, which then receives steps, copies and `fragment` orders through
//!   shared memory.
//! - `action` is work of a crate above this one, such as a job of an experiment: see [`Actions`](super::Actions).
//! - Every other order is a job: the worker carries it out, writes its [`Reply`] and ends.

use std::path::{Path, PathBuf};

use b2b_building::PreparedBuilding;
use b2b_energyplus::{Library, Messages};
use b2b_env::{Env, EpisodeConfig, Error};
use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;

use super::region::Ticket;
use super::setting::Source;

/// An order of an owner to a worker.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(tag = "order", content = "of", rename_all = "snake_case")]
pub(super) enum Order {
    /// Prepare a building up to the end of warm-up, to be copied and stepped.
    Episode(Box<EpisodeOrder>),
    /// Run a part of the episode.
    Fragment(FragmentOrder),
    /// Convert an IDF file to epJSON text.
    Convert(Convert),
    /// Run a model over a weather file to its end: for its sizes, or for its energy.
    Simulate(Simulate),
    /// Check the response of a building to its actuators.
    Authority(Box<AuthorityOrder>),
    /// Carry out an action of the program.
    Action(ActionOrder),
}

/// The environment of a template process.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct EpisodeOrder {
    /// Its slot in the shared memory, which is its standard input.
    pub(super) ticket: Ticket,
    /// The engine's library.
    pub(super) library: PathBuf,
    pub(super) source: Source,
    pub(super) episode: EpisodeConfig,
}

impl EpisodeOrder {
    /// Creates the environment, before its first reset.
    pub(super) fn env(self) -> Result<Env, Box<dyn std::error::Error>> {
        let library = Library::load(&self.library)?;
        let building = self.source.prepare(&library).map_err(Error::building)?;
        Ok(Env::new(library, building.into(), self.episode)?)
    }
}

/// A part of an episode that its worker runs without its owner.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct FragmentOrder {
    /// Kind of the runner: see [`Runners`](super::Runners).
    pub(super) runner: String,
    /// Order, in the runner's own format.
    pub(super) order: Box<RawValue>,
}

/// A conversion.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Convert {
    pub(super) library: PathBuf,
    pub(super) idf: PathBuf,
}

/// A run of a model to its end.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Simulate {
    pub(super) library: PathBuf,
    pub(super) model: PathBuf,
    pub(super) weather: PathBuf,
    /// Folder of the engine's output.
    pub(super) output: PathBuf,
}

/// A response check.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct AuthorityOrder {
    pub(super) library: PathBuf,
    pub(super) building: PreparedBuilding,
    pub(super) weather: PathBuf,
}

/// An action.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct ActionOrder {
    /// Its name: see [`Actions`](super::Actions).
    pub(super) action: String,
    /// Order, in the action's own format.
    pub(super) order: Box<RawValue>,
}

impl Order {
    /// Name of the order, its tag.
    pub(super) fn name(&self) -> &'static str {
        match self {
            Self::Episode(_) => "episode",
            Self::Fragment(_) => "fragment",
            Self::Convert(_) => "convert",
            Self::Simulate(_) => "simulate",
            Self::Authority(_) => "authority",
            Self::Action(_) => "action",
        }
    }

    /// Reads an order.
    ///
    /// # Errors
    /// A text that says what is wrong; for an unknown order, it lists the known ones.
    pub(super) fn parse(text: &[u8]) -> Result<Self, String> {
        serde_json::from_slice(text).map_err(|error| format!("unknown or damaged order: {error}"))
    }

    /// Returns the order as JSON.
    ///
    /// # Errors
    /// For a path that is not UTF-8, which EnergyPlus cannot read either.
    pub(super) fn to_json(&self) -> std::io::Result<Vec<u8>> {
        serde_json::to_vec(self).map_err(std::io::Error::other)
    }
}

/// The reply of a worker to a job.
#[derive(Debug, Serialize, Deserialize)]
#[serde(tag = "reply", content = "of", rename_all = "snake_case")]
pub(super) enum Reply<T> {
    /// The result.
    Done(T),
    /// The job failed.
    Failed(Failure),
}

/// Why a worker could not do a job.
#[derive(Debug, Serialize, Deserialize)]
#[serde(tag = "failure", content = "of", rename_all = "snake_case")]
pub(super) enum Failure {
    /// The engine ended the run.
    Engine {
        /// Exit code of the engine.
        code: i32,
        /// The model.
        model: PathBuf,
        /// The engine's messages.
        messages: Messages,
    },
    /// Another error, as text.
    Other(String),
}

impl From<b2b_energyplus::Error> for Failure {
    fn from(error: b2b_energyplus::Error) -> Self {
        match error {
            b2b_energyplus::Error::Engine { code, model, messages } => Self::Engine { code, model, messages },
            other => Self::Other(other.to_string()),
        }
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        match error {
            Error::Engine(error) => error.into(),
            other => Self::Other(other.to_string()),
        }
    }
}

/// The file of the reply to the order in a file.
pub(super) fn reply_file(order: &Path) -> PathBuf {
    order.with_extension("reply")
}

#[cfg(test)]
mod tests {
    use std::os::unix::ffi::OsStringExt as _;

    use super::*;

    #[test]
    fn every_order_has_its_tag_and_reads_back() {
        let (library, path) = (PathBuf::from("lib.so"), PathBuf::from("m.idf"));
        let raw = RawValue::from_string(r#"{"steps": 3}"#.into()).unwrap();
        let orders = [
            Order::Convert(Convert { library: library.clone(), idf: path.clone() }),
            Order::Simulate(Simulate { library, model: path.clone(), weather: path.clone(), output: path }),
            Order::Fragment(FragmentOrder { runner: "learner".into(), order: raw.clone() }),
            Order::Action(ActionOrder { action: "experiment".into(), order: raw }),
        ];
        for order in orders {
            let text = order.to_json().unwrap();
            let tag = format!(r#"{{"order":"{}","of":{{"#, order.name());
            assert!(text.starts_with(tag.as_bytes()), "{}", String::from_utf8_lossy(&text));
            assert_eq!(Order::parse(&text).unwrap().to_json().unwrap(), text);
        }
        let odd = PathBuf::from(std::ffi::OsString::from_vec(b"caf\xe9.idf".to_vec()));
        let said =
            Order::Convert(Convert { library: odd.clone(), idf: odd }).to_json().unwrap_err().to_string();
        assert!(said.contains("UTF-8"), "{said}");
    }

    #[test]
    fn a_runners_order_is_passed_on_unchanged() {
        let text = br#"{"order":"fragment","of":{"runner":"rollout","order":{"b": 1.50, "a":[ ]}}}"#;
        let Order::Fragment(fragment) = Order::parse(text).unwrap() else { panic!("it is a fragment") };
        assert_eq!((&*fragment.runner, fragment.order.get()), ("rollout", r#"{"b": 1.50, "a":[ ]}"#));
    }

    #[test]
    fn an_unknown_order_is_an_error_that_names_it() {
        let why = Order::parse(br#"{"order":"dance","of":{}}"#).unwrap_err();
        assert!(why.contains("`dance`") && why.contains("`convert`"), "{why}");
        let why = Order::parse(br#"{"steps": 3}"#).unwrap_err();
        assert!(why.contains("missing field `order`"), "{why}");
    }

    #[test]
    fn a_failure_keeps_the_messages_of_the_engine() {
        let text = br#"{"reply":"failed","of":{"failure":"engine","of":{"code":1,"model":"m.idf","messages":
            {"kept":[{"level":"severe","text":"no such node"}],"counts":[0,0,1,0],"last_was_kept":true,"console":[]}}}}"#;
        let reply: Reply<String> = serde_json::from_slice(text).unwrap();
        let Reply::Failed(Failure::Engine { messages, .. }) = reply else { panic!("{reply:?}") };
        assert_eq!(messages.to_string(), "  severe: no such node");
    }
}
