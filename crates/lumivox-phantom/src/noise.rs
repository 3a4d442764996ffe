//! Hashing and smooth noise: the irregularity of living things, from a seed.
//!
//! Everything here is a pure function of its arguments, so a phantom does not depend on the number of threads.

use glam::{IVec3, Vec3};

/// A well mixed 64-bit hash (the finaliser of SplitMix64).
pub(crate) fn hash64(mut x: u64) -> u64 {
    x = x.wrapping_add(0x9E37_79B9_7F4A_7C15);
    x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^ (x >> 31)
}

/// A sample of nearly normal distribution, mean 0 and variance 1, from four uniform ones (Irwin-Hall).
pub(crate) fn gaussian(seed: u64, index: u64) -> f32 {
    let bits = hash64(seed ^ hash64(index));
    let sum: u32 = (0..4).map(|i| (bits >> (16 * i)) as u16 as u32).sum();
    // Four uniforms on [0, 1] have mean 2 and variance 1/3.
    (sum as f32 / 65535.0 - 2.0) * 1.732_050_8
}

fn lattice_hash(p: IVec3, seed: u32) -> u32 {
    let mut h = (p.x as u32).wrapping_mul(0x8DA6_B343)
        ^ (p.y as u32).wrapping_mul(0xD816_3841)
        ^ (p.z as u32).wrapping_mul(0xCB1A_B31F)
        ^ seed.wrapping_mul(0x9E37_79B9);
    h = (h ^ (h >> 15)).wrapping_mul(0x2C1B_3C6D);
    h = (h ^ (h >> 12)).wrapping_mul(0x297A_2D39);
    h ^ (h >> 15)
}

/// Gradient noise (Perlin, *Improving Noise*, SIGGRAPH 2002) of period-free lattice spacing 1; about -1 to 1, mean 0.
pub(crate) fn noise(p: Vec3, seed: u32) -> f32 {
    let cell = p.floor();
    let f = p - cell;
    let cell = cell.as_ivec3();
    let corner = |x: i32, y: i32, z: i32| {
        let offset = IVec3::new(x, y, z);
        let d = f - offset.as_vec3();
        let h = lattice_hash(cell + offset, seed);
        // The twelve edge directions of a cube, four of them twice.
        let (u, v) = match h & 12 {
            0 => (d.x, d.y),
            4 => (d.x, d.z),
            8 => (d.y, d.z),
            _ if h & 2 == 0 => (d.x, d.y),
            _ => (d.y, d.z),
        };
        (if h & 1 == 0 { u } else { -u }) + (if h & 16 == 0 { v } else { -v })
    };
    let s = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
    let face = |z: i32| {
        mix(mix(corner(0, 0, z), corner(1, 0, z), s.x), mix(corner(0, 1, z), corner(1, 1, z), s.x), s.y)
    };
    mix(face(0), face(1), s.z)
}

/// Two octaves of [`noise`], still about -1 to 1.
pub(crate) fn noise2(p: Vec3, seed: u32) -> f32 {
    (noise(p, seed) + 0.5 * noise(p * 2.03 + 17.3, seed ^ 0x5bd1)) / 1.3
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_smooth_centred_and_seeded() {
        let mut sum = 0.0;
        for i in 0..4000 {
            let p = Vec3::new(i as f32 * 0.37, i as f32 * 0.11, i as f32 * -0.23);
            let n = noise(p, 3);
            assert!(n.abs() <= 1.5);
            assert!((noise(p + Vec3::X * 1e-3, 3) - n).abs() < 0.01);
            sum += n;
        }
        assert!((sum / 4000.0).abs() < 0.05, "{sum}");
        assert_ne!(noise(Vec3::splat(0.4), 1), noise(Vec3::splat(0.4), 2));
    }

    #[test]
    fn gaussian_has_unit_variance() {
        let n = 20_000;
        let (mut sum, mut squares) = (0.0, 0.0);
        for i in 0..n {
            let x = gaussian(9, i) as f64;
            sum += x;
            squares += x * x;
        }
        assert!((sum / n as f64).abs() < 0.03);
        assert!((squares / n as f64 - 1.0).abs() < 0.03);
    }
}
