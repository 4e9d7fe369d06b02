//! EMS functions that the engine lacks, because they belong to an engine that was changed for another program.

use crate::model::{Model, items, text};
use crate::schema::Schema;

/// The classes of EMS code.
const CODE: [&str; 2] = ["EnergyManagementSystem:Program", "EnergyManagementSystem:Subroutine"];

/// Returns a problem for every EMS program that calls a function that the engine does not have.
pub(super) fn unknown(model: &Model, schema: &Schema) -> Vec<String> {
    let mut problems = Vec::new();
    for class in CODE {
        for (name, fields) in model.objects(class) {
            let lines = items(fields, "lines").filter_map(|item| text(item, "program_line"));
            let mut called = lines.flat_map(functions);
            if let Some(function) = called.find(|function| !schema.has_function(function)) {
                problems.push(format!(
                    "{class} `{name}` calls `@{function}`, which EnergyPlus does not have: an engine changed for another \
                     program ran this model. Replace what the program sets by objects of EnergyPlus, such as \
                     SetpointManager:Scheduled, and remove it"
                ));
            }
        }
    }
    problems
}

/// Returns the names of the functions that a line calls.
fn functions(line: &str) -> impl Iterator<Item = &str> {
    let is_of_name = |letter: char| letter.is_alphanumeric() || letter == '_';
    let name = move |rest: &'_ str| rest.find(|letter| !is_of_name(letter)).unwrap_or(rest.len());
    line.split('@').skip(1).map(move |rest| &rest[..name(rest)]).filter(|name| !name.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn calls_of_functions_are_found_in_any_place_of_a_line() {
        let of = |line| functions(line).collect::<Vec<_>>();
        assert_eq!(of("SET a = (@Max b c) + @CurveValue 1 d"), ["Max", "CurveValue"]);
        assert_eq!(of("SET a = b"), [""; 0]);
    }
}
