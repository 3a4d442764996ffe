//! The special functions that p-values are made of.

/// Šidák's correction: the significance of each of `tests` independent tests, such that all of them together reject a
/// true hypothesis with probability `significance`.
///
/// Šidák, *Rectangular Confidence Regions for the Means of Multivariate Normal Distributions*, JASA 62, 1967.
pub fn sidak(significance: f64, tests: usize) -> f64 {
    // 1 - (1 - a)^(1/n), without losing the digits of a small result.
    -((-significance).ln_1p() / tests.max(1) as f64).exp_m1()
}

/// Probability that a chi-square variable of that many degrees of freedom is at least `statistic`.
pub fn chi_square_p_value(statistic: f64, degrees_of_freedom: f64) -> f64 {
    gamma_q(degrees_of_freedom / 2.0, statistic / 2.0)
}

/// Probability that a standard normal variable is at least as far from 0 as `z`.
pub fn normal_two_sided_p_value(z: f64) -> f64 {
    // erfc(x) = Q(1/2, x^2).
    gamma_q(0.5, z * z / 2.0)
}

/// The regularised upper incomplete gamma function `Q(a, x)` for `a > 0`, `x >= 0`.
///
/// Press et al., *Numerical Recipes*, 3rd edition, section 6.2: a series below the peak of the integrand, a continued
/// fraction above.
pub fn gamma_q(a: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 1.0;
    }
    if x == f64::INFINITY {
        return 0.0;
    }
    let scale = (a * x.ln() - x - ln_gamma(a)).exp();
    if x < a + 1.0 {
        let mut term = 1.0 / a;
        let mut sum = term;
        let mut n = a;
        while term > sum * 1e-16 {
            n += 1.0;
            term *= x / n;
            sum += term;
        }
        return (1.0 - scale * sum).clamp(0.0, 1.0);
    }
    // Lentz's method; a tiny number stands in for a zero denominator.
    const TINY: f64 = 1e-300;
    let mut b = x + 1.0 - a;
    let mut c = 1.0 / TINY;
    let mut d = 1.0 / b;
    let mut fraction = d;
    for i in 1..100_000 {
        let numerator = -f64::from(i) * (f64::from(i) - a);
        b += 2.0;
        let guard = |v: f64| if v.abs() < TINY { TINY } else { v };
        d = 1.0 / guard(numerator * d + b);
        c = guard(b + numerator / c);
        fraction *= d * c;
        if (d * c - 1.0).abs() < 1e-15 {
            break;
        }
    }
    (scale * fraction).clamp(0.0, 1.0)
}

/// Natural logarithm of the gamma function for `x > 0`: Lanczos' approximation with g = 7 and nine terms.
pub fn ln_gamma(x: f64) -> f64 {
    const COEFFICIENTS: [f64; 8] = [
        676.520_368_121_885_1,
        -1_259.139_216_722_402_8,
        771.323_428_777_653_1,
        -176.615_029_162_140_6,
        12.507_343_278_686_905,
        -0.138_571_095_265_720_12,
        9.984_369_578_019_572e-6,
        1.505_632_735_149_311_6e-7,
    ];
    let x = x - 1.0;
    let t = x + 7.5;
    let sum: f64 = COEFFICIENTS.iter().enumerate().map(|(i, c)| c / (x + i as f64 + 1.0)).sum::<f64>()
        + 0.999_999_999_999_809_9;
    0.5 * std::f64::consts::TAU.ln() + (x + 0.5) * t.ln() - t + sum.ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gamma_is_the_factorial() {
        let mut ln_factorial = 0.0;
        for n in 1..30 {
            ln_factorial += f64::from(n).ln();
            assert!((ln_gamma(f64::from(n) + 1.0) - ln_factorial).abs() < 1e-12 * (1.0 + ln_factorial));
        }
        assert!((ln_gamma(0.5) - 0.5 * std::f64::consts::PI.ln()).abs() < 1e-13);
    }

    #[test]
    fn p_values_are_those_of_the_tables() {
        for (statistic, dof, p) in [
            (3.841_458_820_694_124, 1.0, 0.05),
            (18.307_038_053_275_14, 10.0, 0.05),
            (135.806_723_176, 100.0, 0.01),
        ] {
            assert!((chi_square_p_value(statistic, dof) - p).abs() < 1e-9, "{dof}");
        }
        for (z, p) in [(0.0, 1.0), (1.959_963_984_540_054, 0.05), (5.0, 5.733_031_437_583_869e-7)] {
            assert!((normal_two_sided_p_value(z) / p - 1.0).abs() < 1e-9, "{z}");
        }
        // Two degrees of freedom have a closed form on both branches.
        for x in [0.1, 1.0, 3.0, 10.0, 100.0] {
            assert!((chi_square_p_value(x, 2.0) / (-x / 2.0).exp() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn sidak_holds_the_familywise_error() {
        let alpha = sidak(0.01, 1000);
        assert!((1.0 - (1.0 - alpha).powi(1000) - 0.01).abs() < 1e-12);
        assert_eq!(sidak(0.05, 1), 0.05);
    }
}
