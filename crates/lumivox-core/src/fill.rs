//! Fill values: what programs write where nothing was measured, far from all that was: -9999, -32768, the largest number of a
//! type. Left alone they stretch a scan's range, pass for air or metal, and blur into what lies beside them.

use std::collections::HashSet;

use rayon::prelude::*;

use crate::volume::Voxels;

/// Numbers that are used so, of which a smaller distance from the others is believed.
const USUAL: [f64; 17] = [
    -32768.0, -32767.0, 32767.0, 65535.0, -9999.0, 9999.0, -99999.0, 99999.0, -999.0, -2000.0, -2048.0,
    -3000.0, -3024.0, -1e20, 1e20, 1e30, -1e30,
];

/// Voxels from which on one value is frequent, as a part of all, and the fewest.
const FREQUENT: u64 = 1000;
const LEAST: u64 = 8;

/// Values that a scan has besides; a map of labels has fewer.
const LEAST_VALUES: usize = 32;

/// Samples that a task looks at.
const CHUNK: usize = 1 << 18;

/// A fill value that was found and replaced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fill {
    /// The physical value.
    pub value: f64,
    /// How many voxels had it.
    pub count: u64,
    /// The physical value that they have now.
    pub became: f64,
}

impl Fill {
    /// A sentence for people, of a scan with so many voxels.
    pub fn note(&self, voxels: usize) -> String {
        let count = self.count;
        let [value, became] = [self.value, self.became].map(brief);
        format!(
            "{count} of {voxels} voxels have the fill value {value}, far from all others: nothing was measured there, and \
             they became {became}"
        )
    }
}

/// A value with the digits that a scan's samples have.
fn brief(value: f64) -> String {
    let value = value as f32;
    if value.abs() < 1e9 { value.to_string() } else { format!("{value:e}") }
}

/// Replaces the fill values at both ends of samples, of which a physical value is `stored * slope + intercept`: one exact value
/// that is frequent, and farther from all others than these are from each other. It becomes the lowest other value; 0 in
/// maps that go to both sides of that; and `empty`, if given. Samples that are not finite are passed over.
pub fn replace(voxels: &mut Voxels, rescale: [f64; 2], empty: Option<f64>) -> Vec<Fill> {
    match voxels {
        // 255 is too near to the others to be told.
        Voxels::U8(_) => Vec::new(),
        Voxels::U16(samples) => of_type(samples, rescale, empty, |stored| {
            let rounded = stored.round();
            (0.0..=65535.0).contains(&rounded).then_some(rounded as u16)
        }),
        Voxels::F32(samples) => of_type(samples, rescale, empty, |stored| Some(stored as f32)),
    }
}

/// What stands for nothing among samples that are their own physical values: 0 in maps that go to both sides of it, else the
/// lowest. `None` where they have hardly more values than labels. Samples that are not finite are passed over.
pub fn nothing(samples: &[f32]) -> Option<f64> {
    Others::of(samples, f64::NAN, |stored| stored).map(|others| others.nothing())
}

fn of_type<T: Copy + Into<f64> + Send + Sync>(
    samples: &mut [T],
    [slope, intercept]: [f64; 2],
    empty: Option<f64>,
    from_f64: impl Fn(f64) -> Option<T>,
) -> Vec<Fill> {
    let physical = |stored: f64| stored * slope + intercept;
    let mut found = Vec::new();
    // One at each end, or two beyond each other.
    for _ in 0..2 {
        let ends = Ends::of(samples);
        let Some((stored, count)) = ends.fill(samples.len() as u64, physical) else { break };
        let Some(others) = Others::of(samples, stored, physical) else { break };
        let Some(nothing) = from_f64((empty.unwrap_or(others.nothing()) - intercept) / slope) else { break };
        samples.par_iter_mut().for_each(|sample| {
            if (*sample).into() == stored {
                *sample = nothing;
            }
        });
        found.push(Fill { value: physical(stored), count, became: physical(nothing.into()) });
    }
    found
}

/// The lowest of some numbers.
#[derive(Clone, Copy, Debug)]
struct End {
    value: f64,
    /// How many of them are it.
    count: u64,
    /// The next lowest.
    next: f64,
}

impl End {
    const NONE: Self = Self { value: f64::INFINITY, count: 0, next: f64::INFINITY };

    fn joined(self, other: Self) -> Self {
        let (low, high) = if other.value < self.value { (other, self) } else { (self, other) };
        if low.value == high.value {
            return Self { count: low.count + high.count, next: low.next.min(high.next), ..low };
        }
        Self { next: low.next.min(high.value), ..low }
    }
}

/// The lowest samples, and the highest with their signs changed.
struct Ends([End; 2]);

impl Ends {
    fn of<T: Copy + Into<f64> + Sync>(samples: &[T]) -> Self {
        let of_chunk = |chunk: &[T]| {
            let mut ends = [End::NONE; 2];
            for sample in chunk.iter().map(|&sample| sample.into()).filter(|sample: &f64| sample.is_finite())
            {
                for (end, value) in ends.iter_mut().zip([sample, -sample]) {
                    if value <= end.next {
                        *end = end.joined(End { value, count: 1, next: f64::INFINITY });
                    }
                }
            }
            ends
        };
        let joined = |a: [End; 2], b: [End; 2]| [a[0].joined(b[0]), a[1].joined(b[1])];
        Self(samples.par_chunks(CHUNK).map(of_chunk).reduce(|| [End::NONE; 2], joined))
    }

    /// The stored fill value at one of the ends of so many samples, and how many are it.
    fn fill(&self, samples: u64, physical: impl Fn(f64) -> f64) -> Option<(f64, u64)> {
        /// Air in a CT lies where it should.
        const AIR_HU: [f64; 2] = [-1100.0, -900.0];
        /// How far a fill value lies, by the range of all others; of a usual one.
        const FAR: f64 = 1.0;
        const FAR_IF_USUAL: f64 = 0.2;
        let is_fill = |end: &End, sign: f64, other_end: f64| {
            let value = physical(sign * end.value);
            let is_usual = USUAL.iter().any(|usual| (value - usual).abs() <= 1e-6 * usual.abs());
            let far = if is_usual { FAR_IF_USUAL } else { FAR };
            let range = -other_end - end.next;
            let is_background = value == 0.0 || (AIR_HU[0]..=AIR_HU[1]).contains(&value);
            end.count >= LEAST.max(samples / FREQUENT)
                && !is_background
                && range > 0.0
                && end.next - end.value >= far * range
        };
        let Self([low, high]) = self;
        let of = |end: &End, sign: f64| (sign * end.value, end.count);
        match () {
            () if is_fill(low, 1.0, high.value) => Some(of(low, 1.0)),
            () if is_fill(high, -1.0, low.value) => Some(of(high, -1.0)),
            () => None,
        }
    }
}

/// What a scan holds besides its fill value.
struct Others {
    /// Lowest and highest physical value.
    range: [f64; 2],
    /// The part of them that lies below 0.
    negative: f64,
}

impl Others {
    /// `None` where they have hardly more values than labels have.
    fn of<T: Copy + Into<f64> + Sync>(
        samples: &[T],
        fill: f64,
        physical: impl Fn(f64) -> f64 + Sync,
    ) -> Option<Self> {
        let others = |chunk: &[T]| {
            let (mut range, mut count, mut negative) = ([f64::INFINITY, f64::NEG_INFINITY], 0u64, 0u64);
            let stored = chunk.iter().map(|&sample| sample.into());
            for value in stored.filter(|&sample: &f64| sample.is_finite() && sample != fill).map(&physical) {
                range = [range[0].min(value), range[1].max(value)];
                count += 1;
                negative += u64::from(value < 0.0);
            }
            (range, count, negative)
        };
        let ([low, high], count, negative) = samples.par_chunks(CHUNK).map(others).reduce(
            || ([f64::INFINITY, f64::NEG_INFINITY], 0, 0),
            |a, b| ([a.0[0].min(b.0[0]), a.0[1].max(b.0[1])], a.1 + b.1, a.2 + b.2),
        );
        let mut values = HashSet::new();
        let is_varied = samples.iter().map(|&sample| sample.into()).any(|sample: f64| {
            if sample.is_finite() && sample != fill {
                values.insert(sample.to_bits());
            }
            values.len() >= LEAST_VALUES
        });
        is_varied.then(|| Self { range: [low, high], negative: negative as f64 / count.max(1) as f64 })
    }

    /// What stands for nothing among them.
    fn nothing(&self) -> f64 {
        /// Of maps around 0, each side is no less of all, nor reaches less far than this part of the other's reach.
        const PART: f64 = 0.1;
        let [low, high] = self.range;
        let goes_both_ways = low < 0.0 && high > 0.0 && -low >= PART * high && high >= -PART * low;
        let is_map = goes_both_ways && (PART..=1.0 - PART).contains(&self.negative);
        // A CT goes both ways, too, and has its lowest in air.
        if is_map && !(-1200.0..=-900.0).contains(&low) { 0.0 } else { low }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mr(i: usize) -> f64 {
        (i * 37 % 900) as f64 + 4.0
    }

    /// Every tenth voxel is `fill`, the others are `value`s.
    fn filled(fill: f64, value: impl Fn(usize) -> f64) -> Vec<f64> {
        (0..2000usize).map(|i| if i.is_multiple_of(10) { fill } else { value(i) }).collect()
    }

    fn floats(values: &[f64]) -> (Vec<Fill>, Vec<f64>) {
        let mut voxels = Voxels::F32(values.iter().map(|v| *v as f32).collect());
        let found = replace(&mut voxels, [1.0, 0.0], None);
        (found, (0..voxels.len()).map(|i| voxels.get(i)).collect())
    }

    #[test]
    fn fill_values_of_any_program_are_found() {
        let lowest = (0..2000usize).filter(|i| !i.is_multiple_of(10)).map(mr).fold(1e9, f64::min);
        for fill in [-9999.0, -32768.0, f64::from(f32::MIN), 65535.0, -1e20, 1e20, -1234.0, 1e37] {
            let (found, values) = floats(&filled(fill, mr));
            assert_eq!(found.len(), 1, "{fill}");
            assert_eq!((found[0].value, found[0].count, found[0].became), (fill as f32 as f64, 200, lowest));
            assert!(values.iter().all(|value| (4.0..904.0).contains(value)), "{fill}");
        }
        // One at each end, as of saturated and of missing.
        let both = filled(-32768.0, |i| if i % 10 == 1 { 32767.0 } else { mr(i) });
        let (found, values) = floats(&both);
        assert_eq!(found.len(), 2);
        assert!(values.iter().all(|value| (4.0..904.0).contains(value)));
        assert!(found[0].note(2000).starts_with("200 of 2000 voxels have the fill value "));
    }

    #[test]
    fn what_becomes_of_them_is_nothing() {
        let ct = |i: usize| (i * 37 % 3000) as f64 - 1000.0;
        let air = (0..2000usize).filter(|i| !i.is_multiple_of(10)).map(ct).fold(0.0, f64::min);
        let map = |i: usize| (i * 37 % 900) as f64 / 100.0 - 4.5;
        assert_eq!(floats(&filled(-32768.0, ct)).0[0].became, air, "air");
        assert_eq!(floats(&filled(-9999.0, map)).0[0].became, 0.0, "between both sides");
        // 16 bits that are signed, whose 0 is -32768.
        let stored = filled(-32768.0, ct).iter().map(|v| (v + 32768.0) as u16).collect();
        let mut voxels = Voxels::U16(stored);
        let found = replace(&mut voxels, [1.0, -32768.0], Some(-1000.0));
        assert_eq!(found, [Fill { value: -32768.0, count: 200, became: -1000.0 }]);
        assert_eq!(voxels.get(0), 31768.0);
    }

    #[test]
    fn what_belongs_to_a_scan_stays() {
        let kept = |values: Vec<f64>| floats(&values).0.is_empty();
        assert!(kept(filled(0.0, |i| mr(i) + 2000.0)), "a background of 0");
        assert!(kept(filled(-1024.0, |i| mr(i) / 10.0)), "an organ in air");
        assert!(kept(filled(1500.0, mr)), "near to all others");
        assert!(kept((0..20_000).map(|i| if i < 10 { -9999.0 } else { mr(i) }).collect()), "rare");
        assert!(kept(filled(9999.0, |i| (i % 7) as f64)), "labels");
        assert!(kept(vec![5.0; 2000]));
        assert!(
            kept((0..2000usize).map(|i| if i.is_multiple_of(2) { 65535.0 } else { 0.0 }).collect()),
            "a mask"
        );
        assert_eq!(replace(&mut Voxels::U8(vec![255; 3000]), [1.0, 0.0], None), []);
    }
}
