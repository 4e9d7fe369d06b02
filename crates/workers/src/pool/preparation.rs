//! Preparation, replacement and end of templates.

use std::fs::File;
use std::sync::Arc;

use b2b_building::PreparedBuilding;

use super::template::{
    Prepared, Request, Template, TemplateId, TemplatePhase, TemplateProcess, weather_files,
};
use super::{FAILURES, Pool, lost, unavailable};
use crate::episode::episode_options::EpisodeOptions;
use crate::order::{EpisodeOrder, Order};
use crate::region::Status;
use crate::setting::{EpisodeSetting, Source};
use crate::time_limit::TimeLimit;
use b2b_env::Spaces;
use b2b_env::{Error, Result};

/// Number of prepared buildings kept in memory; more are on disk.
const PREPARED: usize = 16;
/// Number of attempts before a preparation fails.
const ATTEMPTS: u32 = 2;

impl Pool {
    /// Returns the template of a setting, without waiting for it. Queues one if there is none.
    ///
    /// # Errors
    /// The errors of [`EpisodeConfig::check`](b2b_env::EpisodeConfig::check).
    pub(crate) fn template_of(&mut self, setting: &EpisodeSetting) -> Result<TemplateId> {
        self.clock += 1;
        let files = weather_files(setting);
        let is_same = |template: &Template| template.setting.is(setting) && template.files == files;
        let found = self.templates.iter_mut().find(|(_, template)| is_same(template));
        if let Some((id, template)) = found {
            template.used = self.clock;
            return Ok(*id);
        }
        setting.episode.check()?;
        self.make_room();
        let id = TemplateId(self.next_template);
        self.next_template += 1;
        self.templates.insert(id, Template::new(setting.clone(), self.clock));
        self.start_queued();
        Ok(id)
    }

    /// The spaces of a template once it is ready; does not wait.
    ///
    /// # Errors
    /// [`Error::Template`] with the reason when the building cannot be prepared; [`Error::Lost`] when its preparation
    /// died or hung twice; [`Error::Pool`] when no process can be started; [`Error::Io`] for its order. The template is
    /// then dropped, and the next request tries again.
    pub(crate) fn spaces_of(&mut self, id: TemplateId) -> Result<Option<Arc<Spaces>>> {
        let template = self.template_mut(id)?;
        template.is_urgent = true;
        if template.is_unprepared() {
            self.advance_all();
        }
        let template = self.template_mut(id)?;
        match template.failure.take() {
            None => Ok(template.spaces.clone()),
            Some(error) => {
                self.drop_template(id);
                Err(error)
            }
        }
    }

    /// Starts preparations up to the concurrency limit: first for waiting episodes, then in the order of requests.
    pub(super) fn start_queued(&mut self) {
        loop {
            let preparing = |template: &&Template| matches!(template.phase, TemplatePhase::Preparing(_));
            if self.templates.values().filter(preparing).count() >= self.options.preparations.max(1) {
                return;
            }
            let queued =
                self.templates.iter().filter(|(_, template)| template.phase == TemplatePhase::Queued);
            let urgent = |template: &Template| template.is_urgent || !template.waiting.is_empty();
            let Some(id) = queued.min_by_key(|(id, template)| (!urgent(template), **id)).map(|(id, _)| *id)
            else {
                return;
            };
            if let Err(error) = self.start_preparation(id) {
                self.give_up(id, error);
            }
        }
    }

    fn start_preparation(&mut self, id: TemplateId) -> Result<()> {
        let setting = self.template_mut(id)?.setting.clone();
        let process = self.start_process(&setting)?;
        let limit = TimeLimit::new(self.options.preparation_time_limit);
        let template = self.template_mut(id)?;
        template.process = Some(process);
        template.phase = TemplatePhase::Preparing(limit);
        template.attempts += 1;
        Ok(())
    }

    pub(super) fn advance_preparation(&mut self, id: TemplateId, ready: bool, ended: bool, is_late: bool) {
        if ready {
            return match self.read_reply(id) {
                Ok(()) => self.advance(id),
                Err(error) => self.give_up(id, error),
            };
        }
        if ended {
            let why = self.how_it_ended(id);
            return self.retry(id, why);
        }
        if is_late {
            let limit = self.options.preparation_time_limit;
            self.retry(id, format!("its preparation took longer than {limit:?} and was killed"));
        }
    }

    /// How the process of a template ended.
    fn how_it_ended(&mut self, id: TemplateId) -> String {
        let process = self.templates.get_mut(&id).and_then(|template| template.process.as_mut());
        let Some(process) = process else { return "its process is gone".into() };
        let status = process.child.try_wait().ok().flatten();
        let program = self.options.launcher.program().display();
        format!("{} (program {program})", self.slots.describe_end(process.slot, status))
    }

    /// Reads the reply of a ready template.
    fn read_reply(&mut self, id: TemplateId) -> Result<()> {
        let Template { process, setting, .. } = self.template_mut(id)?;
        let Some(process) = process else { return Ok(()) };
        let (slot, child, name) = (process.slot, process.child.id(), setting.source.name().to_owned());
        let (path, setting) = (process.order.with_extension("ready"), setting.clone());
        if self.region.status(slot) == Status::Failed {
            return Err(Error::Template { name, why: self.report(slot) });
        }
        let io = |source| Error::Io { path: path.clone(), source };
        let text = std::fs::read(&path).map_err(io)?;
        let building: PreparedBuilding = serde_json::from_slice(&text).map_err(|error| io(error.into()))?;
        let building = Arc::new(building);
        let spaces = Arc::new(Spaces::new(Arc::clone(&building), setting.episode.clone()));
        let template = self.template_mut(id)?;
        template.process.iter().for_each(TemplateProcess::remove_files);
        template.memory = resident_memory(child).unwrap_or(0);
        template.spaces = Some(spaces);
        template.phase = TemplatePhase::Idle;
        let sizing = template.files[0];
        self.prepared.retain(|(known, ..)| !known.shares_preparation_with(&setting));
        self.prepared.push_back((setting, sizing, building));
        if self.prepared.len() > PREPARED {
            self.prepared.pop_front();
        }
        Ok(())
    }

    /// Retries a preparation that died or hung, or gives up.
    fn retry(&mut self, id: TemplateId, why: String) {
        let Some(template) = self.templates.get(&id) else { return };
        if template.attempts >= ATTEMPTS {
            let what = format!("the template of {}", template.setting.source.name());
            return self.give_up(id, lost(&what, why));
        }
        self.restart(id);
    }

    /// Replaces a ready template that has died or hung: waiting slots get copies of its successor.
    pub(super) fn replace(&mut self, id: TemplateId) {
        let Some(template) = self.templates.get_mut(&id) else { return };
        template.attempts = 0;
        let interrupted = std::mem::take(&mut template.copying);
        for Request { slot, failures } in interrupted.into_iter().rev() {
            // An attached copy no longer needs its template.
            if !self.region.revoke(slot) {
                continue;
            }
            if failures + 1 == FAILURES {
                self.region.fail(slot, &format!("its template died or hung {FAILURES} times"));
            } else {
                template.waiting.push_front(Request { slot, failures: failures + 1 });
            }
        }
        self.restart(id);
    }

    /// Queues a template for a new process.
    fn restart(&mut self, id: TemplateId) {
        let Some(template) = self.templates.get_mut(&id) else { return };
        template.phase = TemplatePhase::Queued;
        template.is_urgent = true;
        if let Some(process) = template.process.take() {
            self.end_process(process);
        }
        self.start_queued();
    }

    /// Stores why a template cannot be prepared, and reports it to the waiting slots.
    fn give_up(&mut self, id: TemplateId, error: Error) {
        let Some(template) = self.templates.get_mut(&id) else { return };
        for Request { slot, .. } in template.waiting.drain(..) {
            self.region.fail(slot, &error.to_string());
        }
        template.phase = TemplatePhase::Failed;
        template.failure = Some(error);
        if let Some(process) = template.process.take() {
            self.end_process(process);
        }
    }

    fn start_process(&mut self, setting: &EpisodeSetting) -> Result<TemplateProcess> {
        let [sizing, _] = weather_files(setting);
        let is_known = |(known, of, _): &&Prepared| known.shares_preparation_with(setting) && *of == sizing;
        let source = match self.prepared.iter().find(is_known) {
            Some((.., building)) => Source::Prepared(Box::new(PreparedBuilding::clone(building))),
            None => Source::clone(&setting.source),
        };
        let slot = self.take_slot(EpisodeOptions::default())?;
        let order = EpisodeOrder {
            ticket: self.region.ticket(slot),
            library: self.options.library.clone(),
            source,
            episode: setting.episode.clone(),
        };
        let started = self.start_process_in(slot, &Order::Episode(Box::new(order)));
        if started.is_err() {
            self.slots.release(slot);
        }
        started
    }

    /// Starts a process for a slot. If that fails, the caller keeps the slot.
    fn start_process_in(&mut self, slot: u32, order: &Order) -> Result<TemplateProcess> {
        let (path, log) = (self.slots.file(slot, "order"), self.slots.file(slot, "log"));
        let written = order.to_json().and_then(|text| std::fs::write(&path, text));
        written.map_err(|source| Error::Io { path: path.clone(), source })?;
        let log = File::create(&log).map_err(|source| Error::Io { path: log, source })?;
        let memory = self.region.share().map_err(unavailable("a descriptor of the shared memory"))?;
        let launcher = &self.options.launcher;
        let child = launcher.start(memory.into(), &path, self.folder.path(), log);
        let child = child.map_err(|source| Error::Pool {
            what: format!("a process of {}", launcher.program().display()),
            source,
        })?;
        let mut process = TemplateProcess { slot, child, order: path };
        if let Err(error) = self.slots.adopt_child(slot, process.child.id()) {
            process.end();
            return Err(unavailable("a handle of a process")(error));
        }
        Ok(process)
    }

    /// Ends the least recently used templates without users until the rest is within the budget.
    fn make_room(&mut self) {
        loop {
            let memory: u64 = self.templates.values().map(|template| template.memory).sum();
            let idle = self.templates.iter().filter(|(_, template)| template.is_idle());
            let oldest = idle.min_by_key(|(_, template)| template.used).map(|(id, _)| *id);
            match oldest {
                Some(id) if memory > self.options.template_memory => self.drop_template(id),
                _ => return,
            }
        }
    }

    pub(super) fn drop_template(&mut self, id: TemplateId) {
        if let Some(process) = self.templates.remove(&id).and_then(|template| template.process) {
            self.end_process(process);
        }
    }

    fn end_process(&mut self, mut process: TemplateProcess) {
        process.end();
        self.slots.release(process.slot);
    }
}

impl TemplateProcess {
    /// Ends the process and removes its files. Its slot remains.
    fn end(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
        self.remove_files();
    }

    /// Removes its order and its reply, if they exist.
    fn remove_files(&self) {
        for path in [&self.order, &self.order.with_extension("ready"), &self.order.with_extension("aside")] {
            let _ = std::fs::remove_file(path);
        }
    }
}

/// Resident memory of a process, bytes.
fn resident_memory(process: u32) -> Option<u64> {
    let text = std::fs::read_to_string(format!("/proc/{process}/statm")).ok()?;
    Some(text.split(' ').nth(1)?.parse::<u64>().ok()? * rustix::param::page_size() as u64)
}
