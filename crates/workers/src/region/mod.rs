//! Memory shared by a pool and its workers: a slot for every worker.
//!
//! A slot belongs to one side at a time: to the worker while it is [`BUSY`], to the owner otherwise. Ownership passes
//! with release and acquire ordering, and the waiting side sleeps on a futex. A worker attaches to its slot with its
//! generation, so a late worker detects that the slot has been reassigned. This is the only module of the crate with
//! unsafe code.

#![allow(unsafe_code, reason = "memory shared with workers")]

use std::fs::File;
use std::mem::size_of;
use std::os::fd::{AsFd, OwnedFd};
use std::slice;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};
use std::time::Duration;

use memmap2::{MmapOptions, MmapRaw};
use rustix::fs::{FallocateFlags, MemfdFlags};
use serde::{Deserialize, Serialize};

use super::episode::episode_options::EpisodeOptions;
use b2b_env::StepNumbers;

mod futex;
mod handover;
mod owner;
mod spin;
mod worker;

use handover::{BUSY, READY};
use spin::Spin;

/// Interval at which a waiting owner checks whether its workers are alive.
pub(super) const LOOK: Duration = Duration::from_millis(50);
/// Slots of a region: more than the processes of one machine.
pub(super) const SLOTS: usize = 2048;
/// Maximum number of actuators and of observation slots of a building.
pub(super) const WIDTH: usize = 1024;
/// Maximum size of a report, bytes.
const REPORT: usize = 48 * 1024;
/// File extension of a longer order.
pub(super) const LONG_ORDER: &str = "fragment";
/// File extension of a longer report.
pub(super) const LONG_REPORT: &str = "report";
/// Maximum number of copies per command.
pub(super) const COPIES: usize = 128;

const PAGE: usize = 4096;
const SLOT: usize = (size_of::<Slot>() + 2 * WIDTH * size_of::<f64>() + REPORT).next_multiple_of(PAGE);
/// Offset of the memory for fragments.
const SHARED: usize = PAGE + SLOTS * SLOT;
/// Maximum number of f32 numbers shared by fragments. Only reserved numbers take memory.
const SHARED_NUMBERS: usize = 1 << 31;
const BYTES: usize = SHARED + SHARED_NUMBERS * size_of::<f32>();

/// A command to a worker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub(super) enum Command {
    /// One step with the action in the slot.
    Step = 0,
    /// A copy of the process for each slot listed.
    Copy = 1,
    /// A fragment by the order in the report.
    Fragment = 2,
    /// A fragment by the order in a file of the worker.
    LongFragment = 3,
}

/// Status of a worker after its last command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub(super) enum Status {
    /// In an episode.
    Running = 0,
    /// At the end of its episode; the report has its metrics.
    Truncated = 1,
    /// Failed; the report says why.
    Failed = 2,
}

/// A slot and its generation, for the worker that attaches to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Ticket {
    pub(super) slot: u32,
    pub(super) generation: u32,
}

impl Ticket {
    /// The name of a file of this worker in the pool's folder.
    pub(super) fn file(self, extension: &str) -> String {
        format!("worker-{}-{}.{extension}", self.slot, self.generation)
    }
}

/// Marks an exit status as known.
const EXITED: u32 = 1 << 31;

/// The first page of the region: the futex that the owner waits on, and counts.
#[repr(C, align(64))]
struct SlotBell {
    /// Number of commands executed by all workers; a futex.
    done: AtomicU32,
    /// The bell rings when `done` reaches this.
    wanted: AtomicU32,
    /// Number of slots reserved so far.
    slots: AtomicU32,
    /// Episodes in progress.
    episodes: AtomicU32,
}

impl SlotBell {
    fn words(&self) -> handover::Bell<'_, AtomicU32> {
        handover::Bell { done: &self.done, wanted: &self.wanted }
    }
}

/// The fixed part of a slot; action, observation and report follow it.
#[repr(C, align(64))]
struct Slot {
    /// [`READY`] or [`BUSY`]; a futex.
    state: AtomicU32,
    command: AtomicU32,
    status: AtomicU32,
    report_bytes: AtomicU32,
    /// Generation in the upper half, process in the lower; process 0 until one attaches.
    occupant: AtomicU64,
    /// Bits of [`StepNumbers`].
    step_numbers: [AtomicU64; size_of::<StepNumbers>() / size_of::<f64>()],
    /// Wait status of an ended process, with [`EXITED`].
    exit: AtomicU32,
    copies: AtomicU32,
    /// Steps after which the episode is truncated; 0 for the whole run period.
    steps: AtomicU32,
    /// The processor that the worker is pinned to, from 1; 0 for none.
    processor: AtomicU32,
    /// Whether the engine finishes its run.
    finish_run: AtomicU32,
    /// Steps of the last fragment.
    fragment_steps: AtomicU32,
    copy_list: [AtomicU64; COPIES],
}

fn pack(generation: u32, process: u32) -> u64 {
    u64::from(generation) << 32 | u64::from(process)
}

fn unpack(packed: u64) -> (u32, u32) {
    ((packed >> 32) as u32, packed as u32)
}

/// Adds a remedy to an error about memory, which `ulimit` may limit.
fn limited(error: std::io::Error, option: &str) -> std::io::Error {
    let size = BYTES >> 30;
    let why = format!(
        "{error}: processes share {size} GB of addresses, most of it never used; if `ulimit {option}` limits them, \
         raise the limit"
    );
    std::io::Error::new(error.kind(), why)
}

/// The shared memory, on either side.
#[derive(Debug)]
pub(super) struct Region {
    map: MmapRaw,
    file: OwnedFd,
    /// Processors that this process may use.
    processors: u32,
    /// Spinning state of this side.
    spin: Spin,
}

impl Region {
    /// Creates anonymous memory with no pages allocated yet.
    pub(super) fn new() -> std::io::Result<Self> {
        let file = rustix::fs::memfd_create("b2b", MemfdFlags::CLOEXEC)?;
        rustix::fs::ftruncate(&file, BYTES as u64).map_err(|error| limited(error.into(), "-f"))?;
        rustix::fs::fallocate(&file, FallocateFlags::empty(), 0, PAGE as u64)?;
        Self::open(file)
    }

    /// The memory behind a descriptor.
    pub(super) fn open(file: OwnedFd) -> std::io::Result<Self> {
        let file = File::from(file);
        let map = MmapOptions::new().len(BYTES).map_raw(&file).map_err(|error| limited(error, "-v"))?;
        let processors = std::thread::available_parallelism().map_or(1, |count| count.get() as u32);
        Ok(Self { map, file: file.into(), processors, spin: Spin::default() })
    }

    /// A descriptor to give to a worker.
    pub(super) fn share(&self) -> std::io::Result<OwnedFd> {
        self.file.as_fd().try_clone_to_owned()
    }

    /// Allocates the memory of a slot, so that writing to it cannot fail.
    pub(super) fn reserve(&self, slot: u32) -> std::io::Result<()> {
        let begin = (PAGE + slot as usize * SLOT) as u64;
        rustix::fs::fallocate(&self.file, FallocateFlags::empty(), begin, SLOT as u64)?;
        self.bell().slots.fetch_max(slot + 1, Ordering::SeqCst);
        Ok(())
    }

    /// Allocates memory for numbers shared by fragments, so that writing to it cannot fail.
    pub(super) fn reserve_shared(&self, place: usize, count: usize) -> std::io::Result<()> {
        if place + count > SHARED_NUMBERS {
            return Err(std::io::Error::other(format!(
                "{count} numbers after {place} exceed the shared memory of {SHARED_NUMBERS}"
            )));
        }
        let [begin, length] = [SHARED + place * size_of::<f32>(), count * size_of::<f32>()].map(|n| n as u64);
        rustix::fs::fallocate(&self.file, FallocateFlags::empty(), begin, length)?;
        Ok(())
    }

    fn shared(&self, place: usize, count: usize) -> &[AtomicU32] {
        assert!(place + count <= SHARED_NUMBERS, "{count} numbers after {place} of {SHARED_NUMBERS}");
        // SAFETY: within the mapping, as just checked, aligned, and only accessed as atomics.
        unsafe {
            slice::from_raw_parts(self.map.as_ptr().add(SHARED + place * size_of::<f32>()).cast(), count)
        }
    }

    /// Reads numbers shared by fragments.
    pub(super) fn read_shared(&self, place: usize, numbers: &mut [f32]) {
        let shared = self.shared(place, numbers.len());
        for (number, bits) in numbers.iter_mut().zip(shared) {
            *number = f32::from_bits(bits.load(Ordering::Relaxed));
        }
    }

    /// Writes numbers shared by fragments.
    pub(super) fn write_shared(&self, place: usize, numbers: &[f32]) {
        for (bits, number) in self.shared(place, numbers.len()).iter().zip(numbers) {
            bits.store(number.to_bits(), Ordering::Relaxed);
        }
    }

    /// Reads f64 numbers shared by fragments, each stored in two places.
    pub(super) fn read_shared_f64(&self, place: usize, numbers: &mut [f64]) {
        let shared = self.shared(place, 2 * numbers.len());
        for (number, bits) in numbers.iter_mut().zip(shared.chunks_exact(2)) {
            let [low, high] = [&bits[0], &bits[1]].map(|half| u64::from(half.load(Ordering::Relaxed)));
            *number = f64::from_bits(high << 32 | low);
        }
    }

    /// Writes f64 numbers shared by fragments, each stored in two places.
    pub(super) fn write_shared_f64(&self, place: usize, numbers: &[f64]) {
        let shared = self.shared(place, 2 * numbers.len());
        for (bits, number) in shared.chunks_exact(2).zip(numbers) {
            let number = number.to_bits();
            bits[0].store(number as u32, Ordering::Relaxed);
            bits[1].store((number >> 32) as u32, Ordering::Relaxed);
        }
    }

    /// Steps of the last fragment.
    pub(super) fn fragment_steps(&self, slot: u32) -> usize {
        self.slot(slot).fragment_steps.load(Ordering::Relaxed) as usize
    }

    /// Sets the steps of the last fragment.
    pub(super) fn set_fragment_steps(&self, slot: u32, steps: usize) {
        self.slot(slot).fragment_steps.store(steps as u32, Ordering::Relaxed);
    }

    fn bell(&self) -> &SlotBell {
        // SAFETY: the region begins with a page for the bell, initially zero and only accessed as atomics, for which
        // every bit pattern is valid.
        unsafe { &*self.map.as_ptr().cast() }
    }

    /// Returns the number of processors that this process may use.
    pub(super) fn processors(&self) -> usize {
        self.processors as usize
    }

    /// Sets the number of episodes in progress.
    pub(super) fn set_episodes(&self, episodes: u32) {
        self.bell().episodes.store(episodes, Ordering::Relaxed);
    }

    /// Spins for a moment until a condition holds, if owner and workers each have a processor. Returns whether it
    /// holds.
    fn wait_actively(&self, is_over: impl Fn() -> bool) -> bool {
        let has_room = self.bell().episodes.load(Ordering::Relaxed) < self.processors;
        if has_room { self.spin.until(is_over) } else { is_over() }
    }

    fn slot(&self, slot: u32) -> &Slot {
        // SAFETY: as for the bell; `at` is within the region and aligned.
        unsafe { &*self.at(slot, 0).cast() }
    }

    fn at(&self, slot: u32, offset: usize) -> *mut u8 {
        let slot = slot as usize;
        assert!(slot < SLOTS && offset < SLOT, "slot {slot} of {SLOTS}");
        // SAFETY: within the mapping, as just checked.
        unsafe { self.map.as_mut_ptr().add(PAGE + slot * SLOT + offset) }
    }

    /// Numbers of a slot. The caller's side must hold the slot.
    #[allow(clippy::mut_from_ref, reason = "the slot's state says who may write, not the borrow")]
    unsafe fn numbers(&self, slot: u32, first: usize, count: usize) -> &mut [f64] {
        assert!(count <= WIDTH, "{count} numbers where {WIDTH} have room");
        let offset = size_of::<Slot>() + first * size_of::<f64>();
        // SAFETY: within the slot, aligned, every bit pattern is a number, and the caller guarantees exclusive access.
        unsafe { slice::from_raw_parts_mut(self.at(slot, offset).cast(), count) }
    }

    /// Writes the action of a slot that this side holds.
    pub(super) fn write_action(&self, slot: u32, action: &[f64]) {
        // SAFETY: the caller holds the slot, and the borrow ends here.
        unsafe { self.numbers(slot, 0, action.len()) }.copy_from_slice(action);
    }

    /// Reads the action of a slot that this side holds.
    pub(super) fn read_action(&self, slot: u32, action: &mut [f64]) {
        // SAFETY: as for `write_action`.
        action.copy_from_slice(unsafe { self.numbers(slot, 0, action.len()) });
    }

    /// Writes the observation of a slot that this side holds.
    pub(super) fn write_observation(&self, slot: u32, observation: &[f64]) {
        // SAFETY: as for `write_action`.
        unsafe { self.numbers(slot, WIDTH, observation.len()) }.copy_from_slice(observation);
    }

    /// Reads the observation of a slot that this side holds.
    pub(super) fn read_observation(&self, slot: u32, observation: &mut [f64]) {
        // SAFETY: as for `write_action`.
        observation.copy_from_slice(unsafe { self.numbers(slot, WIDTH, observation.len()) });
    }

    /// Returns whether an order or a report fits into a slot.
    pub(super) const fn has_room_for(text: &[u8]) -> bool {
        text.len() <= REPORT
    }

    /// Writes a text, truncated to the size of the slot.
    pub(super) fn write_report(&self, slot: u32, report: &[u8]) {
        let report = &report[..report.len().min(REPORT)];
        let offset = size_of::<Slot>() + 2 * WIDTH * size_of::<f64>();
        // SAFETY: within the slot; the caller holds the slot, and the borrow ends here.
        unsafe { slice::from_raw_parts_mut(self.at(slot, offset), report.len()) }.copy_from_slice(report);
        self.slot(slot).report_bytes.store(report.len() as u32, Ordering::Relaxed);
    }

    /// The text in a slot that this side holds.
    pub(super) fn report(&self, slot: u32) -> Vec<u8> {
        let bytes = (self.slot(slot).report_bytes.load(Ordering::Relaxed) as usize).min(REPORT);
        let offset = size_of::<Slot>() + 2 * WIDTH * size_of::<f64>();
        // SAFETY: as for `write_report`.
        unsafe { slice::from_raw_parts(self.at(slot, offset), bytes) }.to_vec()
    }

    /// Reward and terms of the last step.
    pub(super) fn step_numbers(&self, slot: u32) -> StepNumbers {
        self.slot(slot).step_numbers.each_ref().map(|bits| f64::from_bits(bits.load(Ordering::Relaxed)))
    }

    /// Writes reward and terms of a step.
    pub(super) fn set_step_numbers(&self, slot: u32, numbers: StepNumbers) {
        for (bits, number) in self.slot(slot).step_numbers.iter().zip(numbers) {
            bits.store(number.to_bits(), Ordering::Relaxed);
        }
    }

    /// The process attached to a slot, 0 for none.
    pub(super) fn process(&self, slot: u32) -> u32 {
        unpack(self.slot(slot).occupant.load(Ordering::Acquire)).1
    }

    /// A slot in its current use.
    pub(super) fn ticket(&self, slot: u32) -> Ticket {
        Ticket { slot, generation: unpack(self.slot(slot).occupant.load(Ordering::Acquire)).0 }
    }

    /// How the episode of a slot is run.
    pub(super) fn options(&self, slot: u32) -> EpisodeOptions {
        let slot = self.slot(slot);
        let steps = slot.steps.load(Ordering::Relaxed);
        EpisodeOptions {
            max_steps: (steps > 0).then_some(steps as usize),
            processor: slot.processor.load(Ordering::Relaxed).checked_sub(1),
            finish_run: slot.finish_run.load(Ordering::Relaxed) != 0,
        }
    }

    /// Status of the worker of a slot.
    pub(super) fn status(&self, slot: u32) -> Status {
        match self.slot(slot).status.load(Ordering::Relaxed) {
            0 => Status::Running,
            1 => Status::Truncated,
            _ => Status::Failed,
        }
    }

    /// Sets the status of the worker of a slot.
    pub(super) fn set_status(&self, slot: u32, status: Status) {
        self.slot(slot).status.store(status as u32, Ordering::Relaxed);
    }

    /// Wait status of the process of a slot, once its parent has reaped it.
    pub(super) fn exit(&self, slot: u32) -> Option<i32> {
        let exit = self.slot(slot).exit.load(Ordering::Acquire);
        (exit & EXITED != 0).then_some((exit & !EXITED) as i32)
    }
}

#[cfg(test)]
mod tests;
