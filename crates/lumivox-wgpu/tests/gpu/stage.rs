//! A stage on a device, as every host with a frame to keep has one.

use lumivox_core::Camera;
use lumivox_core::glam::DAffine3;
use lumivox_renderer::live::LiveImage;
use lumivox_renderer::stage::{Lent, Recorded, Stage, ViewFrame};
use lumivox_renderer::{HostFrame, LiveSettings, LiveStatus, Recording, ViewKind};
use lumivox_testing::scenes::{self, TestScene};
use lumivox_wgpu::{Gpu, wgpu};

use crate::gpu;

const SIZE: u32 = 48;
const WORLD: u8 = 1;
const VIEW: u8 = 2;

/// Frames for which the camera moves.
const MOVING: usize = 24;

/// A host of one view.
struct Host<'a> {
    gpu: &'a mut Gpu,
    stage: Stage<u8, u8>,
    color: wgpu::Texture,
    settings: LiveSettings,
    frame: u64,
}

impl<'a> Host<'a> {
    fn new(gpu: &'a mut Gpu, settings: LiveSettings) -> Self {
        let color = gpu.executor.device().create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width: SIZE, height: SIZE, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba16Float,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
            view_formats: &[],
        });
        let stage = Stage::new(gpu.executor.limits());
        Self { gpu, stage, color, settings, frame: 0 }
    }

    fn replay(&mut self, recorded: Recorded<u8, u8>) {
        let ticket = recorded.ticket();
        let read_backs = self.gpu.executor.execute(&recorded.recording).unwrap();
        self.stage.executed(recorded, Ok(())).unwrap();
        for read_back in read_backs {
            self.stage.feedback(ticket, &read_back.wait().unwrap());
        }
    }

    /// A frame; `None` while there is nothing to show.
    fn show(&mut self, test: &TestScene, camera: &Camera) -> Option<LiveStatus> {
        self.frame += 1;
        self.stage.begin_frame(self.frame);
        self.stage.expect(WORLD, ViewKind::Live { guides: false, kept_light: self.settings.kept_light });
        let updated = self.stage.update(WORLD, &test.scene, 1, false, &self.gpu.executor).unwrap();
        if let Some(recorded) = updated {
            self.replay(recorded);
        }
        let shown = self.stage.shown(VIEW, WORLD, |_| true)?;
        let settings = self.settings;
        let frame = |lent: Lent| ViewFrame::new(*camera, settings, HostFrame::new(lent.color), 8.0);
        let seen = self.stage.record_view(VIEW, shown, frame).unwrap();
        self.gpu.executor.lend_texture(seen.lent.color, &self.color);
        self.replay(seen.recorded);
        Some(seen.status)
    }

    /// Light and alpha of each pixel.
    fn picture(&mut self) -> Vec<[f32; 4]> {
        let mut recording = Recording::new();
        self.stage.image(VIEW, LiveImage::Color).unwrap().record_read(&mut recording);
        let bytes = self.gpu.executor.execute(&recording).unwrap().remove(0).wait().unwrap();
        bytes.chunks_exact(16).map(bytemuck::pod_read_unaligned).collect()
    }

    fn end(mut self) {
        while let Some(rest) = self.stage.sweep(|_| false, |_| false) {
            self.replay(rest);
        }
        let mut last = Recording::new();
        self.stage.store().free(&mut last);
        self.gpu.executor.execute(&last).unwrap();
    }
}

fn around(test: &TestScene, frame: usize) -> Camera {
    let camera = test.camera.with_aspect(1.0);
    let turn = DAffine3::from_rotation_y(0.01 * frame as f64);
    Camera { world_from_camera: turn * camera.world_from_camera, ..camera }
}

/// What a camera sees that has moved, and bytes of light that were kept for it.
fn moving(gpu: &mut Gpu, test: &TestScene, kept_light: bool) -> (Vec<[f32; 4]>, u64) {
    let settings = LiveSettings::new(SIZE, SIZE).with(|it| it.kept_light = kept_light);
    let mut host = Host::new(gpu, settings);
    let (mut shown, mut bytes) = (0, 0);
    while shown < MOVING {
        let waits = host.gpu.executor.pipeline_waits();
        if let Some(status) = host.show(test, &around(test, shown)) {
            // Kernels are made elsewhere, and until they are light is not kept.
            assert_eq!(host.gpu.executor.pipeline_waits(), waits, "frame {shown} waits for a kernel");
            let is_complete = !kept_light || status.light_bytes > 0;
            (shown, bytes) = (if is_complete { shown + 1 } else { 0 }, status.light_bytes);
        }
    }
    let picture = host.picture();
    host.end();
    (picture, bytes)
}

#[test]
fn what_moves_is_nearer_to_its_converged_picture_where_light_is_kept() {
    let mut gpu = gpu();
    let test = scenes::noise();
    // The drawing of the frame's last step, which a host prepares for its own target.
    let kernels = [lumivox_renderer::recording::Kernel::CompositeColor];
    gpu.executor.prepare_draws(kernels, wgpu::TextureFormat::Rgba16Float, 1);
    while !gpu.executor.is_prepared_to_draw(kernels, wgpu::TextureFormat::Rgba16Float, 1) {
        std::thread::yield_now();
    }
    let last = around(&test, MOVING - 1);
    let still = LiveSettings::new(SIZE, SIZE).with(|it| {
        it.target_samples = 160;
        it.seed = 7;
        // Of which nothing is left in what has converged.
        it.kept_light = false;
    });
    let mut host = Host::new(&mut gpu, still);
    while !host.show(&test, &last).is_some_and(|status| status.converged) {}
    let converged = host.picture();
    host.end();
    let luminance = |p: &[f32; 4]| f64::from(0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2]);
    let error = |picture: &[[f32; 4]]| {
        let square = |(a, b): (&[f32; 4], &[f32; 4])| (luminance(a) - luminance(b)).powi(2);
        (picture.iter().zip(&converged).map(square).sum::<f64>() / converged.len() as f64).sqrt()
    };
    let ((kept, bytes), (plain, none)) = (moving(&mut gpu, &test, true), moving(&mut gpu, &test, false));
    let (of_kept, of_plain) = (error(&kept), error(&plain));
    println!("kept light {of_kept:.4} with {bytes} bytes, without {of_plain:.4}");
    assert!(of_kept < 0.7 * of_plain, "{of_kept} with kept light, {of_plain} without");
    assert!(bytes > 0 && none == 0);
}
