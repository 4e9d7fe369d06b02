//! Memory and CPU time of a process, as reported by the system.

use std::fs;

use anyhow::{Context, Result};

/// Returns the CPU time that a process has used, s.
pub(super) fn cpu_seconds(process: u32) -> Result<f64> {
    let text = read(process, "schedstat")?;
    let nanoseconds: f64 = text.split(' ').next().unwrap_or_default().parse().context("no CPU time")?;
    Ok(nanoseconds / 1e9)
}

/// Returns the memory that a process does not share with others, MB.
pub(super) fn private_mb(process: u32) -> Result<f64> {
    let text = read(process, "smaps_rollup")?;
    Ok(kilobytes(&text, |field| field.starts_with("Private_")) / 1e3)
}

/// Returns the memory of a process with shared pages divided among the processes that share them (PSS), MB.
pub(super) fn proportional_mb(process: u32) -> Result<f64> {
    let text = read(process, "smaps_rollup")?;
    Ok(kilobytes(&text, |field| field == "Pss") / 1e3)
}

/// Returns the resident memory of a process, including shared memory, MB.
pub(super) fn resident_mb(process: u32) -> Result<f64> {
    let text = read(process, "status")?;
    Ok(kilobytes(&text, |field| field == "VmRSS") / 1e3)
}

fn kilobytes(text: &str, wanted: impl Fn(&str) -> bool) -> f64 {
    let fields = text.lines().filter_map(|line| line.split_once(':'));
    let values = fields
        .filter(|(field, _)| wanted(field))
        .filter_map(|(_, value)| value.trim().trim_end_matches(" kB").parse::<f64>().ok());
    values.sum::<f64>() * 1.024
}

fn read(process: u32, file: &str) -> Result<String> {
    let path = format!("/proc/{process}/{file}");
    fs::read_to_string(&path).with_context(|| format!("cannot read {path}"))
}
