//! How far volumes move over the image, for a host that finds a pixel's past by it.

use half::f16;
use lumivox_core::glam::{DAffine3, DVec3};
use lumivox_core::{Camera, Projection};
use lumivox_renderer::live::LiveImage;
use lumivox_renderer::{LiveSettings, Recording};
use lumivox_testing::scenes;
use lumivox_wgpu::Gpu;

use super::{Host, NEAR};
use crate::gpu;

const SIZE: [u32; 2] = [96, 72];

/// What is there before anything is drawn.
const UNTOUCHED: f32 = 7.0;

/// Where a point of the world is in an image: across and down, 0 to 1.
fn seen_at(camera: &Camera, point: DVec3) -> [f64; 2] {
    let own = camera.world_from_camera.inverse().transform_point3(point);
    let (edges, scale) = match camera.projection {
        Projection::Perspective { tangents } => (tangents, -own.z),
        Projection::Orthographic { extents } => (extents, 1.0),
    };
    let [left, right, bottom, top] = edges;
    [(own.x / scale - left) / (right - left), (top - own.y / scale) / (top - bottom)]
}

/// The picture's depth, in the host's numbers; negative where nothing is.
fn depth_of(host: &Host, gpu: &mut Gpu) -> Vec<f32> {
    let mut recording = Recording::new();
    host.live.record_read(LiveImage::Depth, &mut recording).unwrap();
    let bytes = gpu.executor.execute(&recording).unwrap().remove(0).wait().unwrap();
    bytes.chunks_exact(4).map(bytemuck::pod_read_unaligned).collect()
}

#[test]
fn velocity_leads_to_where_a_point_was() {
    let mut gpu = gpu();
    let test = scenes::dense_furnace();
    let parallel = Projection::Orthographic { extents: [-0.14, 0.12, -0.1, 0.1] };
    let from = test.camera.with_aspect(f64::from(SIZE[0]) / f64::from(SIZE[1]));
    for projection in [from.projection, parallel] {
        let before = Camera { projection, ..from };
        let turn =
            DAffine3::from_rotation_y(0.06) * DAffine3::from_translation(DVec3::new(0.004, -0.003, 0.002));
        let now = Camera { world_from_camera: turn * from.world_from_camera, projection };
        // Its volumes move as one.
        let moved = DAffine3::from_rotation_z(0.05) * DAffine3::from_translation(DVec3::new(0.0, 0.006, 0.0));
        let mut scene = test.scene.clone();
        for instance in &mut scene.volumes {
            instance.world_from_patient = moved * instance.world_from_patient;
        }
        let mut host = Host::new(&mut gpu, &test, LiveSettings::new(SIZE[0], SIZE[1]));
        host.wants_velocity = true;
        let untouched = vec![f16::from_f32(UNTOUCHED).to_bits(); 2 * (SIZE[0] * SIZE[1]) as usize];
        let budget = 4 * u64::from(SIZE[0] * SIZE[1]);
        host.frame(&mut gpu, &before, budget);
        host.upload(&gpu, &host.velocity, bytemuck::cast_slice(&untouched), 4);
        host.set_scene(&mut gpu, &scene);
        host.frame(&mut gpu, &now, budget);
        let (velocity, depth) = (host.read(&gpu, &host.velocity, 4), depth_of(&host, &mut gpu));
        let (mut seen, mut fastest) = (0, 0.0_f64);
        for (pixel, bytes) in velocity.chunks_exact(4).enumerate() {
            let told = [0, 1].map(|i| f16::from_le_bytes([bytes[2 * i], bytes[2 * i + 1]]).to_f32());
            if depth[pixel] <= 0.0 {
                assert_eq!(told, [UNTOUCHED; 2], "nothing is there");
                continue;
            }
            let at = [pixel as u32 % SIZE[0], pixel as u32 / SIZE[0]];
            let uv = [0, 1].map(|i| (f64::from(at[i]) + 0.5) / f64::from(SIZE[i]));
            let ray = now.ray(uv);
            let along = ray.direction.dot(-now.world_from_camera.matrix3.z_axis);
            let point = ray.origin + ray.direction * (NEAR / f64::from(depth[pixel]) / along);
            let was = seen_at(&before, moved.inverse().transform_point3(point));
            for axis in 0..2 {
                let wanted = was[axis] - uv[axis];
                let error = (f64::from(told[axis]) - wanted).abs();
                assert!(error < 1e-3 + 2e-3 * wanted.abs(), "{at:?}: {told:?}, and it was at {was:?}");
                fastest = fastest.max(wanted.abs());
            }
            seen += 1;
        }
        assert!(seen > 100 && fastest > 0.02, "{seen} {fastest}");

        // What stands still has none.
        host.frame(&mut gpu, &now, budget);
        let still = host.read(&gpu, &host.velocity, 4);
        let depth = depth_of(&host, &mut gpu);
        let is_zero = |(bytes, depth): (&[u8], &f32)| {
            *depth <= 0.0
                || bytes.chunks_exact(2).all(|b| f16::from_le_bytes([b[0], b[1]]).to_f32().abs() < 1e-4)
        };
        assert!(still.chunks_exact(4).zip(&depth).all(is_zero));
    }
}
