//! The numbers of a label map, as they are read, and the few of them that there are: one byte for each voxel.

use std::{collections::HashMap, collections::TryReserveError};

use crate::{
    claims::{Claims, Settled},
    sample::SampleType,
};

/// Labels that one byte tells apart, beside [`UNLABELLED`](lumivox_core::UNLABELLED).
pub(crate) const MOST_LABELS: usize = 255;

/// How far from a whole number a value may lie that means one: slopes of 32 bits and resampling leave so much.
const WHOLE: f64 = 1e-3;

/// Which label a number means: that of its layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Number {
    pub layer: usize,
    pub value: i128,
}

/// Why numbers are no labels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum NoLabels {
    /// A number has a fraction.
    Fraction(f64),
    /// There are more than [`MOST_LABELS`].
    TooMany,
    /// Voxels have colours.
    Colors,
    /// No file holds any.
    None,
}

/// A grid of labels whose numbers come one after the other, in one layer or several.
pub(crate) struct Collector {
    sample: SampleType,
    big_endian: bool,
    rescale: [f64; 2],
    count: usize,
    voxels: Store,
    layers: usize,
    /// Whether the numbers of all layers of a voxel come before those of the next.
    interleaved: bool,
    /// Samples that came.
    taken: usize,
    /// The layer that counts, where not all do.
    only: Option<usize>,
    /// What each stored number of a layer means: the place in `numbers` and one, or 0.
    known: Vec<HashMap<u64, u8>>,
    numbers: Vec<Number>,
    last: (usize, u64, u8),
    not_finite: bool,
    /// Voxels with a label, and those of them that follow one with another label.
    labelled: u64,
    changes: u64,
    before: u8,
}

/// For each voxel the place of its label in [`Collector::numbers`] and one, or 0.
enum Store {
    One(Vec<u8>),
    /// Of several layers, which may have labels at the same voxel.
    Several(Claims),
}

/// What was collected.
pub(crate) struct Collected {
    /// For each voxel the place in `numbers` and one, or 0 where there is none.
    pub voxels: Vec<u8>,
    /// In the order in which they came.
    pub numbers: Vec<Number>,
    /// Of several layers, what became of voxels that have labels in more than one: places in `numbers` and one.
    pub settled: Option<Settled>,
    /// Whether there were samples that are no number.
    pub not_finite: bool,
    /// Whether hardly a voxel has the label of its neighbour, as the values of a scan are.
    pub is_scattered: bool,
}

impl Collector {
    /// Makes room for `count` voxels in each of `layers`; `rescale` is slope and intercept.
    pub fn new(
        (sample, big_endian): (SampleType, bool),
        rescale: [f64; 2],
        count: usize,
        (layers, interleaved): (usize, bool),
    ) -> Result<Self, TryReserveError> {
        let voxels = if layers > 1 {
            Store::Several(Claims::new(count)?)
        } else {
            let mut voxels = Vec::new();
            voxels.try_reserve_exact(count)?;
            voxels.resize(count, 0);
            Store::One(voxels)
        };
        let known = vec![HashMap::new(); layers];
        let last = (usize::MAX, 0, 0);
        Ok(Self {
            sample,
            big_endian,
            rescale,
            count,
            voxels,
            layers,
            interleaved,
            taken: 0,
            only: None,
            known,
            numbers: Vec::new(),
            last,
            not_finite: false,
            labelled: 0,
            changes: 0,
            before: 0,
        })
    }

    /// Leaves out all layers but one, counted from 0.
    pub fn take_only(&mut self, layer: usize) {
        self.only = Some(layer);
    }

    /// Takes whole samples.
    ///
    /// # Errors
    /// [`NoLabels`] at the first that is none.
    pub fn push(&mut self, bytes: &[u8]) -> Result<(), NoLabels> {
        for sample in bytes.chunks_exact(self.sample.bytes()) {
            let mut wide = [0; 8];
            wide[..sample.len()].copy_from_slice(sample);
            if self.big_endian {
                wide[..sample.len()].reverse();
            }
            let stored = u64::from_le_bytes(wide);
            let (layer, voxel) = if self.interleaved {
                (self.taken % self.layers, self.taken / self.layers)
            } else {
                (self.taken / self.count, self.taken % self.count)
            };
            self.taken += 1;
            if self.only.is_some_and(|only| only != layer) {
                continue;
            }
            if (layer, stored) != (self.last.0, self.last.1) {
                self.last = (layer, stored, self.label(layer, stored)?);
            }
            let label = self.last.2;
            if label != 0 {
                self.labelled += 1;
                self.changes += u64::from(self.before != 0 && self.before != label);
                match &mut self.voxels {
                    Store::One(voxels) => voxels[voxel] = label,
                    Store::Several(claims) => claims.add(voxel, label.into()),
                }
            }
            self.before = label;
        }
        Ok(())
    }

    /// What a stored number means.
    fn label(&mut self, layer: usize, stored: u64) -> Result<u8, NoLabels> {
        if let Some(&label) = self.known[layer].get(&stored) {
            return Ok(label);
        }
        let label = match self.value(stored)? {
            0 => 0,
            value => {
                let number = Number { layer, value };
                let at = self.numbers.iter().position(|known| *known == number).unwrap_or_else(|| {
                    self.numbers.push(number);
                    self.numbers.len() - 1
                });
                if at >= MOST_LABELS {
                    return Err(NoLabels::TooMany);
                }
                at as u8 + 1
            }
        };
        // Ever new bits of what is no number must not fill the memory.
        if self.known[layer].len() <= 4 * MOST_LABELS {
            self.known[layer].insert(stored, label);
        }
        Ok(label)
    }

    /// The number that stored bits stand for; 0 for what is none.
    fn value(&mut self, stored: u64) -> Result<i128, NoLabels> {
        let bytes = stored.to_le_bytes();
        let signed = |bits: u32| i128::from(((stored << (64 - bits)) as i64) >> (64 - bits));
        let exact = match self.sample {
            SampleType::U8 | SampleType::U16 | SampleType::U32 | SampleType::U64 => Ok(i128::from(stored)),
            SampleType::I8 => Ok(signed(8)),
            SampleType::I16 => Ok(signed(16)),
            SampleType::I32 => Ok(signed(32)),
            SampleType::I64 => Ok(signed(64)),
            SampleType::F32 => Err(f64::from(f32::from_bits(stored as u32))),
            SampleType::F64 => Err(f64::from_le_bytes(bytes)),
        };
        let value = match exact {
            Ok(whole) if self.rescale == [1.0, 0.0] => return Ok(whole),
            Ok(whole) => whole as f64 * self.rescale[0] + self.rescale[1],
            Err(value) => value * self.rescale[0] + self.rescale[1],
        };
        if !value.is_finite() {
            self.not_finite = true;
            return Ok(0);
        }
        if (value - value.round()).abs() > WHOLE {
            return Err(NoLabels::Fraction(value));
        }
        Ok(value.round() as i128)
    }

    pub fn finish(self) -> Collected {
        /// Fewer labels may lie however they like.
        const MANY: usize = 32;
        let is_scattered = self.numbers.len() >= MANY && self.changes > self.labelled / 2;
        let Self { voxels, numbers, not_finite, .. } = self;
        let (voxels, settled) = match voxels {
            Store::One(voxels) => (voxels, None),
            Store::Several(claims) => {
                let mut settled = claims.settle();
                // Labels have places of a byte.
                let voxels =
                    std::mem::take(&mut settled.voxels).into_iter().map(|label| label as u8).collect();
                (voxels, Some(settled))
            }
        };
        Collected { voxels, numbers, settled, not_finite, is_scattered }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn collect(sample: SampleType, rescale: [f64; 2], bytes: &[u8]) -> Result<Collected, NoLabels> {
        let mut collector =
            Collector::new((sample, false), rescale, bytes.len() / sample.bytes(), (1, false)).unwrap();
        collector.push(bytes)?;
        Ok(collector.finish())
    }

    fn values(collected: &Collected) -> Vec<i128> {
        let value =
            |&label: &u8| if label == 0 { 0 } else { collected.numbers[usize::from(label) - 1].value };
        collected.voxels.iter().map(value).collect()
    }

    #[test]
    fn numbers_are_exact_whatever_their_type() {
        macro_rules! check {
            ($variant:ident, $type:ty, $values:expr) => {
                let numbers: &[$type] = &$values;
                let bytes: Vec<u8> = numbers.iter().flat_map(|v| v.to_le_bytes()).collect();
                let expected: Vec<i128> = numbers.iter().map(|&v| v as i128).collect();
                let collected = collect(SampleType::$variant, [1.0, 0.0], &bytes).unwrap();
                assert_eq!(values(&collected), expected, stringify!($variant));
            };
        }
        check!(U8, u8, [0, 255, 3]);
        check!(I8, i8, [-128, 127, 0]);
        check!(U16, u16, [65535, 0]);
        check!(I16, i16, [-1, 2035]);
        // Beyond what 32-bit floats tell apart.
        check!(U32, u32, [312_782_546, 312_782_550, u32::MAX]);
        check!(I32, i32, [i32::MIN, 7]);
        check!(U64, u64, [u64::MAX, 1]);
        check!(I64, i64, [i64::MIN, 5]);
        check!(F32, f32, [0.0, 2.0, -3.0]);
        check!(F64, f64, [1e9, 4.0]);
    }

    #[test]
    fn slopes_are_applied_and_fractions_refused() {
        assert_eq!(values(&collect(SampleType::U8, [2.0, -2.0], &[1, 2, 0]).unwrap()), [0, 2, -2]);
        let half = collect(SampleType::U8, [0.5, 0.0], &[2, 1]);
        assert_eq!(half.err(), Some(NoLabels::Fraction(0.5)));
        let bytes: Vec<u8> = [f32::NAN, 3.0, f32::INFINITY].iter().flat_map(|v| v.to_le_bytes()).collect();
        let collected = collect(SampleType::F32, [1.0, 0.0], &bytes).unwrap();
        assert_eq!((values(&collected), collected.not_finite), (vec![0, 3, 0], true));
    }

    #[test]
    fn as_many_as_a_byte_tells_apart_and_no_more() {
        let bytes = |n: u16| -> Vec<u8> { (0..n).flat_map(u16::to_le_bytes).collect() };
        assert_eq!(collect(SampleType::U16, [1.0, 0.0], &bytes(256)).unwrap().numbers.len(), 255);
        let more = collect(SampleType::U16, [1.0, 0.0], &bytes(257));
        assert_eq!(more.err(), Some(NoLabels::TooMany));
    }

    #[test]
    fn the_smaller_label_counts_in_either_order_of_samples() {
        for (interleaved, bytes) in [(true, [1, 0, 1, 1, 0, 0, 1, 2]), (false, [1, 1, 0, 1, 0, 1, 0, 2])] {
            let mut collector =
                Collector::new((SampleType::U8, false), [1.0, 0.0], 4, (2, interleaved)).unwrap();
            collector.push(&bytes).unwrap();
            let collected = collector.finish();
            let number = |voxel: usize| collected.numbers[usize::from(collected.voxels[voxel]) - 1];
            assert_eq!(number(0), Number { layer: 0, value: 1 });
            assert_eq!(number(1), Number { layer: 1, value: 1 });
            assert_eq!(number(3), Number { layer: 1, value: 2 });
            assert_eq!(collected.settled.unwrap().shared, 2);
        }
    }
}
