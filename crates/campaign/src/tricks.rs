//! Folders and files prepared by a stranger, and commands that start at the same time.

use std::os::unix::fs::symlink;
use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::Result;
use b2b_agent::protobuf::{bytes, integer, text};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rustix::process::{Signal, kill_process};

use crate::Campaign;
use crate::ledger::copy;
use crate::material::Material;
use crate::mutation::pick;
use crate::program::{Ended, Program, words};

/// Time limit for a command.
const LIMIT: Duration = Duration::from_secs(120);
/// Time in which a command ends after a signal, with a margin.
const GRACE: Duration = Duration::from_secs(15);

/// Program and material of an attack.
struct Trick<'a> {
    program: &'a Program,
    material: &'a Material,
    folder: &'a Path,
    random: &'a mut ChaCha8Rng,
}

/// The end of a command, and the guarantee that it violated.
type Tried = (Ended, Option<String>);

type Kind = fn(&mut Trick<'_>) -> Result<Tried>;

const KINDS: [(&str, Kind); 6] = [
    ("code in the current folder", |attack| attack.code_in_the_current_folder()),
    ("links in the way", |attack| attack.links_in_the_way()),
    ("endless networks", |attack| attack.endless_network()),
    ("flipped bits", |attack| attack.flipped_bit()),
    ("two at once", |attack| attack.two_at_once()),
    ("two runs in one folder", |attack| attack.two_runs()),
];

/// Attacks the commands until a deadline.
pub fn attack(Campaign { program, material, deadline, mut random, ledger }: Campaign<'_>) -> Result<()> {
    while Instant::now() < deadline {
        let (kind, attack) = *pick(&KINDS, &mut random);
        let folder = tempfile::tempdir()?;
        let mut trick = Trick { program, material, folder: folder.path(), random: &mut random };
        let (ended, broken) = attack(&mut trick)?;
        let broken = ended.broken(false).or(broken);
        ledger.judge(kind, broken, ended.code(), folder.path())?;
    }
    Ok(())
}

impl Trick<'_> {
    fn run(&self, arguments: &str) -> Result<Ended> {
        self.program.run(self.folder, &words(arguments), LIMIT)
    }

    /// Modules that an interpreter would import from the current folder.
    fn code_in_the_current_folder(&mut self) -> Result<Tried> {
        let mark = self.folder.join("ran");
        let code = format!("open({:?}, 'a').close()\n", mark.display().to_string());
        std::fs::create_dir(self.folder.join("pip"))?;
        for module in ["pip/__init__.py", "pip/__main__.py", "token.py", "random.py", "sitecustomize.py"] {
            std::fs::write(self.folder.join(module), &code)?;
        }
        std::fs::copy(pick(self.material.models(), self.random), self.folder.join("m.epJSON"))?;
        let commands =
            ["doctor", "import m.epJSON --place Miami", "run SingleFamilyHouse --period 01-01..01-01"];
        let command = *pick(&commands, self.random);
        let ended = self.run(command)?;
        Ok((ended, mark.exists().then(|| "code of the current folder ran".to_owned())))
    }

    /// Symbolic links to another user's file where a command writes.
    fn links_in_the_way(&mut self) -> Result<Tried> {
        let theirs = self.folder.join("theirs");
        std::fs::write(&theirs, "theirs")?;
        let out = self.folder.join("out");
        std::fs::create_dir(&out)?;
        std::fs::copy(pick(self.material.models(), self.random), self.folder.join("m.epJSON"))?;
        let names = ["evaluation.json", "trajectory.parquet", "summary.json", "m.epJSON", "page.html"];
        for name in names {
            for name in [name.to_owned(), format!("{name}.aside"), format!("{name}.tmp")] {
                symlink(&theirs, out.join(name))?;
            }
        }
        let commands = [
            "run SingleFamilyHouse --period 01-01..01-01 --out out",
            "evaluate SingleFamilyHouse --policy constant --period 01-01..01-01 --out out",
            "view SingleFamilyHouse --out out/page.html",
            "edit m.epJSON --lights 2 --out out/m.epJSON",
        ];
        let command = *pick(&commands, self.random);
        let ended = self.run(command)?;
        let changed = std::fs::read(&theirs)? != b"theirs";
        Ok((ended, changed.then(|| "a link was followed to another file".to_owned())))
    }

    /// A policy that never returns an action, and an interrupt.
    fn endless_network(&mut self) -> Result<Tried> {
        std::fs::write(self.folder.join("p.onnx"), endless_network())?;
        let arguments = words("evaluate SingleFamilyHouse --policy p.onnx --period 01-01..01-01 --out out");
        let mut run = self.program.start(self.folder, "", &arguments)?;
        let moment = Duration::from_secs_f64(self.random.random_range(0.5..8.0));
        run.interrupt_after(moment)?;
        Ok((run.end(moment + GRACE)?, None))
    }

    /// A flipped bit in a file that is read again.
    fn flipped_bit(&mut self) -> Result<Tried> {
        let (name, arguments) = *pick(
            &[
                ("evaluation/episodes.parquet", "evaluate compare evaluation evaluation --out page.html"),
                ("offline-v0/data/0/part-0.parquet", "clone offline-v0 --out cloned --updates 10"),
                ("agent/checkpoint.safetensors", "train --resume agent --steps 3000"),
                (
                    "agent/agent.json",
                    "evaluate SingleFamilyHouse --policy agent --period 01-01..01-01 --out evaluated",
                ),
            ],
            self.random,
        );
        let source = name.split('/').next().unwrap_or(name);
        copy(&self.material.path(source), &self.folder.join(source))?;
        let path = self.folder.join(name);
        let mut damaged = std::fs::read(&path)?;
        let place = self.random.random_range(0..damaged.len());
        damaged[place] ^= 1 << self.random.random_range(0..8);
        std::fs::write(&path, damaged)?;
        let ended = self.run(arguments)?;
        let broken = match ended.code() {
            Some(0) => Some(format!("{name} with another bit in byte {place} is accepted")),
            // The file was not read.
            Some(2) => Some(format!("`b2b {arguments}` is not a command")),
            _ => None,
        };
        Ok((ended, broken))
    }

    /// Two different evaluations in one new folder.
    fn two_at_once(&mut self) -> Result<Tried> {
        let evaluate = |policy: &str| {
            words(&format!("evaluate SingleFamilyHouse --policy {policy} --period 01-01..01-01 --out out"))
        };
        let first = self.program.start(self.folder, "", &evaluate("constant"))?;
        std::thread::sleep(Duration::from_millis(self.random.random_range(0..200)));
        let second = self.program.start(self.folder, "", &evaluate("random"))?;
        Ok(only_one(first.end(LIMIT)?, &second.end(LIMIT)?))
    }

    /// Two different runs in one new folder. The first is paused while it writes to the folder, until the second has
    /// ended.
    fn two_runs(&mut self) -> Result<Tried> {
        let out = self.folder.join("out");
        let run = |controller: &str| {
            words(&format!("run SingleFamilyHouse --controller {controller} --period 01-01..01-31 --out out"))
        };
        let mut first = self.program.start(self.folder, "", &run("hold"))?;
        while !out.exists() && !first.has_ended()? {
            std::thread::sleep(Duration::from_millis(5));
        }
        let paused = first.processes();
        let send = |signal| {
            for process in &paused {
                // Fails if the process has just ended.
                let _ = kill_process(*process, signal);
            }
        };
        send(Signal::STOP);
        let second = self.program.run(self.folder, &run("off"), LIMIT);
        send(Signal::CONT);
        Ok(only_one(first.end(2 * LIMIT)?, &second?))
    }
}

/// Returns the end of the first of two commands for one folder, and what is wrong unless exactly one succeeded.
fn only_one(first: Ended, second: &Ended) -> Tried {
    let succeeded = [&first, second].into_iter().filter(|ended| ended.code() == Some(0)).count();
    let broken = (succeeded != 1)
        .then(|| format!("{succeeded} of 2 succeeded\nfirst: {}\nsecond: {}", first.errors, second.errors));
    (first, broken.or_else(|| second.broken(false)))
}

/// Returns a network of thousands of products of large matrices.
fn endless_network() -> Vec<u8> {
    const PRODUCTS: usize = 2000;
    const FLOAT: u64 = 1;
    const INT64: u64 = 7;
    let name = |place: usize| format!("product {place}");
    let sum = [text(1, "observation"), text(2, "sum"), text(4, "ReduceSum")].concat();
    let expand = [text(1, "sum"), text(1, "sizes"), text(2, &name(0)), text(4, "Expand")].concat();
    let product = |place: usize| {
        let node = [text(1, &name(place)), text(1, &name(0)), text(2, &name(place + 1)), text(4, "MatMul")];
        bytes(1, &node.concat())
    };
    let sizes: Vec<u8> = [4096_u64; 2].iter().flat_map(|size| size.to_le_bytes()).collect();
    let sizes = [integer(1, 2), integer(2, INT64), text(8, "sizes"), bytes(9, &sizes)].concat();
    let value = |name: &str| [text(1, name), bytes(2, &bytes(1, &integer(1, FLOAT)))].concat();
    let graph = [
        bytes(1, &sum),
        bytes(1, &expand),
        (0..PRODUCTS).flat_map(product).collect(),
        text(2, "endless"),
        bytes(5, &sizes),
        bytes(11, &value("observation")),
        bytes(12, &value(&name(PRODUCTS))),
    ];
    let opset = [text(1, ""), integer(2, 17)].concat();
    [integer(1, 8), bytes(7, &graph.concat()), bytes(8, &opset)].concat()
}
