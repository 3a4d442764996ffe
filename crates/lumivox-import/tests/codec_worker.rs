//! Native decoders that crash, hang or eat memory, in a process of their own: the frame is lost, the series is not.
//!
//! This program is its own worker, so it has no test harness.

mod common;
#[allow(dead_code, reason = "not every test program uses all of it")]
#[path = "common/writer.rs"]
mod writer;

use std::{
    io::{self, Read},
    path::Path,
    time::{Duration, Instant},
};

use lumivox_core::{CancelToken, Progress};
use lumivox_import::{CodecWorker, ImportError, ImportOptions, Imported, set_codec_worker};
use writer::*;

/// Does to the worker what a stream says: as a decoder with a fault would.
struct Trap<R>(R);

impl<R: Read> Read for Trap<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n = self.0.read(buffer)?;
        let has = |word: &[u8]| buffer[..n].windows(word.len()).any(|window| window == word);
        if has(b"CRASH THE WORKER") {
            std::process::abort();
        } else if has(b"HANG THE WORKER") {
            std::thread::sleep(Duration::from_secs(600));
        } else if has(b"LEAVE AFTER THE ANSWER") {
            // Nobody reads the next request.
            #[cfg(unix)]
            // SAFETY: from here on, standard input is at its end for this process.
            unsafe {
                libc::close(libc::STDIN_FILENO)
            };
        } else if has(b"EAT 64 MEGABYTES") {
            std::hint::black_box(vec![0u8; 64 << 20]);
        } else if has(b"EAT 2 GIGABYTES") {
            // Page by page: some systems count what was touched.
            std::hint::black_box(vec![1u8; 2 << 30]);
        }
        Ok(n)
    }
}

/// JPEG-LS of 4 x 1 samples of 8 bits (made with CharLS), with `comment` in a marker segment of its own.
fn stream(samples: [u8; 4], comment: &[u8]) -> Vec<u8> {
    let info = charls::FrameInfo { width: 4, height: 1, bits_per_sample: 8, component_count: 1 };
    let whole = charls::CharLS::default().encode(info, 0, &samples).expect("CharLS encodes");
    let mut stream = whole[..2].to_vec();
    stream.extend([0xFF, 0xFE]);
    stream.extend((comment.len() as u16 + 2).to_be_bytes());
    stream.extend(comment);
    stream.extend(&whole[2..]);
    stream.resize(stream.len().next_multiple_of(2), 0);
    stream
}

fn write_series(folder: &Path, bad: &[u8]) {
    write_slices(folder, |k| if k == 2 { bad } else { b"fine" });
}

/// Five slices, each with a comment.
fn write_slices<'a>(folder: &Path, comment: impl Fn(u8) -> &'a [u8]) {
    for k in 0..5u8 {
        let mut image = image("MR", 4, 1, vec![])
            .short(BITS_ALLOCATED, 8)
            .short(BITS_STORED, 8)
            .short(HIGH_BIT, 7)
            .decimals(IMAGE_POSITION_PATIENT, &[0.0, 0.0, 2.0 * f64::from(k)]);
        image.set(PIXEL_DATA, "OB", Value::Fragments(vec![stream([k * 10; 4], comment(k))]));
        image.write(&folder.join(k.to_string()), Syntax::JpegLs);
    }
}

fn load(folder: &Path, cancel: &CancelToken) -> Result<Imported, ImportError> {
    lumivox_import::load(&[folder.to_owned()], &ImportOptions::default(), Progress::SILENT, cancel)
}

fn fill(folder: &Path) -> Imported {
    let mut options = ImportOptions::default();
    options.fill_damaged = true;
    lumivox_import::load(&[folder.to_owned()], &options, Progress::SILENT, &CancelToken::new()).unwrap()
}

/// A comment that the worker meets once it has its first request, and with it its limit.
fn later(words: &[u8]) -> Vec<u8> {
    // More than it reads at a time; twice, should a read part it.
    [&[b'.'; 40_000][..], words, b" ... ", words].concat()
}

/// Of the middle column, from slice to slice.
fn values(imported: &Imported) -> Vec<f64> {
    (0..imported.volume.dims()[2]).map(|z| imported.volume.value([0, 0, z])).collect()
}

fn main() {
    if std::env::args().any(|argument| argument == "--worker") {
        lumivox_import::serve_codecs(Trap(io::stdin().lock()), io::stdout().lock()).unwrap();
        return;
    }
    let mut worker = CodecWorker::new(std::env::current_exe().unwrap(), ["--worker"]);
    // Ample for a frame on a busy machine.
    worker.timeout = Duration::from_secs(4);
    set_codec_worker(Some(worker.clone()));
    let folder = tempfile::tempdir().unwrap();

    write_series(folder.path(), b"fine");
    let imported = load(folder.path(), &CancelToken::new()).unwrap();
    assert!(imported.report.skipped.is_empty(), "{:?}", imported.report.skipped);
    assert_eq!(imported.volume.value_range(), [0.0, 40.0]);
    println!("frames are decoded by the worker ... ok");

    write_series(folder.path(), &later(b"EAT 64 MEGABYTES"));
    let imported = load(folder.path(), &CancelToken::new()).unwrap();
    assert_eq!(values(&imported), [0.0, 10.0, 20.0, 30.0, 40.0], "{:?}", imported.report.skipped);
    println!("memory below the limit is given ... ok");

    // On one thread, so that all frames go to the same worker, if it is there.
    write_slices(folder.path(), |_| b"LEAVE AFTER THE ANSWER");
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let imported = one.install(|| load(folder.path(), &CancelToken::new())).unwrap();
    assert_eq!(values(&imported), [0.0, 10.0, 20.0, 30.0, 40.0], "{:?}", imported.report.skipped);
    println!("a worker that left while it was idle is replaced ... ok");

    let mut traps = vec![
        (b"CRASH THE WORKER".to_vec(), "crashed its decoder"),
        (b"HANG THE WORKER".to_vec(), "kept its decoder busy"),
    ];
    // There alone limits are kept.
    if cfg!(any(target_os = "linux", windows)) {
        traps.push((later(b"EAT 2 GIGABYTES"), "asked it for too much memory"));
    } else {
        println!("asked it for too much memory ... NOT RUN: this system keeps no limit of memory");
    }
    for (bad, why) in traps {
        write_series(folder.path(), &bad);
        let imported = load(folder.path(), &CancelToken::new()).unwrap();
        // The lost slice stays empty, its neighbours were read.
        assert_eq!(values(&imported), [0.0, 10.0, 0.0, 30.0, 40.0]);
        assert_eq!(imported.report.notes[0], "1 of 5 slices is damaged; left empty: slice 3 at (0, 0, 4) mm");
        assert_eq!(imported.report.empty_slices, [2]);
        // Or it is filled in between them.
        let filled = fill(folder.path());
        assert_eq!(values(&filled), [0.0, 10.0, 20.0, 30.0, 40.0]);
        assert_eq!(filled.report.notes[0], "1 of 5 slices could not be decoded");
        assert!(imported.report.skipped[0].path.ends_with("2"));
        assert!(imported.report.skipped[0].reason.contains(why), "{:?}", imported.report.skipped);
        println!("{why} ... ok");
    }

    // Cancelled while a decoder hangs that has all the time of the world.
    write_series(folder.path(), b"HANG THE WORKER");
    worker.timeout = Duration::from_secs(300);
    set_codec_worker(Some(worker.clone()));
    let cancel = CancelToken::new();
    let late = cancel.clone();
    let canceller = std::thread::spawn(move || {
        std::thread::sleep(Duration::from_millis(600));
        late.cancel();
        Instant::now()
    });
    let result = load(folder.path(), &cancel);
    let after = canceller.join().unwrap().elapsed();
    assert!(matches!(result, Err(ImportError::Cancelled(_))), "{result:?}");
    assert!(after < worker.timeout / 10, "cancelled after {after:?}");
    println!("a hanging decoder is cancelled after {after:?} ... ok");

    // A worker that is not there is said.
    set_codec_worker(Some(CodecWorker::new("/nonexistent", ["--worker"])));
    let error = load(folder.path(), &CancelToken::new()).unwrap_err().to_string();
    assert!(error.contains("cannot be started"), "{error}");
    println!("a missing worker is named ... ok");
}
