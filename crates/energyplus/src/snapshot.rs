//! Copies of a running simulation by `fork`.
//!
//! EnergyPlus cannot save its state, but the operating system can copy the whole process: a copy shares its memory with
//! the original until either writes to it, and so takes milliseconds where a start takes a second. Both continue bit
//! for bit as the original would have done.
//!
//! Hazards of a fork, and how they are handled:
//! 1. Threads: the copy would have one thread and the locks of all. A process with several threads is refused.
//! 2. Files being read (weather): both processes would share one file position. The copy reopens them.
//! 3. Files being written: the copy writes to `/dev/null`, except for one file that it may keep a copy of.

#![allow(unsafe_code, reason = "`fork`")]

use std::fs::File;
use std::io;
use std::os::fd::{AsFd, BorrowedFd, RawFd};
use std::path::Path;

use rustix::fs::{FileType, OFlags, SeekFrom};

use crate::{Error, Result, Simulation};

/// The process in which [`Simulation::fork`] returned: original or copy.
#[derive(Debug)]
pub enum Fork {
    /// The original process.
    Original,
    /// The copy, with the result of reopening its files. It must end with [`leave`].
    Copy(Result<()>),
}

/// An open output file that a copied process continues in its own file.
#[derive(Clone, Copy, Debug)]
pub struct KeptFile<'a> {
    /// File name, without a folder.
    pub name: &'a str,
    /// Path of the copy's own file.
    pub copy: &'a Path,
}

/// Returns unused memory to the operating system before a process is copied, for example the memory of the model text.
pub fn give_back_memory() {
    // SAFETY: the allocator releases free memory only; nothing in use moves.
    #[cfg(target_env = "gnu")]
    unsafe {
        libc::malloc_trim(0);
    }
}

/// Moves the memory of this process to large pages (`MADV_COLLAPSE`, Linux 6.1; older kernels refuse, which only costs
/// speed). A copy shares the large pages of its original until it writes to them; the kernel then copies them in small
/// pages of 4 kB, one fault each. Takes about 10 ms.
///
/// # Errors
/// [`Error::Fork`] if the memory map cannot be read.
pub fn collapse_pages() -> Result<()> {
    let map = std::fs::read_to_string("/proc/self/maps").map_err(Error::Fork)?;
    for (start, end) in map.lines().filter_map(own_memory) {
        // SAFETY: the kernel moves the pages to other physical memory; addresses and content stay. It checks the range.
        unsafe { libc::madvise(start as *mut libc::c_void, end - start, libc::MADV_COLLAPSE) };
    }
    Ok(())
}

/// Returns the address range of a line of a memory map if it is private, writable, and anonymous.
fn own_memory(line: &str) -> Option<(usize, usize)> {
    let mut fields = line.split_ascii_whitespace();
    let (range, access, inode) = (fields.next()?, fields.next()?, fields.nth(2)?);
    let (start, end) = range.split_once('-')?;
    let address = |text| usize::from_str_radix(text, 16).ok();
    (access == "rw-p" && inode == "0").then_some((address(start)?, address(end)?))
}

impl Simulation {
    /// Copies this process with the simulation in its current state. The call returns in both processes. The copy
    /// continues to write the file that is `kept`, and no other.
    ///
    /// # Errors
    /// [`Error::Threads`] if the process has several threads; [`Error::Fork`] if the operating system refuses.
    pub fn fork(&mut self, kept: Option<KeptFile<'_>>) -> Result<Fork> {
        let threads = count("/proc/self/task").map_err(Error::Fork)?;
        if threads != 1 {
            return Err(Error::Threads { threads });
        }
        // SAFETY: no other thread exists, so the copy is complete: no lock is held by a thread that it lacks.
        match unsafe { libc::fork() } {
            -1 => Err(Error::Fork(io::Error::last_os_error())),
            0 => Ok(Fork::Copy(reopen_files(kept).map_err(Error::Fork))),
            _ => Ok(Fork::Original),
        }
    }
}

/// Prepares this process for being copied. It ignores terminal interrupts, which its parent handles, and adopts copies
/// of copies whose parent has ended. When a copy ends, the wait of this process is interrupted so that it can read the
/// exit status.
///
/// # Errors
/// [`Error::Fork`] if the operating system refuses.
pub fn become_ancestor() -> Result<()> {
    extern "C" fn wake_up(_: libc::c_int) {}
    // SAFETY: the handler does nothing, which is safe at any time; the action is zeroed and then filled in.
    unsafe {
        libc::signal(libc::SIGINT, libc::SIG_IGN);
        let mut action: libc::sigaction = std::mem::zeroed();
        action.sa_sigaction = wake_up as extern "C" fn(libc::c_int) as usize;
        // The engine's reads and writes are resumed.
        action.sa_flags = libc::SA_RESTART | libc::SA_NOCLDSTOP;
        libc::sigaction(libc::SIGCHLD, &action, std::ptr::null_mut());
    }
    let this = rustix::process::getpid();
    rustix::process::set_child_subreaper(Some(this)).map_err(|error| Error::Fork(error.into()))
}

/// Ends a copy immediately, without stopping or removing anything that the original still uses.
pub fn leave(code: u8) -> ! {
    // SAFETY: ends the process without running any of its code.
    unsafe { libc::_exit(code.into()) }
}

fn count(folder: &str) -> io::Result<usize> {
    Ok(std::fs::read_dir(folder)?.count())
}

/// Reopens files that are read, at the same position, and redirects the others, except the kept one, to `/dev/null`.
/// Shared memory and pipes stay shared.
fn reopen_files(kept: Option<KeptFile<'_>>) -> io::Result<()> {
    let null = File::options().write(true).open("/dev/null")?;
    let descriptors: Vec<RawFd> = std::fs::read_dir("/proc/self/fd")?
        .filter_map(|entry| entry.ok()?.file_name().to_str()?.parse().ok())
        .collect();
    for descriptor in descriptors {
        // SAFETY: the descriptor was open when the folder was read. The descriptor of the folder itself is closed by
        // now, which is an error below, not undefined behavior.
        let file = unsafe { BorrowedFd::borrow_raw(descriptor) };
        let Ok(status) = rustix::fs::fstat(file) else { continue };
        let path = format!("/proc/self/fd/{descriptor}");
        if FileType::from_raw_mode(status.st_mode) == FileType::RegularFile && !is_memory(&path) {
            reopen(file, &path, null.as_fd(), kept)?;
        }
    }
    Ok(())
}

/// Returns whether a descriptor belongs to an anonymous file in memory.
fn is_memory(path: &str) -> bool {
    std::fs::read_link(path).is_ok_and(|target| target.starts_with("/memfd:"))
}

fn reopen(
    file: BorrowedFd<'_>,
    path: &str,
    null: BorrowedFd<'_>,
    kept: Option<KeptFile<'_>>,
) -> io::Result<()> {
    let read_only = rustix::fs::fcntl_getfl(file)?.intersection(OFlags::ACCMODE) == OFlags::RDONLY;
    let fresh = match kept {
        _ if read_only => File::open(Path::new(path))?,
        Some(kept) if is_named(path, kept.name) => {
            std::fs::copy(path, kept.copy)?;
            File::options().write(true).open(kept.copy)?
        }
        _ => return redirect(null, file),
    };
    let position = rustix::fs::tell(file)?;
    rustix::fs::seek(&fresh, SeekFrom::Start(position))?;
    redirect(fresh.as_fd(), file)
}

/// Returns whether a descriptor refers to a file with this name, even if the file has been removed.
fn is_named(path: &str, name: &str) -> bool {
    let target = std::fs::read_link(path).unwrap_or_default();
    let target = target.to_string_lossy();
    Path::new(target.trim_end_matches(" (deleted)")).file_name().is_some_and(|file| file == name)
}

/// Makes the second descriptor refer to the file of the first.
fn redirect(file: BorrowedFd<'_>, at: BorrowedFd<'_>) -> io::Result<()> {
    use std::os::fd::AsRawFd;
    // SAFETY: both are open; the owner of the second, in EnergyPlus, continues to use it under the same number.
    match unsafe { libc::dup2(file.as_raw_fd(), at.as_raw_fd()) } {
        -1 => Err(io::Error::last_os_error()),
        _ => Ok(()),
    }
}
