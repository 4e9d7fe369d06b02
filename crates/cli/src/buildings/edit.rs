//! `b2b edit`: changes of a user's own model.

use std::path::PathBuf;

use anyhow::{Result, anyhow};
use b2b_building::edit::{Change, Edits, Effect, Report, check_other_file, check_output, edit_file};
use serde::Serialize;

use crate::program;
use crate::terminal::progress::Download;
use crate::terminal::stdout;
use crate::terminal::table::Table;

/// Change the envelope, the shape or the internal gains of a model
///
/// Applies the changes that the generator makes to its prototypes to your own model, and writes the result as an
/// epJSON file, which `b2b import` and `b2b run` accept. The model itself is not changed. At least one change is
/// required.
///
/// U-factors of walls and roofs include the air films of ASHRAE 90.1 (0.15 and 0.14 m²K/W), as in `b2b show`. Other
/// surfaces that shared a construction, and skylights that shared a glazing, keep theirs.
#[derive(clap::Args)]
#[command(
    verbatim_doc_comment,
    override_usage = "b2b edit [OPTIONS] --out <FILE.epJSON> <MODEL>",
    after_help = "\
Examples:
  b2b edit office.idf --wall-u 0.3 --roof-u 0.2 --out insulated.epJSON
  b2b edit office.idf --window-u 1.4 --window-shgc 0.35 --window-to-wall 0.3 --out glazed.epJSON
  b2b edit office.idf --infiltration 1.5 --lights 0.6 --out leaky.epJSON
  b2b edit office.idf --x-scale 1.2 --y-scale 0.9 --north-axis 45 --out stretched.epJSON"
)]
pub struct Arguments {
    /// Model file (.idf or .epJSON, EnergyPlus 8.8 to 25.2)
    #[arg(value_name = "MODEL")]
    model: PathBuf,
    /// File to write
    #[arg(long, value_name = "FILE.epJSON")]
    out: PathBuf,
    #[command(flatten)]
    changes: Changes,
    /// Let the model run code (FMU, Python) and name files outside its folder; only for models that you trust
    #[arg(long)]
    allow_external: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// The changes, within the bounds of [`Change::parameter`].
#[derive(clap::Args)]
#[group(required = true, multiple = true)]
struct Changes {
    /// U-factor of the exterior walls, W/m²K
    #[arg(long, value_name = "U")]
    wall_u: Option<f64>,
    /// U-factor of the roofs, W/m²K; under an attic, of the ceilings
    #[arg(long, value_name = "U")]
    roof_u: Option<f64>,
    /// U-factor of windows and glass doors in walls, W/m²K
    #[arg(long, value_name = "U")]
    window_u: Option<f64>,
    /// Solar heat gain coefficient of windows and glass doors in walls
    #[arg(long, value_name = "SHGC")]
    window_shgc: Option<f64>,
    /// Window and glass door area over gross exterior wall area; windows change in height
    #[arg(long, value_name = "RATIO")]
    window_to_wall: Option<f64>,
    /// Multiplier of infiltration, except through doors
    #[arg(long, value_name = "FACTOR")]
    infiltration: Option<f64>,
    /// Stretch along the building's x axis; loads given per zone grow with the floor area
    #[arg(long, value_name = "FACTOR")]
    x_scale: Option<f64>,
    /// Stretch along the building's y axis
    #[arg(long, value_name = "FACTOR")]
    y_scale: Option<f64>,
    /// Angle from true north to the building's y axis, clockwise, 0 to 360 degrees
    #[arg(long, value_name = "DEGREES")]
    north_axis: Option<f64>,
    /// Multiplier of the number of people
    #[arg(long, value_name = "FACTOR")]
    people: Option<f64>,
    /// Multiplier of the power of lights in zones
    #[arg(long, value_name = "FACTOR")]
    lights: Option<f64>,
    /// Multiplier of the power of equipment in zones (electric, gas, hot water, steam, other)
    #[arg(long, value_name = "FACTOR")]
    equipment: Option<f64>,
}

/// The object that `--json` prints.
#[derive(Serialize)]
struct Edited<'a> {
    model: &'a PathBuf,
    out: &'a PathBuf,
    #[serde(flatten)]
    report: &'a Report,
}

/// Runs the command.
pub fn edit(arguments: &Arguments) -> Result<()> {
    let edits = arguments.changes.edits()?;
    check_output(&arguments.out)?;
    check_other_file(&arguments.model, &arguments.out).map_err(|error| anyhow!("--out {error}"))?;
    let catalog = program::catalog(&mut Download::new(arguments.json))?;
    let Arguments { model, out, allow_external, json, .. } = arguments;
    let report = edit_file(model, out, &edits, catalog.library(), *allow_external)?;
    if !json {
        report.warnings.iter().for_each(|warning| eprintln!("warning: {warning}"));
    }
    let edited = Edited { model, out, report: &report };
    stdout::print_result(*json, &edited, || {
        format!("{}\n\n{} written", table(&report.changes), out.display())
    })
}

impl Changes {
    fn edits(&self) -> Result<Edits> {
        let value = |change| match change {
            Change::XScale => self.x_scale,
            Change::YScale => self.y_scale,
            Change::NorthAxis => self.north_axis,
            Change::WallU => self.wall_u,
            Change::RoofU => self.roof_u,
            Change::WindowU => self.window_u,
            Change::WindowShgc => self.window_shgc,
            Change::WindowToWall => self.window_to_wall,
            Change::Infiltration => self.infiltration,
            Change::People => self.people,
            Change::Lights => self.lights,
            Change::Equipment => self.equipment,
        };
        let mut edits = Edits::default();
        for change in Change::ALL {
            if let Some(value) = value(change) {
                edits.set(change, value)?;
            }
        }
        Ok(edits)
    }
}

/// Returns a table with a row per change.
pub fn table(effects: &[Effect]) -> String {
    let mut table = Table::new(["change", "quantity", "before", "after", "unit", "objects"]);
    let number = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |value| format!("{value:.3}"));
    for effect in effects {
        table.row([
            effect.change.to_string(),
            effect.quantity.into(),
            number(effect.before),
            number(effect.after),
            if effect.unit == "1" { String::new() } else { effect.unit.into() },
            effect.objects.to_string(),
        ]);
    }
    table.text()
}
