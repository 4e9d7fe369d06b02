//! Code in the current folder never runs.

use std::path::PathBuf;

use tempfile::TempDir;

use crate::program::command;

/// Names under which an interpreter or a package client would find code or settings in the current folder.
const MODULES: [&str; 6] =
    ["pip.py", "token.py", "random.py", "sitecustomize.py", "building2building.py", "pip/__main__.py"];

/// A folder with code under all these names, which writes a file if it runs, and a model with its weather.
struct Trap {
    folder: TempDir,
    ran: PathBuf,
}

impl Trap {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let ran = folder.path().join("ran");
        let code = format!("open({:?}, 'a').write(__file__ + '\\n')\n", ran.display().to_string());
        std::fs::create_dir(folder.path().join("pip")).unwrap();
        for module in MODULES.into_iter().chain(["pip/__init__.py"]) {
            std::fs::write(folder.path().join(module), &code).unwrap();
        }
        std::fs::write(folder.path().join("w.epw"), "LOCATION,Here\n").unwrap();
        std::fs::write(folder.path().join("m.idf"), "Version,25.2;\n").unwrap();
        Self { folder, ran }
    }

    fn assert_not_run(&self, arguments: &str) {
        assert!(!self.ran.exists(), "{arguments}: {}", std::fs::read_to_string(&self.ran).unwrap());
    }

    /// Runs commands that need every package and find none.
    fn install(&self, commands: &[&str]) {
        for arguments in commands {
            let cache = tempfile::tempdir().unwrap();
            let mut command = command(self.folder.path(), arguments);
            command.env("B2B_CACHE", cache.path()).env("PIP_NO_INDEX", "1").output().unwrap();
            self.assert_not_run(arguments);
        }
    }
}

#[test]
fn commands_run_no_code_of_the_current_folder() {
    Trap::new().install(&["setup", "run m.idf --place Montreal", "train OfficeSmall --steps 1"]);
}

/// Each of them is another way to the packages.
#[test]
fn no_other_command_runs_code_of_the_current_folder() {
    let trap = Trap::new();
    trap.install(&[
        "doctor --authority m.idf --weather w.epw",
        "import m.idf --place Montreal",
        "edit m.idf --lights 2 --out edited.epJSON",
        "weather w.epw",
        "evaluate OfficeSmall --policy reactive",
        "serve OfficeSmall",
        "check OfficeSmall-0001",
        "collect b2b/here-v0 OfficeSmall --period 01-09..01-09",
        "baseline OfficeSmall --task constant --period winter",
        "benchmark run dynamics-house --policy reactive --out b",
    ]);
    // With packages, the interpreter is started too.
    let bench = "bench train --type SingleFamilyHouse --steps 1 --environments 1";
    command(trap.folder.path(), bench).output().unwrap();
    trap.assert_not_run(bench);
}
