//! The report on a conversion.

use serde::{Deserialize, Serialize};

/// What a conversion to the engine's version did.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Conversion {
    /// The version of the model.
    pub from: String,
    /// The engine's version.
    pub to: String,
    /// What was changed.
    pub changed: Vec<Change>,
    /// What has no counterpart and was left out.
    pub left_out: Vec<Change>,
    /// The Transition programs of EnergyPlus that converted it instead of this project's rules.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub programs: Vec<String>,
}

/// A change of the objects of a class.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Change {
    /// The version that introduced it.
    pub version: String,
    /// The class before the change.
    pub class: String,
    /// Number of objects.
    pub objects: usize,
    /// The change.
    pub what: String,
}

impl Conversion {
    pub(super) fn changed(&mut self, version: &str, class: &str, what: String) {
        count(&mut self.changed, version, class, what);
    }

    pub(super) fn left_out(&mut self, version: &str, class: &str, what: String) {
        count(&mut self.left_out, version, class, what);
    }
}

fn count(changes: &mut Vec<Change>, version: &str, class: &str, what: String) {
    let same = |change: &&mut Change| {
        change.version == version && change.class.eq_ignore_ascii_case(class) && change.what == what
    };
    match changes.iter_mut().find(same) {
        Some(change) => change.objects += 1,
        None => {
            changes.push(Change { version: version.to_owned(), class: class.to_owned(), objects: 1, what })
        }
    }
}
