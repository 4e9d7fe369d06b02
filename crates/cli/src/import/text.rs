//! The text report on one model.

use std::path::Path;

use b2b_building::hvac::Uncontrolled;
use b2b_building::import::Notes;
use b2b_building::import::versions::Change;

use super::report::{Report, groups};
use super::trial::Trial;
use crate::arguments::location::Location;
use crate::terminal::table::Table;

/// Returns the text report.
pub fn text(report: &Report, model: &Path, location: &Location) -> String {
    let summary = format!(
        "{} in {}: the agent controls {} of {} zones through {} actuators; conditioned floor area {:.0} m²; HVAC energy: {}",
        report.model,
        report.place,
        report.controlled_zones(),
        report.zones.len(),
        report.actuators(),
        report.conditioned_floor_area_m2,
        report.energy_carriers.iter().map(|carrier| carrier.name()).collect::<Vec<_>>().join(", ")
    );
    let mut parts = vec![summary, format!("Controlled systems\n{}", systems_text(report))];
    for (title, components) in [
        ("Follows the setpoints of its zones, without actuators of its own", &report.follows_setpoints),
        ("Not controlled", &report.not_controlled),
    ] {
        if !components.is_empty() {
            parts.push(format!("{title}\n{}", components_text(components)));
        }
    }
    parts.push(format!("Zones\n{}", zones_text(report)));
    parts.extend(notes_text(&report.notes));
    parts.extend(report.trial.as_ref().map(trial_text));
    parts.push(next_steps(model, location));
    parts.join("\n\n")
}

fn systems_text(report: &Report) -> String {
    let mut table = Table::new(["system", "type", "zones", "actuators", "minimum outdoor air (kg/s)"]);
    for system in &report.systems {
        table.row([
            system.name.clone(),
            system.kind_name().to_owned(),
            system.zones.len().to_string(),
            system.actuators.len().to_string(),
            system.min_outdoor_air_kg_s.map_or_else(|| "–".to_owned(), |flow| format!("{flow:.3}")),
        ]);
    }
    table.text()
}

fn components_text(components: &[Uncontrolled]) -> String {
    let mut table = Table::new(["count", "component", "zones", "reason"]);
    for group in groups(components) {
        table.row([
            group.members.len().to_string(),
            match &group.members[..] {
                [one] => format!("{} `{}`", group.class, one.object.name),
                _ => group.class.to_owned(),
            },
            group.members.iter().map(|member| member.zones.len()).sum::<usize>().to_string(),
            group.reason.to_owned(),
        ]);
    }
    table.text()
}

fn zones_text(report: &Report) -> String {
    let mut table = Table::new(["zone", "floor area (m²)", "equipment"]);
    for zone in &report.zones {
        table.row([zone.name.clone(), format!("{:.1}", zone.floor_area_m2), zone.equipment.clone()]);
    }
    table.text()
}

/// Returns how the model was read and sized; `None` if there is nothing to say.
fn notes_text(notes: &Notes) -> Option<String> {
    if notes.is_empty() {
        return None;
    }
    let mut lines: Vec<String> =
        notes.design_days.iter().map(|days| format!("design days: {days}")).collect();
    lines.extend(notes.calendar.iter().map(|calendar| format!("calendar: {calendar}")));
    if let Some(conversion) = &notes.conversion {
        lines.push(format!("converted from EnergyPlus {} to {}", conversion.from, conversion.to));
        lines.extend(conversion.programs.iter().map(|program| format!("    by {program}")));
        lines.extend(changes("changed", &conversion.changed));
        lines.extend(changes("left out, because it no longer exists", &conversion.left_out));
    }
    if !notes.left_autosized.is_empty() {
        lines.push("still autosized, because the engine reported no size:".to_owned());
        lines.extend(notes.left_autosized.iter().map(|field| format!("  {field}")));
    }
    if !notes.unused_autosized.is_empty() {
        lines.push(
            "autosized, but not used by their objects (a number without effect was written):".to_owned(),
        );
        lines.extend(notes.unused_autosized.iter().map(|field| format!("  {field}")));
    }
    if !notes.changed.is_empty() {
        lines.push("changed:".to_owned());
        lines.extend(notes.changed.iter().map(|change| format!("  {change}")));
    }
    if !notes.switched_off.is_empty() {
        lines.push("switched off by the model's schedules, regardless of setpoints:".to_owned());
        lines.extend(notes.switched_off.iter().map(|off| format!("  {off}")));
    }
    lines.extend(notes.warnings.iter().map(|warning| format!("warning: {warning}")));
    Some(format!("How the model was read\n  {}", lines.join("\n  ")))
}

fn changes(title: &str, changes: &[Change]) -> Vec<String> {
    let line = |change: &Change| {
        let Change { version, class, objects, what } = change;
        format!("    {version}: {objects} × {class}: {what}")
    };
    let lines = changes.iter().map(line);
    if changes.is_empty() { Vec::new() } else { [format!("  {title}:")].into_iter().chain(lines).collect() }
}

/// Returns the deviations of the zones with heating and cooling, and of those without cooling, as far as there are any.
fn deviations(trial: &Trial) -> String {
    let both = trial
        .cools
        .then(|| format!("{:.2} K over the zones with heating and cooling", trial.rms_deviation_k));
    let below = match (trial.rms_heating_only_k, trial.cools) {
        (rms, true) if rms > 0.0 => Some(format!("{rms:.2} K below target over those without cooling")),
        (_, true) => None,
        (rms, false) => Some(format!("{rms:.2} K below target over the zones without cooling")),
    };
    both.into_iter().chain(below).collect::<Vec<_>>().join(", ")
}

fn trial_text(trial: &Trial) -> String {
    let severe: String =
        trial.severe_message.iter().map(|m| format!("\n  severe: {}", m.replace('\n', " "))).collect();
    let far = match &trial.never_near_target[..] {
        [] => String::new(),
        zones => format!("\n  warning: never within the comfort band of the target: {}", zones.join(", ")),
    };
    format!(
        "Simulated {} under the reactive controller, target 21 °C\n  RMS deviation {}; worst zone {}, {:.2} K{far}\n  \
         HVAC energy \
         {:.2} kWh/m² of electricity, {:.2} kWh/m² of gas and other carriers\n  engine messages: {} warnings, {} \
         severe{severe}",
        trial.period,
        deviations(trial),
        trial.worst_zone,
        trial.worst_zone_rms_k,
        trial.electricity_kwh_m2,
        trial.gas_kwh_m2,
        trial.warnings,
        trial.severes,
    )
}

/// Returns commands that the user may run next.
fn next_steps(model: &Path, location: &Location) -> String {
    let arguments = location.arguments().into_iter().map(|a| quoted(&a.to_string_lossy()));
    let words: Vec<_> = [quoted(&model.to_string_lossy())].into_iter().chain(arguments).collect();
    let words = words.join(" ");
    let commands = [
        (format!("b2b run {words}"), "run an episode"),
        (format!("b2b show {words} --actions"), "list the actuators with their bounds"),
        (format!("b2b doctor --authority {words}"), "check the actuator response"),
    ];
    let width = commands.iter().map(|(command, _)| command.chars().count()).max().unwrap_or(0);
    let lines = commands.map(|(command, purpose)| format!("  {command:<width$}  {purpose}"));
    format!("Next steps\n{}", lines.join("\n"))
}

fn quoted(word: &str) -> String {
    if word.contains([' ', '(', ')', '\'', '&', ';']) { format!("{word:?}") } else { word.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deviations_are_of_the_zones_that_there_are() {
        let of = |cools, rms_deviation_k, rms_heating_only_k| {
            deviations(&Trial { cools, rms_deviation_k, rms_heating_only_k, ..Trial::default() })
        };
        assert_eq!(of(true, 0.5, 0.0), "0.50 K over the zones with heating and cooling");
        let both =
            "0.50 K over the zones with heating and cooling, 0.20 K below target over those without cooling";
        assert_eq!(of(true, 0.5, 0.2), both);
        assert_eq!(of(false, -0.0, 0.2), "0.20 K below target over the zones without cooling");
    }
}
