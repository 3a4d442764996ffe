//! What Unity shows on its device: worlds gathered by C#, as core scenes, and views of them.

use std::collections::{HashMap, HashSet};
use std::ffi::c_void;
use std::sync::Arc;

use lumivox_core::glam::DVec3;
use lumivox_core::light::{Cone, Falloff, Lamp};
use lumivox_core::{
    Environment, EnvironmentSource, HostCamera, Light, LightKind, Peel, Scene, VolumeInstance, placement,
};
use lumivox_renderer::stage::{NothingAhead, Recorded, Refusal, Stage, ViewFrame, ViewRecorded, WorldState};
use lumivox_renderer::{
    DeviceLimits, DistanceFog, FineTexels, Fog, HostDepth, HostFrame, LiveSettings, ViewKind,
};

use crate::abi::*;
use crate::border::{free, guard, guard_handle, guard_option, guard_status, known, known_mut, list, text};
use crate::clips::clip_shape;
use crate::steps::LumivoxRecording;
use crate::volume::LumivoxVolume;
use crate::{convert, look};

/// Everything that is shown on one device.
pub struct LumivoxStage {
    stage: Stage<u64, u64>,
    worlds: HashMap<u64, World>,
    /// What each view showed last.
    shown: HashMap<u64, Showing>,
    last_version: u64,
    last_frame: u64,
}

/// A number that C# gives may be any: these are the ones that mean something.
const EXECUTED: u32 = LumivoxOutcome::Executed as u32;
const NO_MEMORY: u32 = LumivoxOutcome::NoMemory as u32;

/// What a view showed last.
#[derive(Clone, Copy)]
struct Showing {
    world: u64,
    frame: LumivoxViewFrame,
}

/// A world as C# gathered it last.
struct World {
    scene: Arc<Scene>,
    version: u64,
    /// Why it cannot be shown.
    error: Option<String>,
}

/// A stage for a device.
///
/// # Safety
/// `limits` points to limits.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_stage_new(limits: *const LumivoxDeviceLimits) -> *mut LumivoxStage {
    guard_handle(|| {
        // SAFETY: as the caller promises.
        let limits = unsafe { known(limits, "limits") }?;
        let stage = Stage::new(device_limits(limits));
        if limits.voxel_bytes > 0 {
            stage.store().set_capacity(limits.voxel_bytes);
        }
        Ok(LumivoxStage {
            stage,
            worlds: HashMap::new(),
            shown: HashMap::new(),
            last_version: 0,
            last_frame: 0,
        })
    })
}

/// What the renderer needs to know of a device.
pub fn device_limits(limits: &LumivoxDeviceLimits) -> DeviceLimits {
    let in_software = limits.is_software != 0;
    DeviceLimits::webgpu_default().with(|it| {
        it.max_texture_3d = limits.max_texture_3d;
        // Unity counts texels of a texture's bytes in 32 bits.
        it.max_texture_bytes = match in_software {
            true => DeviceLimits::TEXTURE_BYTES_OF_SOFTWARE,
            false => DeviceLimits::TEXTURE_BYTES_OF_GPU.min(2000 << 20),
        };
        it.fine_texels = match limits.unorm16 {
            0 => FineTexels::Halves,
            _ => FineTexels::Norms,
        };
        it.few_kernels = true;
        it.max_texture_2d = limits.max_texture_2d;
        it.max_storage_binding = limits.max_buffer_bytes.clamp(16 << 20, 2000 << 20);
        it.max_samples_per_dispatch = match in_software {
            true => DeviceLimits::SAMPLES_OF_SOFTWARE,
            false => DeviceLimits::SAMPLES_OF_GPU,
        };
    })
}

/// Frees a stage. What the device holds for it is the executor's to free.
///
/// # Safety
/// `stage` is null, or a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_stage_free(stage: *mut LumivoxStage) {
    // SAFETY: as the caller promises.
    unsafe { free(stage) };
}

/// The engine begins a frame.
///
/// # Safety
/// `stage` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_stage_begin_frame(stage: *mut LumivoxStage) {
    guard(|| {
        // SAFETY: as the caller promises.
        let this = unsafe { known_mut(stage, "stage") }?;
        this.last_frame += 1;
        this.stage.begin_frame(this.last_frame);
        Ok(())
    });
}

/// What is in a world from now on. Cheap where that is what was there.
///
/// # Safety
/// `stage` is a live handle, the others point to so many, with live handles in them.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_stage_set_world(
    stage: *mut LumivoxStage,
    world: u64,
    instances: *const LumivoxInstance,
    instance_count: u32,
    clips: *const LumivoxClipShape,
    clip_count: u32,
    lights: *const LumivoxLight,
    light_count: u32,
    environment: *const LumivoxEnvironment,
) -> i32 {
    guard_status(|| {
        // SAFETY: as the caller promises.
        let (stage, instances, clips, lights, environment) = unsafe {
            (
                known_mut(stage, "stage")?,
                list(instances, instance_count as usize, "instances")?,
                list(clips, clip_count as usize, "clip shapes")?,
                list(lights, light_count as usize, "lights")?,
                known(environment, "environment")?,
            )
        };
        let scene = Scene {
            volumes: instances
                .iter()
                // SAFETY: as the caller promises.
                .filter_map(|instance| unsafe { volume_instance(instance, clips) }.transpose())
                .collect::<Result<_, String>>()?,
            // SAFETY: as the caller promises.
            environment: unsafe { surroundings(environment) },
            lights: lights.iter().filter_map(light).collect(),
        };
        if stage.worlds.get(&world).is_some_and(|known| known.scene.is_same(&scene)) {
            return Ok(());
        }
        stage.set_scene(world, Arc::new(scene));
        Ok(())
    })
}

/// # Safety
/// Its handles are null or live.
unsafe fn volume_instance(
    instance: &LumivoxInstance,
    clips: &[LumivoxClipShape],
) -> Result<Option<VolumeInstance>, String> {
    // SAFETY: as the caller promises.
    let (scan, part, function, labelling) = unsafe {
        (
            instance.volume.as_ref(),
            instance.part.as_ref(),
            instance.transfer_function.as_ref(),
            instance.labelling.as_ref(),
        )
    };
    let Some(scan) = scan else { return Ok(None) };
    // Its look and its skin are the scan's whatever is seen of it.
    let volume = part.unwrap_or(scan).volume().clone();
    // Clip coordinates are mirrored with the object.
    let [a, b] = [instance.clip_min, instance.clip_max].map(convert::wide);
    let [a, b] = [a, b].map(|corner| DVec3::new(corner.x, corner.y, 1.0 - corner.z));
    let world_from_patient =
        convert::world_from_object(&instance.world_from_object) * placement::node_from_patient(&volume);
    let clip_box = placement::clip_box(&volume, a, b);
    let medium = look::medium(&instance.medium, function, scan.suited());
    let first = instance.first_clip as usize;
    let clips = first.checked_add(instance.clip_count as usize).and_then(|end| clips.get(first..end));
    let clips = clips.ok_or("an instance names clip shapes that are not there")?;
    let peel = f64::from(instance.peel_mm);
    let depth = scan.skin().and_then(Clone::clone).filter(|_| peel > 0.0);
    Ok(Some(VolumeInstance {
        clip_box,
        layers: instance.layers,
        labels: labelling.map(|labelling| labelling.of(&medium)),
        peel: depth.map(|depth| Peel { depth, mm: peel }),
        clip_shapes: clips.iter().map(|clip| clip_shape(clip, world_from_patient)).collect(),
        ..VolumeInstance::new(volume, medium, world_from_patient)
    }))
}

/// # Safety
/// Its map is null or live.
unsafe fn surroundings(environment: &LumivoxEnvironment) -> Environment {
    let source = match environment.kind {
        0 => EnvironmentSource::Uniform(convert::color(environment.zenith)),
        1 => EnvironmentSource::Gradient {
            zenith: convert::color(environment.zenith),
            horizon: convert::color(environment.horizon),
            nadir: convert::color(environment.nadir),
        },
        // SAFETY: as the caller promises.
        3 => match unsafe { environment.map.as_ref() } {
            Some(map) => EnvironmentSource::Map(map.0.clone()),
            None => EnvironmentSource::Uniform([0.0; 3]),
        },
        _ => EnvironmentSource::Studio,
    };
    // Seen in a mirror, it turns the other way.
    Environment {
        source,
        rotation: -f64::from(environment.rotation),
        strength: f64::from(environment.strength),
    }
}

fn light(light: &LumivoxLight) -> Option<Light> {
    let direction = convert::vector(light.direction);
    let strength = convert::color(light.strength);
    let lamp = Lamp {
        position: convert::vector(light.position),
        intensity: strength,
        radius: f64::from(light.radius),
        falloff: match light.falloff {
            1 => Falloff::Relative { range: f64::from(light.range) },
            _ => Falloff::Power {
                range: f64::from(light.range),
                decay: if light.decay > 0.0 { f64::from(light.decay) } else { 2.0 },
            },
        },
    };
    let kind = match light.kind {
        0 => LightKind::Directional {
            direction,
            irradiance: strength,
            angular_radius: f64::from(light.radius),
        },
        1 => LightKind::Point(lamp),
        2 => LightKind::Spot {
            lamp,
            direction,
            half_angle: f64::from(light.outer_half_angle),
            cone: match light.has_attenuation {
                0 => Cone::Between { inner_half_angle: f64::from(light.inner_half_angle) },
                _ => Cone::Power { attenuation: f64::from(light.attenuation) },
            },
        },
        _ => return None,
    };
    Some(Light { kind, layers: light.layers })
}

/// Records what brings a world's copy on the device up to date; null where there is nothing to do, and
/// `lumivox_last_error` then says nothing.
///
/// # Safety
/// `stage` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_stage_record_world(
    stage: *mut LumivoxStage,
    world: u64,
    at_once: u32,
) -> *mut LumivoxRecording {
    guard_option(|| {
        // SAFETY: as the caller promises.
        let LumivoxStage { stage, worlds, .. } = unsafe { known_mut(stage, "stage") }?;
        let known = worlds.get_mut(&world).ok_or_else(|| format!("there is no world {world}"))?;
        // All kernels come with the package.
        stage.expect(world, ViewKind::Live { guides: false, kept_light: true });
        let updated = stage.update(world, &known.scene, known.version, at_once != 0, &NothingAhead);
        known.error = updated.as_ref().err().map(ToString::to_string);
        Ok(updated?.map(LumivoxRecording::new))
    })
}

/// Records a view's frame of a world; null where there is nothing to draw yet, and `lumivox_last_error` then says nothing.
///
/// # Safety
/// `stage` is a live handle, `frame` points to a frame, `out` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_stage_record_view(
    stage: *mut LumivoxStage,
    view: u64,
    world: u64,
    frame: *const LumivoxViewFrame,
    out: *mut LumivoxViewStatus,
) -> *mut LumivoxRecording {
    guard_option(|| {
        // SAFETY: as the caller promises.
        let (this, frame, out) = unsafe {
            (known_mut(stage, "stage")?, known(frame, "frame")?, known_mut(out, "place for the status")?)
        };
        *out = LumivoxViewStatus::default();
        let [width, height] = frame.size;
        let clip_from_camera = convert::matrix(&frame.clip_from_camera);
        let world_from_camera = convert::world_from_camera(&frame.world_from_camera);
        let host = HostCamera::from_matrices(world_from_camera, clip_from_camera)
            .ok_or("the camera sees nothing: its matrices are not finite, or flat")?;
        let jittered = frame.is_jittered != 0;
        let view_frame = |lent: lumivox_renderer::stage::Lent| {
            ViewFrame::new(
                if jittered { host.camera.without_jitter(frame.size) } else { host.camera },
                LiveSettings::new(width, height).with(|it| {
                    it.resolution_scale = f64::from(frame.resolution_scale);
                    it.target_samples = frame.target_samples.max(1);
                    it.target_noise = f64::from(frame.target_noise);
                    it.exposure = f64::from(frame.exposure);
                    it.ambient = convert::color(frame.ambient);
                    it.denoise = frame.denoise != 0;
                    it.kept_light = frame.kept_light != 0;
                }),
                HostFrame::new(lent.color)
                    .with_depth(
                        (frame.has_depth != 0).then_some(
                            HostDepth::new(
                                lent.depth,
                                host.view_depth_from_ndc,
                                f64::from(frame.depth_clear),
                            )
                            .with_jitter(jittered),
                        ),
                    )
                    .with_depth_target((frame.write_depth != 0).then_some(lent.written_depth))
                    .with_fog(fog(frame)),
                f64::from(frame.frame_budget_ms),
            )
        };
        this.shown.insert(view, Showing { world, frame: *frame });
        let Some(shown) = this.stage.shown(view, world, |_| true) else { return Ok(None) };
        let ViewRecorded { recorded, lent, .. } = this.stage.record_view(view, shown, view_frame)?;
        *out = this.status(view);
        out.depth = lent.depth.0;
        out.color = lent.color.0;
        out.written_depth = lent.written_depth.0;
        out.ticket = recorded.ticket();
        Ok(Some(LumivoxRecording::new(recorded)))
    })
}

fn fog(frame: &LumivoxViewFrame) -> Option<Fog> {
    let by_distance = match frame.fog {
        1 => DistanceFog::LinearInDepth { begin: f64::from(frame.fog_start), end: f64::from(frame.fog_end) },
        2 => DistanceFog::ExponentialInDepth { density: f64::from(frame.fog_density) },
        3 => DistanceFog::ExponentialSquaredInDepth { density: f64::from(frame.fog_density) },
        _ => return None,
    };
    Some(Fog { color: convert::color(frame.fog_color), by_distance, by_height: None })
}

impl LumivoxStage {
    /// What a view shows, and how it was asked for last.
    pub fn shown_by(&self, view: u64) -> Option<(Arc<Scene>, LumivoxViewFrame)> {
        let Showing { world, frame } = *self.shown.get(&view)?;
        Some((self.worlds.get(&world)?.scene.clone(), frame))
    }

    /// What is in a world.
    pub(crate) fn scene(&self, world: u64) -> Option<&Arc<Scene>> {
        self.worlds.get(&world).map(|world| &world.scene)
    }

    /// As [`lumivox_stage_set_world`], of what is no array of C#'s.
    pub fn set_scene(&mut self, world: u64, scene: Arc<Scene>) {
        self.last_version += 1;
        let version = self.last_version;
        self.worlds.insert(world, World { scene, version, error: None });
    }

    fn status(&self, view: u64) -> LumivoxViewStatus {
        let Some(showing) = self.shown.get(&view) else { return LumivoxViewStatus::default() };
        let Some(progress) = self.stage.view_progress(view, showing.world) else {
            return LumivoxViewStatus::default();
        };
        LumivoxViewStatus {
            samples: progress.live.samples,
            is_converged: u32::from(progress.is_converged),
            awaits_feedback: u32::from(progress.live.awaits_feedback),
            lost_pixels: progress.live.lost_pixels,
            pixel_samples: progress.live.pixel_samples,
            light_bytes: progress.live.light_bytes,
            ..LumivoxViewStatus::default()
        }
    }
}

/// Tells what became of a recording, one of `LumivoxOutcome`, and frees it. To be called for each, in the order in which
/// they were recorded; `why` says in words what was refused, or is null.
///
/// # Safety
/// `stage` and `recording` are live handles, `why` is null or a string.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_recording_finish(
    stage: *mut LumivoxStage,
    recording: *mut LumivoxRecording,
    outcome: u32,
    why: *const std::ffi::c_char,
) -> i32 {
    guard_status(|| {
        if recording.is_null() {
            return Err("there is no recording: it is null".to_owned());
        }
        // SAFETY: as the caller promises; it is freed here.
        let recorded: Recorded<u64, u64> = unsafe { Box::from_raw(recording) }.recorded;
        // SAFETY: as the caller promises.
        let (this, why) = unsafe { (known_mut(stage, "stage")?, text(why, "reason")) };
        let why = why.ok().flatten().unwrap_or("the device refused it").to_owned();
        let outcome = match outcome {
            EXECUTED => Ok(()),
            NO_MEMORY => Err(Refusal::Memory(why)),
            _ => Err(Refusal::Other(why)),
        };
        Ok(this.stage.executed(recorded, outcome)?)
    })
}

/// Hands over what a read-back has brought; `length` 0 if it got lost. Those of a ticket come in the order of their steps.
///
/// # Safety
/// `stage` is a live handle, `bytes` points to `length` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_stage_feedback(
    stage: *mut LumivoxStage,
    ticket: u64,
    bytes: *const c_void,
    length: u64,
) {
    guard(|| {
        // SAFETY: as the caller promises.
        let (this, bytes) =
            unsafe { (known_mut(stage, "stage")?, list(bytes.cast::<u8>(), length as usize, "bytes")?) };
        this.stage.feedback(ticket, bytes);
        Ok(())
    });
}

/// Tells how long the GPU took for the view's frame of a ticket, where the engine knows.
///
/// # Safety
/// `stage` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_stage_measured(stage: *mut LumivoxStage, ticket: u64, milliseconds: f64) {
    guard(|| {
        // SAFETY: as the caller promises.
        unsafe { known_mut(stage, "stage") }?.stage.measured(ticket, milliseconds);
        Ok(())
    });
}

/// How far a view is, with the read-backs that have come; -1 for one that was never recorded.
///
/// # Safety
/// `stage` is a live handle, `out` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_stage_view_status(
    stage: *const LumivoxStage,
    view: u64,
    out: *mut LumivoxViewStatus,
) -> i32 {
    guard_status(|| {
        // SAFETY: as the caller promises.
        let (this, out) = unsafe { (known(stage, "stage")?, known_mut(out, "place for it")?) };
        let world = this.shown.get(&view).ok_or_else(|| format!("there is no view {view}"))?.world;
        *out = this.status(view);
        match this.worlds.get(&world).and_then(|world| world.error.clone()) {
            Some(error) => Err(error),
            None => Ok(()),
        }
    })
}

/// Records that everything is freed that belongs to no view or world named; null where there is nothing.
///
/// # Safety
/// `stage` is a live handle, the others point to so many.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_stage_sweep(
    stage: *mut LumivoxStage,
    views: *const u64,
    view_count: u32,
    worlds: *const u64,
    world_count: u32,
) -> *mut LumivoxRecording {
    guard_option(|| {
        // SAFETY: as the caller promises.
        let (this, views, worlds) = unsafe {
            (
                known_mut(stage, "stage")?,
                list(views, view_count as usize, "views")?,
                list(worlds, world_count as usize, "worlds")?,
            )
        };
        let views: HashSet<u64> = views.iter().copied().collect();
        let worlds: HashSet<u64> = worlds.iter().copied().collect();
        this.worlds.retain(|world, _| worlds.contains(world));
        this.shown.retain(|view, _| views.contains(view));
        let swept = this.stage.sweep(|view| views.contains(view), |world| worlds.contains(world));
        Ok(swept.map(LumivoxRecording::new))
    })
}

/// Bytes of voxels that are on the device.
///
/// # Safety
/// `stage` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_stage_voxel_bytes(stage: *const LumivoxStage) -> u64 {
    // SAFETY: as the caller promises.
    guard(|| Ok(unsafe { known(stage, "stage") }?.stage.store().bytes())).unwrap_or(0)
}

/// Bytes of the light on the device that is kept in volumes.
///
/// # Safety
/// `stage` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_stage_light_bytes(stage: *const LumivoxStage) -> u64 {
    // SAFETY: as the caller promises.
    guard(|| Ok(unsafe { known(stage, "stage") }?.stage.store().light_bytes())).unwrap_or(0)
}

/// At what part of its resolution a scan is shown: `1 / factor` along a side, 0 where none of it is there; `arriving` is 1
/// while finer voxels are on their way.
///
/// # Safety
/// `stage` and `volume` are live handles, the others can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_volume_resolution(
    stage: *const LumivoxStage,
    volume: *const LumivoxVolume,
    factor: *mut u32,
    arriving: *mut u32,
) -> i32 {
    guard_status(|| {
        // SAFETY: as the caller promises.
        let (this, volume, factor, arriving) = unsafe {
            (
                known(stage, "stage")?,
                known(volume, "scan")?,
                known_mut(factor, "place for the factor")?,
                known_mut(arriving, "place for whether it arrives")?,
            )
        };
        let resolution = this.stage.store().resolution(volume.volume());
        *factor = resolution.map_or(0, |resolution| resolution.factor);
        *arriving = u32::from(resolution.is_some_and(|resolution| resolution.arriving));
        Ok(())
    })
}

/// How far a world is: 0 there, 1 arriving, 2 the one before is shown, 3 nothing is there.
///
/// # Safety
/// `stage` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_stage_world_progress(stage: *const LumivoxStage, world: u64) -> u32 {
    // SAFETY: as the caller promises.
    let progress = guard(|| Ok(unsafe { known(stage, "stage") }?.stage.world_state(world)));
    match progress.unwrap_or(WorldState::Nothing) {
        WorldState::Done => 0,
        WorldState::Arriving => 1,
        WorldState::Before => 2,
        WorldState::Nothing => 3,
    }
}
