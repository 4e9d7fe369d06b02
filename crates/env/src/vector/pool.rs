//! The owner's side: templates, the episodes copied from them, and what became of each.
//!
//! A [`Pool`] owns processes of one thread each. A template stands at the end of a building's warm-up; an episode is
//! its copy, and a snapshot is the copy of an episode. Actions and observations pass through shared memory, and
//! nobody who waits takes a core. A process that dies, hangs or is killed is one episode lost, with a reason.

use std::collections::VecDeque;
use std::fmt;
use std::io;
use std::os::fd::OwnedFd;
use std::path::{Path, PathBuf};
use std::process::Child;
use std::sync::Arc;
use std::time::{Duration, Instant};

use b2b_building::PreparedBuilding;
use rustix::event::{PollFd, PollFlags, Timespec};
use rustix::process::{Pid, PidfdFlags, Signal};
use tempfile::TempDir;

use super::launcher::Launcher;
use super::order::{Order, Source};
use super::region::{COPIES, Command, Region, SEATS, Standing, Start, WIDTH};
use crate::metrics::Metrics;
use crate::reward::Reward;
use crate::spaces::{EpisodeConfig, Spaces};
use crate::{Error, Result};

/// How often somebody who waits looks whether those it waits for are alive.
const LOOK: Duration = Duration::from_millis(50);

/// How a pool works.
#[derive(Clone, Debug)]
pub struct PoolOptions {
    /// How processes are started.
    pub launcher: Launcher,
    /// The engine's library.
    pub library: PathBuf,
    /// Memory that templates without episodes may hold, bytes. The least recently used goes first.
    pub template_memory: u64,
    /// A process that is busy for longer is taken for hung, and its episode is lost.
    pub time_out: Duration,
    /// Asked now and then by whoever waits; when true, waiting ends with [`Error::Interrupted`].
    pub interrupted: fn() -> bool,
}

impl PoolOptions {
    /// 2 GiB for templates, half a minute for a step, and no interrupts.
    pub fn new(launcher: Launcher, library: impl Into<PathBuf>) -> Self {
        Self {
            launcher,
            library: library.into(),
            template_memory: 2 << 30,
            time_out: Duration::from_secs(30),
            interrupted: || false,
        }
    }
}

/// What an episode is of: a building, its weather, its days and its task.
#[derive(Clone, Debug)]
pub struct Setting {
    /// The building. Settings that share one share what was prepared of it.
    pub source: Arc<Source>,
    /// The rest.
    pub episode: EpisodeConfig,
}

impl Setting {
    fn is(&self, other: &Self) -> bool {
        self.episode == other.episode && self.has_building(other)
    }

    fn has_building(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.source, &other.source)
            || self.source.name() == other.source.name() && self.source == other.source
    }
}

/// A template of a pool.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TemplateId(usize);

/// A process that stands somewhere in an episode: an episode in progress, or a snapshot of one. Belongs to the pool
/// that gave it; [`Pool::stop`] ends it.
#[derive(Debug)]
pub struct Live {
    seat: u32,
    template: TemplateId,
    spaces: Arc<Spaces>,
    phase: Phase,
}

/// What may hold an episode: see [`Pool::wait`].
pub trait Held {
    /// The episode, if there is one.
    fn live(&mut self) -> Option<&mut Live>;
}

impl Held for Live {
    fn live(&mut self) -> Option<&mut Live> {
        Some(self)
    }
}

impl Held for Option<Live> {
    fn live(&mut self) -> Option<&mut Live> {
        self.as_mut()
    }
}

/// How a [`Live`] stands.
#[derive(Clone, Debug, PartialEq)]
enum Phase {
    /// Ready for an action.
    Standing,
    /// At work until it reports, or is late.
    Busy(Instant),
    /// At the end of its episode.
    Truncated,
    /// Gone, and why.
    Lost(String),
}

impl Live {
    /// Names, units and bounds.
    pub fn spaces(&self) -> &Arc<Spaces> {
        &self.spaces
    }

    /// Whether it works on a command.
    pub fn is_busy(&self) -> bool {
        matches!(self.phase, Phase::Busy(_))
    }

    /// Whether its episode is over.
    pub fn is_truncated(&self) -> bool {
        self.phase == Phase::Truncated
    }

    /// Why it is gone.
    pub fn lost(&self) -> Option<&str> {
        match &self.phase {
            Phase::Lost(why) => Some(why),
            _ => None,
        }
    }
}

/// A building at the end of its warm-up.
struct Template {
    setting: Setting,
    seat: u32,
    child: Child,
    order: PathBuf,
    spaces: Option<Arc<Spaces>>,
    /// Its resident memory, bytes.
    memory: u64,
    /// Processes that descend from it.
    descendants: usize,
    /// When it was last asked for.
    used: u64,
}

/// Who sits in a seat.
struct Occupant {
    process: OwnedFd,
    /// Whether `process` is its own; until it sits it is that of its original.
    sits: bool,
}

/// A pool of processes.
pub struct Pool {
    options: PoolOptions,
    region: Region,
    templates: Vec<Option<Template>>,
    /// Buildings that were prepared, so that no other template has to.
    prepared: VecDeque<(Setting, Arc<PreparedBuilding>)>,
    occupants: Vec<Option<Occupant>>,
    free: Vec<u32>,
    /// Seats whose processes are about to end.
    dying: VecDeque<u32>,
    clock: u64,
    /// When to look after those who are busy next.
    look: Instant,
    folder: TempDir,
}

/// Buildings whose preparation is remembered.
const PREPARED: usize = 256;

impl fmt::Debug for Pool {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Pool({} templates)", self.templates.iter().flatten().count())
    }
}

impl Pool {
    /// A pool without processes.
    ///
    /// # Errors
    /// [`Error::Pool`] when there is no memory to share or no temporary folder.
    pub fn new(options: PoolOptions) -> Result<Self> {
        let folder = tempfile::Builder::new()
            .prefix("b2b-pool-")
            .tempdir()
            .map_err(|source| Error::Io { path: std::env::temp_dir(), source })?;
        Ok(Self {
            region: Region::new().map_err(pool("memory to share with workers"))?,
            options,
            templates: Vec::new(),
            prepared: VecDeque::new(),
            occupants: Vec::new(),
            free: Vec::new(),
            dying: VecDeque::new(),
            clock: 0,
            look: Instant::now() + LOOK,
            folder,
        })
    }

    /// Has a template made for a setting, unless there is one. Does not wait for it.
    ///
    /// # Errors
    /// [`Error::Pool`] when no process can be started; [`Error::Io`] for its order.
    pub fn prepare(&mut self, setting: &Setting) -> Result<TemplateId> {
        self.clock += 1;
        let there = |t: &Option<Template>| t.as_ref().is_some_and(|t| t.setting.is(setting));
        if let Some(index) = self.templates.iter().position(there) {
            let id = TemplateId(index);
            self.template_mut(id).used = self.clock;
            return Ok(id);
        }
        self.make_room();
        let template = self.start_template(setting)?;
        let vacant = self.templates.iter().position(Option::is_none);
        let index = vacant.unwrap_or(self.templates.len());
        if index == self.templates.len() {
            self.templates.push(None);
        }
        self.templates[index] = Some(template);
        Ok(TemplateId(index))
    }

    /// Waits for a template.
    ///
    /// # Errors
    /// [`Error::Template`] with the reason when the building cannot be made an environment.
    pub fn spaces(&mut self, id: TemplateId) -> Result<Arc<Spaces>> {
        if let Some(spaces) = &self.template(id).spaces {
            return Ok(Arc::clone(spaces));
        }
        while !self.region.is_ready(self.template(id).seat) {
            let done = self.region.done();
            self.check_interrupt()?;
            if self.is_gone(self.template(id).seat) && !self.region.is_ready(self.template(id).seat) {
                let program = self.options.launcher.program().display();
                return Err(self.give_up(id, &format!("its process ({program}) was killed or crashed")));
            }
            self.region.sleep(done, 1, LOOK);
        }
        if self.region.standing(self.template(id).seat) == Standing::Failed {
            let why = String::from_utf8_lossy(&self.region.report(self.template(id).seat)).into_owned();
            return Err(self.give_up(id, &why));
        }
        self.read_reply(id).map_err(|error| self.give_up(id, &error.to_string()))
    }

    /// Whether a template is of a setting.
    pub fn is_of(&self, id: TemplateId, setting: &Setting) -> bool {
        self.template(id).setting.is(setting)
    }

    /// Whether [`Pool::spaces`] would not wait.
    pub fn is_ready(&self, id: TemplateId) -> bool {
        let template = self.template(id);
        template.spaces.is_some() || self.region.is_ready(template.seat) || self.is_gone(template.seat)
    }

    /// Begins an episode at the end of a template's warm-up. It is busy until it stands.
    ///
    /// # Errors
    /// As [`Pool::spaces`]; [`Error::Pool`].
    pub fn begin(&mut self, id: TemplateId, start: Start) -> Result<Live> {
        let mut live = self.begin_several(id, &[start])?;
        Ok(live.remove(0))
    }

    /// As [`Pool::begin`], several at once.
    ///
    /// # Errors
    /// As [`Pool::begin`].
    pub fn begin_several(&mut self, id: TemplateId, starts: &[Start]) -> Result<Vec<Live>> {
        let setting = self.template(id).setting.clone();
        let mut outcome = self.try_begin(id, starts);
        if let Err(Error::Gone { .. }) = outcome {
            // The template was killed: another takes its place.
            let descendants = self.template(id).descendants;
            self.remove_template(id);
            self.templates[id.0] = Some(Template { descendants, ..self.start_template(&setting)? });
            outcome = self.try_begin(id, starts);
        }
        outcome
    }

    fn try_begin(&mut self, id: TemplateId, starts: &[Start]) -> Result<Vec<Live>> {
        let spaces = self.spaces(id)?;
        self.clock += 1;
        let clock = self.clock;
        let template = self.template_mut(id);
        template.used = clock;
        let seat = template.seat;
        self.copy(seat, id, &spaces, starts)
    }

    /// A snapshot of an episode where it stands: another process that stands there too. It is busy until it does.
    ///
    /// # Errors
    /// [`Error::Gone`] when the episode is lost or over; [`Error::Pool`].
    pub fn snapshot(&mut self, live: &Live) -> Result<Live> {
        let mut copies = self.branch(live, 1)?;
        Ok(copies.remove(0))
    }

    /// So many episodes that go on from where this one, or this snapshot, stands.
    ///
    /// # Errors
    /// As [`Pool::snapshot`].
    pub fn branch(&mut self, live: &Live, count: usize) -> Result<Vec<Live>> {
        if live.phase != Phase::Standing {
            let why = live.lost().unwrap_or("it does not stand in an episode").to_owned();
            return Err(Error::Gone { what: "the episode to copy", why });
        }
        let copies = self.copy(live.seat, live.template, &live.spaces, &vec![Start::default(); count])?;
        // It copies itself before it does anything else.
        self.wait_until_ready(live.seat)?;
        Ok(copies)
    }

    /// Gives an action to an episode that stands. It is busy until the step is done.
    ///
    /// # Errors
    /// [`Error::ActionLength`] and [`Error::ActionNotFinite`] before anything is sent; [`Error::Gone`].
    pub fn send(&self, live: &mut Live, action: &[f64]) -> Result<()> {
        if live.phase != Phase::Standing {
            let why = match &live.phase {
                Phase::Lost(why) => why,
                Phase::Truncated => "it is over",
                _ => "it is busy with another step",
            };
            return Err(Error::Gone { what: "the episode to act in", why: why.to_owned() });
        }
        live.spaces.action.check(action)?;
        self.region.write_action(live.seat, action);
        self.region.command(live.seat, Command::Step);
        live.phase = Phase::Busy(Instant::now() + self.options.time_out);
        Ok(())
    }

    /// Waits until at least `count` of these are not busy; a place without an episode is not.
    ///
    /// # Errors
    /// [`Error::Interrupted`]; they go on then.
    pub fn wait<H: Held>(&mut self, held: &mut [H], count: usize) -> Result<()> {
        let count = count.min(held.len());
        loop {
            let done = self.done();
            if self.rest(held, count, done)? >= count {
                return Ok(());
            }
        }
    }

    /// What has been done so far, for [`Pool::rest`]: to be had before looking at what is done.
    pub(super) fn done(&self) -> u32 {
        self.region.done()
    }

    /// Sleeps until `count` of these are not busy, or something else has happened since `done`. How many are not
    /// busy.
    pub(super) fn rest<H: Held>(&mut self, held: &mut [H], count: usize, done: u32) -> Result<usize> {
        let ready = held.iter_mut().map(|held| usize::from(self.settle(held))).sum::<usize>();
        if ready >= count {
            return Ok(ready);
        }
        self.region.sleep(done, (count - ready) as u32, LOOK);
        if Instant::now() >= self.look {
            self.check_interrupt()?;
            held.iter_mut().filter_map(Held::live).for_each(|live| self.look_after(live));
            self.look = Instant::now() + LOOK;
        }
        Ok(held.iter_mut().map(|held| usize::from(self.settle(held))).sum())
    }

    /// The observation where an episode stands. Length is that of the observation space.
    pub fn observation(&self, live: &Live, observation: &mut [f64]) {
        self.region.read_observation(live.seat, observation);
    }

    /// The action that the last step carried out.
    pub fn action(&self, live: &Live, action: &mut [f64]) {
        self.region.read_action(live.seat, action);
    }

    /// The reward of the last step.
    pub fn reward(&self, live: &Live) -> Reward {
        let [temperature_penalty, energy_penalty] = self.region.penalties(live.seat);
        Reward { temperature_penalty, energy_penalty }
    }

    /// The sums over an episode that is over. `None` before its end.
    pub fn metrics(&self, live: &Live) -> Option<Metrics> {
        live.is_truncated().then(|| serde_json::from_slice(&self.region.report(live.seat)).ok()).flatten()
    }

    /// The process of an episode, for those who measure it. `None` before it stands.
    pub fn process(&self, live: &Live) -> Option<u32> {
        Some(self.region.process(live.seat)).filter(|process| *process != 0)
    }

    /// The processes of the templates.
    pub fn template_processes(&self) -> Vec<u32> {
        self.templates.iter().flatten().map(|template| template.child.id()).collect()
    }

    /// The temporary folder of everything its processes write. It goes with the pool.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// Ends a process.
    pub fn stop(&mut self, live: Live) {
        let template = self.templates.get_mut(live.template.0).and_then(Option::as_mut);
        if let Some(template) = template {
            template.descendants = template.descendants.saturating_sub(1);
        }
        self.vacate(live.seat);
    }

    /// Whether one is no longer busy; reads what it reports.
    fn settle<H: Held>(&mut self, held: &mut H) -> bool {
        let Some(live) = held.live() else { return true };
        if !live.is_busy() {
            return true;
        }
        if !self.region.is_ready(live.seat) {
            return false;
        }
        live.phase = match self.region.standing(live.seat) {
            Standing::Running => self.meet(live.seat),
            Standing::Truncated => Phase::Truncated,
            Standing::Failed => {
                Phase::Lost(String::from_utf8_lossy(&self.region.report(live.seat)).into_owned())
            }
        };
        true
    }

    /// Makes the acquaintance of a process that sits for the first time.
    fn meet(&mut self, seat: u32) -> Phase {
        let process = self.region.process(seat) as i32;
        match &mut self.occupants[seat as usize] {
            Some(occupant) if !occupant.sits => match open_process(process) {
                Ok(opened) => {
                    *occupant = Occupant { process: opened, sits: true };
                    Phase::Standing
                }
                Err(error) => Phase::Lost(format!("its process {process} is gone: {error}")),
            },
            _ => Phase::Standing,
        }
    }

    /// Finds out whether a busy one is dead or late.
    fn look_after(&mut self, live: &mut Live) {
        let Phase::Busy(deadline) = live.phase else { return };
        if self.is_gone(live.seat) {
            // It may have reported before it died.
            if !self.settle(live) {
                live.phase = Phase::Lost("its process was killed or crashed".into());
            }
        } else if Instant::now() > deadline {
            self.kill(live.seat);
            live.phase = Phase::Lost(format!("its process took longer than {:?}", self.options.time_out));
        }
    }

    /// Commands the process in a seat to copy itself.
    fn copy(
        &mut self,
        source: u32,
        template: TemplateId,
        spaces: &Arc<Spaces>,
        starts: &[Start],
    ) -> Result<Vec<Live>> {
        let mut lives = Vec::with_capacity(starts.len());
        for starts in starts.chunks(COPIES) {
            self.wait_until_ready(source)?;
            let first = lives.len();
            for start in starts {
                let process = self.process_of(source)?;
                let seat = self.take_seat(Occupant { process, sits: false })?;
                self.region.lay(seat, *start);
                let phase = Phase::Busy(Instant::now() + self.options.time_out);
                lives.push(Live { seat, template, spaces: Arc::clone(spaces), phase });
            }
            let seats: Vec<u32> = lives[first..].iter().map(|live| live.seat).collect();
            self.region.list_copies(source, &seats);
            self.region.command(source, Command::Copy);
        }
        self.template_mut(template).descendants += lives.len();
        Ok(lives)
    }

    /// Waits for a process that copies itself to be done with that.
    fn wait_until_ready(&mut self, seat: u32) -> Result<()> {
        let deadline = Instant::now() + self.options.time_out;
        loop {
            let done = self.region.done();
            if self.is_gone(seat) {
                return Err(gone("its process was killed or crashed"));
            }
            if self.region.is_ready(seat) {
                return Ok(());
            }
            self.check_interrupt()?;
            if Instant::now() > deadline {
                self.kill(seat);
                return Err(gone("its process hung"));
            }
            self.region.sleep(done, 1, LOOK);
        }
    }

    fn check_interrupt(&self) -> Result<()> {
        if (self.options.interrupted)() { Err(Error::Interrupted) } else { Ok(()) }
    }
}

/// Templates.
impl Pool {
    fn template(&self, id: TemplateId) -> &Template {
        self.templates[id.0].as_ref().expect("a template is removed only with its id")
    }

    fn template_mut(&mut self, id: TemplateId) -> &mut Template {
        self.templates[id.0].as_mut().expect("a template is removed only with its id")
    }

    fn start_template(&mut self, setting: &Setting) -> Result<Template> {
        let known = self.prepared.iter().find(|(known, _)| {
            known.episode.weather == setting.episode.weather && known.has_building(setting)
        });
        let source = match known {
            Some((_, building)) => Source::Prepared(Box::new(PreparedBuilding::clone(building))),
            None => Source::clone(&setting.source),
        };
        let order = Order { library: self.options.library.clone(), source, episode: setting.episode.clone() };
        let seat = self.free_seat()?;
        self.region.lay(seat, Start::default());
        let path = self.folder.path().join(format!("template-{seat}-{}.json", self.clock));
        let text = serde_json::to_vec(&order).expect("an order is plain data");
        std::fs::write(&path, text).map_err(|source| Error::Io { path: path.clone(), source })?;
        let memory = self.region.share().map_err(pool("a descriptor of the shared memory"))?;
        let launcher = &self.options.launcher;
        let child = launcher.start(memory, seat, &path, self.folder.path()).map_err(|source| {
            Error::Pool { what: format!("a process of {}", launcher.program().display()), source }
        })?;
        let process = open_process(child.id() as i32).map_err(pool("a handle of a process"))?;
        self.occupants[seat as usize] = Some(Occupant { process, sits: true });
        Ok(Template {
            setting: setting.clone(),
            seat,
            child,
            order: path,
            spaces: None,
            memory: 0,
            descendants: 0,
            used: self.clock,
        })
    }

    /// What a template says it is.
    fn read_reply(&mut self, id: TemplateId) -> Result<Arc<Spaces>> {
        let template = self.template(id);
        let path = template.order.with_extension("ready");
        let io = |source| Error::Io { path: path.clone(), source };
        let text = std::fs::read(&path).map_err(io)?;
        let building: PreparedBuilding = serde_json::from_slice(&text).map_err(|e| io(e.into()))?;
        for path in [&path, &template.order] {
            std::fs::remove_file(path).map_err(io)?;
        }
        let building = Arc::new(building);
        let memory = resident_memory(template.child.id()).unwrap_or(0);
        let setting = template.setting.clone();
        let spaces = Arc::new(Spaces::new(Arc::clone(&building), setting.episode.clone()));
        check_widths(&spaces)?;
        let template = self.template_mut(id);
        template.memory = memory;
        template.spaces = Some(Arc::clone(&spaces));
        self.prepared.retain(|(known, _)| {
            known.episode.weather != setting.episode.weather || !known.has_building(&setting)
        });
        self.prepared.push_back((setting, building));
        if self.prepared.len() > PREPARED {
            self.prepared.pop_front();
        }
        Ok(spaces)
    }

    fn give_up(&mut self, id: TemplateId, why: &str) -> Error {
        let name = self.template(id).setting.source.name().to_owned();
        let gone = self.is_gone(self.template(id).seat);
        if !gone || self.region.standing(self.template(id).seat) == Standing::Failed {
            return Error::Template { name, why: why.to_owned() };
        }
        Error::Gone { what: "a template", why: why.to_owned() }
    }

    /// Ends templates that nobody descends from, the least recently used first, until the rest is within budget.
    fn make_room(&mut self) {
        loop {
            let memory: u64 = self.templates.iter().flatten().map(|template| template.memory).sum();
            let idle = self.templates.iter().enumerate().filter_map(|(index, template)| {
                let template = template.as_ref()?;
                (template.descendants == 0 && template.spaces.is_some()).then_some((template.used, index))
            });
            match idle.min() {
                Some((_, index)) if memory > self.options.template_memory => {
                    self.remove_template(TemplateId(index));
                    self.templates[index] = None;
                }
                _ => return,
            }
        }
    }

    fn remove_template(&mut self, id: TemplateId) {
        let Some(mut template) = self.templates[id.0].take() else { return };
        // Killing a process that is gone already is no error that matters here.
        let _ = template.child.kill();
        let _ = template.child.wait();
        let _ = std::fs::remove_file(&template.order);
        let _ = std::fs::remove_file(template.order.with_extension("ready"));
        self.vacate(template.seat);
    }
}

/// Seats.
impl Pool {
    fn take_seat(&mut self, occupant: Occupant) -> Result<u32> {
        let seat = self.free_seat()?;
        self.occupants[seat as usize] = Some(occupant);
        Ok(seat)
    }

    fn free_seat(&mut self) -> Result<u32> {
        self.collect_the_dead();
        if let Some(seat) = self.free.pop() {
            return Ok(seat);
        }
        let seat = self.occupants.len();
        if seat == SEATS {
            let full = io::Error::other(format!("all {SEATS} seats are taken"));
            return Err(pool("another process")(full));
        }
        self.region.reserve(seat as u32).map_err(pool("memory to share with a worker"))?;
        self.occupants.push(None);
        Ok(seat as u32)
    }

    /// Ends the process in a seat; the seat is free once it is gone.
    fn vacate(&mut self, seat: u32) {
        self.kill(seat);
        self.dying.push_back(seat);
    }

    fn kill(&self, seat: u32) {
        if let Some(Occupant { process, sits: true }) = &self.occupants[seat as usize] {
            // It may be gone already.
            let _ = rustix::process::pidfd_send_signal(process, Signal::KILL);
        }
    }

    fn collect_the_dead(&mut self) {
        for _ in 0..self.dying.len() {
            let Some(seat) = self.dying.pop_front() else { return };
            let sits = self.occupants[seat as usize].as_ref().is_some_and(|occupant| occupant.sits);
            if !sits && self.meet_late(seat) {
                self.kill(seat);
            }
            let sits = self.occupants[seat as usize].as_ref().is_none_or(|occupant| occupant.sits);
            if sits && self.is_gone(seat) {
                self.occupants[seat as usize] = None;
                self.free.push(seat);
            } else {
                self.dying.push_back(seat);
            }
        }
    }

    /// A copy that was given up before it sat may sit later.
    fn meet_late(&mut self, seat: u32) -> bool {
        self.region.process(seat) != 0 && self.meet(seat) == Phase::Standing
    }

    fn process_of(&self, seat: u32) -> Result<OwnedFd> {
        let occupant = self.occupants[seat as usize].as_ref().ok_or_else(|| gone("it was stopped"))?;
        occupant.process.try_clone().map_err(pool("a handle of a process"))
    }

    /// Whether the process in a seat has ended; for one that does not sit yet, whether its original has.
    fn is_gone(&self, seat: u32) -> bool {
        let Some(occupant) = &self.occupants[seat as usize] else { return true };
        let mut ends = [PollFd::new(&occupant.process, PollFlags::IN)];
        rustix::event::poll(&mut ends, Some(&Timespec::default())).is_ok_and(|ready| ready > 0)
    }
}

impl Drop for Pool {
    /// Ends every process: copies first, so that their templates see them off.
    fn drop(&mut self) {
        let templates: Vec<u32> = self.templates.iter().flatten().map(|template| template.seat).collect();
        let copies = (0..self.occupants.len() as u32).filter(|seat| !templates.contains(seat));
        let copies: Vec<u32> = copies.collect();
        let deadline = Instant::now() + Duration::from_secs(5);
        for seat in copies {
            if self.region.process(seat) != 0 {
                self.meet(seat);
            }
            self.kill(seat);
            let sits = self.occupants[seat as usize].as_ref().is_some_and(|occupant| occupant.sits);
            while sits && !self.is_gone(seat) && Instant::now() < deadline {
                std::thread::sleep(Duration::from_micros(200));
            }
        }
        (0..self.templates.len()).for_each(|index| self.remove_template(TemplateId(index)));
    }
}

/// A worker must have room for the action and the observation.
fn check_widths(spaces: &Spaces) -> Result<()> {
    for (what, width) in [("actuators", spaces.action.len()), ("slots", spaces.observation.len())] {
        if width > WIDTH {
            let name = spaces.building.name.clone();
            return Err(Error::TooWide { name, what, width, most: WIDTH });
        }
    }
    Ok(())
}

fn open_process(process: i32) -> io::Result<OwnedFd> {
    let pid = Pid::from_raw(process).ok_or_else(|| io::Error::other("it has no number"))?;
    Ok(rustix::process::pidfd_open(pid, PidfdFlags::empty())?)
}

/// Resident memory of a process, bytes.
fn resident_memory(process: u32) -> Option<u64> {
    let text = std::fs::read_to_string(format!("/proc/{process}/statm")).ok()?;
    Some(text.split(' ').nth(1)?.parse::<u64>().ok()? * rustix::param::page_size() as u64)
}

fn pool(what: &str) -> impl Fn(io::Error) -> Error {
    move |source| Error::Pool { what: what.to_owned(), source }
}

fn gone(why: &str) -> Error {
    Error::Gone { what: "a template", why: why.to_owned() }
}
