//! When and how pictures are made of the light that is kept: rays of some pixels are marched, as many as a frame's budget buys, and
//! the others come from the pictures before (`light_fill.wgsl` says how).

use lumivox_shaders::layout;

use super::images::pixels;
use super::passes::LightFill;
use super::reprojection::{self, Seen};
use crate::recording::{Recording, ResourceId, Step};
use crate::store::LightRoom;

/// Paths that leave points that a ray through what is kept is counted as. It takes the time of .25 to .38 (H200), but a path that
/// leaves a point takes more than one of a film, by which budgets are counted: so frames take about what theirs would.
const SAMPLES_OF_A_LOOK: f64 = 0.65;

/// The part of a frame's budget that is looked with at most: a picture of one pixel in four is as good as one of all, for the ones
/// before fill it in, and points are wanted.
const LOOKED_WITH: f64 = 0.35;

/// And where one ray is marched for so many pixels along each axis or more: there pictures want rays as much as points.
const LOOKED_WITH_COARSELY: f64 = 0.7;
const COARSE: u32 = 4;

/// And of all budgets at rest, until rays of all pixels were marched and from then on: a picture is made as soon as the frames
/// since the last one have saved so much.
const LOOKED_WITH_AT_FIRST: f64 = 0.6;
const LOOKED_WITH_AT_REST: f64 = 0.2;

/// Pixels from one whose ray is marched to the next, of those that are tried.
const STRIDES: [u32; 5] = [1, 2, 3, 4, 6];

/// How many times as much as a stride takes has to be there for one that is less than the one before: the picture's grain would
/// jump to and fro.
const WELL_AFFORDABLE: f64 = 1.5;

/// From one of the pixels within a stride to the next whose ray is marched: coprime to the square of any stride.
const SCATTERED: u32 = 5;

/// Bytes of a pixel that is kept for the next picture.
const BYTES_BEFORE: u64 = 8;

/// How a picture is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Look {
    /// Pixels along each axis from one whose ray is marched to the next.
    pub stride: u32,
    /// About how many pixel samples that takes.
    pub pixel_samples: u64,
}

/// What pictures hold for the next ones.
#[derive(Debug)]
struct Before {
    /// Of the picture before, and for the next one.
    buffers: [ResourceId; 2],
    /// What the first one shows, if anything.
    seen: Option<Seen>,
}

/// The pictures of a view.
#[derive(Debug)]
pub(super) struct Looks {
    /// Of the last one.
    stride: u32,
    /// Counts them.
    turn: u32,
    /// Pictures after which all that is known was looked at, and after which rays of all pixels were marched from here.
    stale: u32,
    missing: u32,
    /// Whether what is seen is another than in the last one.
    is_new: bool,
    /// Pixel samples that frames have saved for the next one.
    saved: f64,
    before: Option<Before>,
}

impl Looks {
    /// None was made yet.
    pub fn new() -> Self {
        Self { stride: 1, turn: 0, stale: 1, missing: 1, is_new: true, saved: 0.0, before: None }
    }

    /// The camera has moved, or something else that is seen.
    pub fn look_again(&mut self) {
        self.is_new = true;
    }

    /// More is known now.
    pub fn go_on(&mut self) {
        self.stale = self.stride * self.stride;
    }

    /// Whether there is another picture than the last one.
    pub fn is_stale(&self) -> bool {
        self.is_new || self.stale > 0
    }

    /// How the next one is made, of so many pixels and within the budget of a frame; at rest, where it can wait, whether it is.
    pub fn plan(&mut self, size: [u32; 2], budget: u64, is_at_rest: bool) -> Option<Look> {
        let samples = |stride: u32| {
            let [x, y] = size.map(|n| f64::from(n.div_ceil(stride)));
            SAMPLES_OF_A_LOOK * x * y
        };
        let is_affordable = |stride: u32| {
            let reserve = if stride < self.stride { WELL_AFFORDABLE } else { 1.0 };
            let part = if stride < COARSE { LOOKED_WITH } else { LOOKED_WITH_COARSELY };
            samples(stride) * reserve <= part * budget as f64
        };
        // So that rays of some pixels are marched wherever they begin.
        let most = STRIDES[STRIDES.len() - 1].min(size[0]).min(size[1]);
        let stride = STRIDES.into_iter().find(|stride| is_affordable(*stride)).unwrap_or(most).min(most);
        let part = if self.missing > 0 { LOOKED_WITH_AT_FIRST } else { LOOKED_WITH_AT_REST };
        self.saved += part * budget as f64;
        let is_made = !is_at_rest || self.is_new || self.saved >= samples(stride);
        is_made.then(|| {
            self.saved = 0.0;
            Look { stride, pixel_samples: samples(stride).ceil() as u64 }
        })
    }

    /// It is made now. Returns the first pixel whose ray is marched.
    pub fn begin(&mut self, look: Look) -> [u32; 2] {
        let stride = look.stride;
        let places = stride * stride;
        if std::mem::take(&mut self.is_new) || stride != self.stride {
            (self.stride, self.stale, self.missing) = (stride, places, places);
        }
        self.stale = self.stale.saturating_sub(1);
        self.missing = self.missing.saturating_sub(1);
        self.turn = (self.turn + 1) % places;
        let place = SCATTERED * self.turn % places;
        [place % stride, place / stride]
    }

    /// How pixels between marched ones are filled in: what is known of the picture before, whose place the one
    /// takes that shows what is `seen` now. Where there is no room for pictures, `unused` buffers are bound.
    pub fn before(
        &mut self,
        look: Look,
        seen: Seen,
        size: [u32; 2],
        unused: [ResourceId; 2],
        room: &mut LightRoom,
        recording: &mut Recording,
    ) -> LightFill {
        let params = layout::LightFillParams {
            camera_parallel: u32::from(reprojection::is_parallel(&seen.camera)),
            ..Default::default()
        };
        if look.stride == 1 {
            // The next one has none like it before it.
            self.before.iter_mut().for_each(|before| before.seen = None);
            return LightFill { params, buffers: unused };
        }
        let bytes = pixels(size) * BYTES_BEFORE;
        if self.before.is_none() && room.bytes() + 2 * bytes <= room.most() {
            room.resize(room.bytes() + 2 * bytes);
            let buffers =
                ["picture before", "picture for the next"].map(|it| recording.create_buffer(it, bytes));
            self.before = Some(Before { buffers, seen: None });
        }
        let Some(before) = &mut self.before else { return LightFill { params, buffers: unused } };
        before.buffers.reverse();
        // Whatever has changed since: what is marched around a pixel says what it may be.
        let map = before.seen.as_ref().and_then(|it| reprojection::before_from_now(it, &seen));
        before.seen = Some(seen);
        let columns = map.unwrap_or_default().to_cols_array_2d();
        let params = layout::LightFillParams {
            before_from_now: columns.map(|column| column.map(|x| x as f32)),
            has_before: u32::from(map.is_some()),
            keeps: 1,
            ..params
        };
        LightFill { params, buffers: before.buffers }
    }

    /// Frees what is kept of the pictures, which were of so many pixels: they will have others.
    pub fn forget(&mut self, size: [u32; 2], room: &mut LightRoom, gone: &mut Recording) {
        if let Some(before) = self.before.take() {
            room.resize(room.bytes() - 2 * pixels(size) * BYTES_BEFORE);
            before.buffers.into_iter().for_each(|id| gone.push(Step::Free { id }));
        }
        self.look_again();
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    const SIZE: [u32; 2] = [192, 108];
    const PIXELS: u64 = 192 * 108;

    #[test]
    fn small_budgets_march_few_pixels_and_never_all_of_their_samples_go_into_that() {
        for (parts, stride) in [(1, 1), (2, 2), (4, 2), (8, 3), (16, 4), (32, 4), (64, 6), (1000, 6)] {
            let budget = 2 * PIXELS / parts;
            let look = Looks::new().plan(SIZE, budget, false).unwrap();
            assert_eq!(look.stride, stride, "of {budget}");
            let is_least = parts == 1000;
            let part = if stride < COARSE { LOOKED_WITH } else { LOOKED_WITH_COARSELY };
            assert!(look.pixel_samples as f64 <= part * budget as f64 + 1.0 || is_least);
        }
        assert_eq!(Looks::new().plan([2, 3], 0, false).unwrap().stride, 2);
        assert_eq!(Looks::new().plan([1, 1], 0, false).unwrap().stride, 1);
    }

    #[test]
    fn the_grain_of_pictures_does_not_jump_to_and_fro() {
        let mut looks = Looks::new();
        let mut changes = 0;
        for frame in 0..20 {
            let budget = PIXELS / 2 + if frame % 2 == 0 { 0 } else { PIXELS / 8 };
            let before = looks.stride;
            let look = looks.plan(SIZE, budget - PIXELS / 14, false).unwrap();
            looks.begin(look);
            changes += u32::from(look.stride != before);
        }
        assert_eq!(changes, 1);
    }

    #[test]
    fn at_rest_rays_of_every_pixel_are_marched_once_and_then_no_more() {
        for budget in [2 * PIXELS, PIXELS, PIXELS / 2, PIXELS / 4, PIXELS / 8, PIXELS / 16] {
            let mut looks = Looks::new();
            let (mut places, mut pictures, mut spent) = (HashSet::new(), 0, 0);
            let mut frames = 0;
            while looks.is_stale() {
                frames += 1;
                if let Some(look) = looks.plan(SIZE, budget, frames > 1) {
                    places.insert(looks.begin(look));
                    (pictures, spent) = (pictures + 1, spent + look.pixel_samples);
                }
            }
            let places = places.len() as u32;
            assert_eq!((places, pictures), (looks.stride * looks.stride, places), "of {budget}");
            assert!(spent as f64 <= (LOOKED_WITH_AT_FIRST * frames as f64 + 1.0) * budget as f64);
            // More is known: they are looked at again, one after the other.
            looks.go_on();
            assert!(looks.is_stale());
        }
    }
}
