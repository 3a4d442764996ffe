//! Opacity and colour of a physical value.
//!
//! A transfer function maps the *physical* value (HU for CT), never a normalised one, so that it means the same on
//! every scan. Opacity knots and colour stops are apart: one shapes what is seen, the other how it is painted.

/// How opacity goes from one knot to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Ease {
    /// A straight line.
    #[default]
    Linear,
    /// Slow at both ends: `t^2 / (t^2 + (1 - t)^2)` along the segment.
    InOut,
}

impl Ease {
    /// The eased fraction of a fraction `t` in `[0, 1]`; monotone, 0 at 0 and 1 at 1.
    #[inline]
    pub fn apply(self, t: f64) -> f64 {
        match self {
            Ease::Linear => t,
            Ease::InOut => t * t / (t * t + (1.0 - t) * (1.0 - t)),
        }
    }
}

/// A point of the opacity curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpacityKnot {
    /// Physical value.
    pub value: f64,
    /// Opacity, 0 to 1.
    pub opacity: f64,
    /// How the curve leaves this knot towards the next.
    pub ease: Ease,
}

/// A point of the colour curve, which is linear between stops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColorStop {
    /// Physical value.
    pub value: f64,
    /// Linear RGB, 0 to 1 each.
    pub color: [f64; 3],
}

/// Why knots and stops do not make a transfer function.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TransferFunctionError {
    /// There is no opacity knot.
    #[error("a transfer function needs at least one opacity knot")]
    NoOpacity,
    /// There is no colour stop.
    #[error("a transfer function needs at least one colour stop")]
    NoColor,
    /// A number is NaN, infinite or outside its range.
    #[error("{what} {index}: {field} {value} is not {expected}")]
    OutOfRange {
        /// `opacity knot` or `colour stop`.
        what: &'static str,
        /// Its place in the list, from 0.
        index: usize,
        /// The field.
        field: &'static str,
        /// What it holds.
        value: f64,
        /// What it should be.
        expected: &'static str,
    },
}

/// Opacity knots and colour stops over physical values. Before the first and after the last, the end's value holds;
/// at two points of the same value the curve jumps.
#[derive(Clone, Debug, PartialEq)]
pub struct TransferFunction {
    knots: Vec<OpacityKnot>,
    stops: Vec<ColorStop>,
}

/// Values beyond this are in no scan, and stay finite when they are moved.
const MOST: f64 = 1e30;

impl TransferFunction {
    /// A transfer function from points in any order; points of equal value keep theirs.
    ///
    /// # Errors
    /// [`TransferFunctionError`] when a list is empty, a value is not finite, or an opacity or colour is outside 0..1.
    pub fn new(
        mut knots: Vec<OpacityKnot>,
        mut stops: Vec<ColorStop>,
    ) -> Result<Self, TransferFunctionError> {
        if knots.is_empty() {
            return Err(TransferFunctionError::NoOpacity);
        }
        if stops.is_empty() {
            return Err(TransferFunctionError::NoColor);
        }
        let finite = |what, index, value: f64| {
            let error = TransferFunctionError::OutOfRange {
                what,
                index,
                field: "value",
                value,
                expected: "a finite number",
            };
            value.is_finite().then_some(()).ok_or(error)
        };
        let unit = |what, index, field, value: f64| {
            let error =
                TransferFunctionError::OutOfRange { what, index, field, value, expected: "between 0 and 1" };
            (0.0..=1.0).contains(&value).then_some(()).ok_or(error)
        };
        for (i, knot) in knots.iter().enumerate() {
            finite("opacity knot", i, knot.value)?;
            unit("opacity knot", i, "opacity", knot.opacity)?;
        }
        for (i, stop) in stops.iter().enumerate() {
            finite("colour stop", i, stop.value)?;
            stop.color.iter().try_for_each(|&c| unit("colour stop", i, "color", c))?;
        }
        knots.sort_by(|a, b| a.value.total_cmp(&b.value));
        stops.sort_by(|a, b| a.value.total_cmp(&b.value));
        Ok(Self { knots, stops })
    }

    /// The same opacity and colour for every value.
    ///
    /// # Panics
    /// When a number is outside 0..1.
    pub fn constant(opacity: f64, color: [f64; 3]) -> Self {
        let knot = OpacityKnot { value: 0.0, opacity, ease: Ease::Linear };
        Self::new(vec![knot], vec![ColorStop { value: 0.0, color }]).expect("numbers between 0 and 1")
    }

    /// Opacity `(value, opacity)` with one ease for all segments, and colours `(value, linear RGB)`.
    ///
    /// # Errors
    /// As [`TransferFunction::new`].
    pub fn from_points(
        ease: Ease,
        opacity: &[(f64, f64)],
        color: &[(f64, [f64; 3])],
    ) -> Result<Self, TransferFunctionError> {
        Self::new(
            opacity.iter().map(|&(value, opacity)| OpacityKnot { value, opacity, ease }).collect(),
            color.iter().map(|&(value, color)| ColorStop { value, color }).collect(),
        )
    }

    /// What an editor holds: points in any order, of which those that are not finite are passed over and the others clamped
    /// to 0..1. Without knots nothing is seen, without stops it is white. The whole is widened by `window_scale` about its
    /// centre, clamped to 0.01..100, and moved by `shift`.
    pub fn windowed(
        knots: impl IntoIterator<Item = OpacityKnot>,
        stops: impl IntoIterator<Item = ColorStop>,
        shift: f64,
        window_scale: f64,
    ) -> Self {
        let mut knots: Vec<OpacityKnot> = knots
            .into_iter()
            .filter(|knot| knot.value.is_finite() && !knot.opacity.is_nan())
            .map(|knot| OpacityKnot {
                value: knot.value.clamp(-MOST, MOST),
                opacity: knot.opacity.clamp(0.0, 1.0),
                ..knot
            })
            .collect();
        let mut stops: Vec<ColorStop> = stops
            .into_iter()
            .filter(|stop| stop.value.is_finite() && !stop.color.iter().any(|c| c.is_nan()))
            .map(|stop| ColorStop {
                value: stop.value.clamp(-MOST, MOST),
                color: stop.color.map(|c| c.clamp(0.0, 1.0)),
            })
            .collect();
        if knots.is_empty() {
            knots.push(OpacityKnot { value: 0.0, opacity: 0.0, ease: Ease::Linear });
        }
        if stops.is_empty() {
            stops.push(ColorStop { value: 0.0, color: [1.0; 3] });
        }
        let curve = Self::new(knots, stops).expect("every number was checked");
        let [scale, offset] = curve.window(shift, window_scale);
        curve.remapped(scale, offset)
    }

    /// Where a window sends values, as the scale and the shift of [`remapped`](Self::remapped): it widens this function by
    /// `window_scale` about its centre, clamped to 0.01..100, and moves it by `shift`. What is not finite does nothing.
    pub fn window(&self, shift: f64, window_scale: f64) -> [f64; 2] {
        let [low, high] = self.value_range();
        let centre = low / 2.0 + high / 2.0;
        let scale = if window_scale.is_finite() { window_scale.clamp(0.01, 100.0) } else { 1.0 };
        let shift = if shift.is_finite() { shift.clamp(-MOST, MOST) } else { 0.0 };
        [scale, centre * (1.0 - scale) + shift]
    }

    /// The opacity knots, by rising value.
    pub fn opacity_knots(&self) -> &[OpacityKnot] {
        &self.knots
    }

    /// The colour stops, by rising value.
    pub fn color_stops(&self) -> &[ColorStop] {
        &self.stops
    }

    /// Opacity at a physical value, 0 to 1.
    pub fn opacity(&self, value: f64) -> f64 {
        let next = self.knots.partition_point(|k| k.value <= value);
        if next == 0 {
            return self.knots[0].opacity;
        }
        let a = self.knots[next - 1];
        let Some(b) = self.knots.get(next) else { return a.opacity };
        let t = (value - a.value) / (b.value - a.value);
        a.opacity + (b.opacity - a.opacity) * a.ease.apply(t)
    }

    /// Linear RGB at a physical value.
    pub fn color(&self, value: f64) -> [f64; 3] {
        let next = self.stops.partition_point(|s| s.value <= value);
        if next == 0 {
            return self.stops[0].color;
        }
        let a = self.stops[next - 1];
        let Some(b) = self.stops.get(next) else { return a.color };
        let t = (value - a.value) / (b.value - a.value);
        std::array::from_fn(|i| a.color[i] + (b.color[i] - a.color[i]) * t)
    }

    /// Smallest and largest value of any knot or stop: outside, nothing changes.
    pub fn value_range(&self) -> [f64; 2] {
        let first = self.knots[0].value.min(self.stops[0].value);
        let last = self.knots[self.knots.len() - 1].value.max(self.stops[self.stops.len() - 1].value);
        [first, last]
    }

    /// Whether no value has any opacity.
    pub fn is_transparent(&self) -> bool {
        self.knots.iter().all(|k| k.opacity == 0.0)
    }

    /// The same shape with every value sent through `value * scale + shift` (a window's width and level).
    ///
    /// # Panics
    /// When the result is not finite, or `scale` is not positive.
    #[must_use]
    pub fn remapped(&self, scale: f64, shift: f64) -> Self {
        assert!(scale > 0.0, "the scale must be positive");
        let map = |v: f64| v * scale + shift;
        let knots = self.knots.iter().map(|k| OpacityKnot { value: map(k.value), ..*k }).collect();
        let stops = self.stops.iter().map(|s| ColorStop { value: map(s.value), ..*s }).collect();
        Self::new(knots, stops).expect("a finite map")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_editors_points_are_taken_as_they_come() {
        let knot = |value, opacity| OpacityKnot { value, opacity, ease: Ease::Linear };
        let nothing = TransferFunction::windowed([], [], 0.0, 1.0);
        assert!(nothing.is_transparent());
        assert_eq!(nothing.color(5.0), [1.0; 3]);
        let messy = [knot(100.0, 7.0), knot(f64::NAN, 1.0), knot(0.0, -1.0), knot(f64::INFINITY, 1.0)];
        let curve = TransferFunction::windowed(messy, [], 0.0, 1.0);
        assert_eq!([curve.opacity(0.0), curve.opacity(50.0), curve.opacity(100.0)], [0.0, 0.5, 1.0]);
        // Twice as wide about its centre, 50, and moved by 10.
        let wide = TransferFunction::windowed(messy, [], 10.0, 2.0);
        assert_eq!(wide.value_range(), [-40.0, 160.0]);
        let far = TransferFunction::windowed([knot(1e300, 1.0)], [], f64::NAN, f64::INFINITY);
        assert_eq!(far.opacity(0.0), 1.0);
    }

    #[test]
    fn ease_is_monotone_and_symmetric() {
        for ease in [Ease::Linear, Ease::InOut] {
            let curve: Vec<f64> = (0..=100).map(|i| ease.apply(i as f64 / 100.0)).collect();
            assert!(curve.windows(2).all(|w| w[0] < w[1]));
            assert_eq!((curve[0], curve[50], curve[100]), (0.0, 0.5, 1.0));
        }
        assert!(Ease::InOut.apply(0.1) < 0.05);
    }

    #[test]
    fn ends_hold_and_equal_values_jump() {
        let tf = TransferFunction::from_points(
            Ease::Linear,
            &[(0.0, 0.2), (100.0, 0.4), (100.0, 0.9), (200.0, 1.0)],
            &[(0.0, [0.0; 3]), (100.0, [1.0; 3])],
        )
        .unwrap();
        assert_eq!(tf.opacity(-1e9), 0.2);
        assert!((tf.opacity(50.0) - 0.3).abs() < 1e-15);
        assert!(tf.opacity(99.999) < 0.41);
        assert_eq!(tf.opacity(100.0), 0.9);
        assert_eq!(tf.opacity(1e9), 1.0);
        assert_eq!(tf.color(25.0), [0.25; 3]);
    }

    #[test]
    fn bad_points_are_named() {
        let error =
            TransferFunction::from_points(Ease::Linear, &[(0.0, 1.5)], &[(0.0, [0.0; 3])]).unwrap_err();
        assert_eq!(error.to_string(), "opacity knot 0: opacity 1.5 is not between 0 and 1");
        let error = TransferFunction::from_points(Ease::Linear, &[(f64::NAN, 1.0)], &[(0.0, [0.0; 3])]);
        assert!(error.is_err());
        assert_eq!(TransferFunction::new(vec![], vec![]), Err(TransferFunctionError::NoOpacity));
    }
}
