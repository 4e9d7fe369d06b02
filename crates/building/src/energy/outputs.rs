//! Output files of the engine: by default almost none.

use serde_json::{Map, json};

use crate::model::Model;

/// Every file of `OutputControl:Files`.
const FILES: &str = "csv mtr eso eio tabular sqlite json audit space_sizing zone_sizing system_sizing dxf bnd \
                     rdd mdd mtd end shd dfs glhe delightin delighteldmp delightdfdmp edd dbg perflog sln sci \
                     wrl screen extshd tarcog";

/// Removes every output and makes the engine write only these files, for example `sqlite`. Results are read from
/// memory, because writing files would take a third of a run's time.
///
/// `Meter:Custom` objects stay: a transformer may refer to one, and a dangling reference crashes the engine.
pub(crate) fn write_only(model: &mut Model, files: &[&str]) {
    let is_output = |class: &&str| class.starts_with("Output:") || class.starts_with("OutputControl:");
    let outputs: Vec<String> = model.classes().filter(is_output).map(str::to_owned).collect();
    for class in outputs {
        model.remove_class(&class);
    }
    let choice = |file: &str| if files.contains(&file) { "Yes" } else { "No" };
    let fields: Map<_, _> =
        FILES.split_whitespace().map(|file| (format!("output_{file}"), json!(choice(file)))).collect();
    model.insert("OutputControl:Files", "Files", fields.into());
}
