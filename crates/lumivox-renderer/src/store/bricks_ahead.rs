//! Bricks cut out of a volume by other threads, before the frames that bring them: to read and to filter voxels takes
//! longer than a frame has.

use std::collections::VecDeque;
use std::sync::{Arc, OnceLock};

use lumivox_core::host;

use super::Bricks;
use super::bricks::{self, BrickGrid, Run};
use super::source::WeakSource;
use crate::recording::{Payload, TextureFormat};

/// Bytes of a piece at most: about what a frame brings at least.
const PIECE_BYTES: u64 = 5 << 18;

/// Bytes that are cut ahead at most, for frames that bring much.
const MOST_AHEAD: u64 = 64 << 20;

/// Frames that a piece is waited for: threads that are busy with something else, as an import, take up what came last.
const PATIENCE: u32 = 8;

/// Pieces of a volume, in the order of its bricks.
#[derive(Debug)]
pub(super) struct BricksAhead {
    source: WeakSource,
    /// The first brick that nobody cuts yet.
    next: usize,
    pieces: VecDeque<Piece>,
    /// Bytes of the pieces.
    ahead: u64,
}

#[derive(Debug)]
struct Piece {
    cut: Cut,
    bytes: u64,
    texels: Arc<OnceLock<Payload>>,
    /// Frames that have asked for it.
    asked: u32,
}

/// What is to be cut.
#[derive(Clone, Debug)]
struct Cut {
    source: WeakSource,
    factor: u32,
    grid: BrickGrid,
    run: Run,
    format: TextureFormat,
}

impl Cut {
    /// `None` where the volume is gone.
    fn texels(&self) -> Option<Payload> {
        let source = self.source.upgrade()?;
        Some(bricks::texels(&source, self.factor, self.grid, self.run, self.format))
    }
}

impl BricksAhead {
    /// Of what comes after so many bricks.
    pub fn new(source: &WeakSource, done: usize) -> Self {
        Self { source: source.clone(), next: done, pieces: VecDeque::new(), ahead: 0 }
    }

    /// Whether there is a thread besides this one.
    pub fn has_threads() -> bool {
        rayon::current_num_threads() > 1
    }

    /// The next piece, if it is no larger and cut by now; one that nobody cuts is cut here.
    pub fn take(&mut self, most: u64) -> Option<(Run, Payload)> {
        let piece = self.pieces.front_mut().filter(|piece| piece.bytes <= most)?;
        piece.asked += 1;
        let texels = match piece.texels.get() {
            Some(texels) => texels.clone(),
            None if piece.asked > PATIENCE => piece.cut.texels()?,
            None => return None,
        };
        let piece = self.pieces.pop_front()?;
        self.ahead -= piece.bytes;
        Some((piece.cut.run, texels))
    }

    /// Has pieces cut for frames that bring so many bytes each, of bricks of `brick_bytes`.
    pub fn go_on(&mut self, bricks: &Bricks, of_page: impl Fn(u32) -> (TextureFormat, u64), budget: u64) {
        let piece_bytes = budget.min(PIECE_BYTES);
        // For the next frame, and for those in which they are cut.
        let wanted = budget.saturating_mul(3).clamp(2 * piece_bytes, MOST_AHEAD);
        while self.ahead < wanted && self.next < bricks.pages.len() {
            let (format, brick_bytes) = of_page(bricks.pages[self.next]);
            let run = bricks::run(bricks, self.next, (piece_bytes / brick_bytes).max(1) as usize);
            let bytes = run.bricks() as u64 * brick_bytes;
            let texels = Arc::new(OnceLock::new());
            self.next += run.bricks();
            self.ahead += bytes;
            let (factor, grid) = (bricks.factor, bricks.grid);
            let cut = Cut { source: self.source.clone(), factor, grid, run, format };
            self.pieces.push_back(Piece { cut: cut.clone(), bytes, texels: texels.clone(), asked: 0 });
            host::aside(move || {
                // Nobody waits for what is gone, nor for a piece that was given up.
                if Arc::strong_count(&texels) > 1
                    && let Some(cut) = cut.texels()
                {
                    let _ = texels.set(cut);
                }
            });
        }
    }
}
