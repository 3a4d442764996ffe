//! What happens to light at a collision: scattering by the medium, or reflection by a surface in it.
//!
//! The hybrid of Kroes, Post and Botha, *Exposure Render: An Interactive Photo-Realistic Volume Rendering Framework*,
//! PLoS ONE 7(7), 2012, section "Hybrid scattering", in the form that
//! [`SurfaceReflection`](lumivox_core::SurfaceReflection) describes.

use lumivox_core::glam::DVec3;

use crate::medium::{Part, PlacedMedium};
use crate::rng::Rng;
use crate::sampling::{
    cosine_hemisphere, henyey_greenstein, sample_cosine_hemisphere, sample_henyey_greenstein,
};

/// A collision of light with a medium at one point, seen from one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Collision {
    /// Fraction of light that survives, per colour.
    pub albedo: [f64; 3],
    /// Unit normal of the value's gradient on the viewer's side; zero where there is no gradient.
    pub normal: DVec3,
    /// The direction of travel that ended here.
    travel: DVec3,
    /// Mean cosine of the phase function.
    anisotropy: f64,
    /// How likely a surface reflects instead of the phase function scattering.
    surface_probability: f64,
    /// The fraction of surface events that are specular.
    fresnel: f64,
    /// Fraction of light that survives those, per colour.
    pub(crate) gloss: [f64; 3],
    /// Mean cosine of the specular lobe about the mirror direction.
    lobe_anisotropy: f64,
}

impl Collision {
    /// The collision of light traced along the unit direction `travel` with a part of a medium.
    pub fn new(medium: &PlacedMedium, part: &Part, travel: DVec3) -> Self {
        let look = medium.medium();
        let wo = -travel;
        let surface = part.surface;
        let edge = part.gradient_per_mm.length() / surface.gradient_per_mm;
        let of_value = surface.strength * (1.0 - (-edge * edge).exp());
        let (distance, across) = part.cut;
        let of_cut = surface.strength * (-(distance / medium.cut_width_mm()).powi(2)).exp();
        let (surface_probability, gradient) =
            if of_cut > of_value { (of_cut, across) } else { (of_value, part.gradient_per_mm) };
        let outwards = medium.world_normal(gradient).unwrap_or(DVec3::ZERO);
        let normal = if outwards.dot(wo) < 0.0 { -outwards } else { outwards };
        let specular = surface.specular;
        let albedo = part.color.map(|c| c * look.albedo);
        Self {
            albedo,
            normal,
            travel,
            anisotropy: look.anisotropy,
            surface_probability,
            // Schlick, An Inexpensive BRDF Model for Physically-based Rendering, 1994, equation 15.
            fresnel: specular + (1.0 - specular) * (1.0 - normal.dot(wo).clamp(0.0, 1.0)).powi(5),
            // Light of its own colour from what insulates, and of the medium's from metal.
            gloss: albedo.map(|c| 1.0 - surface.metallic * (1.0 - c)),
            lobe_anisotropy: surface.lobe_anisotropy(),
        }
    }

    /// Fraction of light that survives events that are not specular, of all events.
    pub fn diffuse_color(&self) -> [f64; 3] {
        self.albedo.map(|c| c * (1.0 - self.surface_probability * self.fresnel))
    }

    /// Where the mirror of the surface sends light.
    fn mirror(&self) -> DVec3 {
        let wo = -self.travel;
        (2.0 * self.normal.dot(wo) * self.normal - wo).normalize()
    }

    /// A direction `wi` in which the path goes on, and the factor of its throughput.
    ///
    /// Analog: which of the three things happens is drawn with its true probability, so the factor is an albedo.
    pub fn sample(&self, rng: &mut Rng) -> (DVec3, [f64; 3]) {
        if rng.uniform() >= self.surface_probability {
            (sample_henyey_greenstein(self.travel, self.anisotropy, rng.uniform_2d()), self.albedo)
        } else if rng.uniform() < self.fresnel {
            (sample_henyey_greenstein(self.mirror(), self.lobe_anisotropy, rng.uniform_2d()), self.gloss)
        } else {
            (sample_cosine_hemisphere(self.normal, rng.uniform_2d()), self.albedo)
        }
    }

    /// Radiance towards the viewer per steradian of unit radiance from `wi`: what [`sample`](Self::sample) draws
    /// from, as a function.
    pub fn evaluate(&self, wi: DVec3) -> [f64; 3] {
        let phase =
            (1.0 - self.surface_probability) * henyey_greenstein(self.travel.dot(wi), self.anisotropy);
        if self.surface_probability == 0.0 {
            return self.albedo.map(|a| a * phase);
        }
        let specular = self.surface_probability
            * self.fresnel
            * henyey_greenstein(self.mirror().dot(wi), self.lobe_anisotropy);
        let diffuse =
            self.surface_probability * (1.0 - self.fresnel) * cosine_hemisphere(self.normal.dot(wi));
        std::array::from_fn(|c| self.albedo[c] * (phase + diffuse) + self.gloss[c] * specular)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::medium::place;
    use lumivox_testing::chi_square::{SphereTest, Verdict};
    use lumivox_testing::scenes;

    /// A glossy collision with every kind of event, half of them on the surface.
    fn glossy(albedo: f64, cos_theta_o: f64) -> Collision {
        let sin = (1.0 - cos_theta_o * cos_theta_o).sqrt();
        Collision {
            albedo: [albedo; 3],
            normal: DVec3::Y,
            travel: -DVec3::new(sin, cos_theta_o, 0.0),
            anisotropy: 0.4,
            surface_probability: 0.5,
            fresnel: 0.3,
            gloss: [1.0; 3],
            lobe_anisotropy: 0.75,
        }
    }

    #[test]
    fn sampled_directions_follow_the_function() {
        let test = SphereTest { tests: 3, ..SphereTest::default() };
        for (i, cos) in [0.9, 0.5, 0.05].into_iter().enumerate() {
            let collision = glossy(1.0, cos);
            let mut rng = Rng::new(i as u64, 0, 0);
            let result = test.run(|d| collision.evaluate(d)[0], || collision.sample(&mut rng).0);
            assert_eq!(result.verdict, Verdict::Accepted, "cos {cos}: {result}");
        }
    }

    #[test]
    fn sampled_weights_carry_the_colour() {
        // E[weight] = albedo on phase and diffuse events, 1 on specular ones.
        let collision = glossy(0.25, 0.7);
        let mut rng = Rng::new(9, 0, 0);
        let n = 200_000;
        let mean = (0..n).map(|_| collision.sample(&mut rng).1[0]).sum::<f64>() / n as f64;
        let expected = 0.15 + 0.85 * 0.25;
        assert!((mean - expected).abs() < 5.0 * 0.27 / (n as f64).sqrt(), "{mean} {expected}");
    }

    #[test]
    fn metal_has_its_own_gloss_and_all_else_the_lights() {
        let mut test = scenes::glossy_surface();
        let of = |test: &scenes::TestScene| {
            let media = place(&test.scene);
            let point = test.scene.volumes[0].world_from_box().transform_point3(DVec3::new(0.5, 0.5, 0.13));
            Collision::new(&media[0], &media[0].pick(point, 0.0), DVec3::NEG_Z)
        };
        assert_eq!(of(&test).gloss, [1.0; 3]);
        let volume = &mut test.scene.volumes[0];
        volume.medium.albedo = 0.5;
        volume.medium.surface.metallic = 1.0;
        let metal = of(&test);
        for c in 0..3 {
            assert!(metal.albedo[c] <= 0.5 && (metal.gloss[c] - metal.albedo[c]).abs() < 1e-12, "{metal:?}");
        }
        test.scene.volumes[0].medium.surface.metallic = 0.5;
        let half = of(&test);
        for c in 0..3 {
            assert!((half.gloss[c] - 0.5 * (1.0 + half.albedo[c])).abs() < 1e-12, "{half:?}");
        }
    }

    #[test]
    fn each_lobe_points_where_it_should() {
        let travel = DVec3::new(1.0, -1.0, 0.0).normalize();
        let only = |surface_probability, fresnel| Collision {
            albedo: [1.0; 3],
            normal: DVec3::Y,
            travel,
            anisotropy: 0.6,
            surface_probability,
            fresnel,
            gloss: [1.0; 3],
            lobe_anisotropy: 0.9,
        };
        // Mean directions: g forward, the lobe's g along the mirror ray, 2/3 along the normal.
        let cases = [
            (only(0.0, 0.0), 0.6 * travel),
            (only(1.0, 1.0), 0.9 * DVec3::new(1.0, 1.0, 0.0).normalize()),
            (only(1.0, 0.0), DVec3::Y * 2.0 / 3.0),
        ];
        for (collision, expected) in cases {
            let mut rng = Rng::new(3, 0, 0);
            let n = 40_000;
            let mean = (0..n).map(|_| collision.sample(&mut rng).0).sum::<DVec3>() / f64::from(n);
            assert!(mean.distance(expected) < 0.015, "{mean} {expected}");
        }
    }

    #[test]
    fn gloss_grows_to_one_at_grazing_angles_and_edges_make_surfaces() {
        let test = scenes::stretched_sphere();
        let media = place(&test.scene);
        let surface = media[0].medium().surface;
        let world_from_box = test.scene.volumes[0].world_from_box();
        let point = world_from_box.transform_point3(DVec3::new(0.5, 0.5, 0.13));
        let normal = media[0].world_normal(media[0].gradient_per_mm(point)).unwrap();
        let head_on = Collision::new(&media[0], &media[0].pick(point, 0.0), normal);
        assert!((head_on.fresnel - surface.specular).abs() < 1e-9);
        let grazing = Collision::new(&media[0], &media[0].pick(point, 0.0), normal.any_orthonormal_vector());
        assert!((grazing.fresnel - 1.0).abs() < 1e-6);
        let edge = media[0].gradient_per_mm(point).length() / surface.gradient_per_mm;
        let expected = surface.strength * (1.0 - (-edge.powi(2)).exp());
        assert!(edge > 0.5 && (head_on.surface_probability - expected).abs() < 1e-12, "{edge}");
        let inside = Collision::new(
            &media[0],
            &media[0].pick(world_from_box.transform_point3(DVec3::splat(0.5)), 0.0),
            normal,
        );
        assert_eq!(inside.surface_probability, 0.0);
    }

    #[test]
    fn the_normal_looks_at_the_viewer_and_out_of_a_stretched_sphere() {
        let test = scenes::stretched_sphere();
        let media = place(&test.scene);
        let world_from_box = test.scene.volumes[0].world_from_box();
        let center = world_from_box.transform_point3(DVec3::splat(0.5));
        for direction in [DVec3::X, DVec3::new(1.0, 1.0, 1.0), DVec3::new(-1.0, 2.0, -0.5)] {
            // On an ellipsoid |A^-1 (x - c)| = r the normal is A^-T A^-1 (x - c).
            let in_box = direction.normalize() * 0.35;
            let point = world_from_box.transform_point3(DVec3::splat(0.5) + in_box);
            let expected = (world_from_box.matrix3.inverse().transpose() * in_box).normalize();
            for side in [1.0, -1.0] {
                let travel = (center - point).normalize() * side;
                let collision = Collision::new(&media[0], &media[0].pick(point, 0.0), travel);
                assert!(collision.normal.dot(travel) <= 0.0);
                // The grid is coarse: its gradient is right to a degree or two.
                assert!(collision.normal.dot(expected * side) > 0.999, "{direction}");
            }
        }
    }
}
