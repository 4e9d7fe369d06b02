//! The tests in progress, each in a thread with its own worker processes.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use b2b_workers::WorkerOptions;
use tokio::sync::oneshot;

use crate::calls::{Answer, Arguments, Call, Refusal};
use crate::simulation::Simulation;
use crate::subject::Subject;

/// Idle time after which a new test may replace a test, as in BOPTEST.
const IDLE: Duration = Duration::from_secs(15 * 60);
/// Id of the test for clients that do not select one.
pub(super) const CLASSIC: &str = "";
/// Memory for warmed-up engines from which a test can begin again, bytes.
const TEMPLATES: u64 = 512 << 20;

/// A request to a test.
struct Request {
    call: Call,
    arguments: Arguments,
    reply: oneshot::Sender<Answer>,
    work: Work,
}

/// Counts as work in progress until it is dropped, which the test does, because a client may leave before.
struct Work(Arc<AtomicUsize>);

impl Work {
    fn begin(in_progress: &Arc<AtomicUsize>) -> Self {
        in_progress.fetch_add(1, Ordering::Relaxed);
        Self(Arc::clone(in_progress))
    }
}

impl Drop for Work {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}

/// A test and its thread, which ends when the last sender is dropped.
struct Session {
    requests: Sender<Request>,
    thread: JoinHandle<()>,
    last_request: Instant,
    /// Number of requests in progress.
    in_progress: Arc<AtomicUsize>,
}

/// The tests in progress by id.
pub(super) struct Sessions {
    subject: Arc<Subject>,
    workers: WorkerOptions,
    /// Maximum number of tests at a time.
    limit: usize,
    open: Mutex<BTreeMap<String, Session>>,
}

impl Sessions {
    pub(super) fn new(subject: Arc<Subject>, workers: WorkerOptions, limit: usize) -> Self {
        let workers = WorkerOptions { template_memory: TEMPLATES, ..workers };
        Self { subject, workers, limit: limit.max(1), open: Mutex::default() }
    }

    /// Begins a test and returns its id.
    ///
    /// # Errors
    /// A refusal while the maximum number of tests is in progress and none has been idle for long.
    pub(super) fn select(&self) -> Result<String, Refusal> {
        let id = random_id()?;
        self.add(&mut self.lock(), &id, true)?;
        Ok(id)
    }

    /// Returns whether there is a test with an id.
    pub(super) fn has(&self, id: &str) -> bool {
        self.lock().contains_key(id)
    }

    /// Ends a test once it has answered its last request. Returns whether there was one.
    pub(super) fn stop(&self, id: &str) -> bool {
        self.lock().remove(id).is_some()
    }

    /// Ends all tests and waits for their processes.
    pub(super) fn stop_all(&self) {
        let sessions = std::mem::take(&mut *self.lock());
        let threads: Vec<_> = sessions.into_values().map(|session| session.thread).collect();
        for thread in threads {
            // A test that panicked has nothing left to end.
            let _ = thread.join();
        }
    }

    /// Passes a request to a test and waits for its answer. Without an id, passes it to the classic test.
    pub(super) async fn ask(&self, id: Option<&str>, call: Call, arguments: Arguments) -> Answer {
        let id = id.unwrap_or(CLASSIC);
        let answer = match self.send(id, call, arguments) {
            Ok(answer) => answer,
            Err(refusal) => return refusal.into(),
        };
        answer.await.unwrap_or_else(|_| {
            self.stop(id);
            Refusal::with_status(500, "the test ended while it worked on the request; begin another").into()
        })
    }

    fn send(&self, id: &str, call: Call, arguments: Arguments) -> Result<oneshot::Receiver<Answer>, Refusal> {
        let mut open = self.lock();
        if id == CLASSIC && !open.contains_key(id) {
            self.add(&mut open, id, false)?;
        }
        let session = open.get_mut(id).ok_or_else(|| no_test(id))?;
        session.last_request = Instant::now();
        let (reply, answer) = oneshot::channel();
        let work = Work::begin(&session.in_progress);
        // A thread that has ended drops the request and the sender of its reply, which ends the caller's wait.
        let _ = session.requests.send(Request { call, arguments, reply, work });
        Ok(answer)
    }

    fn add(
        &self,
        open: &mut BTreeMap<String, Session>,
        id: &str,
        begins_itself: bool,
    ) -> Result<(), Refusal> {
        if open.len() >= self.limit {
            let idle = |session: &Session| {
                session.in_progress.load(Ordering::Relaxed) == 0 && session.last_request.elapsed() > IDLE
            };
            let oldest = open.iter().filter(|(_, session)| idle(session));
            let oldest = oldest.min_by_key(|(_, session)| session.last_request).map(|(id, _)| id.clone());
            let oldest = oldest.ok_or_else(|| self.full())?;
            open.remove(&oldest);
        }
        let (requests, received) = channel();
        let (subject, workers) = (Arc::clone(&self.subject), self.workers.clone());
        let thread = std::thread::spawn(move || run(subject, workers, begins_itself, &received));
        let (last_request, in_progress) = (Instant::now(), Arc::default());
        open.insert(id.to_owned(), Session { requests, thread, last_request, in_progress });
        Ok(())
    }

    fn full(&self) -> Refusal {
        let limit = self.limit;
        let tests = if limit == 1 { "test is" } else { "tests are" };
        Refusal::with_status(
            503,
            format!(
                "{limit} {tests} in progress; end one with PUT /stop/TESTID (PUT /stop ends the test without an id), or serve more \
                 (`--tests`)"
            ),
        )
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<String, Session>> {
        self.open.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Returns a refusal of an unknown id.
pub(super) fn no_test(id: &str) -> Refusal {
    Refusal::bad(format!("no test has the id `{id}`; POST /testcases/NAME/select begins one"))
}

/// Answers requests until the last sender is dropped.
fn run(subject: Arc<Subject>, workers: WorkerOptions, begins_itself: bool, requests: &Receiver<Request>) {
    let mut simulation = Simulation::new(subject, workers, begins_itself);
    while let Ok(Request { call, arguments, reply, work }) = requests.recv() {
        let answer = match &mut simulation {
            Ok(simulation) => simulation.answer(call, &arguments),
            Err(error) => Refusal::with_status(500, format!("the test cannot begin: {error}")).into(),
        };
        // The client may be gone.
        let _ = reply.send(answer);
        drop(work);
    }
}

/// Returns a random UUID (version 4).
fn random_id() -> Result<String, Refusal> {
    let mut bytes = [0; 16];
    getrandom::fill(&mut bytes)
        .map_err(|error| Refusal::with_status(500, format!("no random number: {error}")))?;
    bytes[6] = bytes[6] & 0x0f | 0x40;
    bytes[8] = bytes[8] & 0x3f | 0x80;
    let digits: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
    let part = |range| &digits[range];
    Ok([part(0..8), part(8..12), part(12..16), part(16..20), part(20..32)].join("-"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_id_is_a_uuid_of_version_4() {
        let id = random_id().unwrap();
        assert_eq!((id.len(), &id[14..15]), (36, "4"));
        assert_ne!(id, random_id().unwrap());
    }
}
