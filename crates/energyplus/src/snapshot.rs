//! Copies of a simulation in progress, by `fork`.
//!
//! The engine cannot save its state, but the system can copy the whole process: a copy shares its memory with the
//! original until one of the two writes to it, so that it takes milliseconds where a start takes a second. Both go
//! on bit for bit as the original would have.
//!
//! What a fork would break, and what is done about it:
//! 1. A process with several threads: the copy has one, with the locks of all. It is refused.
//! 2. Files that are being read (the weather) share one position between the two. The copy opens its own.
//! 3. Files that are being written: the copy writes to nowhere, but for one that it may keep a copy of.

use std::fs::File;
use std::io;
use std::os::fd::{AsFd, BorrowedFd, RawFd};
use std::path::Path;

use rustix::fs::{FileType, OFlags, SeekFrom};

use crate::{Error, Result, Simulation};

/// Which of the two processes goes on after [`Simulation::fork`].
#[derive(Debug)]
pub enum Fork {
    /// The process that was copied.
    Original,
    /// The copy, and whether its files could be opened anew. It must end with [`leave`].
    Copy(Result<()>),
}

/// A file that is being written and that a copy goes on to write, in a file of its own.
#[derive(Clone, Copy, Debug)]
pub struct KeptFile<'a> {
    /// Its name, without a folder.
    pub name: &'a str,
    /// Where the copy's own is.
    pub copy: &'a Path,
}

/// Gives memory back to the system that was used and is not any more, such as that of a model's text: a process that
/// stands to be copied has no use for it.
pub fn give_back_memory() {
    // SAFETY: the allocator is asked to look at what it has; nothing that is in use moves.
    #[cfg(target_env = "gnu")]
    unsafe {
        libc::malloc_trim(0);
    }
}

impl Simulation {
    /// Copies this process, and with it the simulation at its current point. Both processes return from the call. The
    /// copy continues to write the file that is `kept`, and no other.
    ///
    /// # Errors
    /// [`Error::Threads`] when this is not the only thread; [`Error::Fork`] when the system refuses.
    pub fn fork(&mut self, kept: Option<KeptFile<'_>>) -> Result<Fork> {
        let threads = count("/proc/self/task").map_err(Error::Fork)?;
        if threads != 1 {
            return Err(Error::Threads { threads });
        }
        // SAFETY: no other thread exists, so that the copy is whole: no lock is held by a thread that it lacks.
        match unsafe { libc::fork() } {
            -1 => Err(Error::Fork(io::Error::last_os_error())),
            0 => Ok(Fork::Copy(open_files_anew(kept).map_err(Error::Fork))),
            _ => Ok(Fork::Original),
        }
    }
}

/// Makes this process one to be copied: a terminal's interrupt is left to whoever started it, and it becomes the
/// parent of all copies of copies whose own parent is gone. A copy that ends interrupts what this process waits for, so
/// that it can ask for the exit status.
///
/// # Errors
/// [`Error::Fork`] when the system refuses.
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

/// Ends a copy at once: nothing that the original still uses is stopped or removed.
pub fn leave(code: u8) -> ! {
    // SAFETY: ends the process without running any code of it.
    unsafe { libc::_exit(code.into()) }
}

fn count(folder: &str) -> io::Result<usize> {
    Ok(std::fs::read_dir(folder)?.count())
}

/// Gives every open regular file a position of its own. Memory and pipes that are shared stay shared.
fn open_files_anew(kept: Option<KeptFile<'_>>) -> io::Result<()> {
    let nowhere = File::options().write(true).open("/dev/null")?;
    let descriptors: Vec<RawFd> = std::fs::read_dir("/proc/self/fd")?
        .filter_map(|entry| entry.ok()?.file_name().to_str()?.parse().ok())
        .collect();
    for descriptor in descriptors {
        // SAFETY: the descriptor was open when the folder was read; the one of the folder itself is closed by now,
        // and a closed one is an error below, not undefined.
        let file = unsafe { BorrowedFd::borrow_raw(descriptor) };
        let Ok(status) = rustix::fs::fstat(file) else { continue };
        let path = format!("/proc/self/fd/{descriptor}");
        if FileType::from_raw_mode(status.st_mode) == FileType::RegularFile && !is_memory(&path) {
            open_anew(file, &path, nowhere.as_fd(), kept)?;
        }
    }
    Ok(())
}

/// Whether a descriptor is of a file without a name on any disk.
fn is_memory(path: &str) -> bool {
    std::fs::read_link(path).is_ok_and(|target| target.starts_with("/memfd:"))
}

fn open_anew(
    file: BorrowedFd<'_>,
    path: &str,
    nowhere: BorrowedFd<'_>,
    kept: Option<KeptFile<'_>>,
) -> io::Result<()> {
    let read_only = rustix::fs::fcntl_getfl(file)?.intersection(OFlags::ACCMODE) == OFlags::RDONLY;
    let fresh = match kept {
        _ if read_only => File::open(Path::new(path))?,
        Some(kept) if is_named(path, kept.name) => {
            std::fs::copy(path, kept.copy)?;
            File::options().write(true).open(kept.copy)?
        }
        _ => return put(nowhere, file),
    };
    let position = rustix::fs::tell(file)?;
    rustix::fs::seek(&fresh, SeekFrom::Start(position))?;
    put(fresh.as_fd(), file)
}

/// Whether a descriptor is of a file of this name, which may have been removed.
fn is_named(path: &str, name: &str) -> bool {
    let target = std::fs::read_link(path).unwrap_or_default();
    let target = target.to_string_lossy();
    Path::new(target.trim_end_matches(" (deleted)")).file_name().is_some_and(|file| file == name)
}

/// Makes the second descriptor one of the first's file.
fn put(file: BorrowedFd<'_>, at: BorrowedFd<'_>) -> io::Result<()> {
    use std::os::fd::AsRawFd;
    // SAFETY: both are open; the owner of the second, in the engine, goes on to use it under the same number.
    match unsafe { libc::dup2(file.as_raw_fd(), at.as_raw_fd()) } {
        -1 => Err(io::Error::last_os_error()),
        _ => Ok(()),
    }
}
