//! A stage without a GPU: what it records, and that nothing is left behind.

use std::collections::HashSet;
use std::sync::Arc;
use std::thread::sleep;
use std::time::Duration;

use lumivox_core::glam::{DAffine3, DVec3};
use lumivox_core::{Environment, Filter, Medium, Modality, Orbit, Scene, TransferFunction, Volume, Voxels};

use super::*;
use crate::features::ViewKind;
use crate::limits::{FineTexels, LoopTurns};

const WORLD: u64 = 7;
const VIEW: u64 = 9;

fn limits() -> DeviceLimits {
    DeviceLimits {
        max_texture_3d: 512,
        max_texture_bytes: 1 << 30,
        fine_texels: FineTexels::Norms,
        one_pool: false,
        few_kernels: false,
        max_texture_2d: 4096,
        max_storage_binding: 128 << 20,
        max_samples_per_dispatch: DeviceLimits::SAMPLES_OF_GPU,
        loop_turns: None::<LoopTurns>,
    }
}

fn scene(opacity: f64) -> Scene {
    let voxels = Voxels::U8((0..16 * 16 * 16).map(|i| i as u8).collect());
    let volume = Volume::new([16; 3], voxels, [1.0, 0.0], DAffine3::IDENTITY, Modality::Ct).unwrap();
    let medium = Medium::new(TransferFunction::constant(opacity, [1.0; 3]));
    Scene { environment: Environment::uniform(1.0), ..Scene::with_volume(Arc::new(volume), medium) }
}

/// What a host holds after replaying recordings.
#[derive(Default)]
struct Device(HashSet<ResourceId>);

impl Device {
    fn replay(&mut self, recording: &Recording) {
        for step in &recording.steps {
            match step {
                Step::CreateBuffer { id, .. } | Step::CreateTexture { id, .. } => assert!(self.0.insert(*id)),
                Step::Free { id } => {
                    self.0.remove(id);
                }
                Step::Dispatch { resources, .. } => resources.iter().for_each(|id| self.is_there(id)),
                Step::WriteBuffer { id, .. } | Step::WriteTexture { id, .. } => self.is_there(id),
                _ => {}
            }
        }
    }

    fn is_there(&self, id: &ResourceId) {
        assert!(self.0.contains(id), "{id:?} is not there");
    }
}

fn frame(lent: Lent) -> ViewFrame {
    let orbit = Orbit { target: DVec3::ZERO, azimuth: 0.0, elevation: 0.0, distance: 1.0, vertical_fov: 0.7 };
    ViewFrame {
        camera: orbit.camera().with_aspect(1.0),
        settings: LiveSettings::new(16, 16),
        host: HostFrame::new(lent.color),
        budget_milliseconds: 8.0,
    }
}

/// The view's frame of the world, whatever stands in for it.
fn record(stage: &mut Stage<u64, u64>, frame: fn(Lent) -> ViewFrame) -> Option<ViewRecorded<u64, u64>> {
    let shown = stage.shown(VIEW, WORLD, |_| true)?;
    Some(stage.record_view(VIEW, shown, frame).unwrap())
}

fn update(stage: &mut Stage<u64, u64>, device: &mut Device, scene: &Scene, version: u64, at_once: bool) {
    if let Some(recorded) = stage.update(WORLD, scene, version, at_once, &NothingAhead).unwrap() {
        device.replay(&recorded.recording);
        stage.executed(recorded, Ok(())).unwrap();
    }
}

fn draw(stage: &mut Stage<u64, u64>, device: &mut Device) -> Option<(LiveStatus, u64)> {
    let ViewRecorded { recorded, status, lent } = record(stage, frame)?;
    device.0.extend(lent.ids());
    device.replay(&recorded.recording);
    let ticket = recorded.ticket();
    stage.executed(recorded, Ok(())).unwrap();
    Some((status, ticket))
}

#[test]
fn a_world_is_shown_once_it_is_prepared_and_leaves_nothing() {
    let (mut stage, mut device) = (Stage::new(limits()), Device::default());
    let scene = scene(0.5);
    assert_eq!(stage.world_state(WORLD), WorldState::Nothing);
    for number in 1..1000 {
        stage.begin_frame(number);
        update(&mut stage, &mut device, &scene, 1, false);
        if stage.world_state(WORLD) == WorldState::Done {
            break;
        }
        sleep(Duration::from_millis(2));
    }
    assert_eq!(stage.world_state(WORLD), WorldState::Done);
    let (status, _) = draw(&mut stage, &mut device).expect("the world is there");
    assert!(status.pixel_samples > 0);
    assert!(!stage.view_progress(VIEW, WORLD).unwrap().is_converged);
    drop(scene);
    let recorded = stage.sweep(|_| false, |_| false).expect("there is something to free");
    device.replay(&recorded.recording);
    stage.executed(recorded, Ok(())).unwrap();
    assert_eq!(stage.store().bytes(), 0);
    let mut last = Recording::new();
    stage.store().free(&mut last);
    device.replay(&last);
    assert_eq!(device.0, HashSet::new());
}

#[test]
fn at_once_means_in_this_frame() {
    let (mut stage, mut device) = (Stage::new(limits()), Device::default());
    assert!(draw(&mut stage, &mut device).is_none(), "there is no world yet");
    stage.begin_frame(1);
    update(&mut stage, &mut device, &scene(0.5), 1, true);
    assert_eq!(stage.world_state(WORLD), WorldState::Done);
    assert!(draw(&mut stage, &mut device).is_some());
}

/// Kernels are never made in time.
struct Slow;

impl Workbench for Slow {
    fn are_ready(&self, _: &[Kernel]) -> bool {
        false
    }

    fn texture_maker(&self) -> Box<dyn FnMut(&TextureOrder) -> bool + Send> {
        Box::new(|_| false)
    }
}

#[test]
fn the_world_before_goes_on_while_another_is_prepared() {
    let (mut stage, mut device) = (Stage::new(limits()), Device::default());
    let first = scene(0.5);
    update(&mut stage, &mut device, &first, 1, true);
    draw(&mut stage, &mut device);
    assert!(stage.update(WORLD, &scene(0.7), 2, false, &Slow).unwrap().is_none());
    assert_eq!(stage.world_state(WORLD), WorldState::Before);
    assert!(draw(&mut stage, &mut device).is_some());
    let progress = stage.view_progress(VIEW, WORLD).unwrap();
    assert_eq!((progress.live.samples, progress.is_converged), (0, false));
    assert_eq!(stage.stalls(), [0, 1]);
    // Back again before the kernels are made.
    update(&mut stage, &mut device, &first, 1, false);
    assert_eq!(stage.world_state(WORLD), WorldState::Done);
}

/// Notes the kernels that it is asked for.
#[derive(Default)]
struct Noting(std::cell::RefCell<Vec<Kernel>>);

impl Workbench for Noting {
    fn are_ready(&self, kernels: &[Kernel]) -> bool {
        self.0.replace(kernels.to_vec());
        true
    }

    fn texture_maker(&self) -> Box<dyn FnMut(&TextureOrder) -> bool + Send> {
        Box::new(|_| false)
    }
}

#[test]
fn a_world_whose_views_keep_guides_waits_for_their_kernel() {
    let (mut stage, mut device) = (Stage::new(limits()), Device::default());
    update(&mut stage, &mut device, &scene(0.5), 1, true);
    let has_guides = |kernel: &Kernel| matches!(kernel, Kernel::PathTrace(variant) if variant.guides);
    let workbench = Noting::default();
    for guides in [false, true] {
        let frame: fn(Lent) -> ViewFrame = match guides {
            false => frame,
            true => |lent| {
                let frame = frame(lent);
                ViewFrame { settings: LiveSettings { guides: true, ..frame.settings }, ..frame }
            },
        };
        let ViewRecorded { recorded, lent, .. } = record(&mut stage, frame).unwrap();
        device.0.extend(lent.ids());
        device.replay(&recorded.recording);
        stage.executed(recorded, Ok(())).unwrap();
        assert_eq!(stage.image(VIEW, LiveImage::Normal).is_some(), guides);
        let version = 2 + u64::from(guides);
        let recorded = stage.update(WORLD, &scene(0.7), version, false, &workbench).unwrap();
        assert_eq!(workbench.0.borrow().iter().any(has_guides), guides);
        if let Some(recorded) = recorded {
            device.replay(&recorded.recording);
            stage.executed(recorded, Ok(())).unwrap();
        }
    }
}

/// What is made of kernels at once, but for those that light is kept with.
struct LacksLight(std::cell::Cell<bool>);

impl Workbench for LacksLight {
    fn are_ready(&self, kernels: &[Kernel]) -> bool {
        !self.0.get() || !kernels.contains(&Kernel::LightResolve)
    }

    fn texture_maker(&self) -> Box<dyn FnMut(&TextureOrder) -> bool + Send> {
        Box::new(|_| false)
    }
}

fn show_with(stage: &mut Stage<u64, u64>, device: &mut Device, version: u64, workbench: &impl Workbench) {
    // The light around is a little brighter each time: every frame shows something new.
    let scene = Scene { environment: Environment::uniform(version as f64), ..scene(0.5) };
    stage.begin_frame(version);
    if let Some(recorded) = stage.update(WORLD, &scene, version, false, workbench).unwrap() {
        device.replay(&recorded.recording);
        stage.executed(recorded, Ok(())).unwrap();
    }
}

#[test]
fn light_is_kept_once_its_kernels_are_made_and_nothing_waits_for_them() {
    let (mut stage, mut device) = (Stage::new(limits()), Device::default());
    let workbench = LacksLight(std::cell::Cell::new(true));
    let bytes = |stage: &Stage<u64, u64>| stage.view_progress(VIEW, WORLD).unwrap().live.light_bytes;
    stage.expect(WORLD, ViewKind::Live { guides: false, kept_light: true });
    let mut version = 0;
    let mut show = |stage: &mut Stage<u64, u64>, device: &mut Device| {
        version += 1;
        show_with(stage, device, version, &workbench);
        draw(stage, device)
    };
    for _ in 0..1000 {
        if show(&mut stage, &mut device).is_some() {
            break;
        }
        sleep(Duration::from_millis(2));
    }
    assert_eq!(bytes(&stage), 0, "its kernels are not made");
    assert_eq!(stage.stalls()[1], 0);
    workbench.0.set(false);
    show(&mut stage, &mut device);
    assert!(bytes(&stage) > 0);
    // From then on a scene waits for all that it takes: light that is known is not forgotten for a moment.
    workbench.0.set(true);
    show(&mut stage, &mut device);
    assert_eq!((stage.stalls()[1], bytes(&stage) > 0), (1, true));
}

#[test]
fn where_the_device_refuses_light_a_view_goes_on_without() {
    for refusal in [Refusal::Memory("full".to_owned()), Refusal::Other("no such kernel".to_owned())] {
        let (mut stage, mut device) = (Stage::new(limits()), Device::default());
        stage.expect(WORLD, ViewKind::Live { guides: false, kept_light: true });
        update(&mut stage, &mut device, &scene(0.5), 1, true);
        let refused = record(&mut stage, frame).unwrap();
        assert!(refused.status.light_bytes > 0 && stage.store().light_bytes() > 0);
        assert_eq!(stage.executed(refused.recorded, Err(refusal.clone())), Ok(()));
        assert_eq!(stage.store().light_bytes(), 0);
        let (status, _) = draw(&mut stage, &mut device).expect("the world is there");
        assert_eq!(status.light_bytes, 0, "{refusal:?}");
        // Without light it is an error.
        let refused = record(&mut stage, frame).unwrap().recorded;
        assert!(stage.executed(refused, Err(refusal)).is_err());
    }
}

#[test]
fn light_gives_way_to_voxels_that_the_device_has_no_room_for() {
    const OTHER: u64 = WORLD + 1;
    let (mut stage, mut device) = (Stage::new(limits()), Device::default());
    let shown = scene(0.5);
    stage.expect(WORLD, ViewKind::Live { guides: false, kept_light: true });
    update(&mut stage, &mut device, &shown, 1, true);
    draw(&mut stage, &mut device);
    assert!(stage.store().light_bytes() > 0);
    let other = scene(0.7);
    let refused = stage.update(OTHER, &other, 2, true, &NothingAhead).unwrap().expect("voxels");
    assert_eq!(stage.executed(refused, Err(Refusal::Memory("full".to_owned()))), Ok(()));
    assert_eq!(stage.store().light_bytes(), 0);
    // Whole.
    let recorded = stage.update(OTHER, &other, 2, true, &NothingAhead).unwrap().expect("voxels");
    stage.executed(recorded, Ok(())).unwrap();
    assert_eq!(stage.store().resolution(&other.volumes[0].volume).map(|it| it.factor), Some(1));
}

#[test]
fn only_a_world_that_may_stand_in_is_shown_in_the_place_of_another() {
    const NEXT: u64 = 8;
    let (mut stage, mut device) = (Stage::new(limits()), Device::default());
    update(&mut stage, &mut device, &scene(0.5), 1, true);
    draw(&mut stage, &mut device);
    assert!(stage.shown(VIEW, NEXT, |before| *before != WORLD).is_none());
    let before = stage.shown(VIEW, NEXT, |before| *before == WORLD).expect("the world before may be shown");
    let ViewRecorded { recorded, .. } = stage.record_view(VIEW, before, frame).unwrap();
    device.replay(&recorded.recording);
    stage.executed(recorded, Ok(())).unwrap();
    assert_eq!(stage.view_progress(VIEW, NEXT).unwrap().live.samples, 0);
    assert!(!stage.wants_sweep());
    // Once the next is there, the view leaves the one before.
    let recorded = stage.update(NEXT, &scene(0.7), 2, true, &NothingAhead).unwrap().unwrap();
    device.replay(&recorded.recording);
    stage.executed(recorded, Ok(())).unwrap();
    assert!(stage.holds(NEXT, 2) && !stage.holds(NEXT, 1));
    let next = stage.shown(VIEW, NEXT, |_| false).expect("it is there");
    let ViewRecorded { recorded, status, .. } = stage.record_view(VIEW, next, frame).unwrap();
    let makes = |step: &Step| matches!(step, Step::CreateBuffer { .. } | Step::CreateTexture { .. });
    assert!(!recorded.recording.steps.iter().any(makes), "it has its films");
    assert!(status.pixel_samples > 0, "what is in them counts for nothing");
    device.replay(&recorded.recording);
    stage.executed(recorded, Ok(())).unwrap();
    assert!(stage.wants_sweep());
    let swept =
        stage.sweep(|view| *view == VIEW, |world| *world == NEXT).expect("nobody shows the world before");
    device.replay(&swept.recording);
    stage.executed(swept, Ok(())).unwrap();
    assert!(!stage.wants_sweep());
    assert_eq!(stage.world_state(WORLD), WorldState::Nothing);
    assert!(stage.record_view(VIEW, before, frame).is_err(), "it is gone by now");
}

#[test]
fn what_an_error_leaves_can_be_had_at_once() {
    let (mut stage, mut device) = (Stage::new(limits()), Device::default());
    update(&mut stage, &mut device, &scene(0.5), 1, true);
    draw(&mut stage, &mut device);
    let films = device.0.len();
    assert!(stage.left_over().is_none());
    let refused = record(&mut stage, frame).unwrap().recorded;
    assert!(stage.executed(refused, Err(Refusal::Other("no".to_owned()))).is_err());
    let rest = stage.left_over().expect("the view's films");
    device.replay(&rest.recording);
    stage.executed(rest, Ok(())).unwrap();
    assert!(device.0.len() < films);
    assert!(stage.left_over().is_none());
}

#[test]
fn a_view_that_the_device_refuses_starts_over() {
    let (mut stage, mut device) = (Stage::new(limits()), Device::default());
    update(&mut stage, &mut device, &scene(0.5), 1, true);
    let refused = record(&mut stage, frame).unwrap().recorded;
    let why = Refusal::Other("no".to_owned());
    assert_eq!(stage.executed(refused, Err(why.clone())), Err(StageError::Refused(why)));
    assert!(stage.view_progress(VIEW, WORLD).is_none());
    assert!(draw(&mut stage, &mut device).is_some());
}

#[test]
fn what_a_refusal_takes_from_another_world_is_made_anew_before_it_is_drawn() {
    const OTHER: u64 = WORLD + 1;
    let (mut stage, mut device) = (Stage::new(limits()), Device::default());
    let shown = scene(0.5);
    update(&mut stage, &mut device, &shown, 1, true);
    assert!(draw(&mut stage, &mut device).is_some());
    // The same voxels with value ranges of its own.
    let mut other = shown.clone();
    other.volumes[0].medium.filter = Filter::Tricubic;
    let refused = stage.update(OTHER, &other, 2, true, &NothingAhead).unwrap().expect("value ranges");
    assert!(stage.executed(refused, Err(Refusal::Other("no".to_owned()))).is_err());
    assert!(stage.shown(VIEW, WORLD, |_| true).is_none(), "its bricks are given to others");
    update(&mut stage, &mut device, &shown, 1, true);
    assert!(draw(&mut stage, &mut device).is_some());
}

#[test]
fn read_backs_reach_the_view_that_asked_and_no_other() {
    let (mut stage, mut device) = (Stage::new(limits()), Device::default());
    update(&mut stage, &mut device, &scene(0.5), 1, true);
    let with_depth: fn(Lent) -> ViewFrame = |lent| {
        let mut frame = frame(lent);
        frame.host.depth = Some(crate::live::HostDepth {
            texture: lent.depth,
            view_depth_from_ndc: [0.0, 1.0, 1.0, 0.0],
            clear: 0.0,
            jittered: false,
        });
        frame
    };
    let ViewRecorded { recorded, lent, .. } = record(&mut stage, with_depth).unwrap();
    device.0.extend(lent.ids());
    device.replay(&recorded.recording);
    let ticket = recorded.ticket();
    stage.executed(recorded, Ok(())).unwrap();
    assert!(stage.view_progress(VIEW, WORLD).unwrap().live.awaits_feedback);
    stage.feedback(ticket + 1, &[0; 4]);
    assert!(stage.view_progress(VIEW, WORLD).unwrap().live.awaits_feedback);
    stage.feedback(ticket, &[0; 4]);
    assert!(!stage.view_progress(VIEW, WORLD).unwrap().live.awaits_feedback);
}
