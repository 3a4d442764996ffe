//! Bricks cut out of a volume by other threads, before the frames that bring them: to read and to filter voxels takes
//! longer than a frame has.

use std::collections::VecDeque;
use std::sync::{Arc, OnceLock};

use super::Resident;
use super::bricks::{self, Run};
use super::source::WeakSource;
use crate::recording::{Payload, TextureFormat};

/// Bytes of a piece at most: about what a frame brings at least, and a whole row of most scans' bricks.
const PIECE_BYTES: u64 = 5 << 18;

/// Bytes that are cut ahead at most, for frames that bring much.
const MOST_AHEAD: u64 = 64 << 20;

/// Pieces of a volume, in the order of its bricks.
#[derive(Debug)]
pub(super) struct Cutter {
    source: WeakSource,
    /// The first brick that nobody cuts yet.
    next: usize,
    pieces: VecDeque<Piece>,
    /// Bytes of the pieces.
    ahead: u64,
}

#[derive(Debug)]
struct Piece {
    run: Run,
    bytes: u64,
    texels: Arc<OnceLock<Payload>>,
}

impl Cutter {
    /// Of what comes after so many bricks.
    pub fn new(source: &WeakSource, done: usize) -> Self {
        Self { source: source.clone(), next: done, pieces: VecDeque::new(), ahead: 0 }
    }

    /// Whether there is a thread besides this one.
    pub fn has_threads() -> bool {
        rayon::current_num_threads() > 1
    }

    /// The next piece, if it is cut by now and no larger.
    pub fn take(&mut self, most: u64) -> Option<(Run, Payload)> {
        let piece = self.pieces.front().filter(|piece| piece.bytes <= most)?;
        let texels = piece.texels.get()?.clone();
        let Piece { run, bytes, .. } = self.pieces.pop_front()?;
        self.ahead -= bytes;
        Some((run, texels))
    }

    /// Has pieces cut for frames that bring so many bytes each, of bricks of `brick_bytes`.
    pub fn go_on(&mut self, resident: &Resident, format: impl Fn(u32) -> (TextureFormat, u64), budget: u64) {
        let piece_bytes = budget.min(PIECE_BYTES);
        // For the next frame, and for those in which they are cut.
        let wanted = budget.saturating_mul(3).clamp(2 * piece_bytes, MOST_AHEAD);
        while self.ahead < wanted && self.next < resident.pages.len() {
            let (format, brick_bytes) = format(resident.pages[self.next]);
            let run = bricks::run(resident, self.next, (piece_bytes / brick_bytes).max(1) as usize);
            let bytes = run.bricks() as u64 * brick_bytes;
            let texels = Arc::new(OnceLock::new());
            self.next += run.bricks();
            self.ahead += bytes;
            self.pieces.push_back(Piece { run, bytes, texels: texels.clone() });
            let (source, factor, grid) = (self.source.clone(), resident.factor, resident.bricks);
            rayon::spawn_fifo(move || {
                // Nobody waits for what is gone, nor for a piece that was given up.
                if Arc::strong_count(&texels) > 1
                    && let Some(source) = source.upgrade()
                {
                    let _ = texels.set(bricks::texels(&source, factor, grid, run, format));
                }
            });
        }
    }
}
