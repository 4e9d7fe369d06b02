//! Sequences: episodes of a building that one controller runs, one after another.

use super::episode::EpisodePlan;
use crate::policy::Policy;

/// Returns the sequences of a list of episodes, each as positions in the list: the episodes with the same building,
/// task and seed for a policy that [keeps its memory](Policy::keeps_memory), otherwise every episode alone. A sequence
/// is the unit of work: if one of its episodes has not ended, all of them are run. Episodes of one building should be
/// adjacent in the list.
pub fn sequences<'a>(
    episodes: impl IntoIterator<Item = &'a EpisodePlan>,
    policy: &dyn Policy,
) -> Vec<Vec<usize>> {
    let mut sequences: Vec<(&EpisodePlan, Vec<usize>)> = Vec::new();
    for (position, episode) in episodes.into_iter().enumerate() {
        let of_building = |(first, _): &&mut (&EpisodePlan, _)| first.subject == episode.subject;
        let mut known = sequences.iter_mut().rev().take_while(of_building);
        match known.find(|(first, _)| policy.keeps_memory() && continues(first, episode)) {
            Some((_, sequence)) => sequence.push(position),
            None => sequences.push((episode, vec![position])),
        }
    }
    sequences.into_iter().map(|(_, sequence)| sequence).collect()
}

/// Returns whether two episodes of a building belong to one sequence.
fn continues(first: &EpisodePlan, next: &EpisodePlan) -> bool {
    first.task == next.task && first.seed == next.seed && first.steps_per_hour == next.steps_per_hour
}

#[cfg(test)]
mod tests {
    use b2b_control::Controller;

    use super::*;
    use crate::{EpisodeContext, Result, Subject};

    struct Keeping(bool);

    impl Policy for Keeping {
        fn name(&self) -> String {
            "keeping".to_owned()
        }

        fn identity(&self) -> String {
            self.name()
        }

        fn keeps_memory(&self) -> bool {
            self.0
        }

        fn controller(&self, _: EpisodeContext<'_>) -> Result<Box<dyn Controller>> {
            unreachable!("no episode is run")
        }
    }

    #[test]
    fn a_sequence_has_one_building_task_and_seed_in_the_order_of_the_list() {
        let mut episodes = Vec::new();
        for building in ["SingleFamilyHouse-1", "SingleFamilyHouse-2"] {
            for period in ["01-01..01-07", "01-08..01-14"] {
                for task in ["constant", "occupancy"] {
                    for seed in [0, 1] {
                        episodes.push(EpisodePlan {
                            subject: Subject::at_home(building.parse().unwrap()),
                            task: task.parse().unwrap(),
                            period: period.parse().unwrap(),
                            seed,
                            steps_per_hour: 12,
                        });
                    }
                }
            }
        }
        let kept = sequences(&episodes, &Keeping(true));
        let pairs = [0, 8].into_iter().flat_map(|first| (first..first + 4).map(|each| vec![each, each + 4]));
        let expected: Vec<_> = pairs.collect();
        assert_eq!(kept, expected);
        let alone = sequences(&episodes, &Keeping(false));
        assert_eq!(alone, (0..16).map(|position| vec![position]).collect::<Vec<_>>());
    }
}
