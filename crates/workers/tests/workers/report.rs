//! The engine's report from a worker process.

use b2b_building::BuildingType;
use b2b_env::{Environment, Trajectory, rollout};
use b2b_workers::{EpisodeOptions, Workers};

use crate::case::{Case, random_episode};
use crate::workers::{options, setting};

struct Random(crate::case::Dice);

impl b2b_env::Controller for Random {
    fn reset(&mut self) {}

    fn act(&mut self, _: &[f64], action: &mut [f64]) {
        action.copy_from_slice(self.0.roll());
    }
}

#[test]
fn a_worker_that_finishes_its_run_reports_the_same_as_the_engine_in_process() {
    for building_type in [BuildingType::RestaurantFastFood, BuildingType::Warehouse] {
        let case = Case::at_home(building_type);
        let mut env = case.env("01-10..01-10");
        let expected = random_episode(&mut env, 1);

        let workers = Workers::new(options(&case)).unwrap();
        let finish = EpisodeOptions { finish_run: true, ..EpisodeOptions::default() };
        let mut episode = workers.episode(&setting(&case, "01-10..01-10")).unwrap().with_options(finish);
        for _ in 0..2 {
            let mut trajectory = Trajectory::for_episode(episode.spaces());
            let mut controller = Random(crate::workers::dice(env.action_space()));
            let metrics = rollout(&mut episode, &mut controller, &mut trajectory).unwrap();
            assert_eq!(trajectory.hash(), expected.hash());
            assert_eq!(metrics, *env.metrics());
            let report = episode.report().unwrap();
            assert_eq!(report.engine, env.engine_report());
            assert!(report.engine.meters.is_some_and(|[electricity, _]| electricity > 0.0));
            assert!(report.cpu.as_secs_f64() > 0.01);
        }
    }
}
