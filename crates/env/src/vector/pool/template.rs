//! Templates: processes that stand at the end of a building's warm-up, to be copied.

use std::collections::VecDeque;
use std::path::PathBuf;
use std::process::Child;
use std::sync::Arc;
use std::time::Instant;

use crate::spaces::Spaces;
use crate::vector::setting::Setting;

/// A template of a pool. Never used again for another, so that one that was dropped is not found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::vector) struct TemplateId(pub(super) u64);

/// A building at the end of its warm-up, or on the way there.
pub(super) struct Template {
    pub(super) setting: Setting,
    pub(super) process: TemplateProcess,
    pub(super) phase: Phase,
    pub(super) spaces: Option<Arc<Spaces>>,
    /// Preparations tried in a row.
    pub(super) attempts: u32,
    /// Resident memory, bytes.
    pub(super) memory: u64,
    /// Slots that belong to copies of it, or to episodes that wait for one.
    pub(super) users: usize,
    /// When it was last asked for.
    pub(super) used: u64,
    /// Slots that wait for a copy.
    pub(super) waiting: VecDeque<Request>,
    /// Slots that the copies in progress are for.
    pub(super) copying: Vec<Request>,
}

/// The process of a template.
pub(super) struct TemplateProcess {
    pub(super) slot: u32,
    pub(super) child: Child,
    pub(super) order: PathBuf,
}

/// What the process of a template does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Phase {
    /// Sizing and warm-up, until a deadline.
    Preparing(Instant),
    /// Waits to be copied.
    Idle,
    /// Copies itself, until a deadline.
    Copying(Instant),
}

/// A slot that waits for a copy.
#[derive(Clone, Copy, Debug)]
pub(super) struct Request {
    pub(super) slot: u32,
    /// Templates that died or hung while it waited.
    pub(super) failures: u32,
}

impl Template {
    pub(super) fn new(setting: Setting, process: TemplateProcess, deadline: Instant, used: u64) -> Self {
        Self {
            setting,
            process,
            phase: Phase::Preparing(deadline),
            spaces: None,
            attempts: 1,
            memory: 0,
            users: 0,
            used,
            waiting: VecDeque::new(),
            copying: Vec::new(),
        }
    }

    /// Whether it may be ended to make room.
    pub(super) fn is_idle(&self) -> bool {
        self.phase == Phase::Idle && self.users == 0
    }
}
