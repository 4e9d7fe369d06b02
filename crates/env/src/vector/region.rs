//! Memory that a pool shares with its workers: a slot for every worker.
//!
//! A slot belongs to one side at a time: to the worker while it is [`BUSY`], to the owner otherwise. The state changes
//! hands with release and acquire, and whoever waits sleeps on a futex. A worker attaches to its slot with the
//! generation that it was given, so that one that comes late, after its slot was given to another, finds out.
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

use super::episode_options::EpisodeOptions;

/// How often a waiting owner looks whether the workers it waits for are alive.
pub(super) const LOOK: Duration = Duration::from_millis(50);
/// Slots of a region: more processes than one machine holds.
pub(super) const SLOTS: usize = 2048;
/// Maximum number of actuators of a building, and of slots of an observation.
pub(super) const WIDTH: usize = 1024;
/// Maximum size of a report, bytes.
const REPORT: usize = 48 * 1024;
/// Maximum number of copies that one command makes.
pub(super) const COPIES: usize = 128;

const PAGE: usize = 4096;
const SLOT: usize = (size_of::<Slot>() + 2 * WIDTH * size_of::<f64>() + REPORT).next_multiple_of(PAGE);
/// Where the memory for fragments begins.
const SHARED: usize = PAGE + SLOTS * SLOT;
/// Maximum number of f32 numbers that fragments share. Only what is reserved takes memory.
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

/// A slot in its current use, as it is told to the worker that shall attach to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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

/// The slot waits for the owner.
const READY: u32 = 0;
/// A command is being carried out.
const BUSY: u32 = 1;
/// Marks an exit status as known.
const EXITED: u32 = 1 << 31;

/// What both sides wait on.
#[repr(C, align(64))]
struct Bell {
    /// Commands carried out by all workers; a futex.
    done: AtomicU32,
    /// The bell rings when `done` reaches this.
    wanted: AtomicU32,
    /// Slots ever reserved.
    slots: AtomicU32,
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
    temperature_penalty: AtomicU64,
    energy_penalty: AtomicU64,
    /// Wait status of a process that ended, and [`EXITED`].
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

    /// A descriptor to give to a worker.
    pub(super) fn share(&self) -> std::io::Result<OwnedFd> {
        self.file.as_fd().try_clone_to_owned()
    }

    /// Takes memory for a slot, so that none can be missing when it is written to.
    pub(super) fn reserve(&self, slot: u32) -> std::io::Result<()> {
        let begin = (PAGE + slot as usize * SLOT) as u64;
        rustix::fs::fallocate(&self.file, FallocateFlags::empty(), begin, SLOT as u64)?;
        self.bell().slots.fetch_max(slot + 1, Ordering::SeqCst);
        Ok(())
    }

    /// Takes memory for numbers that fragments share, so that none can be missing when they are written to.
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
        // SAFETY: within the mapping, as just checked, aligned, and only ever touched as atomics.
        unsafe {
            slice::from_raw_parts(self.map.as_ptr().add(SHARED + place * size_of::<f32>()).cast(), count)
        }
    }

    /// Reads numbers that fragments share.
    pub(super) fn read_shared(&self, place: usize, numbers: &mut [f32]) {
        let shared = self.shared(place, numbers.len());
        for (number, bits) in numbers.iter_mut().zip(shared) {
            *number = f32::from_bits(bits.load(Ordering::Relaxed));
        }
    }

    /// Writes numbers that fragments share.
    pub(super) fn write_shared(&self, place: usize, numbers: &[f32]) {
        for (bits, number) in self.shared(place, numbers.len()).iter().zip(numbers) {
            bits.store(number.to_bits(), Ordering::Relaxed);
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

    fn bell(&self) -> &Bell {
        // SAFETY: the region begins with a page of its own for the bell, all zeros at first and only ever touched
        // as atomics, for which every bit pattern is valid.
        unsafe { &*self.map.as_ptr().cast() }
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
        // SAFETY: within the slot, aligned, every bit pattern is a number, and by the caller's promise nobody else
        // touches it.
        unsafe { slice::from_raw_parts_mut(self.at(slot, offset).cast(), count) }
    }

    /// The action of a slot that this side holds.
    pub(super) fn write_action(&self, slot: u32, action: &[f64]) {
        // SAFETY: the caller holds the slot, and the borrow ends here.
        unsafe { self.numbers(slot, 0, action.len()) }.copy_from_slice(action);
    }

    /// The action of a slot that this side holds.
    pub(super) fn read_action(&self, slot: u32, action: &mut [f64]) {
        // SAFETY: as for `write_action`.
        action.copy_from_slice(unsafe { self.numbers(slot, 0, action.len()) });
    }

    /// The observation of a slot that this side holds.
    pub(super) fn write_observation(&self, slot: u32, observation: &[f64]) {
        // SAFETY: as for `write_action`.
        unsafe { self.numbers(slot, WIDTH, observation.len()) }.copy_from_slice(observation);
    }

    /// The observation of a slot that this side holds.
    pub(super) fn read_observation(&self, slot: u32, observation: &mut [f64]) {
        // SAFETY: as for `write_action`.
        observation.copy_from_slice(unsafe { self.numbers(slot, WIDTH, observation.len()) });
    }

    /// Whether an order of this length has room in a slot.
    pub(super) const fn has_room_for(order: &[u8]) -> bool {
        order.len() <= REPORT
    }

    /// Writes a text, cut to the room there is.
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

    /// The penalties of the last step.
    pub(super) fn penalties(&self, slot: u32) -> [f64; 2] {
        let slot = self.slot(slot);
        [&slot.temperature_penalty, &slot.energy_penalty]
            .map(|bits| f64::from_bits(bits.load(Ordering::Relaxed)))
    }

    /// Writes the penalties of a step.
    pub(super) fn set_penalties(&self, slot: u32, [temperature, energy]: [f64; 2]) {
        let slot = self.slot(slot);
        slot.temperature_penalty.store(temperature.to_bits(), Ordering::Relaxed);
        slot.energy_penalty.store(energy.to_bits(), Ordering::Relaxed);
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

/// The owner's side.
impl Region {
    /// Initializes a slot for a worker to come: busy until the worker reports.
    pub(super) fn init(&self, slot: u32, options: EpisodeOptions) {
        let entry = self.slot(slot);
        let Ticket { generation, .. } = self.ticket(slot);
        entry.report_bytes.store(0, Ordering::Relaxed);
        entry.exit.store(0, Ordering::Relaxed);
        let steps = options.max_steps.map_or(0, |steps| steps.clamp(1, u32::MAX as usize) as u32);
        entry.steps.store(steps, Ordering::Relaxed);
        entry.processor.store(options.processor.map_or(0, |processor| processor + 1), Ordering::Relaxed);
        entry.finish_run.store(options.finish_run.into(), Ordering::Relaxed);
        entry.status.store(Status::Running as u32, Ordering::Relaxed);
        entry.state.store(BUSY, Ordering::Relaxed);
        entry.occupant.store(pack(generation.wrapping_add(1), 0), Ordering::Release);
    }

    /// Takes a slot back from a worker that has not attached yet and now never can. False if it has attached.
    pub(super) fn revoke(&self, slot: u32) -> bool {
        let Ticket { generation, .. } = self.ticket(slot);
        let (awaited, next) = (pack(generation, 0), pack(generation.wrapping_add(1), 0));
        let occupant = &self.slot(slot).occupant;
        occupant.compare_exchange(awaited, next, Ordering::AcqRel, Ordering::Acquire).is_ok()
    }

    /// Reports a failure in the name of a worker that never attached.
    pub(super) fn fail(&self, slot: u32, why: &str) {
        self.write_report(slot, why.as_bytes());
        self.set_status(slot, Status::Failed);
        self.slot(slot).state.store(READY, Ordering::Release);
    }

    /// Gives a command to the worker of a slot that is ready.
    pub(super) fn command(&self, slot: u32, command: Command) {
        let slot = self.slot(slot);
        slot.command.store(command as u32, Ordering::Relaxed);
        slot.state.store(BUSY, Ordering::Release);
        wake(&slot.state);
    }

    /// Lists the slots for [`Command::Copy`].
    pub(super) fn list_copies(&self, slot: u32, copies: &[u32]) {
        let entry = self.slot(slot);
        for (item, copy) in entry.copy_list.iter().zip(copies) {
            let Ticket { slot, generation } = self.ticket(*copy);
            item.store(pack(generation, slot), Ordering::Relaxed);
        }
        entry.copies.store(copies.len() as u32, Ordering::Relaxed);
    }

    /// Whether the owner holds a slot.
    pub(super) fn is_ready(&self, slot: u32) -> bool {
        self.slot(slot).state.load(Ordering::Acquire) == READY
    }

    /// Commands carried out so far: to be read before slots are looked at, and given to [`Region::sleep`].
    pub(super) fn done(&self) -> u32 {
        self.bell().done.load(Ordering::SeqCst)
    }

    /// Sleeps until `more` commands after `done` are carried out, or the time is over, or a signal comes.
    pub(super) fn sleep(&self, done: u32, more: u32, at_most: Duration) {
        let bell = self.bell();
        bell.wanted.store(done.wrapping_add(more), Ordering::SeqCst);
        let now = bell.done.load(Ordering::SeqCst);
        if (now.wrapping_sub(done) as i32) < more as i32 {
            wait(&bell.done, now, at_most);
        }
    }
}

/// A worker's side.
impl Region {
    /// Attaches this process to a slot. False if the slot was given to another meanwhile.
    pub(super) fn attach(&self, Ticket { slot, generation }: Ticket) -> bool {
        let (awaited, own) = (pack(generation, 0), pack(generation, std::process::id()));
        let occupant = &self.slot(slot).occupant;
        occupant.compare_exchange(awaited, own, Ordering::AcqRel, Ordering::Acquire).is_ok()
    }

    /// Hands the slot back to the owner, and rings the bell if that is the last it waits for.
    pub(super) fn hand_back(&self, slot: u32) {
        let slot = self.slot(slot);
        slot.state.store(READY, Ordering::Release);
        let bell = self.bell();
        let done = bell.done.fetch_add(1, Ordering::SeqCst).wrapping_add(1);
        if done.wrapping_sub(bell.wanted.load(Ordering::SeqCst)) as i32 >= 0 {
            wake(&bell.done);
        }
    }

    /// Waits for a command; `None` when there is none for a time, or a signal comes.
    pub(super) fn next_command(&self, slot: u32, at_most: Duration) -> Option<Command> {
        let slot = self.slot(slot);
        if slot.state.load(Ordering::Acquire) == READY {
            wait(&slot.state, READY, at_most);
            if slot.state.load(Ordering::Acquire) == READY {
                return None;
            }
        }
        Some(match slot.command.load(Ordering::Relaxed) {
            0 => Command::Step,
            1 => Command::Copy,
            _ => Command::Fragment,
        })
    }

    /// The slots listed for copies, those left out that were revoked meanwhile.
    pub(super) fn copies(&self, slot: u32) -> Vec<Ticket> {
        let entry = self.slot(slot);
        let count = (entry.copies.load(Ordering::Relaxed) as usize).min(COPIES);
        let listed = entry.copy_list.iter().take(count).map(|item| {
            let (generation, slot) = unpack(item.load(Ordering::Relaxed));
            Ticket { slot, generation }
        });
        listed.filter(|ticket| self.ticket(ticket.slot) == *ticket).collect()
    }

    /// Keeps the wait status of a process that was attached to a slot.
    pub(super) fn record_exit(&self, process: u32, status: i32) {
        let slots = self.bell().slots.load(Ordering::SeqCst);
        if let Some(slot) = (0..slots).find(|slot| self.process(*slot) == process) {
            self.slot(slot).exit.store(status as u32 | EXITED, Ordering::Release);
        }
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
mod tests;
