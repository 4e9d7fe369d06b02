//! `b2b serve` from the outside, on the real engine.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};

use crate::program::sandbox::{B2B, Sandbox};
use crate::program::{stderr, workers_of};

/// Starts a server on a free port and returns it with its address.
fn start(sandbox: &Sandbox) -> (Child, String) {
    let mut command = sandbox.command(B2B, "serve OfficeSmall --port 0");
    let mut server = command.stdout(Stdio::piped()).spawn().unwrap();
    let mut line = String::new();
    BufReader::new(server.stdout.as_mut().unwrap()).read_line(&mut line).unwrap();
    let address = line.split("http://").nth(1).and_then(|rest| rest.split(',').next()).expect(&line);
    (server, address.to_owned())
}

/// Sends a request and returns the answer with its head.
fn send(address: &str, method: &str, path: &str, body: &str) -> String {
    let mut stream = TcpStream::connect(address).unwrap();
    let length = body.len();
    let head = format!(
        "{method} {path} HTTP/1.1\r\nHost: b2b\r\nConnection: close\r\nContent-Length: {length}\r\n\r\n"
    );
    stream.write_all(format!("{head}{body}").as_bytes()).unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    answer
}

#[test]
fn a_server_outlives_a_killed_engine_and_ends_with_its_folders_on_a_termination_request() {
    let sandbox = Sandbox::new();
    let (mut server, address) = start(&sandbox);
    let begin = || send(&address, "PUT", "/initialize", r#"{"start_time": 0, "warmup_period": 0}"#);
    let advance = || send(&address, "POST", "/advance", "{}");
    assert!(begin().contains("\"time\":0.0"));
    assert!(advance().contains("\"time\":3600.0"));
    for worker in workers_of(server.id()) {
        // Ending one may end another.
        let _ = kill_process(Pid::from_raw(worker as i32).unwrap(), Signal::KILL);
    }
    assert!(advance().starts_with("HTTP/1.1 500"), "its engine was killed");
    assert!(advance().contains("PUT /initialize"));
    assert!(begin().starts_with("HTTP/1.1 200"));

    let asked = Instant::now();
    kill_process(Pid::from_child(&server), Signal::TERM).unwrap();
    assert!(server.wait().unwrap().success());
    assert!(asked.elapsed() < Duration::from_secs(8), "{:?}", asked.elapsed());
    assert!(sandbox.left_behind().is_empty(), "{:?}", sandbox.left_behind());
}

#[test]
fn a_task_with_targets_and_a_planner_are_refused_with_what_to_use_instead() {
    let sandbox = Sandbox::new();
    for (arguments, words) in [
        ("serve OfficeSmall --port 0 --task occupancy", ["occupancy", "operate"]),
        ("serve OfficeSmall --port 0 --task operate+tou", ["tariff", "PUT /scenario"]),
        (
            r#"serve OfficeSmall --port 0 --task {"setpoints":{"mode":"band"},"prices":{"electricity":1,"gas":1}}"#,
            ["prices of its own", "PUT /scenario"],
        ),
        ("serve OfficeSmall --port 0 --controller planner", ["planner", "guideline36"]),
    ] {
        let output = sandbox.b2b(arguments);
        let said = stderr(&output);
        assert!(!output.status.success() && words.iter().all(|word| said.contains(word)), "{said}");
    }
}
