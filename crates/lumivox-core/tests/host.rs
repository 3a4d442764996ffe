//! A host without threads, and with a clock of its own: a process has one, so this has a program for itself.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use lumivox_core::host::{self, Host, Moment, Work};

static MILLISECONDS: AtomicU64 = AtomicU64::new(0);

struct Page;

impl Host for Page {
    fn now(&self) -> Duration {
        Duration::from_millis(MILLISECONDS.load(Ordering::Relaxed))
    }

    fn spare_threads(&self) -> usize {
        0
    }

    fn spawn(&self, _: &str, work: Work) -> Result<(), Work> {
        Err(work)
    }

    fn sleep(&self, _: Duration) {}
}

#[test]
fn the_clock_and_the_threads_are_those_of_the_host() {
    assert!(host::set_host(Box::new(Page)).is_ok());
    let began = Moment::now();
    host::sleep(Duration::from_secs(3600));
    assert_eq!(began.elapsed(), Duration::ZERO);
    MILLISECONDS.store(40, Ordering::Relaxed);
    assert_eq!(began.elapsed(), Duration::from_millis(40));
    assert_eq!(host::spare_threads(), 0);

    let (send, receive) = std::sync::mpsc::channel();
    let undone = host::spawn("nowhere", move || send.send(std::thread::current().id()).unwrap());
    assert!(receive.try_recv().is_err(), "there is no thread for it");
    undone.expect_err("it comes back")();
    assert_eq!(receive.try_recv(), Ok(std::thread::current().id()));
    assert!(host::set_host(Box::new(Page)).is_err(), "a process has one host");
}
