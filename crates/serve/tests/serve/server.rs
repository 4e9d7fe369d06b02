//! A server in this process, which ends on drop.

use std::net::{SocketAddr, TcpListener};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use b2b_building::{BuildingType, PreparedBuilding};
use b2b_climate::{Place, Site};
use b2b_dataset::{Preparation, archetype};
use b2b_energyplus::Library;
use b2b_energyplus::install::{Engine, Quiet};
use b2b_serve::{Options, Subject, SubjectOptions, serve};
use b2b_workers::{Launcher, WorkerOptions};

use crate::client::Client;

static STOP: AtomicBool = AtomicBool::new(false);
/// Held by the server of a process.
static ONE: Mutex<()> = Mutex::new(());

/// A small office at its home with its engine.
pub struct Office {
    pub library: Library,
    pub building: Arc<PreparedBuilding>,
    pub weather: PathBuf,
}

impl Office {
    pub fn new() -> Self {
        let engine = Engine::ensure(&mut Quiet).unwrap();
        let library = Library::load(&engine.library).unwrap();
        let building_type = BuildingType::OfficeSmall;
        let weather = Place::find(building_type.home()).unwrap().epw(&mut Quiet).unwrap();
        let site = Site::read(&weather).unwrap();
        let model = archetype::base_model(building_type, &engine, &library, &site).unwrap();
        let building = Preparation::new(building_type.name(), model).run(&weather, &library).unwrap();
        Self { library, building: Arc::new(building), weather }
    }

    /// Serves the office under the guideline's sequences, at 12 control steps an hour.
    pub fn serve(&self, tests: usize) -> Server {
        let one = ONE.lock().unwrap_or_else(PoisonError::into_inner);
        let subject = Subject::new(SubjectOptions {
            building: Arc::clone(&self.building),
            weather: self.weather.clone(),
            task: "operate".parse().unwrap(),
            steps_per_hour: 12,
            controller: b2b_control::kind("guideline36").unwrap(),
        });
        let subject = Arc::new(subject.unwrap());
        let launcher = Launcher::new(env!("CARGO_BIN_EXE_b2b-serve-worker"));
        let workers = WorkerOptions::new(launcher, self.library.path());
        let workers = WorkerOptions { interrupted: || STOP.load(Ordering::Relaxed), ..workers };
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        let options = Options { workers, tests };
        let thread = std::thread::spawn(move || serve(subject, options, listener).unwrap());
        Server { address, thread: Some(thread), _one: one }
    }
}

/// A server; one in a process at a time.
pub struct Server {
    address: SocketAddr,
    thread: Option<JoinHandle<()>>,
    _one: MutexGuard<'static, ()>,
}

impl Server {
    pub fn client(&self) -> Client {
        Client::new(self.address)
    }

    /// Ends the server like an interrupt.
    pub fn stop(&mut self) {
        STOP.store(true, Ordering::Relaxed);
        self.thread.take().map(JoinHandle::join);
        STOP.store(false, Ordering::Relaxed);
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.stop();
    }
}
