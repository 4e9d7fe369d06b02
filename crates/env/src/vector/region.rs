//! Memory that the owner of a pool and its processes share: a seat for every process.
//!
//! A seat belongs to one side at a time. It is the process's while a command stands in it, and the owner's
//! otherwise; its state says which, and changes hands with release and acquire. Whoever waits sleeps on a futex.
//! This is the one module of the crate with unsafe code.

use std::fs::File;
use std::mem::size_of;
use std::os::fd::{AsFd, OwnedFd};
use std::slice;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};
use std::time::Duration;

use memmap2::{MmapOptions, MmapRaw};
use rustix::fs::{FallocateFlags, MemfdFlags};
use rustix::thread::futex::{self, Timespec};

/// Seats of a region: more processes than one machine holds.
pub(super) const SEATS: usize = 2048;
/// Most actuators of a building, and most slots of an observation.
pub(super) const WIDTH: usize = 1024;
/// Most bytes of a report.
const REPORT: usize = 48 * 1024;
/// Most copies that one command makes.
pub(super) const COPIES: usize = 128;

const PAGE: usize = 4096;
const SEAT: usize = (size_of::<Seat>() + 2 * WIDTH * size_of::<f64>() + REPORT).next_multiple_of(PAGE);
const BYTES: usize = PAGE + SEATS * SEAT;

/// What the owner asks of a process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub(super) enum Command {
    /// One step with the action in the seat.
    Step = 0,
    /// A copy of itself for each seat listed.
    Copy = 1,
}

/// How a copy begins.
#[derive(Clone, Copy, Debug, Default)]
pub struct Start {
    /// Steps after which its episode is truncated; all of the run period if `None`.
    pub steps: Option<usize>,
    /// The processor that its process keeps to, counted among those that it may use; any if `None`.
    pub processor: Option<u32>,
}

/// How a process stands after its last command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub(super) enum Standing {
    /// In an episode.
    Running = 0,
    /// At the end of its episode; the report has its metrics.
    Truncated = 1,
    /// Of no use any more; the report says why.
    Failed = 2,
}

/// A seat is waiting for the owner.
const READY: u32 = 0;
/// A command is being carried out.
const BUSY: u32 = 1;

/// What both sides wait on.
#[repr(C, align(64))]
struct Bell {
    /// Commands carried out by all processes; a futex.
    done: AtomicU32,
    /// The bell rings when that many are.
    wanted: AtomicU32,
}

/// The fixed part of a seat; action, observation and report follow it.
#[repr(C, align(64))]
struct Seat {
    /// [`READY`] or [`BUSY`]; a futex.
    state: AtomicU32,
    command: AtomicU32,
    standing: AtomicU32,
    process: AtomicU32,
    report_bytes: AtomicU32,
    copies: AtomicU32,
    /// Steps after which the episode is over; 0 for all of the run period.
    steps: AtomicU32,
    /// The processor to keep to, from 1; 0 for any.
    processor: AtomicU32,
    temperature_penalty: AtomicU64,
    energy_penalty: AtomicU64,
    copy_seats: [AtomicU32; COPIES],
}

/// The shared memory, on either side.
#[derive(Debug)]
pub(super) struct Region {
    map: MmapRaw,
    file: OwnedFd,
}

impl Region {
    /// New memory, without a name and without pages.
    pub(super) fn new() -> std::io::Result<Self> {
        let file = rustix::fs::memfd_create("b2b", MemfdFlags::CLOEXEC)?;
        rustix::fs::ftruncate(&file, BYTES as u64)?;
        rustix::fs::fallocate(&file, FallocateFlags::empty(), 0, PAGE as u64)?;
        Self::open(file)
    }

    /// The memory behind a descriptor.
    pub(super) fn open(file: OwnedFd) -> std::io::Result<Self> {
        let file = File::from(file);
        let map = MmapOptions::new().len(BYTES).map_raw(&file)?;
        Ok(Self { map, file: file.into() })
    }

    /// A descriptor to give to a process.
    pub(super) fn share(&self) -> std::io::Result<OwnedFd> {
        self.file.as_fd().try_clone_to_owned()
    }

    /// Takes memory for a seat, so that none can be missing when it is written to.
    pub(super) fn reserve(&self, seat: u32) -> std::io::Result<()> {
        let begin = (PAGE + seat as usize * SEAT) as u64;
        Ok(rustix::fs::fallocate(&self.file, FallocateFlags::empty(), begin, SEAT as u64)?)
    }

    fn bell(&self) -> &Bell {
        // SAFETY: the region begins with a page of its own for the bell, all zeros at first and only ever touched
        // as atomics, for which every bit pattern is valid.
        unsafe { &*self.map.as_ptr().cast() }
    }

    fn seat(&self, seat: u32) -> &Seat {
        // SAFETY: as for the bell; `at` is within the region and aligned.
        unsafe { &*self.at(seat, 0).cast() }
    }

    fn at(&self, seat: u32, offset: usize) -> *mut u8 {
        let seat = seat as usize;
        assert!(seat < SEATS && offset < SEAT, "seat {seat} of {SEATS}");
        // SAFETY: within the mapping, as just checked.
        unsafe { self.map.as_mut_ptr().add(PAGE + seat * SEAT + offset) }
    }

    /// Numbers of a seat. The caller's side must hold the seat.
    #[allow(clippy::mut_from_ref, reason = "the seat's state says who may write, not the borrow")]
    unsafe fn numbers(&self, seat: u32, first: usize, count: usize) -> &mut [f64] {
        assert!(count <= WIDTH, "{count} numbers where {WIDTH} have room");
        let offset = size_of::<Seat>() + first * size_of::<f64>();
        // SAFETY: within the seat, aligned, every bit pattern is a number, and by the caller's promise nobody else
        // touches it.
        unsafe { slice::from_raw_parts_mut(self.at(seat, offset).cast(), count) }
    }

    /// The action of a seat that this side holds.
    pub(super) fn write_action(&self, seat: u32, action: &[f64]) {
        // SAFETY: the caller holds the seat, and the borrow ends here.
        unsafe { self.numbers(seat, 0, action.len()) }.copy_from_slice(action);
    }

    /// The action of a seat that this side holds.
    pub(super) fn read_action(&self, seat: u32, action: &mut [f64]) {
        // SAFETY: as for `write_action`.
        action.copy_from_slice(unsafe { self.numbers(seat, 0, action.len()) });
    }

    /// The observation of a seat that this side holds.
    pub(super) fn write_observation(&self, seat: u32, observation: &[f64]) {
        // SAFETY: as for `write_action`.
        unsafe { self.numbers(seat, WIDTH, observation.len()) }.copy_from_slice(observation);
    }

    /// The observation of a seat that this side holds.
    pub(super) fn read_observation(&self, seat: u32, observation: &mut [f64]) {
        // SAFETY: as for `write_action`.
        observation.copy_from_slice(unsafe { self.numbers(seat, WIDTH, observation.len()) });
    }

    /// Leaves a text, cut to the room there is.
    pub(super) fn write_report(&self, seat: u32, report: &[u8]) {
        let report = &report[..report.len().min(REPORT)];
        let offset = size_of::<Seat>() + 2 * WIDTH * size_of::<f64>();
        // SAFETY: within the seat; the caller holds the seat, and the borrow ends here.
        unsafe { slice::from_raw_parts_mut(self.at(seat, offset), report.len()) }.copy_from_slice(report);
        self.seat(seat).report_bytes.store(report.len() as u32, Ordering::Relaxed);
    }

    /// The text left in a seat that this side holds.
    pub(super) fn report(&self, seat: u32) -> Vec<u8> {
        let bytes = (self.seat(seat).report_bytes.load(Ordering::Relaxed) as usize).min(REPORT);
        let offset = size_of::<Seat>() + 2 * WIDTH * size_of::<f64>();
        // SAFETY: as for `write_report`.
        unsafe { slice::from_raw_parts(self.at(seat, offset), bytes) }.to_vec()
    }

    /// The penalties of the last step.
    pub(super) fn penalties(&self, seat: u32) -> [f64; 2] {
        let seat = self.seat(seat);
        [&seat.temperature_penalty, &seat.energy_penalty]
            .map(|bits| f64::from_bits(bits.load(Ordering::Relaxed)))
    }

    /// Leaves the penalties of a step.
    pub(super) fn set_penalties(&self, seat: u32, [temperature, energy]: [f64; 2]) {
        let seat = self.seat(seat);
        seat.temperature_penalty.store(temperature.to_bits(), Ordering::Relaxed);
        seat.energy_penalty.store(energy.to_bits(), Ordering::Relaxed);
    }

    /// The process in a seat, 0 for none.
    pub(super) fn process(&self, seat: u32) -> u32 {
        self.seat(seat).process.load(Ordering::Relaxed)
    }

    /// How many steps the episode of a seat has; 0 for all of the run period.
    pub(super) fn steps(&self, seat: u32) -> u32 {
        self.seat(seat).steps.load(Ordering::Relaxed)
    }

    /// The processor that the process of a seat keeps to; `None` for any.
    pub(super) fn processor(&self, seat: u32) -> Option<u32> {
        self.seat(seat).processor.load(Ordering::Relaxed).checked_sub(1)
    }

    /// How the process of a seat stands.
    pub(super) fn standing(&self, seat: u32) -> Standing {
        match self.seat(seat).standing.load(Ordering::Relaxed) {
            0 => Standing::Running,
            1 => Standing::Truncated,
            _ => Standing::Failed,
        }
    }

    /// Says how this process stands.
    pub(super) fn set_standing(&self, seat: u32, standing: Standing) {
        self.seat(seat).standing.store(standing as u32, Ordering::Relaxed);
    }
}

/// What the owner does.
impl Region {
    /// Lays a seat for a process to come: busy until it reports.
    pub(super) fn lay(&self, seat: u32, start: Start) {
        let place = self.seat(seat);
        place.process.store(0, Ordering::Relaxed);
        place.report_bytes.store(0, Ordering::Relaxed);
        place.steps.store(start.steps.map_or(0, |steps| steps.max(1) as u32), Ordering::Relaxed);
        place.processor.store(start.processor.map_or(0, |processor| processor + 1), Ordering::Relaxed);
        place.standing.store(Standing::Running as u32, Ordering::Relaxed);
        place.state.store(BUSY, Ordering::Release);
    }

    /// Gives a command to the process in a seat that is ready.
    pub(super) fn command(&self, seat: u32, command: Command) {
        let seat = self.seat(seat);
        seat.command.store(command as u32, Ordering::Relaxed);
        seat.state.store(BUSY, Ordering::Release);
        wake(&seat.state);
    }

    /// Asks the process in a seat for copies of itself in other seats. The list is for [`Command::Copy`].
    pub(super) fn list_copies(&self, seat: u32, seats: &[u32]) {
        let place = self.seat(seat);
        for (entry, seat) in place.copy_seats.iter().zip(seats) {
            entry.store(*seat, Ordering::Relaxed);
        }
        place.copies.store(seats.len() as u32, Ordering::Relaxed);
    }

    /// Whether the owner holds a seat.
    pub(super) fn is_ready(&self, seat: u32) -> bool {
        self.seat(seat).state.load(Ordering::Acquire) == READY
    }

    /// Commands carried out so far: to be read before seats are looked at, and given to [`Region::sleep`].
    pub(super) fn done(&self) -> u32 {
        self.bell().done.load(Ordering::SeqCst)
    }

    /// Sleeps until so many more commands than `done` are carried out, or a time is over, or a signal comes.
    pub(super) fn sleep(&self, done: u32, more: u32, at_most: Duration) {
        let bell = self.bell();
        bell.wanted.store(done.wrapping_add(more), Ordering::SeqCst);
        let now = bell.done.load(Ordering::SeqCst);
        if (now.wrapping_sub(done) as i32) < more as i32 {
            wait(&bell.done, now, at_most);
        }
    }
}

/// What a process does.
impl Region {
    /// Takes a seat in the name of this process.
    pub(super) fn sit(&self, seat: u32) {
        self.seat(seat).process.store(std::process::id(), Ordering::Relaxed);
    }

    /// Hands the seat back to the owner, and rings the bell if that is the last it waits for.
    pub(super) fn hand_back(&self, seat: u32) {
        let place = self.seat(seat);
        place.state.store(READY, Ordering::Release);
        let bell = self.bell();
        let done = bell.done.fetch_add(1, Ordering::SeqCst).wrapping_add(1);
        if done.wrapping_sub(bell.wanted.load(Ordering::SeqCst)) as i32 >= 0 {
            wake(&bell.done);
        }
    }

    /// Waits for a command; `None` when there is none for a time.
    pub(super) fn next_command(&self, seat: u32, at_most: Duration) -> Option<Command> {
        let place = self.seat(seat);
        if place.state.load(Ordering::Acquire) == READY {
            wait(&place.state, READY, at_most);
            if place.state.load(Ordering::Acquire) == READY {
                return None;
            }
        }
        Some(match place.command.load(Ordering::Relaxed) {
            0 => Command::Step,
            _ => Command::Copy,
        })
    }

    /// The seats listed for copies.
    pub(super) fn copies(&self, seat: u32) -> Vec<u32> {
        let place = self.seat(seat);
        let count = place.copies.load(Ordering::Relaxed) as usize;
        place.copy_seats.iter().take(count).map(|seat| seat.load(Ordering::Relaxed)).collect()
    }
}

fn wait(word: &AtomicU32, value: u32, at_most: Duration) {
    let time = Timespec { tv_sec: at_most.as_secs() as i64, tv_nsec: at_most.subsec_nanos().into() };
    // Every way of waking up is followed by another look at the word.
    let _ = futex::wait(word, futex::Flags::empty(), value, Some(&time));
}

fn wake(word: &AtomicU32) {
    // Cannot fail on a valid address.
    let _ = futex::wake(word, futex::Flags::empty(), 1);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seat_changes_hands_with_what_was_written() {
        let region = Region::new().unwrap();
        region.reserve(3).unwrap();
        region.lay(3, Start { steps: Some(7), processor: Some(1) });
        assert!(!region.is_ready(3));
        region.sit(3);
        region.write_observation(3, &[1.0, 2.0]);
        region.write_report(3, b"all is well");
        region.hand_back(3);
        assert!(region.is_ready(3));
        let mut observation = [0.0; 2];
        region.read_observation(3, &mut observation);
        assert_eq!((observation, region.steps(3), region.done()), ([1.0, 2.0], 7, 1));
        assert_eq!(region.processor(3), Some(1));
        assert_eq!(region.report(3), b"all is well");
        assert_eq!(region.process(3), std::process::id());
    }

    #[test]
    fn the_owner_sleeps_until_the_last_of_those_it_waits_for() {
        let region = Region::new().unwrap();
        (0..3).for_each(|seat| region.lay(seat, Start::default()));
        let done = region.done();
        std::thread::scope(|scope| {
            scope.spawn(|| {
                for seat in 0..3 {
                    std::thread::sleep(Duration::from_millis(5));
                    region.hand_back(seat);
                }
            });
            while !(0..3).all(|seat| region.is_ready(seat)) {
                region.sleep(done, 3, Duration::from_secs(10));
            }
        });
        assert_eq!(region.done(), 3);
    }
}
