//! Writing to a process that may be dead, in a host that has not said what that shall do.

/// While this lives, a write to a closed pipe is an error for this thread and nothing else. Unix would end the whole
/// process by SIGPIPE, unless it ignores that signal: Rust programs do, engines may not.
pub(crate) struct BrokenPipesAreErrors {
    #[cfg(unix)]
    before: libc::sigset_t,
    #[cfg(unix)]
    was_pending: bool,
    /// The signal mask is a thread's own.
    #[cfg(unix)]
    _on_this_thread: std::marker::PhantomData<*const ()>,
}

#[cfg(not(unix))]
impl BrokenPipesAreErrors {
    pub fn new() -> Self {
        Self {}
    }
}

#[cfg(unix)]
impl BrokenPipesAreErrors {
    pub fn new() -> Self {
        let was_pending = is_pending();
        // SAFETY: both sets are valid for the call, which changes nothing but this thread's mask.
        let before = unsafe {
            let mut before = std::mem::zeroed();
            libc::pthread_sigmask(libc::SIG_BLOCK, &broken_pipe(), &mut before);
            before
        };
        Self { before, was_pending, _on_this_thread: std::marker::PhantomData }
    }
}

#[cfg(unix)]
impl Drop for BrokenPipesAreErrors {
    fn drop(&mut self) {
        if !self.was_pending && is_pending() {
            let mut taken = 0;
            // SAFETY: the signal is blocked and pending for this thread: it is taken at once.
            unsafe { libc::sigwait(&broken_pipe(), &mut taken) };
        }
        // SAFETY: the mask is the one that the thread had.
        unsafe { libc::pthread_sigmask(libc::SIG_SETMASK, &self.before, std::ptr::null_mut()) };
    }
}

#[cfg(unix)]
fn broken_pipe() -> libc::sigset_t {
    // SAFETY: `sigemptyset` initialises the set.
    unsafe {
        let mut set = std::mem::zeroed();
        libc::sigemptyset(&mut set);
        libc::sigaddset(&mut set, libc::SIGPIPE);
        set
    }
}

#[cfg(unix)]
fn is_pending() -> bool {
    // SAFETY: `sigpending` initialises the set.
    unsafe {
        let mut set = std::mem::zeroed();
        libc::sigpending(&mut set) == 0 && libc::sigismember(&set, libc::SIGPIPE) == 1
    }
}

#[cfg(all(test, unix))]
mod tests {
    use std::io::{Error, ErrorKind, PipeWriter, Write};
    use std::time::Duration;

    use super::*;

    /// As in a process that does not ignore the signal: there, a second one would be the end of this one.
    #[test]
    fn a_reader_that_is_gone_is_an_error() {
        // SAFETY: the handler is the system's own.
        let before = unsafe { libc::signal(libc::SIGPIPE, libc::SIG_DFL) };
        for _ in 0..2 {
            let guard = BrokenPipesAreErrors::new();
            let (reader, writer) = std::io::pipe().unwrap();
            drop(reader);
            assert_eq!(first_error(writer).kind(), ErrorKind::BrokenPipe);
            drop(guard);
            assert!(!is_pending());
        }
        // SAFETY: as above.
        unsafe { libc::signal(libc::SIGPIPE, before) };
    }

    /// A process that another test starts at this moment holds a copy of the reader until it is itself.
    fn first_error(mut writer: PipeWriter) -> Error {
        for _ in 0..10_000 {
            if let Err(error) = writer.write_all(b"?") {
                return error;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        panic!("ten thousand writes reached a reader that is gone");
    }
}
