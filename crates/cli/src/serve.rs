//! `b2b serve`: BOPTEST's interface for a building.

use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener};
use std::sync::Arc;

use anyhow::{Context, Result};
use b2b_control::{KINDS, Kind};
use b2b_dataset::BuildingName;
use b2b_env::Task;
use b2b_serve::{Options, Subject, SubjectOptions, serve as serve_subject};

use crate::arguments::location::Location;
use crate::program::prepare::Prepared;
use crate::terminal::stdout;

/// Serve a building behind BOPTEST's REST calls
///
/// Clients of BOPTEST, such as its Python examples and boptest-gym, run against the building with another URL and other
/// point names. Inputs that a client does not activate follow the baseline controller. Ctrl-C ends the server. See
/// docs/serve.md.
#[derive(clap::Args)]
#[command(verbatim_doc_comment, after_help = EXAMPLES)]
pub struct Arguments {
    /// Building type (`b2b list`), dataset building such as OfficeSmall-0042, or model file (.idf, .epJSON)
    #[arg(value_name = "BUILDING")]
    building: BuildingName,
    #[command(flatten)]
    location: Location,
    /// Task with comfort bands: operate (setpoints of the building's own thermostats), or for example
    /// operate:21-24/15.6-28 (with people and without)
    #[arg(long, default_value = "operate", value_name = "TASK", value_parser = Task::from_text)]
    task: Task,
    /// Baseline controller of the inputs that are not activated; under `own`, the model controls itself and there are
    /// no inputs
    #[arg(long, default_value = "guideline36", value_name = "CONTROLLER", value_parser = kind)]
    controller: &'static dyn Kind,
    /// Control steps per hour
    #[arg(long, default_value_t = 12, value_name = "N")]
    steps_per_hour: u32,
    /// Address to listen on; any other than loopback lets anyone on the network run simulations here
    #[arg(long, default_value_t = IpAddr::V4(Ipv4Addr::LOCALHOST), value_name = "ADDRESS")]
    host: IpAddr,
    /// Port to listen on; 0 for a free one
    #[arg(long, default_value_t = 8000, value_name = "PORT")]
    port: u16,
    /// Maximum number of tests at a time, each with its own engine
    #[arg(long, default_value_t = 4, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=256))]
    tests: u32,
}

const EXAMPLES: &str = "\
Examples:
  b2b serve OfficeSmall-0042
  b2b serve OfficeMedium --place Miami --port 5000
  b2b serve my.idf --weather my.epw --task operate:21-24/15.6-28
  curl http://127.0.0.1:8000/measurements
  curl -X PUT -d '{\"time_period\": \"peak_heat_day\"}' http://127.0.0.1:8000/scenario
  curl -X POST -d '{}' http://127.0.0.1:8000/advance";

fn kind(name: &str) -> Result<&'static dyn Kind, String> {
    let steps = || KINDS.into_iter().filter(|kind| !kind.plans());
    let found = steps().find(|kind| kind.name() == name);
    found.ok_or_else(|| format!("expected {}", steps().map(Kind::name).collect::<Vec<_>>().join(", ")))
}

/// Runs the command until it is interrupted.
pub fn serve(arguments: &Arguments) -> Result<()> {
    let address = SocketAddr::new(arguments.host, arguments.port);
    let listener = TcpListener::bind(address)
        .with_context(|| format!("cannot listen on {address}; choose another port with `--port`"))?;
    let address = listener.local_addr()?;
    let prepared =
        Prepared::under(arguments.controller.controls(), &arguments.building, &arguments.location, false)?;
    if !arguments.host.is_loopback() {
        eprintln!(
            "warning: anyone who reaches {address} can run simulations here; there is no access control"
        );
    }
    let options = Options { workers: prepared.worker_options(), tests: arguments.tests as usize };
    let subject = Subject::new(SubjectOptions {
        building: prepared.building,
        weather: prepared.weather,
        task: arguments.task.clone(),
        steps_per_hour: arguments.steps_per_hour,
        controller: arguments.controller,
    })?;
    stdout::print(&format!(
        "test case {} in {} on http://{address}, {} controller; Ctrl-C ends it",
        subject.name(),
        prepared.place,
        arguments.controller.name()
    ))?;
    Ok(serve_subject(Arc::new(subject), options, listener)?)
}
