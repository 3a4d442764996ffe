//! The library that the package's tests load: all of `lumivox-unity`, and what they compare with.
//!
//! A still is recorded for both, and its film comes back from the wgpu host here and from the package's executor there. Of
//! live views, [`lumivox_twin_picture`] shows what the wgpu host makes of what the package was given.

mod twin;

use std::ffi::{CString, c_char};
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};

use lumivox_renderer::{DeviceLimits, Recording, SceneCache, View, ViewSettings, VoxelStore};
use lumivox_testing::scenes::{self, TestScene};
use lumivox_unity::abi::LumivoxDeviceLimits;
use lumivox_unity::stage::device_limits;
use lumivox_unity::steps::LumivoxRecording;
use lumivox_wgpu::Gpu;

pub use twin::*;

// Its symbols are exported with those of this library.
pub use lumivox_unity::abi;

/// What chooses the random numbers of stills.
const SEED: u32 = 7;

/// What tells software from a GPU for both hosts.
pub(crate) const LIMITS: LumivoxDeviceLimits = LumivoxDeviceLimits {
    max_texture_3d: 2048,
    max_texture_2d: 8192,
    max_buffer_bytes: 128 << 20,
    voxel_bytes: 0,
    unorm16: 1,
    is_software: 1,
};

static SCENES: LazyLock<Vec<(CString, TestScene)>> = LazyLock::new(|| {
    let named = |scene: TestScene| (CString::new(scene.name).expect("a name without 0"), scene);
    scenes::all().into_iter().map(named).collect()
});

/// The wgpu host's device, one for all pictures: most have kernels of those before them.
pub(crate) fn gpu() -> MutexGuard<'static, Gpu> {
    static GPU: LazyLock<Mutex<Gpu>> =
        LazyLock::new(|| Mutex::new(Gpu::open(None).expect("a Vulkan device")));
    GPU.lock().unwrap_or_else(PoisonError::into_inner)
}

/// How many test scenes there are.
#[unsafe(no_mangle)]
pub extern "C" fn lumivox_twin_scene_count() -> u32 {
    SCENES.len() as u32
}

/// The name of a test scene; null beyond the last.
#[unsafe(no_mangle)]
pub extern "C" fn lumivox_twin_scene_name(index: u32) -> *const c_char {
    SCENES.get(index as usize).map_or(std::ptr::null(), |(name, _)| name.as_ptr())
}

/// A still of a test scene for a device of such limits: `side` x `side` pixels, its film read back at the end. And what frees
/// all that it made.
fn still(index: u32, side: u32, samples: u32, limits: DeviceLimits) -> [Recording; 2] {
    let (_, test) = &SCENES[index as usize];
    let mut recording = Recording::new();
    let store = VoxelStore::new(limits);
    let mut cache = SceneCache::new(&store);
    cache.update(&test.scene, &mut recording).expect("test scenes fit");
    let settings = ViewSettings::new(side, side).with(|it| it.seed = SEED);
    let mut view = View::new(settings, &cache, &mut recording).expect("test films fit");
    while view.record_samples(&cache, &test.camera, samples, u64::MAX >> 8, &mut recording) > 0 {}
    view.record_read_film(&mut recording);
    let mut end = Recording::new();
    view.free(&mut end);
    cache.free(&mut end);
    store.free(&mut end);
    [recording, end]
}

/// The recording of a still, for the package's executor. Freed by `lumivox_recording_finish`.
#[unsafe(no_mangle)]
pub extern "C" fn lumivox_twin_still(index: u32, side: u32, samples: u32) -> *mut LumivoxRecording {
    let [recording, _] = still(index, side, samples, device_limits(&LIMITS));
    Box::into_raw(Box::new(recording.into()))
}

/// The film of the same still by the wgpu host; returns how many floats it has.
///
/// # Safety
/// `film` can hold `capacity` floats.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_twin_still_film(
    index: u32,
    side: u32,
    samples: u32,
    film: *mut f32,
    capacity: u32,
) -> u32 {
    let mut gpu = gpu();
    let [recording, end] = still(index, side, samples, device_limits(&LIMITS));
    let mut bytes = vec![];
    for read_back in gpu.executor.execute(&recording).expect("test scenes run") {
        bytes.extend(read_back.wait().expect("films come back"));
    }
    gpu.executor.execute(&end).expect("what was made is freed");
    let floats: Vec<f32> = bytemuck::pod_collect_to_vec(&bytes);
    if !film.is_null() {
        let count = floats.len().min(capacity as usize);
        // SAFETY: as the caller promises.
        unsafe { std::slice::from_raw_parts_mut(film, count) }.copy_from_slice(&floats[..count]);
    }
    floats.len() as u32
}
