//! The tests that the gate leaves to the nightly command.

use std::fs::{read_dir, read_to_string};
use std::path::Path;

#[test]
fn the_tests_left_to_the_nightly_command_exist() {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let config = read_to_string(crates.join("../.config/nextest.toml")).unwrap();
    let names: Vec<_> = config.split("test(=").skip(1).map(|rest| rest.split_once(')').unwrap().0).collect();
    assert!(!names.is_empty());
    for name in names {
        let (module, function) = name.rsplit_once("::").unwrap();
        let exists = read_dir(crates).unwrap().map(|each| each.unwrap().path()).any(|each| {
            let folder = each.file_name().unwrap().to_str().unwrap();
            let folders = [folder, "learners"].map(|tests| each.join("tests").join(tests));
            let mut texts =
                folders.iter().filter_map(|tests| read_to_string(tests.join(format!("{module}.rs"))).ok());
            texts.any(|text| text.contains(&format!("fn {function}(")))
        });
        assert!(exists, "`{name}` of .config/nextest.toml is no test; remove the line or correct the name");
    }
}
