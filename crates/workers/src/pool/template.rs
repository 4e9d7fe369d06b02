//! Templates: processes that wait at the end of a building's warm-up to be copied.

use std::collections::VecDeque;
use std::os::unix::fs::MetadataExt;
use std::path::PathBuf;
use std::process::Child;
use std::sync::Arc;

use crate::setting::{EpisodeSetting, Source};
use crate::time_limit::TimeLimit;
use b2b_building::PreparedBuilding;
use b2b_env::Error;
use b2b_env::Spaces;

/// A prepared building with its setting and the state of the weather file it was sized for.
pub(super) type Prepared = (EpisodeSetting, Option<FileState>, Arc<PreparedBuilding>);

/// Id of a template in a pool. Never reused, so a dropped template is not found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct TemplateId(pub(super) u64);

/// A building at the end of its warm-up, or before.
pub(super) struct Template {
    pub(super) setting: EpisodeSetting,
    /// The weather files of its sizing and its episode when it was requested.
    pub(super) files: [Option<FileState>; 2],
    /// `None` until its preparation starts, and once it has failed.
    pub(super) process: Option<TemplateProcess>,
    pub(super) phase: TemplatePhase,
    /// Why it cannot be prepared, until read.
    pub(super) failure: Option<Error>,
    pub(super) spaces: Option<Arc<Spaces>>,
    /// Preparations tried in a row.
    pub(super) attempts: u32,
    /// Resident memory, bytes.
    pub(super) memory: u64,
    /// Number of its copies, waiting episodes and reservations.
    pub(super) users: usize,
    /// Whether its preparation comes before those that nobody waits for.
    pub(super) is_urgent: bool,
    /// Time of the last request.
    pub(super) used: u64,
    /// Slots that wait for a copy.
    pub(super) waiting: VecDeque<Request>,
    /// Slots of the copies in progress.
    pub(super) copying: Vec<Request>,
}

/// What tells that a file was written again: device, inode, time of change (s and ns) and length.
pub(super) type FileState = (u64, u64, i64, i64, u64);

/// Returns the states of the weather files of the sizing and of the episode of a setting; `None` for a prepared building
/// and for a file that cannot be read.
pub(super) fn weather_files(setting: &EpisodeSetting) -> [Option<FileState>; 2] {
    let sizing = match &*setting.source {
        Source::Prepared(_) => None,
        Source::Model { weather, .. } => Some(weather),
    };
    [sizing, Some(&setting.episode.weather)].map(|file| {
        let file = std::fs::metadata(file?).ok()?;
        Some((file.dev(), file.ino(), file.mtime(), file.mtime_nsec(), file.len()))
    })
}

/// The process of a template.
pub(super) struct TemplateProcess {
    pub(super) slot: u32,
    pub(super) child: Child,
    pub(super) order: PathBuf,
}

/// The phase of a template's process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TemplatePhase {
    /// Waits for its turn to be prepared.
    Queued,
    /// Sizing and warm-up, within a limit.
    Preparing(TimeLimit),
    /// Waits to be copied.
    Idle,
    /// Copies itself, within a limit.
    Copying(TimeLimit),
    /// Cannot be made.
    Failed,
}

/// A slot that waits for a copy.
#[derive(Clone, Copy, Debug)]
pub(super) struct Request {
    pub(super) slot: u32,
    /// Templates that died or hung while it waited.
    pub(super) failures: u32,
}

impl Template {
    /// Creates a queued template.
    pub(super) fn new(setting: EpisodeSetting, used: u64) -> Self {
        Self {
            files: weather_files(&setting),
            setting,
            process: None,
            phase: TemplatePhase::Queued,
            failure: None,
            spaces: None,
            attempts: 0,
            memory: 0,
            users: 0,
            is_urgent: false,
            used,
            waiting: VecDeque::new(),
            copying: Vec::new(),
        }
    }

    /// Returns whether it may be ended to make room.
    pub(super) fn is_idle(&self) -> bool {
        matches!(self.phase, TemplatePhase::Idle | TemplatePhase::Failed) && self.users == 0
    }

    /// Returns whether it is queued or being prepared.
    pub(super) fn is_unprepared(&self) -> bool {
        matches!(self.phase, TemplatePhase::Queued | TemplatePhase::Preparing(_))
    }

    /// Returns whether there is something to do once its process reports or ends.
    pub(super) fn is_underway(&self) -> bool {
        matches!(self.phase, TemplatePhase::Preparing(_))
            || !self.waiting.is_empty()
            || !self.copying.is_empty()
    }

    /// The id of its process, if it has one.
    pub(super) fn process_id(&self) -> Option<u32> {
        self.process.as_ref().map(|process| process.child.id())
    }
}
