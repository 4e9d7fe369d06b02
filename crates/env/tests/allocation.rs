//! A step allocates nothing, for any task. Only Rust's allocations are counted, not the engine's.

#![allow(unsafe_code, reason = "an allocator that counts")]

#[path = "env/case.rs"]
mod case;
#[path = "env/models/mod.rs"]
mod models;

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use b2b_building::{BuildingType, Controls};
use b2b_energyplus::Level;
use b2b_env::Env;
use case::{Case, Dice};
use models::{fan_coil, office, packaged, room};

struct Counting;

static COUNT: AtomicUsize = AtomicUsize::new(0);
/// Held by the test that counts.
static COUNTS: Mutex<()> = Mutex::new(());

// SAFETY: every call is passed to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller upholds the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the pointer is from `System`, like every pointer that `alloc` returned.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn messages(env: &Env) -> usize {
    [Level::Info, Level::Warning, Level::Severe].map(|level| env.message_count(level)).iter().sum()
}

#[test]
fn a_step_allocates_nothing() {
    let house = Case::at_home(BuildingType::SingleFamilyHouse);
    for task in [
        "occupancy+energy0.5",
        "random+pmv+cost1",
        "occupancy+deadband+peak1",
        "occupancy+presence2",
        "operate:21-24/15.6-28+pmv+tou+preview+co2",
    ] {
        steps_allocate_nothing(&house, task);
    }
    // Units, an air loop with terminals, and a zone that is only heated.
    for building in [BuildingType::OfficeSmall, BuildingType::OfficeMedium, BuildingType::Warehouse] {
        steps_allocate_nothing(&Case::at_home(building), "operate");
    }
    steps_allocate_nothing(&Case::under_setpoints(BuildingType::SingleFamilyHouse), "operate");
}

/// Imported: units in their room, and a room that is controlled through its setpoints.
#[test]
fn a_step_of_an_imported_room_allocates_nothing() {
    for model in [packaged::heat_pump(), fan_coil::fan_coil(), room::room()] {
        steps_allocate_nothing(&Case::of_user(&model, Controls::default()), "operate");
    }
}

/// Imported: terminals without reheat, and a unit of several zones.
#[test]
fn a_step_of_imported_air_systems_allocates_nothing() {
    steps_allocate_nothing(&office::with_bare_terminals(), "operate");
    let denver = "USA_CO_Denver-Aurora-Buckley.AFB.724695_TMY3.epw";
    steps_allocate_nothing(&Case::imported("ASHRAE901_HotelSmall_STD2019_Denver.idf", denver), "operate");
}

/// Measured from noon on, across a midnight, because the first steps fill the engine's buffers.
fn steps_allocate_nothing(case: &Case, task: &str) {
    let _counts = COUNTS.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let mut env = case.env_for("01-03..01-04", task);
    let mut dice = Dice::new(env.action_space(), 1);
    env.reset().unwrap();
    let mut counts = Vec::with_capacity(env.episode_steps());
    for step in 1..env.episode_steps() {
        let action = dice.roll();
        let said = messages(&env);
        let before = COUNT.load(Ordering::Relaxed);
        env.step(action).unwrap();
        let count = COUNT.load(Ordering::Relaxed) - before;
        // Messages of the engine are stored, which allocates.
        if messages(&env) == said {
            counts.push((step, count));
        }
    }
    assert!(counts.len() > 530, "{task}: the engine wrote messages in {} steps", 575 - counts.len());
    counts.retain(|(step, count)| *step > 144 && *count > 0);
    assert_eq!(counts, [], "{task}: steps and their allocations");
}
