//! The resource that a task penalizes, as its spelling in results tells it.

use std::collections::BTreeSet;

use b2b_env::{Resource, Task};

/// The heading of the resource of different tasks relative to the baseline.
pub const RESOURCE: &str = "task's resource / baseline";

/// Returns the heading of a resource relative to the baseline: `cost / baseline`.
pub fn heading_of(resource: Resource) -> String {
    format!("{} / baseline", resource.penalty().word)
}

/// Returns the heading of the resource of these tasks, likewise.
pub fn resource_heading<'a>(tasks: impl IntoIterator<Item = &'a str>) -> String {
    common_resource(&tasks.into_iter().collect()).map_or(RESOURCE.to_owned(), heading_of)
}

/// Returns whether amounts of the resources of these tasks may be added up.
pub(super) fn is_same_resource<'a>(tasks: impl Iterator<Item = &'a str>) -> bool {
    let tasks: BTreeSet<&str> = tasks.collect();
    tasks.len() <= 1 || common_resource(&tasks).is_some()
}

/// Returns the resource of all tasks; `None` if they differ, or if a spelling does not tell, as of a tariff that only
/// its file has.
fn common_resource(tasks: &BTreeSet<&str>) -> Option<Resource> {
    let of = |task: &&str| {
        let spelling = task.split('#').next().unwrap_or(task);
        Some(spelling.parse::<Task>().ok()?.resource)
    };
    let mut resources = tasks.iter().map(of);
    let first = resources.next()??;
    resources.all(|other| other == Some(first)).then_some(first)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_heading_names_the_resource_of_all_tasks() {
        let heading = |tasks: &[&str]| resource_heading(tasks.iter().copied());
        assert_eq!(heading(&["operate", "operate+tou"]), "cost / baseline");
        assert_eq!(heading(&["operate+carbon1"]), "carbon / baseline");
        assert_eq!(heading(&["constant+energy0.5#12345678"]), "energy / baseline");
        for tasks in [&["operate", "operate+carbon1"][..], &["operate+my-tariff#12345678"], &[]] {
            assert_eq!(heading(tasks), RESOURCE, "{tasks:?}");
        }
    }

    #[test]
    fn amounts_of_one_resource_are_added_up() {
        let same = |tasks: &[&str]| is_same_resource(tasks.iter().copied());
        assert!(same(&["operate", "operate+tou"]) && same(&["operate+my-tariff#12345678"; 2]) && same(&[]));
        assert!(!same(&["operate", "operate+carbon1"]) && !same(&["operate", "operate+my-tariff#12345678"]));
    }
}
