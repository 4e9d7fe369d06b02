//! The owner's side: templates, the workers copied from them, and their ends.
//!
//! A [`Pool`] owns processes of one thread each. A template waits at the end of a building's warm-up; an episode is its
//! copy, and a snapshot is the copy of an episode. Actions and observations pass through shared memory, and waiting
//! uses no CPU time. If a worker dies, hangs or is killed, only its episode is lost, with a reason; a template is
//! replaced.

mod preparation;
pub(crate) mod slots;
mod template;

use std::collections::{BTreeMap, VecDeque};
use std::io;
use std::ops::Bound;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use b2b_base::scratch::temporary_folder;
use tempfile::TempDir;

use self::slots::Slots;
pub(super) use self::template::TemplateId;
use self::template::{Prepared, Request, Template, TemplatePhase};
use super::episode::episode_options::EpisodeOptions;
use super::region::{COPIES, Command, LOOK, Region, Status};
use super::setting::EpisodeSetting;
use super::time_limit::TimeLimit;
use super::workers::worker_options::WorkerOptions;
use b2b_env::{Error, Result};

/// Number of templates that die or hang while an episode waits to begin, after which it is lost.
const FAILURES: u32 = 3;
/// Interval at which background preparations are checked.
const BACKGROUND: Duration = Duration::from_millis(5);

/// A pool of worker processes.
pub(super) struct Pool {
    pub(super) options: WorkerOptions,
    region: Arc<Region>,
    slots: Slots,
    templates: BTreeMap<TemplateId, Template>,
    next_template: u64,
    /// Episodes in progress.
    episodes: u32,
    /// Prepared buildings, for other templates.
    prepared: VecDeque<Prepared>,
    clock: u64,
    /// When to check the busy workers next.
    look: Instant,
    /// When to check background preparations next.
    background: Instant,
    /// Folder for all files of its processes; removed with the pool.
    folder: TempDir,
}

/// An episode's place in a pool.
#[derive(Clone, Copy, Debug)]
pub(super) struct SlotPlace {
    pub(super) slot: u32,
    pub(super) template: TemplateId,
}

impl Pool {
    /// Creates a pool without processes.
    ///
    /// # Errors
    /// [`Error::Io`] when there is no temporary folder.
    pub(super) fn new(options: WorkerOptions, region: Arc<Region>) -> Result<Self> {
        let folder = temporary_folder("b2b-pool-").map_err(b2b_energyplus::Error::from)?;
        Ok(Self {
            slots: Slots::new(Arc::clone(&region), folder.path()),
            region,
            options,
            templates: BTreeMap::new(),
            next_template: 0,
            episodes: 0,
            prepared: VecDeque::new(),
            clock: 0,
            look: Instant::now() + LOOK,
            background: Instant::now(),
            folder,
        })
    }

    /// Requests that an episode begin at the end of its template's warm-up, and returns without waiting. The slot is
    /// ready once the episode has begun.
    pub(super) fn start(&mut self, setting: &EpisodeSetting, options: EpisodeOptions) -> Result<SlotPlace> {
        let mut template = self.template_of(setting)?;
        if self.template_mut(template)?.phase == TemplatePhase::Failed {
            self.drop_template(template);
            template = self.template_of(setting)?;
        }
        let slot = self.take_episode_slot(options)?;
        let entry = self.template_mut(template)?;
        entry.users += 1;
        entry.waiting.push_back(Request { slot, failures: 0 });
        Ok(SlotPlace { slot, template })
    }

    /// Advances all waits for templates and all preparations.
    pub(super) fn advance_all(&mut self) {
        let mut next = self.underway(Bound::Unbounded);
        while let Some(id) = next {
            self.advance(id);
            next = self.underway(Bound::Excluded(id));
        }
        self.start_queued();
    }

    /// Advances background preparations, at intervals.
    pub(super) fn advance_all_when_due(&mut self) {
        let now = Instant::now();
        if now >= self.background {
            self.background = now + BACKGROUND;
            if self.templates.values().any(Template::is_unprepared) {
                self.advance_all();
            }
        }
    }

    /// The next template whose process has something to report.
    fn underway(&self, after: Bound<TemplateId>) -> Option<TemplateId> {
        let mut templates = self.templates.range((after, Bound::Unbounded));
        templates.find(|(_, template)| template.is_underway()).map(|(id, _)| *id)
    }

    /// Advances a template: reads its reply, requests copies, replaces it if it has died.
    fn advance(&mut self, id: TemplateId) {
        let Some(template) = self.templates.get_mut(&id) else { return };
        let Some(slot) = template.process.as_ref().map(|process| process.slot) else { return };
        let (ended, ready) = (self.slots.has_ended(slot), self.region.is_ready(slot));
        let is_late = match &mut template.phase {
            TemplatePhase::Preparing(limit) | TemplatePhase::Copying(limit) => limit.is_exceeded(),
            TemplatePhase::Queued | TemplatePhase::Idle | TemplatePhase::Failed => false,
        };
        match template.phase {
            TemplatePhase::Preparing(_) => return self.advance_preparation(id, ready, ended, is_late),
            TemplatePhase::Copying(_) if ready => {
                template.copying.clear();
                template.phase = TemplatePhase::Idle;
            }
            TemplatePhase::Copying(_) if !ended && !is_late => return,
            TemplatePhase::Copying(_) => return self.replace(id),
            TemplatePhase::Queued | TemplatePhase::Idle | TemplatePhase::Failed => {}
        }
        match template.waiting.is_empty() {
            true => {}
            false if ended => self.replace(id),
            false => self.copy_for_those_waiting(id),
        }
    }

    /// Requests copies of an idle template for the waiting slots.
    fn copy_for_those_waiting(&mut self, id: TemplateId) {
        let limit = TimeLimit::new(self.options.step_time_limit);
        let Some(template) = self.templates.get_mut(&id) else { return };
        let Some(source) = template.process.as_ref().map(|process| process.slot) else { return };
        let count = template.waiting.len().min(COPIES);
        template.copying = template.waiting.drain(..count).collect();
        template.phase = TemplatePhase::Copying(limit);
        let slots: Vec<u32> = template.copying.iter().map(|request| request.slot).collect();
        self.region.list_copies(source, &slots);
        self.region.command(source, Command::Copy);
    }

    /// Copies the worker in a slot, which must be ready.
    pub(super) fn branch(
        &mut self,
        of: SlotPlace,
        count: usize,
        options: EpisodeOptions,
    ) -> Result<Vec<SlotPlace>> {
        let mut places = Vec::with_capacity(count);
        let outcome = self.try_branch(of, count, options, &mut places);
        match outcome {
            Ok(()) => Ok(places),
            Err(error) => {
                places.into_iter().for_each(|place| self.release(place));
                Err(error)
            }
        }
    }

    fn try_branch(
        &mut self,
        of: SlotPlace,
        count: usize,
        options: EpisodeOptions,
        places: &mut Vec<SlotPlace>,
    ) -> Result<()> {
        while places.len() < count {
            let first = places.len();
            for _ in first..count.min(first + COPIES) {
                let slot = self.take_episode_slot(options)?;
                // The template may have died; copies of an episode do not need it.
                if let Some(template) = self.templates.get_mut(&of.template) {
                    template.users += 1;
                }
                places.push(SlotPlace { slot, template: of.template });
            }
            let slots: Vec<u32> = places[first..].iter().map(|place| place.slot).collect();
            self.region.list_copies(of.slot, &slots);
            self.region.command(of.slot, Command::Copy);
            self.wait_until_ready(of.slot)?;
        }
        places.iter().try_for_each(|place| self.wait_until_ready(place.slot))
    }

    /// Returns an error if a worker has reported a failure.
    fn check_status(&self, slot: u32) -> Result<()> {
        match self.region.status(slot) {
            Status::Running | Status::Truncated => Ok(()),
            Status::Failed => Err(lost("a copy of an episode", self.report(slot))),
        }
    }

    /// The report of a worker, as text.
    fn report(&self, slot: u32) -> String {
        String::from_utf8_lossy(&self.region.report(slot)).into_owned()
    }

    /// Waits for a worker that copies itself, or for the copy. Takes milliseconds, so it cannot be interrupted.
    ///
    /// # Errors
    /// [`Error::Lost`] when it ended, took too long, or reported a failure.
    fn wait_until_ready(&mut self, slot: u32) -> Result<()> {
        let mut limit = TimeLimit::new(self.options.step_time_limit);
        loop {
            let done = self.region.done();
            let ended = self.slots.has_ended(slot);
            if self.region.is_ready(slot) {
                self.slots.adopt(slot);
                return self.check_status(slot);
            }
            if ended {
                return Err(lost("an episode to copy", self.slots.describe_end(slot, None)));
            }
            if limit.is_exceeded() {
                return Err(lost("an episode to copy", self.time_out(slot)));
            }
            self.region.sleep(done, 1, LOOK);
        }
    }

    /// Returns whether an episode waits for its template, rather than for an existing copy.
    pub(super) fn waits_for_template(&self, place: SlotPlace) -> bool {
        let template = self.templates.get(&place.template);
        let mut requests =
            template.iter().flat_map(|template| template.waiting.iter().chain(&template.copying));
        requests.any(|request| request.slot == place.slot)
    }

    /// Returns why the worker of a slot will never report, if it has ended or exceeded its limit.
    pub(super) fn failure(&mut self, slot: u32, is_late: bool) -> Option<String> {
        let ended = self.slots.has_ended(slot);
        // It may have reported before it died.
        if self.region.is_ready(slot) {
            return None;
        }
        if ended {
            return Some(self.slots.describe_end(slot, None));
        }
        is_late.then(|| self.time_out(slot))
    }

    /// Kills the worker of a slot after a time-out.
    fn time_out(&mut self, slot: u32) -> String {
        self.slots.kill(slot);
        let (process, limit) = (self.region.process(slot), self.options.step_time_limit);
        format!("worker process {process} took longer than {limit:?} and was killed")
    }

    /// Returns whether it is time to check the busy workers.
    pub(super) fn check_is_due(&mut self) -> bool {
        let due = Instant::now() >= self.look;
        if due {
            self.look = Instant::now() + LOOK;
        }
        due
    }

    /// Opens a handle to a worker after its first report.
    pub(super) fn adopt(&mut self, slot: u32) {
        self.slots.adopt(slot);
    }

    /// A file of the worker in a slot.
    pub(super) fn file(&self, slot: u32, extension: &str) -> PathBuf {
        self.slots.file(slot, extension)
    }

    /// Reserves the template of a setting for a future episode; queues one if there is none.
    ///
    /// # Errors
    /// Same as [`Pool::template_of`].
    pub(super) fn reserve(&mut self, setting: &EpisodeSetting) -> Result<TemplateId> {
        let id = self.template_of(setting)?;
        self.template_mut(id)?.users += 1;
        Ok(id)
    }

    /// Releases a reservation. Drops a preparation that has not started and has no other user.
    pub(super) fn cancel(&mut self, id: TemplateId) {
        let Some(template) = self.templates.get_mut(&id) else { return };
        template.users = template.users.saturating_sub(1);
        if template.users == 0 && template.phase == TemplatePhase::Queued {
            self.drop_template(id);
        }
    }

    /// Returns whether a template is ready, so that an episode of it begins within milliseconds.
    pub(super) fn is_prepared(&self, id: TemplateId) -> bool {
        self.templates.get(&id).is_some_and(|template| !template.is_unprepared())
    }

    /// Ends a worker, or the wait for one.
    pub(super) fn release(&mut self, place: SlotPlace) {
        if let Some(template) = self.templates.get_mut(&place.template) {
            template.users = template.users.saturating_sub(1);
            template.waiting.retain(|request| request.slot != place.slot);
            template.copying.retain(|request| request.slot != place.slot);
        }
        self.slots.release(place.slot);
        self.episodes = self.episodes.saturating_sub(1);
        self.region.set_episodes(self.episodes);
    }

    /// The processes of the templates.
    pub(super) fn template_processes(&self) -> Vec<u32> {
        self.templates.values().filter_map(Template::process_id).collect()
    }

    /// The processes of the templates that are not ready yet.
    pub(super) fn preparing_processes(&self) -> Vec<u32> {
        let preparing =
            self.templates.values().filter(|template| matches!(template.phase, TemplatePhase::Preparing(_)));
        preparing.filter_map(Template::process_id).collect()
    }

    /// The temporary folder for all files of its processes.
    pub(super) fn folder(&self) -> &Path {
        self.folder.path()
    }

    fn take_episode_slot(&mut self, options: EpisodeOptions) -> Result<u32> {
        let slot = self.take_slot(options)?;
        self.episodes += 1;
        self.region.set_episodes(self.episodes);
        Ok(slot)
    }

    fn take_slot(&mut self, options: EpisodeOptions) -> Result<u32> {
        self.slots.take(options).map_err(unavailable("a worker slot"))
    }

    fn template_mut(&mut self, id: TemplateId) -> Result<&mut Template> {
        self.templates.get_mut(&id).ok_or_else(|| lost("a template", "it was dropped".into()))
    }
}

impl Drop for Pool {
    /// Ends every process; copies first, so that their templates reap them.
    fn drop(&mut self) {
        let processes = self.templates.values().filter_map(|template| template.process.as_ref());
        let templates: Vec<u32> = processes.map(|process| process.slot).collect();
        self.slots.end_all_but(&templates);
        for id in self.templates.keys().copied().collect::<Vec<_>>() {
            self.drop_template(id);
        }
    }
}

fn unavailable(what: &str) -> impl Fn(io::Error) -> Error {
    move |source| Error::Pool { what: what.to_owned(), source }
}

fn lost(what: &str, why: String) -> Error {
    Error::Lost { what: what.to_owned(), why }
}
