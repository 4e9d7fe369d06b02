//! A run of EnergyPlus on its own stack, suspended inside its callbacks.
//!
//! EnergyPlus calls back into [`Context`] at fixed points of the run; there the run is suspended and its caller
//! continues. Callbacks for messages carry no state pointer, so the context of the current run is kept in a
//! thread-local during every resume.

#![allow(unsafe_code, reason = "the C API of EnergyPlus")]

use std::cell::{Cell, RefCell};
use std::ffi::{CStr, CString, c_char, c_int};
use std::ptr;
use std::sync::Arc;

use corosensei::stack::DefaultStack;
use corosensei::{Coroutine, CoroutineResult, Yielder};

use crate::abort_line::Withheld;
use crate::api::{Api, State};
use crate::event::Event;
use crate::library::exclusive;
use crate::message::Messages;
use crate::{Error, Library, Result};

/// Size of the stack of EnergyPlus. It is mapped, not committed: only touched pages use memory.
const STACK_BYTES: usize = 64 << 20;
/// `kindOfSim` of a run over a weather file.
const WEATHER_RUN: c_int = 3;

thread_local! {
    static CURRENT: Cell<*const Context> = const { Cell::new(ptr::null()) };
}

/// Zone time steps at which a run is suspended.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stops {
    pub(crate) warmup_steps: bool,
    /// Interval in steps of the run period; 0 for never.
    pub(crate) every: u32,
}

/// State shared by the callbacks of a run and its owner.
struct Context {
    api: Arc<Api>,
    state: State,
    yielder: Cell<*const Yielder<(), Event>>,
    stops: Stops,
    started: Cell<bool>,
    /// Completed steps of the run period.
    steps: Cell<u32>,
    stopping: Cell<bool>,
    messages: RefCell<Messages>,
    /// Standard error, from the last message of an aborted run to its return.
    withheld: Cell<Option<Withheld>>,
}

/// A run of EnergyPlus with its state.
pub(crate) struct EngineRun {
    context: Box<Context>,
    coroutine: Option<Coroutine<(), Event, c_int, DefaultStack>>,
}

/// How a resume ended.
pub(crate) enum Outcome {
    /// The run was suspended at this point.
    At(Event),
    /// EnergyPlus returned this exit code.
    Returned(c_int),
}

/// Registers the callbacks of a run and requests its variables.
fn register(api: &Api, state: State, stops: Stops, requests: &[(CString, CString)]) {
    // SAFETY: the state is live, the callbacks are functions of this module with the C signatures the
    // engine expects, and the strings live through the calls, which copy them.
    unsafe {
        (api.setConsoleOutputState)(state, 0);
        (api.registerErrorCallback)(state, on_error);
        (api.registerStdOutCallback)(state, on_console);
        (api.callbackBeginZoneTimeStepBeforeInitHeatBalance)(state, on_begin_zone_step);
        (api.callbackAfterNewEnvironmentWarmupComplete)(state, on_warmup_complete);
        if stops.every > 0 || stops.warmup_steps {
            (api.callbackEndOfZoneTimeStepAfterZoneReporting)(state, on_end_zone_step);
        }
        for (name, key) in requests {
            (api.requestVariable)(state, name.as_ptr(), key.as_ptr());
        }
    }
}

impl EngineRun {
    /// Prepares a run with these command-line arguments. Computation starts at the first resume.
    pub(crate) fn new(
        library: &Library,
        arguments: &[&str],
        requests: &[(String, String)],
        stops: Stops,
    ) -> Result<Self> {
        let _lock = exclusive();
        let api = Arc::clone(&library.api);
        let arguments = arguments.iter().map(|a| c_string(a)).collect::<Result<Vec<_>>>()?;
        let requests = requests
            .iter()
            .map(|(name, key)| Ok((c_string(name)?, c_string(key)?)))
            .collect::<Result<Vec<_>>>()?;
        let stack = DefaultStack::new(STACK_BYTES).map_err(Error::Stack)?;

        // SAFETY: a new state is used only by this run and deleted in `drop`.
        let state = unsafe { (api.stateNew)() };
        let context = Box::new(Context {
            api: Arc::clone(&api),
            state,
            yielder: Cell::new(ptr::null()),
            stops,
            started: Cell::new(false),
            steps: Cell::new(0),
            stopping: Cell::new(false),
            messages: RefCell::new(Messages::default()),
            withheld: Cell::new(None),
        });
        register(&api, state, stops, &requests);
        let coroutine = Coroutine::with_stack(stack, move |yielder, ()| {
            let context = CURRENT.get();
            // SAFETY: `resume` set the pointer to the boxed context of this run, which outlives it.
            unsafe { (*context).yielder.set(yielder) };
            let argv: Vec<*const c_char> = arguments.iter().map(|a| a.as_ptr()).collect();
            // SAFETY: the state is live and `argv` outlives the call.
            unsafe { (api.energyplus)(state, argv.len() as c_int, argv.as_ptr()) }
        });
        Ok(Self { context, coroutine: Some(coroutine) })
    }

    /// Resumes the run until it is suspended again or ends.
    pub(crate) fn resume(&mut self) -> Outcome {
        let Some(coroutine) = &mut self.coroutine else {
            return Outcome::Returned(0);
        };
        let _lock = exclusive();
        let before = CURRENT.replace(&*self.context);
        let result = coroutine.resume(());
        CURRENT.set(before);
        drop(self.context.withheld.take());
        match result {
            CoroutineResult::Yield(event) => Outcome::At(event),
            CoroutineResult::Return(code) => {
                self.coroutine = None;
                Outcome::Returned(code)
            }
        }
    }

    /// Ends a suspended run early. A suspended coroutine must not be dropped: its stack holds C++ frames that cannot be
    /// unwound from outside.
    pub(crate) fn stop(&mut self) {
        if self.coroutine.is_some() && !self.context.yielder.get().is_null() {
            self.context.stopping.set(true);
            // SAFETY: the state is live and the run is suspended in a callback.
            unsafe { (self.context.api.stopSimulation)(self.context.state) };
            while let Outcome::At(_) = self.resume() {}
        }
    }

    /// The functions of EnergyPlus.
    #[inline]
    pub(crate) fn api(&self) -> &Api {
        &self.context.api
    }

    /// The state of EnergyPlus.
    #[inline]
    pub(crate) fn state(&self) -> State {
        self.context.state
    }

    /// Returns the messages so far.
    pub(crate) fn messages(&self) -> Messages {
        self.context.messages.borrow().clone()
    }

    /// Inspects the messages without copying them.
    pub(crate) fn with_messages<T>(&self, look: impl FnOnce(&Messages) -> T) -> T {
        look(&self.context.messages.borrow())
    }
}

impl Drop for EngineRun {
    fn drop(&mut self) {
        self.stop();
        self.coroutine = None;
        let _lock = exclusive();
        // SAFETY: the run is over (or never started) and nothing else holds the state.
        unsafe { (self.context.api.stateDelete)(self.context.state) };
    }
}

pub(crate) fn c_string(text: &str) -> Result<CString> {
    CString::new(text).map_err(|_| Error::ZeroByte { text: text.to_owned() })
}

impl Context {
    /// Suspends the run unless it is being stopped.
    fn suspend(&self, event: Event) {
        if !self.stopping.get() {
            // SAFETY: a callback runs on the coroutine's stack, below the frame that owns the yielder.
            unsafe { (*self.yielder.get()).suspend(event) };
        }
    }

    fn in_weather_run(&self) -> bool {
        // SAFETY: the state is live during its own callback.
        unsafe { (self.api.kindOfSim)(self.state) == WEATHER_RUN }
    }

    fn in_warmup(&self) -> bool {
        // SAFETY: the state is live during its own callback.
        unsafe { (self.api.warmupFlag)(self.state) != 0 }
    }

    fn data_ready(&self) -> bool {
        // SAFETY: the state is live during its own callback.
        unsafe { (self.api.apiDataFullyReady)(self.state) == 1 }
    }
}

/// Returns the context of the current run on this thread.
fn current() -> Option<&'static Context> {
    // SAFETY: not null only while `resume` is on this thread's call stack, which holds the run and so its
    // boxed context; no callback keeps the reference beyond its own return.
    unsafe { CURRENT.get().as_ref() }
}

extern "C" fn on_begin_zone_step(_: State) {
    if let Some(run) = current()
        && !run.started.get()
        && run.in_weather_run()
        && run.data_ready()
    {
        run.started.set(true);
        run.suspend(Event::Started);
    }
}

extern "C" fn on_warmup_complete(_: State) {
    if let Some(run) = current()
        && run.in_weather_run()
    {
        run.suspend(Event::WarmedUp);
    }
}

extern "C" fn on_end_zone_step(_: State) {
    let Some(run) = current() else { return };
    if !run.in_weather_run() {
        return;
    }
    if run.in_warmup() {
        if run.stops.warmup_steps {
            run.suspend(Event::WarmupStep);
        }
        return;
    }
    let steps = run.steps.get() + 1;
    run.steps.set(steps);
    if run.stops.every > 0 && steps % run.stops.every == 0 {
        run.suspend(Event::Step);
    }
}

extern "C" fn on_error(level: c_int, text: *const c_char) {
    with_text(text, |run, messages, text| {
        messages.push(level, text);
        if let Some(withheld) = Withheld::after(text) {
            run.withheld.set(Some(withheld));
        }
    });
}

extern "C" fn on_console(text: *const c_char) {
    with_text(text, |_, messages, text| messages.push_console(text));
}

fn with_text(text: *const c_char, take: impl FnOnce(&Context, &mut Messages, &str)) {
    if let Some(run) = current()
        && !text.is_null()
        && let Ok(mut messages) = run.messages.try_borrow_mut()
    {
        // SAFETY: the engine passes a zero-terminated string that lives through the callback.
        let text = unsafe { CStr::from_ptr(text) }.to_string_lossy();
        take(run, &mut messages, &text);
    }
}
