//! The resource that a task penalizes, as its spelling in results tells it.

use b2b_env::{Resource, Task};

/// The heading of the resource of different tasks relative to the baseline.
pub const RESOURCE: &str = "task's resource / baseline";

/// Returns the resource of a task; `None` if its spelling does not tell, as of a tariff that only its file has.
fn resource_of(task: &str) -> Option<Resource> {
    let spelling = task.split('#').next().unwrap_or(task);
    Some(spelling.parse::<Task>().ok()?.resource)
}

/// Returns whether amounts of the resources of these tasks may be added up.
pub(super) fn is_same_resource<'a>(mut tasks: impl Iterator<Item = &'a str>) -> bool {
    let Some(first) = tasks.next() else { return true };
    let same = |task: &str| resource_of(task).is_some_and(|resource| resource_of(first) == Some(resource));
    tasks.all(|task| task == first || same(task))
}

/// Returns the heading of the resource of these tasks relative to the baseline: `cost / baseline`.
pub fn resource_heading<'a>(tasks: impl IntoIterator<Item = &'a str>) -> String {
    let mut resources = tasks.into_iter().map(resource_of);
    let first = resources.next().flatten().filter(|first| resources.all(|other| other == Some(*first)));
    first.map_or(RESOURCE.to_owned(), |resource| format!("{} / baseline", resource.penalty().word))
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
