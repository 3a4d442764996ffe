//! Recordings that any device of WebGPU takes: what it guarantees, step by step.

use std::collections::HashSet;

use lumivox_core::Camera;
use lumivox_renderer::recording::{BindingKind, Kernel, TextureFormat};
use lumivox_renderer::{
    DeviceLimits, DisplaySettings, HostDepth, HostFrame, LiveSettings, LiveView, Recording, ResourceId,
    SceneCache, Step, View, ViewSettings, VoxelStore,
};
use lumivox_testing::scenes;

use crate::scenes::{camera, replay, scene, volume};

const STORAGE_BINDING: u64 = 128 << 20;
const UNIFORM_BINDING: usize = 64 << 10;

fn check_kernel(kernel: Kernel) {
    let count =
        |wanted: &[BindingKind]| kernel.bindings().iter().filter(|kind| wanted.contains(kind)).count();
    assert!(count(&[BindingKind::StorageRead, BindingKind::StorageReadWrite]) <= 8, "{kernel:?}");
    assert!(count(&[BindingKind::Uniform]) <= 12, "{kernel:?}");
    assert!(count(&[BindingKind::Texture3d, BindingKind::Texture2dLoaded]) <= 16, "{kernel:?}");
    assert!(count(&[BindingKind::LinearSampler]) <= 16, "{kernel:?}");
    assert!(kernel.workgroup_size().iter().product::<u32>() <= 256, "{kernel:?}");
}

fn check(name: &str, recording: &Recording) {
    for step in &recording.steps {
        match step {
            // A buffer is bound whole.
            Step::CreateBuffer { label, size, .. } => {
                assert!(*size <= STORAGE_BINDING, "{name}: {label} of {size} bytes")
            }
            Step::CreateTexture { label, format, size, .. } => {
                let most = if size[2] == 0 { 8192 } else { 2048 };
                assert!(size.iter().all(|side| *side <= most), "{name}: {label} of {size:?}");
                assert_ne!(*format, TextureFormat::R16Unorm, "{name}: {label}");
            }
            Step::WriteBuffer { offset, data, .. } => {
                assert_eq!((offset % 4, data.bytes().len() % 4), (0, 0), "{name}");
            }
            Step::ReadBuffer { range, .. } => assert_eq!((range.start % 4, range.end % 4), (0, 0), "{name}"),
            Step::Dispatch { kernel, uniforms, workgroups, .. } => {
                check_kernel(*kernel);
                assert!(
                    workgroups.iter().all(|count| (1..=65_535).contains(count)),
                    "{name}: {kernel:?} {workgroups:?}"
                );
                assert!(uniforms.iter().all(|bytes| bytes.len() <= UNIFORM_BINDING), "{name}: {kernel:?}");
            }
            Step::Draw { kernel, uniforms, .. } => {
                check_kernel(*kernel);
                assert!(uniforms.iter().all(|bytes| bytes.len() <= UNIFORM_BINDING), "{name}: {kernel:?}");
            }
            Step::WriteTexture { .. }
            | Step::CopyTexture { .. }
            | Step::ClearBuffer { .. }
            | Step::Free { .. } => {}
        }
    }
}

/// Plain scenes, labels, lamps and many bricks; as stills with guides and as live views, with them and without.
#[test]
fn usual_scenes_keep_to_what_webgpu_guarantees() {
    const SIZE: [u32; 2] = [1920, 1080];
    let mut tests: Vec<_> =
        scenes::all().into_iter().map(|test| (test.name, test.scene, test.camera)).collect();
    tests.push(("larger", scene(&[volume(160)]), camera()));
    for (name, scene, camera) in tests {
        let mut alive = HashSet::new();
        let mut cache = SceneCache::new(&VoxelStore::new(DeviceLimits::webgpu_default()));
        let mut recording = Recording::new();
        cache.update(&scene, &mut recording).unwrap();
        let settings = ViewSettings::new(SIZE[0], SIZE[1]).with(|it| it.guides = true);
        let mut view = View::new(settings, &cache, &mut recording).unwrap();
        view.record_samples(&cache, &camera, 64, u64::MAX, &mut recording);
        view.record_count(&mut recording);
        view.record_display(&cache, &DisplaySettings::default(), &mut recording);
        view.record_read_film(&mut recording);

        let mut settings = LiveSettings::new(SIZE[0], SIZE[1]);
        let mut live = LiveView::new(&settings, &cache, &mut recording).unwrap();
        let [color_target, texture, depth_target] = [(); 3].map(|()| ResourceId::external());
        let depth = HostDepth::new(texture, [0.0, 0.01, 1.0, 0.0], 0.0);
        let host = HostFrame::new(color_target).with_depth(depth).with_depth_target(depth_target);
        alive.extend([color_target, texture, depth_target]);
        let camera: Camera = camera.with_aspect(f64::from(SIZE[0]) / f64::from(SIZE[1]));
        for frame in 0..4 {
            // At full resolution they are more than such a device binds.
            settings.guides = frame >= 2;
            settings.resolution_scale = if settings.guides { 0.9 } else { 1.0 };
            live.record_frame(&cache, &camera, &settings, &host, 1 << 24, &mut recording).unwrap();
        }
        check(name, &recording);
        replay(&recording, &mut alive);
    }
}

/// Those that no scene here asks for, too.
#[test]
fn every_kernel_keeps_to_what_webgpu_guarantees() {
    Kernel::all().for_each(check_kernel);
}
