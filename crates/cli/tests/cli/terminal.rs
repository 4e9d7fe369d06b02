//! Help and tables fit the terminal, and arguments are understood in any order.

use crate::program::{assert_rejected, b2b, command, json, stderr};

/// Returns the output of a command in a terminal of some width.
fn printed(arguments: &str, width: usize) -> String {
    let folder = tempfile::tempdir().unwrap();
    let output = command(folder.path(), arguments).env("COLUMNS", width.to_string()).output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    String::from_utf8(output.stdout).unwrap()
}

fn assert_fits(text: &str, width: usize) {
    for line in text.lines() {
        assert!(line.chars().count() <= width, "{} characters: {line}", line.chars().count());
    }
}

/// Returns the commands and their subcommands.
fn commands() -> Vec<String> {
    let names = |page: &str| -> Vec<String> {
        let command = |line: &str| {
            let name = line.strip_prefix("  ")?.split(' ').next()?;
            (!name.is_empty() && name.chars().all(|c| c.is_ascii_lowercase())).then(|| name.to_owned())
        };
        page.lines().filter_map(command).filter(|name| name != "b2b" && name != "help").collect()
    };
    let mut all = names(&printed("--help", 80));
    assert!(all.len() >= 17, "{all:?}");
    for name in all.clone() {
        let page = printed(&format!("{name} --help"), 80);
        let Some((_, rest)) = page.split_once("Commands:") else { continue };
        let listed = rest.split("\n\n").next().unwrap_or_default();
        all.extend(names(listed).iter().map(|each| format!("{name} {each}")));
    }
    all
}

#[test]
fn help_fits_80_columns_and_a_file() {
    let commands = commands();
    assert!(commands.iter().any(|name| name == "benchmark run"), "{commands:?}");
    assert_fits(&printed("--help", 80), 80);
    for name in commands {
        assert_fits(&printed(&format!("{name} --help"), 80), 80);
        let folder = tempfile::tempdir().unwrap();
        let output =
            command(folder.path(), &format!("{name} --help")).env_remove("COLUMNS").output().unwrap();
        assert_fits(std::str::from_utf8(&output.stdout).unwrap(), 80);
    }
}

#[test]
fn tables_fit_80_columns() {
    for arguments in [
        "list",
        "list --sizes",
        "list places",
        "list tariffs",
        "show OfficeSmall --all",
        "show SingleFamilyHouse-0042",
        "benchmark list",
        "benchmark show goal-setpoint-mode",
    ] {
        let text = printed(arguments, 80);
        assert_fits(&text, 80);
    }
}

#[test]
fn no_area_is_minus_zero() {
    let text = printed("show OfficeMedium --zones", 200);
    assert!(text.contains("MidFloor_Plenum") && !text.contains("-0.0"), "{text}");
    let folder = tempfile::tempdir().unwrap();
    let plenum = &json(folder.path(), "show OfficeMedium")["zones"][0];
    assert!(!plenum.to_string().contains("-0.0"), "{plenum}");
}

#[test]
fn a_parameter_does_not_take_the_type_behind_it() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = "generate --count 1 --set x_scale=1.2 --set y_scale=0.9 --place Miami Warehouse --out o";
    let output = b2b(folder.path(), arguments);
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(folder.path().join("o/Warehouse-seed0-0001.epJSON").exists());
}

#[test]
fn a_weather_file_as_a_place_is_answered_with_the_argument() {
    let folder = tempfile::tempdir().unwrap();
    assert_rejected(folder.path(), "run OfficeSmall --place my.epw", &["`my.epw`", "`--weather my.epw`"]);
    assert_rejected(folder.path(), "generate Warehouse --place my.epw --out o", &["--weather my.epw"]);
}
