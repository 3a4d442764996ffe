//! Suites beside each other: each keeps about one core busy for most of its time, compiling shaders or waiting for one.

use std::collections::VecDeque;
use std::io::{Read, Write};
use std::process::{Command, Stdio};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Suites that run at the same time. More would only wait for each other on two cores, and tests of more than two engines
/// at once would need memory that small machines have not.
const LANES: usize = 2;

type Work = dyn FnOnce(&mut String) -> Result<(), String> + Send;

/// Something to run whose output is kept together.
pub struct Job {
    pub name: String,
    work: Box<Work>,
}

impl Job {
    /// `work` adds what it has to say to the text that it is given, [captured](capture) or its own.
    pub fn new(
        name: impl Into<String>,
        work: impl FnOnce(&mut String) -> Result<(), String> + Send + 'static,
    ) -> Self {
        Self { name: name.into(), work: Box::new(work) }
    }

    /// Runs one program.
    pub fn of(name: impl Into<String>, mut command: Command) -> Self {
        Self::new(name, move |output| capture(&mut command, output))
    }
}

/// What became of a job.
#[derive(Debug)]
pub struct Done {
    pub name: String,
    /// All that its programs said.
    pub output: String,
    /// How it failed, if it did.
    pub failure: Option<String>,
}

/// Runs jobs, those that come first begun first, and prints the output of each when it ends. All run, even after a failure.
pub fn run(jobs: Vec<Job>) -> Vec<Done> {
    let waiting = Mutex::new(jobs.into_iter().collect::<VecDeque<_>>());
    let done = Mutex::new(vec![]);
    std::thread::scope(|scope| {
        for _ in 0..LANES {
            scope.spawn(|| {
                loop {
                    let next = waiting.lock().unwrap_or_else(PoisonError::into_inner).pop_front();
                    let Some(job) = next else { break };
                    println!("-- {} begins", job.name);
                    let start = Instant::now();
                    let ended = finish(job);
                    print(&ended, start.elapsed());
                    done.lock().unwrap_or_else(PoisonError::into_inner).push(ended);
                }
            });
        }
    });
    done.into_inner().unwrap_or_else(PoisonError::into_inner)
}

fn finish(job: Job) -> Done {
    let mut output = String::new();
    let failure = (job.work)(&mut output).err();
    Done { name: job.name, output, failure }
}

/// Runs a program and keeps what it says on both of its streams, in its order.
pub fn capture(command: &mut Command, output: &mut String) -> Result<(), String> {
    let error = |error: std::io::Error| error.to_string();
    let (mut reader, writer) = std::io::pipe().map_err(error)?;
    command.stdin(Stdio::null()).stdout(writer.try_clone().map_err(error)?).stderr(writer);
    let spawned = command.spawn();
    // The command holds our ends of the pipe, which would never run dry.
    command.stdout(Stdio::null()).stderr(Stdio::null());
    let mut child = spawned.map_err(|error| format!("{}: {error}", command.get_program().display()))?;
    let mut bytes = vec![];
    let read = reader.read_to_end(&mut bytes);
    output.push_str(&String::from_utf8_lossy(&bytes));
    let status = child.wait().map_err(error)?;
    read.map_err(error)?;
    if status.success() { Ok(()) } else { Err(status.to_string()) }
}

/// In one piece: other lanes print, too.
fn print(done: &Done, took: Duration) {
    let Done { name, output, failure } = done;
    let ending = if output.is_empty() || output.ends_with('\n') { "" } else { "\n" };
    let outcome = failure.as_ref().map_or("ok".to_owned(), |failure| format!("FAILED, {failure}"));
    let text = format!("\n-- {name}\n{output}{ending}-- {name}: {outcome} in {took:.0?}\n");
    // Nobody may be reading any more: that fails nothing.
    let _ = std::io::stdout().lock().write_all(text.as_bytes());
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    fn shell(name: &str, line: &str) -> Job {
        let mut command = Command::new("sh");
        command.args(["-c", line]);
        Job::of(name, command)
    }

    #[test]
    fn all_jobs_run_and_their_outputs_are_whole() {
        let mut done = run(vec![
            shell("both streams", "echo one; echo two >&2; echo three"),
            shell("fails", "echo before; exit 3"),
            Job::of("missing", Command::new("no-such-program")),
        ]);
        done.sort_by(|a, b| a.name.cmp(&b.name));
        let said: Vec<_> =
            done.iter().map(|done| (&*done.name, &*done.output, done.failure.is_none())).collect();
        assert_eq!(
            said,
            [
                ("both streams", "one\ntwo\nthree\n", true),
                ("fails", "before\n", false),
                ("missing", "", false)
            ]
        );
        assert!(done[1].failure.as_ref().unwrap().contains('3'));
        assert!(done[2].failure.as_ref().unwrap().contains("no-such-program"));
    }

    #[test]
    fn two_run_beside_each_other() {
        let folder = std::env::temp_dir().join(format!("lumivox-lanes-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir(&folder).unwrap();
        let at = folder.display();
        // Each ends when it sees the other: alone, neither would.
        let meet = |own: &str, other: &str| {
            let line = format!("touch '{at}/{own}'; while [ ! -e '{at}/{other}' ]; do sleep 0.01; done");
            shell(own, &line)
        };
        let done = run(vec![meet("a", "b"), meet("b", "a")]);
        assert!(done.iter().all(|done| done.failure.is_none()), "{done:?}");
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
