//! Both sides of the shared memory in one process.

use super::*;

#[test]
fn a_slot_passes_with_its_contents() {
    let region = Region::new().unwrap();
    region.reserve(3).unwrap();
    let options = EpisodeOptions { max_steps: Some(7), processor: Some(1), finish_run: true };
    region.init(3, options);
    assert!(!region.is_ready(3));
    assert!(region.attach(region.ticket(3)));
    region.write_observation(3, &[1.0, 2.0]);
    region.write_report(3, b"all is well");
    region.complete(3);
    assert!(region.is_ready(3));
    let mut observation = [0.0; 2];
    region.read_observation(3, &mut observation);
    assert_eq!((observation, region.options(3), region.done()), ([1.0, 2.0], options, 1));
    assert_eq!(region.report(3), b"all is well");
    assert_eq!(region.process(3), std::process::id());
    assert_eq!(region.exit(3), None);
    region.record_exit(std::process::id(), 9);
    assert_eq!(region.exit(3), Some(9));
}

#[test]
fn a_late_worker_cannot_attach() {
    let region = Region::new().unwrap();
    region.reserve(0).unwrap();
    region.init(0, EpisodeOptions::default());
    let late = region.ticket(0);
    assert!(region.revoke(0));
    assert!(!region.attach(late));
    region.init(0, EpisodeOptions::default());
    assert!(!region.attach(late));
    assert!(region.attach(region.ticket(0)));
    assert!(!region.revoke(0), "an attached worker has the slot");
}

#[test]
fn the_owner_sleeps_until_the_last_awaited_slot() {
    let region = Region::new().unwrap();
    (0..3).for_each(|slot| region.init(slot, EpisodeOptions::default()));
    let done = region.done();
    std::thread::scope(|scope| {
        scope.spawn(|| {
            for slot in 0..3 {
                std::thread::sleep(Duration::from_millis(5));
                region.complete(slot);
            }
        });
        while !(0..3).all(|slot| region.is_ready(slot)) {
            region.sleep(done, 3, Duration::from_secs(10));
        }
    });
    assert_eq!(region.done(), 3);
}
