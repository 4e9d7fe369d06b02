//! The learners, listed by name for configurations.

pub mod ppo;
pub mod sac;

use std::fmt;
use std::ops::Deref;
use std::sync::{Arc, PoisonError, RwLock};

use serde::Serialize;
use serde::de::DeserializeOwned;
use toml::Table;

use crate::error::{Error, Result};
use crate::learner::LearnerOptions;

/// The built-in kinds of learners, the default first.
const BUILT_IN: &[LearnerKind] =
    &[LearnerKind::of::<ppo::PpoConfig>("ppo"), LearnerKind::of::<sac::SacConfig>("sac")];

/// Kinds that programs have added.
static ADDED: RwLock<Vec<LearnerKind>> = RwLock::new(Vec::new());

/// A kind of learner.
#[derive(Clone, Copy)]
pub struct LearnerKind {
    /// Name: the value of `algorithm` in a configuration, and the name of the table with its options.
    pub name: &'static str,
    read: fn(Table) -> std::result::Result<Arc<dyn LearnerOptions>, toml::de::Error>,
    write: fn(&'static str, &dyn LearnerOptions) -> String,
}

impl LearnerKind {
    /// Returns the kind of learner with these options, each of which has a default.
    pub const fn of<O: LearnerOptions + Serialize + DeserializeOwned>(name: &'static str) -> Self {
        Self { name, read: read::<O>, write: write::<O> }
    }

    /// Finds a kind.
    ///
    /// # Errors
    /// [`Error::Invalid`] for an unknown name.
    pub fn find(name: &str) -> Result<Self> {
        let unknown = || {
            let names: Vec<_> = kinds().iter().map(|kind| kind.name).collect();
            Error::Invalid(format!("unknown algorithm `{name}`; expected {}", names.join(" or ")))
        };
        kinds().into_iter().find(|kind| kind.name == name).ok_or_else(unknown)
    }

    /// Reads a learner of this kind with the options in a table.
    pub(crate) fn read(self, table: Table) -> std::result::Result<LearnerChoice, toml::de::Error> {
        Ok(LearnerChoice { kind: self, options: (self.read)(table)? })
    }
}

fn read<O: LearnerOptions + DeserializeOwned>(
    table: Table,
) -> std::result::Result<Arc<dyn LearnerOptions>, toml::de::Error> {
    Ok(Arc::new(table.try_into::<O>()?))
}

fn write<O: LearnerOptions + Serialize>(name: &'static str, options: &dyn LearnerOptions) -> String {
    let options: &dyn std::any::Any = options;
    let options = options.downcast_ref::<O>().expect("a kind reads the options that it writes");
    toml::to_string(&std::collections::BTreeMap::from([(name, options)]))
        .expect("plain data always serializes")
}

/// Returns all kinds of learners.
pub fn kinds() -> Vec<LearnerKind> {
    let added = ADDED.read().unwrap_or_else(PoisonError::into_inner);
    BUILT_IN.iter().chain(added.iter()).copied().collect()
}

/// Adds a kind of learner that configurations can then name. Called once per name, before a configuration with it is
/// read.
pub fn register(kind: LearnerKind) {
    ADDED.write().unwrap_or_else(PoisonError::into_inner).push(kind);
}

/// A configuration's learner: a kind and its options, to which it dereferences.
#[derive(Clone)]
pub struct LearnerChoice {
    kind: LearnerKind,
    options: Arc<dyn LearnerOptions>,
}

impl LearnerChoice {
    /// Returns the name of the kind.
    pub fn name(&self) -> &'static str {
        self.kind.name
    }

    /// Returns the options, if they are of this type.
    pub fn options<O: LearnerOptions>(&self) -> Option<&O> {
        let options: &dyn std::any::Any = &*self.options;
        options.downcast_ref()
    }

    /// Returns the options as a TOML table with the name of the kind.
    pub fn to_toml(&self) -> String {
        (self.kind.write)(self.kind.name, &*self.options)
    }
}

impl Default for LearnerChoice {
    fn default() -> Self {
        BUILT_IN[0].into()
    }
}

impl From<LearnerKind> for LearnerChoice {
    /// Returns a learner of this kind with default options.
    fn from(kind: LearnerKind) -> Self {
        kind.read(Table::new()).expect("every option of a learner has a default")
    }
}

impl Deref for LearnerChoice {
    type Target = dyn LearnerOptions;

    fn deref(&self) -> &Self::Target {
        &*self.options
    }
}

impl PartialEq for LearnerChoice {
    fn eq(&self, other: &Self) -> bool {
        self.to_toml() == other.to_toml()
    }
}

impl fmt::Debug for LearnerChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {:?}", self.kind.name, self.options)
    }
}
