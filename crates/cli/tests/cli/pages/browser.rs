//! A page in a headless Chromium, over its DevTools protocol on two pipes: commands in, answers and events out, each
//! ended by a zero byte.

use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

/// Names of the browser on the path.
const NAMES: [&str; 5] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome"];

/// A script that names elements outside their card, except scrolling elements and drawings.
pub const OUTSIDE: &str = "
    [...document.querySelectorAll('section, .tile')].flatMap(card => {
        const edges = card.getBoundingClientRect();
        const leaves = ({ left, right, width }) => width && (left < edges.left - 1 || right > edges.right + 1);
        const parts = [...card.querySelectorAll('*')].filter(part => !part.parentElement.closest('.scroll, svg, .legend'));
        return parts.filter(part => leaves(part.getBoundingClientRect()))
            .map(part => `${part.tagName} ${part.className}: ${part.textContent.slice(0, 40)}`);
    })";

/// The browser to test with: the one that `B2B_BROWSER` names, or one on the path.
pub fn find() -> Option<PathBuf> {
    if let Some(path) = std::env::var_os("B2B_BROWSER") {
        return Some(path.into());
    }
    let folders: Vec<PathBuf> = std::env::split_paths(&std::env::var_os("PATH")?).collect();
    NAMES
        .iter()
        .flat_map(|name| folders.iter().map(move |folder| folder.join(name)))
        .find(|path| path.is_file())
}

/// A browser with one page.
pub struct Browser {
    process: Child,
    commands: File,
    answers: BufReader<File>,
    session: Option<String>,
    number: u64,
    /// Errors of scripts.
    pub errors: Vec<String>,
}

impl Browser {
    /// Starts it; `folder` is for its profile and the pipes.
    pub fn start(path: &Path, folder: &Path) -> Self {
        let pipes = ["in", "out"].map(|name| folder.join(name));
        assert!(Command::new("mkfifo").args(&pipes).status().unwrap().success());
        let script = r#"in="$1"; out="$2"; shift 2; exec "$@" 3<"$in" 4>"$out""#;
        let process = Command::new("sh")
            .args(["-c", script, "sh"])
            .args(&pipes)
            .arg(path)
            .args([
                "--headless",
                "--no-sandbox",
                "--disable-gpu",
                "--disable-dev-shm-usage",
                "--hide-scrollbars",
            ])
            .args(["--no-first-run", "--window-size=1400,1500", "--remote-debugging-pipe"])
            .args([
                "--disable-quic",
                "--disable-background-networking",
                "--disable-component-update",
                "--disable-sync",
            ])
            .arg(format!("--user-data-dir={}", folder.join("profile").display()))
            .arg("about:blank")
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let commands = File::options().write(true).open(&pipes[0]).unwrap();
        let answers = BufReader::new(File::open(&pipes[1]).unwrap());
        let mut browser = Self { process, commands, answers, session: None, number: 0, errors: Vec::new() };
        let target = browser.ask("Target.createTarget", json!({"url": "about:blank"}));
        let attached =
            browser.ask("Target.attachToTarget", json!({"targetId": target["targetId"], "flatten": true}));
        browser.session = Some(attached["sessionId"].as_str().unwrap().to_owned());
        for domain in ["Page", "Runtime", "Log"] {
            browser.ask(&format!("{domain}.enable"), json!({}));
        }
        browser
    }

    /// Opens a file, and waits until a script's value is true.
    pub fn open(&mut self, file: &Path, until: &str) {
        self.ask("Page.navigate", json!({"url": format!("file://{}", file.display())}));
        let deadline = Instant::now() + Duration::from_secs(120);
        while self.value(until) != true {
            assert!(Instant::now() < deadline, "`{until}` never was true; errors: {:?}", self.errors);
            std::thread::sleep(Duration::from_millis(100));
        }
    }

    /// Sets the width of the page and the color scheme.
    pub fn emulate(&mut self, width: u32, dark: bool) {
        let metrics = json!({"width": width, "height": 1000, "deviceScaleFactor": 1, "mobile": false});
        self.ask("Emulation.setDeviceMetricsOverride", metrics);
        let scheme = if dark { "dark" } else { "light" };
        let features = json!([{"name": "prefers-color-scheme", "value": scheme}]);
        self.ask("Emulation.setEmulatedMedia", json!({"features": features}));
    }

    /// The value of a script.
    pub fn value(&mut self, script: &str) -> Value {
        self.ask("Runtime.evaluate", json!({"expression": script, "returnByValue": true}))["result"]["value"]
            .clone()
    }

    /// Sends a command and waits for its answer; events on the way are looked through for errors.
    fn ask(&mut self, method: &str, parameters: Value) -> Value {
        self.number += 1;
        let mut command = json!({"id": self.number, "method": method, "params": parameters});
        if let Some(session) = &self.session {
            command["sessionId"] = session.clone().into();
        }
        self.commands.write_all(format!("{command}\0").as_bytes()).unwrap();
        loop {
            let mut message = Vec::new();
            self.answers.read_until(0, &mut message).unwrap();
            assert_eq!(message.pop(), Some(0), "the browser is gone");
            let message: Value = serde_json::from_slice(&message).unwrap();
            if message["id"] == self.number {
                assert!(message["error"].is_null(), "{method}: {}", message["error"]);
                return message["result"].clone();
            }
            let parameters = &message["params"];
            match message["method"].as_str() {
                Some("Runtime.exceptionThrown") => {
                    self.errors.push(parameters["exceptionDetails"].to_string())
                }
                Some("Log.entryAdded") if parameters["entry"]["level"] == "error" => {
                    self.errors.push(parameters["entry"].to_string());
                }
                _ => {}
            }
        }
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        // It may be gone already.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
