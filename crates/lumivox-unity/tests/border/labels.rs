//! Label maps, their looks, clip shapes, and functions of value and gradient.

use super::*;

/// Half of a cube, as large as the phantom, is `bone`; `shift` millimetres further.
fn halves(shift: f64) -> *mut LumivoxVolume {
    let place = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, shift - 7.5, -7.5, -7.5];
    let voxels: Vec<u8> = (0..4096).map(|i| if i % 16 < 8 { 0 } else { 7 }).collect();
    let label = LumivoxLabel { value: 7, color: [1.0, 0.5, 0.25], milliliters: 0.0 };
    // SAFETY: all of it is there.
    let map = unsafe {
        let names = [c"bone".as_ptr()];
        lumivox_labels_new([16; 3].as_ptr(), voxels.as_ptr(), 4096, place.as_ptr(), &label, names.as_ptr(), 1)
    };
    assert!(!map.is_null(), "{}", last_error());
    map
}

fn style(value: u32) -> LumivoxLabelStyle {
    LumivoxLabelStyle {
        value,
        visible: 1,
        painted: 0,
        clipped: 1,
        color: [1.0; 3],
        opacity: 1.0,
        density: -1.0,
        has_surface: 0,
        surface: SURFACE,
        transfer_function: null(),
    }
}

#[test]
fn labels_and_clip_shapes_reach_the_kernels() {
    let (stage, volume, map) = (stage(), cube(), halves(0.0));
    // SAFETY: all handles are live, and freed once.
    unsafe {
        assert_eq!((lumivox_labels_count(map), lumivox_labels_count(volume)), (1, -1));
        let mut label = LumivoxLabel { value: 0, color: [0.0; 3], milliliters: 0.0 };
        assert_eq!(lumivox_labels_list(map, &mut label, 1), 0, "{}", last_error());
        assert_eq!(label, LumivoxLabel { value: 7, color: [1.0, 0.5, 0.25], milliliters: 2.048 });
        assert_eq!(take_text(lumivox_labels_name(map, 0)), "bone");
        let far = halves(5000.0);
        assert_eq!(lumivox_labels_share_in(map, volume), 1.0);
        assert_eq!(lumivox_labels_share_in(far, volume), 0.0);
        lumivox_volume_free(far);
        assert!(lumivox_labelling_new(volume, null(), 0).is_null());
        assert_eq!(last_error(), "it is a scan and no label map");
        let painted = LumivoxLabelStyle { painted: 1, has_surface: 1, ..style(7) };
        let styles = [LumivoxLabelStyle { visible: 0, ..style(0) }, painted, style(900)];
        let labelling = lumivox_labelling_new(map, styles.as_ptr(), 3);
        assert!(!labelling.is_null(), "{}", last_error());
        lumivox_volume_free(map);
        let clip = |kind| LumivoxClipShape { world_from_shape: IDENTITY, kind, inverted: 1 };
        let clips = [clip(0), clip(1), clip(2)];
        let classes = |instance: LumivoxInstance| {
            let set =
                lumivox_stage_set_world(stage, 5, &instance, 1, clips.as_ptr(), 3, null(), 0, &studio());
            if set < 0 {
                return Err(last_error());
            }
            for _ in 0..2 {
                lumivox_stage_begin_frame(stage);
                let world = lumivox_stage_record_world(stage, 5, 1);
                if !world.is_null() {
                    assert_eq!(lumivox_recording_finish(stage, world, EXECUTED, null()), 0);
                }
            }
            let mut status = LumivoxViewStatus::default();
            let view = lumivox_stage_record_view(stage, 8, 5, &frame(), &mut status);
            assert!(!view.is_null(), "{}", last_error());
            let mut count = 0;
            let steps = lumivox_recording_steps(view, &mut count);
            let steps = std::slice::from_raw_parts(steps, count as usize);
            let dispatches = steps.iter().filter(|step| step.kind == LumivoxStepKind::Dispatch);
            let names: Vec<String> = dispatches.map(|step| text(lumivox_kernel_name(step.kernel))).collect();
            lumivox_recording_finish(stage, view, EXECUTED, null());
            let traced: Vec<&String> = names.iter().filter(|name| name.starts_with("path_trace")).collect();
            assert!(!traced.is_empty(), "{names:?}");
            Ok(traced.iter().all(|name| name.contains("_classes")))
        };
        let plain = instance(volume);
        assert_eq!(classes(plain), Ok(false));
        assert_eq!(classes(LumivoxInstance { clip_count: 3, ..plain }), Ok(true));
        assert_eq!(classes(LumivoxInstance { labelling, ..plain }), Ok(true));
        assert_eq!(classes(plain), Ok(false));
        let beyond = LumivoxInstance { first_clip: 2, clip_count: 2, ..plain };
        assert_eq!(classes(beyond), Err("an instance names clip shapes that are not there".to_owned()));
        let overflow = LumivoxInstance { first_clip: u32::MAX, clip_count: u32::MAX, ..plain };
        assert!(classes(overflow).is_err());
        lumivox_labelling_free(labelling);
        lumivox_volume_free(volume);
        lumivox_stage_free(stage);
    }
}

#[test]
fn labels_are_stored_found_and_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| CString::new(folder.path().join(name).to_str().unwrap()).unwrap();
    let (stored, nrrd) = (path("a.lumivox"), path("a.nrrd"));
    let header = "NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: 4 4 4\n\
                  space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\nencoding: raw\n\n";
    let voxels = (0..64u8).map(|i| i / 16);
    std::fs::write(nrrd.to_str().unwrap(), header.bytes().chain(voxels).collect::<Vec<_>>()).unwrap();
    // SAFETY: all handles are live, and freed once.
    unsafe {
        let map = halves(0.0);
        let done = |job: *mut LumivoxJob| {
            let state = wait(job);
            let made = (state, lumivox_job_take_volume(job), take_text(lumivox_job_error(job)));
            lumivox_job_free(job);
            made
        };
        assert_eq!(done(lumivox_volume_save(map, stored.as_ptr())).0, LumivoxJobState::Done);
        let (_, again, error) = done(lumivox_volume_open(stored.as_ptr()));
        assert!(!again.is_null(), "{error}");
        assert_eq!(take_text(lumivox_labels_name(again, 0)), "bone");
        lumivox_volume_free(again);
        lumivox_volume_free(map);

        let read = |labels, file: &CStr| {
            let options = LumivoxImportOptions { labels, ..import_options() };
            let (_, volume, error) = done(lumivox_import_load([file.as_ptr()].as_ptr(), 1, &options, null()));
            if volume.is_null() {
                return Err(error);
            }
            let count = lumivox_labels_count(volume);
            lumivox_volume_free(volume);
            Ok(count)
        };
        assert_eq!([0, 1, 2].map(|labels| read(labels, &nrrd)), [Ok(-1), Ok(3), Ok(3)]);
        assert!(read(1, &path("no.nrrd")).unwrap_err().contains("no.nrrd"));

        let torso = super::parts::imported(super::torso(), 1);
        let (_, found, error) = done(lumivox_labels_find(torso));
        assert!(!found.is_null(), "{error}");
        assert!(take_text(lumivox_volume_report(found)).contains("confidence"));
        let names: Vec<String> = (0..lumivox_labels_count(found) as u32)
            .map(|i| take_text(lumivox_labels_name(found, i)))
            .collect();
        assert!(names.contains(&"body".to_owned()), "{names:?}");
        lumivox_volume_free(found);
        assert_eq!(lumivox_volume_skin(torso), 0);
        assert_eq!(done(lumivox_skin_find(torso)).0, LumivoxJobState::Done);
        assert_eq!(lumivox_volume_skin(torso), 1);
        let stopped = lumivox_labels_find(torso);
        lumivox_job_cancel(stopped);
        assert_eq!(done(stopped).0, LumivoxJobState::Cancelled);
        lumivox_volume_free(torso);
        let cube = cube();
        assert_eq!(done(lumivox_skin_find(cube)).0, LumivoxJobState::Done);
        assert_eq!(lumivox_volume_skin(cube), 2, "a cube has no skin");
        lumivox_volume_free(cube);
    }
}

#[test]
fn rows_for_gradients_are_kept_and_follow_the_window() {
    let folder = tempfile::tempdir().unwrap();
    let file = CString::new(folder.path().join("a.json").to_str().unwrap()).unwrap();
    let knot = |value, opacity| LumivoxOpacityKnot { value, opacity, ease: 0, padding: 0 };
    let (knots, row) = ([knot(0.0, 0.0), knot(100.0, 1.0)], [knot(0.0, 1.0), knot(50.0, 0.0)]);
    // SAFETY: all handles are live, and freed once.
    unsafe {
        // About 50, twice as wide, and 10 further: what was at 0 is at -40, what was at 50 at 60.
        let function = lumivox_transfer_function_new(knots.as_ptr(), 2, null(), 0, 10.0, 2.0);
        let add =
            |per_mm| lumivox_transfer_function_add_gradient(function, per_mm, row.as_ptr(), 2, null(), 0);
        assert_eq!((add(120.0), add(f64::NAN), add(-1.0)), (0, -1, -1));
        assert!(last_error().contains("above 0"), "{}", last_error());
        assert_eq!(lumivox_transfer_function_save(function, file.as_ptr()), 0, "{}", last_error());
        let again = lumivox_transfer_function_load(file.as_ptr());
        assert!(!again.is_null(), "{}", last_error());
        for function in [function, again] {
            assert_eq!(lumivox_transfer_function_gradient_count(function), 1);
            let mut per_mm = 0.0;
            let row = lumivox_transfer_function_gradient(function, 0, &mut per_mm);
            assert_eq!(per_mm, 120.0);
            let mut points = [knot(0.0, 0.0); 2];
            assert_eq!(lumivox_transfer_function_knots(row, points.as_mut_ptr(), 2), 2);
            assert_eq!(points.map(|point| (point.value, point.opacity)), [(-40.0, 1.0), (60.0, 0.0)]);
            assert!(lumivox_transfer_function_gradient(function, 1, &mut per_mm).is_null());
            lumivox_transfer_function_free(row);
            lumivox_transfer_function_free(function);
        }
    }
}
