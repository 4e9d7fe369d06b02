//! Copies continue bit for bit.

use b2b_building::BuildingType;
use b2b_env::{Environment, Error};
use b2b_workers::Workers;

use crate::case::Case;
use crate::workers::{DAY, dice, options, setting, started, steps, whole};

fn copies_continue_bit_for_bit(building_type: BuildingType) {
    let period = "01-10..01-11";
    let case = Case::at_home(building_type);
    let mut env = case.env(period);
    let mut same = dice(env.action_space());
    let expected = whole(&mut env, &mut same);
    let row = env.observation_space().len() + 2;

    let workers = Workers::new(options(&case)).unwrap();
    let mut episode = started(&workers, &setting(&case, period));
    let mut first = dice(env.action_space());
    let mut trace = steps(&mut episode, &mut first, 200);
    let snapshot = episode.snapshot().unwrap();
    assert_eq!(snapshot.observation(), episode.observation());
    trace.extend(steps(&mut episode, &mut first, usize::MAX));
    assert!(trace == expected, "an episode copied from a template differs");
    assert_eq!(episode.metrics(), Some(env.metrics()));

    let rest = || {
        let mut dice = dice(env.action_space());
        (0..200).for_each(|_| _ = dice.roll());
        dice
    };
    for mut copy in snapshot.branch(2).unwrap() {
        let trace = steps(&mut copy, &mut rest(), usize::MAX);
        assert!(trace == expected[200 * row..], "an episode that continues from a snapshot differs");
    }
    episode.restore(&snapshot).unwrap();
    let trace = steps(&mut episode, &mut rest(), usize::MAX);
    assert!(trace == expected[200 * row..], "a restored episode differs");
}

#[test]
fn copies_of_the_house_continue_bit_for_bit() {
    copies_continue_bit_for_bit(BuildingType::SingleFamilyHouse);
}

#[test]
fn copies_of_the_small_office_continue_bit_for_bit() {
    copies_continue_bit_for_bit(BuildingType::OfficeSmall);
}

#[test]
fn copies_of_the_medium_office_continue_bit_for_bit() {
    copies_continue_bit_for_bit(BuildingType::OfficeMedium);
}

#[test]
fn copies_of_the_shop_continue_bit_for_bit() {
    copies_continue_bit_for_bit(BuildingType::RetailStandalone);
}

#[test]
fn copies_of_the_restaurant_continue_bit_for_bit() {
    copies_continue_bit_for_bit(BuildingType::RestaurantFastFood);
}

#[test]
fn copies_of_the_warehouse_continue_bit_for_bit() {
    copies_continue_bit_for_bit(BuildingType::Warehouse);
}

#[test]
fn an_episode_cannot_be_restored_to_a_snapshot_of_another() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let workers = Workers::new(options(&case)).unwrap();
    let mut winter = started(&workers, &setting(&case, DAY));
    let summer = started(&workers, &setting(&case, "07-10..07-10"));
    let snapshot = summer.snapshot().unwrap();
    assert!(matches!(winter.restore(&snapshot), Err(Error::OtherSnapshot { .. })));
    let mut dice = dice(&winter.spaces().action);
    assert!(!steps(&mut winter, &mut dice, 2).is_empty(), "the episode remains where it was");
}

#[test]
fn a_process_ends_with_its_episode_or_snapshot() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let workers = Workers::new(options(&case)).unwrap();
    let episode = started(&workers, &setting(&case, DAY));
    let branches = episode.branch(2).unwrap();
    let mut processes: Vec<u32> = branches.iter().map(|branch| branch.process().unwrap()).collect();
    processes.push(episode.process().unwrap());
    assert!(processes.iter().all(|process| crate::workers::is_alive(*process)));
    drop((episode, branches));
    let dropped = std::time::Instant::now();
    while processes.iter().any(|process| crate::workers::is_alive(*process)) {
        assert!(dropped.elapsed() < std::time::Duration::from_secs(2), "a process is left");
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
}
