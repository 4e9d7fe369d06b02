//! Rules of conversion: one file of data for each step from a version to the next.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use serde::Deserialize;

use super::special::Special;

/// A step from a version of EnergyPlus to the next.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Step {
    /// The version of the input.
    pub from: String,
    /// The version after the step.
    pub to: String,
    /// Changes of classes.
    pub classes: Vec<ClassRule>,
    /// Parts of the names of output variables and meters, and what replaces them.
    pub names: Vec<(String, String)>,
    /// Conversions that need other objects or arithmetic.
    pub special: Vec<Special>,
}

/// What happens to the objects of a class.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClassRule {
    /// The class before the step.
    pub class: String,
    /// Its new name, also where fields name the class.
    pub becomes: Option<String>,
    /// Why its objects are removed.
    pub remove: Option<String>,
    /// Why its objects cannot be converted.
    pub refuse: Option<String>,
    /// Changes of fields, in order: positions include the effects of earlier changes.
    #[serde(default)]
    pub edits: Vec<Edit>,
}

/// A change of a field. Positions are as in an IDF, from 1; names as in an epJSON.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
pub enum Edit {
    /// A new field.
    Insert {
        /// Its name.
        insert: String,
        /// Its position.
        at: usize,
        /// Its value; blank without one.
        #[serde(default)]
        value: String,
        /// A class whose only object it names.
        name_of: Option<String>,
    },
    /// A field that no longer exists.
    Drop {
        /// Its name.
        drop: String,
        /// Its position.
        at: usize,
    },
    /// A new name at the same position.
    Rename {
        /// The name before.
        rename: String,
        /// The name after.
        to: String,
    },
    /// A new name at another position.
    Move {
        /// The name before.
        #[serde(rename = "move")]
        from: String,
        /// The position before.
        at: usize,
        /// The name after.
        to: String,
        /// The position after.
        to_at: usize,
    },
    /// New words for values.
    Change {
        /// The field; `*` for every field.
        change: String,
        /// Its position.
        #[serde(default)]
        at: usize,
        /// Values before and after; case is ignored.
        values: BTreeMap<String, String>,
    },
    /// The default of a blank field, which the step changes.
    Default {
        /// The field.
        default: String,
        /// Its position.
        at: usize,
        /// Its default before.
        value: String,
    },
    /// Fields that become an object of their own.
    Split {
        /// The field that names the new object; empty without one.
        split: String,
        /// Its position.
        at: usize,
        /// Class of the new object.
        class: String,
        /// Name of the new object; `{name}` stands for the object's.
        name: String,
        /// Fields of the new object, in order.
        fields: Vec<SplitField>,
    },
    /// Numbered fields that become a list of an epJSON; positions do not change.
    List {
        /// The list.
        list: String,
        /// Its fields.
        of: Vec<ListField>,
    },
}

/// A field of an object that is split off.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SplitField {
    /// Its name.
    pub field: String,
    /// The field whose value it takes.
    pub from: Option<String>,
    /// Position of that field.
    #[serde(default)]
    pub at: usize,
    /// A given value; `{name}` stands for the object's name.
    pub value: Option<String>,
}

/// A field of a list.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ListField {
    /// The numbered field, with `{n}` for the number from 1.
    pub numbered: String,
    /// The field of the list.
    pub field: String,
}

macro_rules! steps {
    ($($file:literal),*) => {
        [$(include_str!(concat!("../../../data/versions/", $file, ".json"))),*]
    };
}

/// The steps, oldest first.
pub static STEPS: LazyLock<Vec<Step>> = LazyLock::new(|| {
    let files = steps!(
        "9/8.9", "9/9.0", "9/9.1", "9/9.2", "9/9.3", "9/9.4", "9/9.5", "9/9.6", "22/22.1", "22/22.2",
        "22/23.1", "22/23.2", "22/24.1", "22/24.2", "22/25.1", "22/25.2"
    );
    let parse = |text: &&str| serde_json::from_str(text).expect("the rules are tested");
    files.iter().map(parse).collect()
});

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_step_continues_the_one_before_and_names_a_class_once() {
        for pair in STEPS.windows(2) {
            assert_eq!(pair[0].to, pair[1].from);
        }
        for step in STEPS.iter() {
            let mut classes: Vec<_> = step.classes.iter().map(|rule| rule.class.to_lowercase()).collect();
            classes.sort();
            let all = classes.len();
            classes.dedup();
            assert_eq!(classes.len(), all, "{} to {}", step.from, step.to);
        }
    }
}
