//! Code in the current folder never runs.

use crate::program::command;

/// Names under which an interpreter or a package client would find code or settings in the current folder.
const MODULES: [&str; 6] =
    ["pip.py", "token.py", "random.py", "sitecustomize.py", "building2building.py", "pip/__main__.py"];

#[test]
fn no_command_runs_code_of_the_current_folder() {
    let folder = tempfile::tempdir().unwrap();
    let ran = folder.path().join("ran");
    let code = format!("open({:?}, 'a').write(__file__ + '\\n')\n", ran.display().to_string());
    std::fs::create_dir(folder.path().join("pip")).unwrap();
    for module in MODULES.into_iter().chain(["pip/__init__.py"]) {
        std::fs::write(folder.path().join(module), &code).unwrap();
    }
    std::fs::write(folder.path().join("w.epw"), "LOCATION,Here\n").unwrap();
    std::fs::write(folder.path().join("m.idf"), "Version,25.2;\n").unwrap();
    let installs = [
        "setup",
        "doctor --authority m.idf --weather w.epw",
        "run m.idf --place Montreal",
        "import m.idf --place Montreal",
        "edit m.idf --lights 2 --out edited.epJSON",
        "weather w.epw",
        "evaluate OfficeSmall --policy reactive",
        "train OfficeSmall --steps 1",
        "serve OfficeSmall",
        "check OfficeSmall-0001",
        "collect b2b/here-v0 OfficeSmall --period 01-09..01-09",
        "baseline OfficeSmall --task constant --period winter",
        "benchmark run dynamics-house --policy reactive --out b",
    ];
    // Each of them is another way to the packages.
    for arguments in installs {
        let cache = tempfile::tempdir().unwrap();
        let mut command = command(folder.path(), arguments);
        // Every package is needed, and none is found.
        command.env("B2B_CACHE", cache.path()).env("PIP_NO_INDEX", "1").output().unwrap();
        assert!(!ran.exists(), "{arguments}: {}", std::fs::read_to_string(&ran).unwrap());
    }
    // With packages, the interpreter is started too.
    let bench = "bench train --type SingleFamilyHouse --steps 1 --environments 1";
    command(folder.path(), bench).output().unwrap();
    assert!(!ran.exists(), "{bench}: {}", std::fs::read_to_string(&ran).unwrap());
}
