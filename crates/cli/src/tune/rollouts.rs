//! Episodes of tuning, in worker processes.

use b2b_building::RunPeriod;
use b2b_control::tune::Rollouts;
use b2b_control::{Error, Result};
use b2b_dataset::BuildingId;
use b2b_dataset::Catalog;
use b2b_env::Task;

use crate::progress::Download;
use crate::workers::worker_options;

/// A winter week and a summer week: the default run periods.
pub const WEEKS: [&str; 2] = ["01-08..01-14", "07-08..07-14"];

/// Returns the episodes of these buildings, ready to run. Waiting for them ends with an interrupt.
pub fn rollouts(
    catalog: &Catalog,
    ids: &[BuildingId],
    periods: &[RunPeriod],
    tasks: &[Task],
) -> Result<Rollouts> {
    let options = worker_options(catalog.library().path())
        .map_err(|source| Error::Io { path: "this program".into(), source })?;
    Rollouts::new(options, catalog, ids, periods, tasks, &mut Download::new(true))
}
