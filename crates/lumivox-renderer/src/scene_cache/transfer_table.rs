//! A transfer function as the GPU reads it: samples over the values that occur, linear between them.

use std::sync::Arc;

use lumivox_core::{TransferFunction, Volume};
use lumivox_shaders::layout::{RANGE_MAXIMUM_LEVELS, TABLE_SIZE};

/// Opacity and colour at [`TABLE_SIZE`] equidistant values. Between entries the table is linear; it meets the curve
/// exactly at its entries, and a jump is spread over one entry.
#[derive(Clone, Debug, PartialEq)]
pub struct TransferTable {
    /// Physical values of the first and the last entry.
    pub domain: [f64; 2],
    /// Opacity of each entry.
    pub opacity: Vec<f32>,
    /// Linear RGB of each entry.
    pub color: Vec<[f32; 3]>,
}

impl TransferTable {
    /// Samples `function` where `volume` has values and the function changes.
    #[cfg(test)]
    pub fn new(function: &TransferFunction, volume: &Volume) -> Self {
        Self::over(domain(std::slice::from_ref(function), volume), function)
    }

    fn over([low, high]: [f64; 2], function: &TransferFunction) -> Self {
        let value = |i: usize| low + (high - low) * i as f64 / (TABLE_SIZE - 1) as f64;
        Self {
            domain: [low, high],
            opacity: (0..TABLE_SIZE).map(|i| function.opacity(value(i)) as f32).collect(),
            color: (0..TABLE_SIZE).map(|i| function.color(value(i)).map(|c| c as f32)).collect(),
        }
    }

    /// `(scale, bias)` that send `texel * per_texel + at_zero`, a physical value, to a table coordinate.
    pub(crate) fn coordinate(&self, texel: crate::store::TexelScale) -> (f64, f64) {
        let entries_per_value = (TABLE_SIZE - 1) as f64 / (self.domain[1] - self.domain[0]);
        (texel.per_texel * entries_per_value, (texel.at_zero - self.domain[0]) * entries_per_value)
    }

    /// Each entry's opacity with its successor's, so that the GPU interpolates from one load; then each entry's colour, in
    /// two pairs.
    pub(crate) fn pairs(&self) -> Vec<[f32; 2]> {
        let opacities = self.opacity.iter().zip(self.opacity.iter().skip(1).chain(self.opacity.last()));
        let colors = self.color.iter().flat_map(|&[r, g, b]| [[r, g], [b, 0.0]]);
        opacities.map(|(&own, &next)| [own, next]).chain(colors).collect()
    }

    /// Level `k`, entry `i`: the largest opacity of entries `i .. i + 2^k`.
    pub(crate) fn range_maxima(&self) -> Vec<f32> {
        let mut levels = self.opacity.clone();
        for level in 1..RANGE_MAXIMUM_LEVELS {
            let below = (level - 1) * TABLE_SIZE;
            let half = 1 << (level - 1);
            for i in 0..TABLE_SIZE {
                levels.push(levels[below + i].max(levels[below + (i + half).min(TABLE_SIZE - 1)]));
            }
        }
        levels
    }
}

/// The values over which functions are sampled: where the volume has some and one of them changes.
fn domain(functions: &[TransferFunction], volume: &Volume) -> [f64; 2] {
    let values = volume.value_range();
    let ranges = functions.iter().map(TransferFunction::value_range);
    let changes = ranges.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]).unwrap_or(values);
    let mut low = changes[0].clamp(values[0], values[1]);
    let mut high = changes[1].clamp(values[0], values[1]);
    if high - low <= f64::EPSILON * low.abs().max(high.abs()) {
        high = low + low.abs().max(1.0) * 1e-3;
    }
    // What lies below the domain reads the first entry. Should the function jump at its first point, that entry
    // has to be from before the jump.
    if changes[0] > values[0] {
        low -= (high - low) / (TABLE_SIZE - 2) as f64;
    }
    [low, high]
}

/// Rows of a function of value and gradient, over the same values; most have one. Shared by clones: what stays is handed on in
/// every frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Function(Arc<[TransferTable]>);

impl Function {
    /// Samples the rows, of which there is one at least.
    pub fn new(rows: &[TransferFunction], volume: &Volume) -> Self {
        let domain = domain(rows, volume);
        Self(rows.iter().map(|row| TransferTable::over(domain, row)).collect())
    }

    /// See [`TransferTable::coordinate`].
    pub(crate) fn coordinate(&self, texel: crate::store::TexelScale) -> (f64, f64) {
        self.0[0].coordinate(texel)
    }

    /// Those of the rows, one after the other.
    pub(crate) fn pairs(&self) -> Vec<[f32; 2]> {
        self.0.iter().flat_map(TransferTable::pairs).collect()
    }

    /// Level `k`, entry `i`: the largest opacity of entries `i .. i + 2^k` of any row. What is linear between rows is never
    /// larger.
    pub(crate) fn range_maxima(&self) -> Vec<f32> {
        let mut most = self.0[0].range_maxima();
        for row in &self.0[1..] {
            most.iter_mut().zip(row.range_maxima()).for_each(|(most, of_row)| *most = most.max(of_row));
        }
        most
    }
}

/// The largest opacity of several functions at each value: a bound that is asked for before it is known which of them counts.
/// Shared by clones.
#[derive(Clone, Debug, PartialEq)]
pub struct Envelope(Arc<TransferTable>);

/// Table coordinates by which it looks to either side, for rounding.
const SLACK: f64 = 0.1;

impl Envelope {
    /// Of functions, each with the factor of its opacity.
    pub fn new(functions: &[(&Function, f64)]) -> Self {
        let domains = functions.iter().map(|(function, _)| function.0[0].domain);
        let [low, high] = domains.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]).unwrap_or([0.0, 1.0]);
        let last = TABLE_SIZE - 1;
        // Between each entry and its successor.
        let mut most = vec![0.0f32; last];
        for (function, factor) in functions {
            let [begin, end] = function.0[0].domain;
            let coordinate = |entry: usize| {
                let value = low + (high - low) * entry as f64 / last as f64;
                (value - begin) / (end - begin) * last as f64
            };
            for (i, most) in most.iter_mut().enumerate() {
                let within = |coordinate: f64| coordinate.clamp(0.0, last as f64) as usize;
                let first = within((coordinate(i) - SLACK).floor());
                let behind = within((coordinate(i + 1) + SLACK).ceil());
                for row in &*function.0 {
                    let largest = row.opacity[first..=behind].iter().copied().fold(0.0, f32::max);
                    *most = most.max((f64::from(largest) * factor) as f32);
                }
            }
        }
        // What is linear between entries that bound both their sides bounds what lies between.
        let around =
            |i: usize| most[i.saturating_sub(1)..=i.min(last - 1)].iter().copied().fold(0.0, f32::max);
        let opacity = (0..TABLE_SIZE).map(around).collect();
        Self(Arc::new(TransferTable { domain: [low, high], opacity, color: vec![] }))
    }

    /// See [`TransferTable::coordinate`].
    pub(crate) fn coordinate(&self, texel: crate::store::TexelScale) -> (f64, f64) {
        self.0.coordinate(texel)
    }

    /// Each entry's opacity with its successor's.
    pub(crate) fn pairs(&self) -> Vec<[f32; 2]> {
        self.0.pairs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_jump_at_the_first_point_leaves_lower_values_alone() {
        use lumivox_core::{Ease, Modality, Voxels, glam::DAffine3};
        let voxels = Voxels::U16(vec![0, 4000]);
        let place = DAffine3::IDENTITY;
        let volume = Volume::new([2, 1, 1], voxels, [1.0, -1000.0], place, Modality::Ct).unwrap();
        for points in [&[(100.0, 0.0), (100.0, 1.0)][..], &[(100.0, 0.0), (100.0, 1.0), (900.0, 0.5)]] {
            let step = TransferFunction::from_points(Ease::Linear, points, &[(200.0, [1.0; 3])]).unwrap();
            let table = TransferTable::new(&step, &volume);
            assert!(table.domain[0] < 100.0, "{:?}", table.domain);
            assert_eq!((table.opacity[0], table.opacity[TABLE_SIZE - 1]), (0.0, step.opacity(5000.0) as f32));
        }
    }

    #[test]
    fn an_envelope_is_never_below_its_functions_and_seldom_far_above() {
        use lumivox_core::{Ease, Modality, Voxels, glam::DAffine3};
        let voxels = Voxels::U16(vec![0, 4000]);
        let volume =
            Volume::new([2, 1, 1], voxels, [1.0, -1000.0], DAffine3::IDENTITY, Modality::Ct).unwrap();
        let function = |points: &[(f64, f64)]| {
            let curve = TransferFunction::from_points(Ease::Linear, points, &[(0.0, [1.0; 3])]).unwrap();
            Function::new(&[curve], &volume)
        };
        // A jump, a peak on a narrow domain, a slope over all values.
        let functions = [
            (&function(&[(-200.0, 0.0), (100.0, 0.2), (100.0, 0.9), (300.0, 0.0)]), 0.5),
            (&function(&[(700.0, 0.0), (710.0, 1.0), (720.0, 0.0)]), 1.5),
            (&function(&[(-1000.0, 0.0), (3000.0, 0.3)]), 1.0),
        ];
        let envelope = Envelope::new(&functions);
        let read = |table: &TransferTable, value: f64| {
            let u = (value - table.domain[0]) / (table.domain[1] - table.domain[0]) * (TABLE_SIZE - 1) as f64;
            let u = u.clamp(0.0, (TABLE_SIZE - 1) as f64);
            let entry = (u as usize).min(TABLE_SIZE - 2);
            let [low, high] = [table.opacity[entry], table.opacity[entry + 1]].map(f64::from);
            low + (high - low) * (u - entry as f64)
        };
        let (mut sum, mut bound) = (0.0, 0.0);
        for i in 0..40_000 {
            let value = -1100.0 + f64::from(i) * 0.105;
            let most =
                functions.iter().map(|(of, factor)| factor * read(&of.0[0], value)).fold(0.0, f64::max);
            let own = read(&envelope.0, value);
            assert!(own >= most - 1e-6, "{own} of {most} at {value}");
            sum += most;
            bound += own;
        }
        assert!(bound < 1.05 * sum, "{bound} for {sum}");
    }

    #[test]
    fn range_maxima_are_maxima() {
        let opacity: Vec<f32> = (0..TABLE_SIZE).map(|i| ((i * 7919) % 4093) as f32).collect();
        let table = TransferTable { domain: [0.0, 1.0], opacity: opacity.clone(), color: vec![] };
        let maxima = table.range_maxima();
        for (low, high) in [(0, 0), (5, 6), (17, 1000), (0, TABLE_SIZE - 1), (4000, 4095)] {
            let level = (high - low + 1usize).ilog2() as usize;
            let a = maxima[level * TABLE_SIZE + low];
            let b = maxima[level * TABLE_SIZE + high + 1 - (1 << level)];
            let expected = opacity[low..=high].iter().copied().fold(0.0, f32::max);
            assert_eq!(a.max(b), expected, "{low}..={high}");
        }
    }
}
