//! The versions that a result depends on.

use b2b_base::digest::sha256;
use b2b_building::Class;
use b2b_dataset::GENERATOR_VERSION;
use b2b_energyplus::install::ENGINE_VERSION;
use serde::{Deserialize, Serialize};

use crate::guideline36::REVISION;
use crate::{Kind, Objective, ReactiveParameters};

/// The versions that a result depends on, in addition to the policy.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Versions {
    /// Version of this package.
    pub package: String,
    /// Version of the building generator and its dataset.
    pub generator: String,
    /// Version of EnergyPlus.
    pub engine: String,
    /// Hash of the reactive controllers' parameters; empty in files of older versions.
    #[serde(default)]
    pub controllers: String,
    /// Revision of the sequences of `guideline36` ([`REVISION`]); 0 in files of older versions, which do not state it.
    #[serde(default, skip_serializing_if = "is_unknown")]
    pub guideline36: u32,
}

impl Versions {
    /// Returns the versions of this program.
    pub fn current() -> Self {
        Self {
            package: env!("CARGO_PKG_VERSION").to_owned(),
            generator: GENERATOR_VERSION.to_owned(),
            engine: ENGINE_VERSION.to_owned(),
            controllers: controllers_hash(),
            guideline36: REVISION,
        }
    }

    /// Describes the differences from other versions, if any: `dataset v0 (v1 in this program)`.
    pub fn differences(&self, here: &Self) -> Option<String> {
        let revisions = [self, here].map(|versions| versions.guideline36.to_string());
        let pairs = [
            ("package", &self.package, &here.package),
            ("dataset", &self.generator, &here.generator),
            ("EnergyPlus", &self.engine, &here.engine),
            ("reactive controllers", &self.controllers, &here.controllers),
            ("guideline36 revision", &revisions[0], &revisions[1]),
        ];
        let different = pairs.into_iter().filter(|(_, there, here)| there != here);
        let lines: Vec<_> =
            different.map(|(what, there, here)| format!("{what} {there} ({here} in this program)")).collect();
        (!lines.is_empty()).then(|| lines.join("; "))
    }
}

impl std::fmt::Display for Versions {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { package, generator, engine, controllers, guideline36 } = self;
        write!(
            f,
            "building2building {package}, dataset {generator}, EnergyPlus {engine}, reactive controllers {controllers}, \
             guideline36 revision {guideline36}"
        )
    }
}

fn is_unknown(revision: &u32) -> bool {
    *revision == 0
}

/// Returns one hash of the parameters of all reactive controllers.
fn controllers_hash() -> String {
    let classes = Class::all().map(Some).chain([None]);
    let sets = classes
        .flat_map(|class| Objective::ALL.map(|objective| ReactiveParameters::tuned(class, false, objective)));
    let all: String = sets.map(|set| parameters_hash(&set)).collect();
    short(sha256(all))
}

/// Returns the hash of the parameters of one reactive controller.
pub fn parameters_hash(parameters: &ReactiveParameters) -> String {
    short(sha256(parameters.fingerprint()))
}

/// Returns the hash of a kind of controller with its default parameters.
pub fn kind_hash(kind: &dyn Kind) -> String {
    short(sha256(format!("{} {}", kind.name(), kind.defaults())))
}

fn short(mut hash: String) -> String {
    hash.truncate(16);
    hash
}
