//! The border as C uses it: handles, jobs, and whatever is null, freed or nonsense.

mod labels;
mod parts;
mod scenes;

use std::ffi::{CStr, CString, c_char};
use std::path::{Path, PathBuf};
use std::ptr::{null, null_mut};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use lumivox_core::{CancelToken, Progress};
use lumivox_phantom::TorsoOptions;
use lumivox_unity::abi::*;
use lumivox_unity::stage::*;
use lumivox_unity::steps::*;
use lumivox_unity::*;

fn text(text: *const c_char) -> String {
    assert!(!text.is_null());
    // SAFETY: a string of the library's.
    unsafe { CStr::from_ptr(text) }.to_str().unwrap().to_owned()
}

fn last_error() -> String {
    text(lumivox_last_error())
}

fn take_text(handle: *mut LumivoxText) -> String {
    assert!(!handle.is_null(), "{}", last_error());
    // SAFETY: a live handle, freed once.
    unsafe {
        let copy = text(lumivox_text(handle));
        lumivox_text_free(handle);
        copy
    }
}

fn wait(job: *mut LumivoxJob) -> LumivoxJobState {
    assert!(!job.is_null(), "{}", last_error());
    let began = Instant::now();
    loop {
        let mut progress = LumivoxProgress { stage: null(), done: 0, total: 0 };
        // SAFETY: a live handle.
        let state = unsafe { lumivox_job_poll(job, &mut progress) };
        text(progress.stage);
        if state != LumivoxJobState::Running {
            return state;
        }
        // Under valgrind, on a machine that is busy: minutes.
        assert!(began.elapsed() < Duration::from_secs(900), "the job goes on and on");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Nothing special.
fn import_options() -> LumivoxImportOptions {
    LumivoxImportOptions {
        series: null(),
        phase: 0,
        leave_gaps: 0,
        fill_damaged: 0,
        allow_outside_data: 0,
        keep_everything: 0,
        labels: 0,
        padding: 0,
        raw: null(),
    }
}

/// The folder of a torso on a table, as slices of DICOM. Under valgrind, where a torso grows for a minute, one that grew before.
fn torso() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        if let Some(made) = std::env::var_os("LUMIVOX_TEST_TORSO") {
            return made.into();
        }
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("border_torso");
        let (silent, never) = (Progress::SILENT, CancelToken::new());
        let options = TorsoOptions { size: 40, ..Default::default() };
        let torso = lumivox_phantom::torso(options, silent, &never).unwrap();
        let series = lumivox_phantom::SeriesDescription::default();
        lumivox_phantom::write_dicom_series(&torso, &folder, &series, silent, &never).unwrap();
        folder
    })
}

fn cube() -> *mut LumivoxVolume {
    // SAFETY: a string.
    let volume = unsafe { lumivox_volume_phantom(c"cube".as_ptr(), 16) };
    assert!(!volume.is_null(), "{}", last_error());
    volume
}

fn stage() -> *mut LumivoxStage {
    let limits = LumivoxDeviceLimits {
        max_texture_3d: 2048,
        max_texture_2d: 16384,
        max_buffer_bytes: 1 << 30,
        voxel_bytes: 0,
        unorm16: 1,
        is_software: 0,
    };
    // SAFETY: limits are there.
    let stage = unsafe { lumivox_stage_new(&limits) };
    assert!(!stage.is_null(), "{}", last_error());
    stage
}

const EXECUTED: u32 = LumivoxOutcome::Executed as u32;
const IDENTITY: [f32; 16] = [1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.];

/// What the component has by default.
const SURFACE: LumivoxSurface =
    LumivoxSurface { strength: 1.0, gradient: 0.0, roughness: 0.4, specular: 0.04, metallic: 0.0 };

fn instance(volume: *const LumivoxVolume) -> LumivoxInstance {
    LumivoxInstance {
        volume,
        part: null(),
        transfer_function: null(),
        labelling: null(),
        world_from_object: IDENTITY,
        clip_min: [0.0; 3],
        clip_max: [1.0; 3],
        layers: 1,
        medium: LumivoxMedium {
            density: 2.0,
            albedo: 1.0,
            anisotropy: 0.0,
            max_bounces: 100,
            filter: 3,
            extinction_space: 0,
            surface: SURFACE,
        },
        peel_mm: 0.0,
        first_clip: 0,
        clip_count: 0,
    }
}

fn studio() -> LumivoxEnvironment {
    LumivoxEnvironment {
        kind: 2,
        zenith: [0.0; 3],
        horizon: [0.0; 3],
        nadir: [0.0; 3],
        rotation: 0.0,
        strength: 1.0,
        map: null(),
    }
}

/// A camera two metres before the origin, that looks at it.
fn frame() -> LumivoxViewFrame {
    let mut world_from_camera = IDENTITY;
    world_from_camera[10] = -1.0;
    world_from_camera[14] = -2.0;
    // 53 degrees, z reversed, far away at 0.
    let mut clip_from_camera = [0.0; 16];
    (clip_from_camera[0], clip_from_camera[5], clip_from_camera[11]) = (2.0, -2.0, -1.0);
    clip_from_camera[14] = 0.1;
    LumivoxViewFrame {
        world_from_camera,
        clip_from_camera,
        size: [32, 24],
        has_depth: 1,
        depth_clear: 0.0,
        is_jittered: 0,
        write_depth: 1,
        exposure: 1.0,
        ambient: [0.0; 3],
        resolution_scale: 1.0,
        target_samples: 4,
        target_noise: 0.0,
        frame_budget_ms: 8.0,
        denoise: 0,
        kept_light: 1,
        fog: 0,
        fog_color: [0.0; 3],
        fog_start: 0.0,
        fog_end: 0.0,
        fog_density: 0.0,
        at_once: 1,
    }
}

fn kinds(recording: *const LumivoxRecording) -> Vec<LumivoxStepKind> {
    let mut count = 0;
    // SAFETY: a live handle; so many steps are there.
    unsafe {
        let steps = lumivox_recording_steps(recording, &mut count);
        std::slice::from_raw_parts(steps, count as usize).iter().map(|step| step.kind).collect()
    }
}

#[test]
fn a_frame_goes_through_the_border() {
    let (stage, volume) = (stage(), cube());
    // SAFETY: all handles are live, and freed once.
    unsafe {
        let environment = studio();
        lumivox_stage_begin_frame(stage);
        let instances = [instance(volume), instance(null())];
        assert_eq!(
            lumivox_stage_set_world(stage, 5, instances.as_ptr(), 2, null(), 0, null(), 0, &environment),
            0
        );
        // The stage goes on with a scan whose handle is gone.
        lumivox_volume_free(volume);
        let world = lumivox_stage_record_world(stage, 5, 1);
        assert!(!world.is_null(), "{}", last_error());
        assert!(kinds(world).contains(&LumivoxStepKind::WriteTexture));
        assert_eq!(lumivox_recording_finish(stage, world, EXECUTED, null()), 0);
        assert_eq!(lumivox_stage_world_progress(stage, 5), 0);
        assert!(lumivox_stage_voxel_bytes(stage) > 0);
        // Nothing to do any more, and nothing wrong.
        let world = lumivox_stage_record_world(stage, 5, 1);
        assert!(world.is_null() && last_error().is_empty(), "{}", last_error());
        let mut status = LumivoxViewStatus::default();
        let view = lumivox_stage_record_view(stage, 8, 5, &frame(), &mut status);
        assert!(!view.is_null(), "{}", last_error());
        let kinds = kinds(view);
        for kind in [LumivoxStepKind::Dispatch, LumivoxStepKind::Draw, LumivoxStepKind::ReadBuffer] {
            assert!(kinds.contains(&kind), "{kind:?} in {kinds:?}");
        }
        assert!(status.pixel_samples > 0 && status.color != 0 && status.awaits_feedback == 1);
        let ticket = status.ticket;
        let mut count = 0;
        let steps = lumivox_recording_steps(view, &mut count);
        let steps = std::slice::from_raw_parts(steps, count as usize);
        let reads = steps.iter().filter(|step| step.kind == LumivoxStepKind::ReadBuffer);
        let read_backs: Vec<u64> = reads.map(|step| step.length).collect();
        assert_eq!(lumivox_recording_finish(stage, view, EXECUTED, null()), 0);
        for length in &read_backs {
            let bytes = vec![0u8; *length as usize];
            lumivox_stage_feedback(stage, ticket, bytes.as_ptr().cast(), *length);
        }
        assert_eq!(lumivox_stage_view_status(stage, 8, &mut status), 0);
        assert_eq!(status.awaits_feedback, 0);
        // The device refuses: the view says why, and starts over.
        let mut moved = frame();
        (moved.target_samples, moved.frame_budget_ms) = (1 << 16, 0.5);
        moved.world_from_camera[12] += 0.01;
        let view = lumivox_stage_record_view(stage, 8, 5, &moved, &mut status);
        // The light that is kept may have been the cause: it is tried without, and nothing said.
        assert!(status.light_bytes > 0 && lumivox_stage_light_bytes(stage) == status.light_bytes);
        let failed = LumivoxOutcome::Failed as u32;
        assert_eq!(lumivox_recording_finish(stage, view, failed, c"no".as_ptr()), 0);
        let view = lumivox_stage_record_view(stage, 8, 5, &moved, &mut status);
        assert_eq!((status.light_bytes, lumivox_stage_light_bytes(stage)), (0, 0));
        let refused = lumivox_recording_finish(stage, view, failed, c"no".as_ptr());
        assert_eq!((refused, last_error().as_str()), (-1, "no"));
        let swept = lumivox_stage_sweep(stage, null(), 0, null(), 0);
        assert!(self::kinds(swept).contains(&LumivoxStepKind::Free));
        lumivox_recording_finish(stage, swept, EXECUTED, null());
        assert_eq!(lumivox_stage_voxel_bytes(stage), 0);
        lumivox_stage_free(stage);
    }
}

#[test]
fn jobs_store_scans_and_open_them_again() {
    let folder = tempfile::tempdir().unwrap();
    let file = CString::new(folder.path().join("a.lumivox").to_str().unwrap()).unwrap();
    // SAFETY: all handles are live, and freed once.
    unsafe {
        let made = lumivox_phantom_start(c"head".as_ptr(), 16);
        assert_eq!(wait(made), LumivoxJobState::Done);
        let volume = lumivox_job_take_volume(made);
        assert!(!volume.is_null());
        assert!(lumivox_job_take_volume(made).is_null(), "it was taken");
        assert!(lumivox_job_report(made).is_null());
        lumivox_job_free(made);
        let saved = lumivox_volume_save(volume, file.as_ptr());
        assert_eq!(wait(saved), LumivoxJobState::Done);
        lumivox_job_free(saved);
        let opened = lumivox_volume_open(file.as_ptr());
        assert_eq!(wait(opened), LumivoxJobState::Done);
        let again = lumivox_job_take_volume(opened);
        lumivox_job_free(opened);
        let bytes = std::fs::read(file.to_str().unwrap()).unwrap();
        let from_memory = lumivox_volume_open_bytes(bytes.as_ptr().cast(), bytes.len() as u64);
        drop(bytes);
        assert_eq!(wait(from_memory), LumivoxJobState::Done);
        lumivox_job_free(from_memory);
        let counts = |volume| {
            let mut counts = [0f32; 64];
            assert_eq!(lumivox_volume_histogram(volume, -1024.0, 3071.0, 64, counts.as_mut_ptr()), 0);
            counts
        };
        assert_eq!(counts(volume), counts(again));
        assert_eq!(text(lumivox_preset_for(again)), "ct-muscle");
        assert_eq!(take_text(lumivox_volume_report(again)), "null");
        let another = lumivox_volume_clone(again);
        lumivox_volume_free(again);
        assert_eq!(counts(volume), counts(another));
        lumivox_volume_free(another);
        lumivox_volume_free(volume);
    }
}

#[test]
fn what_cannot_be_read_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = CString::new(folder.path().to_str().unwrap()).unwrap();
    // SAFETY: all handles are live, and freed once.
    unsafe {
        let paths = [path.as_ptr()];
        let job = lumivox_import_load(paths.as_ptr(), 1, null(), null());
        assert_eq!(wait(job), LumivoxJobState::Failed);
        let error = take_text(lumivox_job_error(job));
        assert!(error.contains(folder.path().to_str().unwrap()), "{error}");
        lumivox_job_free(job);
        let job = lumivox_volume_open(path.as_ptr());
        assert_eq!(wait(job), LumivoxJobState::Failed);
        lumivox_job_free(job);
        assert!(lumivox_import_load(null(), 0, null(), null()).is_null());
        assert!(last_error().contains("name a file, a folder or an archive"), "{}", last_error());
        let options = LumivoxImportOptions { raw: c"256xx".as_ptr(), ..import_options() };
        assert!(lumivox_import_load(paths.as_ptr(), 1, &options, null()).is_null());
        assert!(!last_error().is_empty());
    }
}

#[test]
fn the_patient_is_imported_alone_unless_everything_is_asked_for() {
    let path = CString::new(torso().to_str().unwrap()).unwrap();
    let paths = [path.as_ptr()];
    // SAFETY: all handles are live, and freed once.
    unsafe {
        let scanned = lumivox_import_scan(paths.as_ptr(), 1, null());
        assert_eq!(wait(scanned), LumivoxJobState::Done);
        let study = lumivox_job_take_study(scanned);
        lumivox_job_free(scanned);
        let load = |keep_everything, study| {
            let options = LumivoxImportOptions { keep_everything, ..import_options() };
            let job = lumivox_import_load(paths.as_ptr(), 1, &options, study);
            assert_eq!(wait(job), LumivoxJobState::Done);
            let (volume, report) = (lumivox_job_take_volume(job), take_text(lumivox_job_report(job)));
            lumivox_job_free(job);
            let mut dense = 0.0;
            assert_eq!(lumivox_volume_histogram(volume, -700.0, 3000.0, 1, &mut dense), 0);
            lumivox_volume_free(volume);
            (dense, report.contains("hidden: other objects"))
        };
        for study in [null(), study.cast_const()] {
            let (alone, all) = (load(0, study), load(1, study));
            assert!(alone.1 && !all.1);
            assert!(alone.0 < 0.95 * all.0 && alone.0 > 0.8 * all.0, "{alone:?} of {all:?}");
        }
        lumivox_study_free(study);
        let torso = lumivox_volume_phantom(c"torso".as_ptr(), 8);
        assert!(!torso.is_null(), "{}", last_error());
        lumivox_volume_free(torso);
    }
}

#[test]
fn a_job_can_be_cancelled() {
    // SAFETY: all handles are live, and freed once.
    unsafe {
        let job = lumivox_phantom_start(c"head".as_ptr(), 256);
        lumivox_job_cancel(job);
        assert_eq!(wait(job), LumivoxJobState::Cancelled);
        assert!(lumivox_job_take_volume(job).is_null());
        lumivox_job_free(job);
    }
}

#[test]
fn null_is_an_error_and_never_worse() {
    let mut status = LumivoxViewStatus::default();
    // SAFETY: null is allowed everywhere.
    unsafe {
        lumivox_text_free(null_mut());
        lumivox_volume_free(null_mut());
        lumivox_transfer_function_free(null_mut());
        lumivox_map_free(null_mut());
        lumivox_stage_free(null_mut());
        lumivox_study_free(null_mut());
        lumivox_job_free(null_mut());
        lumivox_job_cancel(null());
        lumivox_labelling_free(null_mut());
        assert!(lumivox_labels_new(null(), null(), 0, null(), null(), null(), 0).is_null());
        assert!(lumivox_labels_find(null()).is_null() && lumivox_skin_find(null()).is_null());
        assert!(lumivox_part_find(null(), 1).is_null());
        assert_eq!(lumivox_preset_part(null()), 0);
        assert!(
            lumivox_labels_name(null(), 0).is_null() && lumivox_labelling_new(null(), null(), 0).is_null()
        );
        assert_eq!((lumivox_labels_count(null()), lumivox_labels_list(null(), null_mut(), 0)), (-1, -1));
        assert_eq!((lumivox_labels_share_in(null(), null()), lumivox_volume_skin(null())), (-1.0, 0));
        assert_eq!(lumivox_transfer_function_add_gradient(null_mut(), 1.0, null(), 0, null(), 0), -1);
        assert_eq!(lumivox_transfer_function_gradient_count(null()), 0);
        assert!(lumivox_transfer_function_gradient(null(), 0, null_mut()).is_null());
        lumivox_set_codec_program(null());
        assert_eq!(text(lumivox_text(null())), "");
        assert!(lumivox_volume_phantom(null(), 16).is_null());
        assert!(last_error().contains("it is null"), "{}", last_error());
        assert!(lumivox_volume_clone(null()).is_null());
        assert_eq!(lumivox_volume_info(null(), null_mut()), -1);
        assert!(lumivox_stage_new(null()).is_null());
        assert_eq!(lumivox_stage_set_world(null_mut(), 1, null(), 0, null(), 0, null(), 0, null()), -1);
        assert!(lumivox_stage_record_world(null_mut(), 1, 0).is_null());
        assert!(lumivox_stage_record_view(null_mut(), 1, 1, null(), &mut status).is_null());
        assert_eq!(lumivox_recording_finish(null_mut(), null_mut(), EXECUTED, null()), -1);
        assert!(lumivox_recording_steps(null(), null_mut()).is_null());
        lumivox_stage_feedback(null_mut(), 1, null(), 0);
        lumivox_stage_measured(null_mut(), 1, 1.0);
        assert!(lumivox_map_new(4, 2, null()).is_null());
        assert!(lumivox_map_load(null()).is_null());
        assert!(lumivox_transfer_function_load(c"".as_ptr()).is_null());
        assert!(lumivox_preset(c"nothing".as_ptr(), null(), null_mut()).is_null());
        assert_eq!(lumivox_job_poll(null_mut(), null_mut()), LumivoxJobState::Failed);
        let (stage, volume) = (stage(), cube());
        // A count without a list, a world that nobody set, a view that nobody recorded.
        assert_eq!(lumivox_stage_set_world(stage, 1, null(), 3, null(), 0, null(), 0, &studio()), -1);
        assert!(lumivox_stage_record_world(stage, 77, 0).is_null());
        assert_eq!(last_error(), "there is no world 77");
        assert_eq!(lumivox_stage_view_status(stage, 3, &mut status), -1);
        // Numbers that are none.
        let mut odd = instance(volume);
        odd.world_from_object = [f32::NAN; 16];
        odd.medium.density = f32::INFINITY;
        odd.clip_min = [f32::NAN; 3];
        let light = LumivoxLight {
            kind: 1,
            layers: u32::MAX,
            position: [f32::NAN; 3],
            direction: [0.0; 3],
            strength: [f32::INFINITY; 3],
            radius: -1.0,
            range: 0.0,
            falloff: 9,
            decay: f32::NAN,
            outer_half_angle: f32::NAN,
            inner_half_angle: f32::NAN,
            has_attenuation: 1,
            attenuation: f32::NAN,
        };
        let environment = LumivoxEnvironment { kind: 3, strength: f32::NAN, ..studio() };
        assert_eq!(lumivox_stage_set_world(stage, 1, &odd, 1, null(), 0, &light, 1, &environment), 0);
        let world = lumivox_stage_record_world(stage, 1, 1);
        assert!(!world.is_null(), "{}", last_error());
        lumivox_recording_finish(stage, world, EXECUTED, null());
        let blind = LumivoxViewFrame { clip_from_camera: [f32::NAN; 16], ..frame() };
        assert!(lumivox_stage_record_view(stage, 1, 1, &blind, &mut status).is_null());
        assert!(last_error().contains("the camera sees nothing"), "{}", last_error());
        let empty = LumivoxViewFrame { size: [0, 9], ..frame() };
        assert!(lumivox_stage_record_view(stage, 1, 1, &empty, &mut status).is_null());
        assert!(last_error().contains("at least one pixel"), "{}", last_error());
        lumivox_volume_free(volume);
        lumivox_stage_free(stage);
    }
}

#[test]
fn a_scan_is_pictured_as_it_is_and_as_presets_show_it() {
    let volume = cube();
    let picture = |preset: *const c_char, side: u32| {
        // SAFETY: live handles; the picture is copied before its job is freed.
        unsafe {
            let job = lumivox_volume_picture(volume, preset, side);
            assert_eq!(wait(job), LumivoxJobState::Done);
            let mut picture = LumivoxPicture { width: 0, height: 0, rgba: null() };
            assert_eq!(lumivox_job_picture(job, &mut picture), 0, "{}", last_error());
            let bytes = 4 * (picture.width * picture.height) as usize;
            let rgba = std::slice::from_raw_parts(picture.rgba, bytes).to_vec();
            lumivox_job_free(job);
            (picture.width, picture.height, rgba)
        }
    };
    let (width, height, suited) = picture(null(), 24);
    assert_eq!(width.max(height), 24);
    assert!(suited.chunks_exact(4).any(|pixel| pixel[3] > 128), "it shows nothing");
    let (_, _, bone) = picture(c"ct-bone".as_ptr(), 24);
    assert!(suited != bone, "the preset is not followed");
    // SAFETY: live handles, and null.
    unsafe {
        assert!(lumivox_volume_picture(volume, c"ct-bones".as_ptr(), 24).is_null());
        assert!(last_error().contains("ct-bone"), "{}", last_error());
        assert!(lumivox_volume_picture(null(), null(), 24).is_null());
        lumivox_volume_free(volume);
    }
}
