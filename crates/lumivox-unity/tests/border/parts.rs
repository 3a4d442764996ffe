//! What of a scan is seen in place of the patient.

use super::*;
use lumivox_core::Organ;

/// A torso on a table, as the importer gives it: with what it has put aside, or with everything.
pub fn imported(folder: &Path, keep_everything: u32) -> *mut LumivoxVolume {
    let path = CString::new(folder.to_str().unwrap()).unwrap();
    let paths = [path.as_ptr()];
    let options = LumivoxImportOptions { keep_everything, ..import_options() };
    // SAFETY: all handles are live, and freed once.
    unsafe {
        let job = lumivox_import_load(paths.as_ptr(), 1, &options, null());
        assert_eq!(wait(job), LumivoxJobState::Done);
        let volume = lumivox_job_take_volume(job);
        lumivox_job_free(job);
        assert!(!volume.is_null());
        volume
    }
}

fn info(volume: *const LumivoxVolume) -> LumivoxVolumeInfo {
    let mut info = std::mem::MaybeUninit::<LumivoxVolumeInfo>::zeroed();
    // SAFETY: a live handle; numbers may be zeros.
    unsafe {
        assert_eq!(lumivox_volume_info(volume, info.as_mut_ptr()), 0, "{}", last_error());
        info.assume_init()
    }
}

fn counts(volume: *const LumivoxVolume) -> [f32; 256] {
    let mut counts = [0f32; 256];
    // SAFETY: a live handle, and room for so many.
    assert_eq!(unsafe { lumivox_volume_histogram(volume, -1024.0, 3071.0, 256, counts.as_mut_ptr()) }, 0);
    counts
}

/// A part of a scan; null where there is none.
fn part(volume: *const LumivoxVolume, number: u32) -> *mut LumivoxVolume {
    // SAFETY: all handles are live, and freed once.
    unsafe {
        let job = lumivox_part_find(volume, number);
        assert_eq!(wait(job), LumivoxJobState::Done);
        let found = lumivox_job_take_volume(job);
        assert!(last_error().is_empty(), "{}", last_error());
        lumivox_job_free(job);
        found
    }
}

#[test]
fn what_was_put_aside_comes_back_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let (alone, all) = (imported(torso(), 0), imported(torso(), 1));
    assert_eq!((info(alone).has_surroundings, info(all).has_surroundings), (1, 0));
    assert!(part(all, 1).is_null(), "there is nothing to put back");
    // SAFETY: all handles are live, and freed once.
    unsafe {
        assert!(lumivox_part_find(alone, 0).is_null() && lumivox_part_find(alone, 4).is_null());
        assert_eq!(last_error(), "a scan has the parts 1 to 3, not 4");
        let whole = part(alone, 1);
        assert!(counts(alone) != counts(all));
        assert_eq!(counts(whole), counts(all));
        // Stored and opened, the scan has them still.
        let file = CString::new(folder.path().join("a.lumivox").to_str().unwrap()).unwrap();
        let saved = lumivox_volume_save(alone, file.as_ptr());
        assert_eq!(wait(saved), LumivoxJobState::Done);
        lumivox_job_free(saved);
        let opened = lumivox_volume_open(file.as_ptr());
        assert_eq!(wait(opened), LumivoxJobState::Done);
        let again = lumivox_job_take_volume(opened);
        lumivox_job_free(opened);
        assert_eq!(info(again).has_surroundings, 1);
        let whole_again = part(again, 1);
        assert_eq!(counts(whole_again), counts(all));
        // A world shows the part in place of the scan, and goes on without its handle.
        let (stage, environment) = (stage(), studio());
        lumivox_stage_begin_frame(stage);
        let shown = LumivoxInstance { part: whole, ..instance(alone) };
        assert_eq!(
            lumivox_stage_set_world(stage, 1, &shown, 1, null(), 0, null(), 0, &environment),
            0,
            "{}",
            last_error()
        );
        let world = lumivox_stage_record_world(stage, 1, 1);
        assert!(!world.is_null(), "{}", last_error());
        assert_eq!(lumivox_recording_finish(stage, world, EXECUTED, null()), 0);
        let factor = |volume| {
            let (mut factor, mut arriving) = (9, 9);
            assert_eq!(lumivox_volume_resolution(stage, volume, &mut factor, &mut arriving), 0);
            factor
        };
        assert_eq!((factor(whole), factor(alone)), (1, 0));
        [alone, all, whole, again, whole_again].into_iter().for_each(|handle| lumivox_volume_free(handle));
        lumivox_stage_free(stage);
    }
}

#[test]
fn organs_that_presets_are_for_are_found_or_not_there() {
    let numbers = |names: [&CStr; 4]| {
        names.map(|name| {
            // SAFETY: a string.
            unsafe { lumivox_preset_part(name.as_ptr()) }
        })
    };
    assert_eq!(numbers([c"ct-airways", c"ct-lung-vessels", c"ct-bone", c"ct-nothing"]), [2, 3, 0, 0]);
    let (silent, never) = (Progress::SILENT, CancelToken::new());
    let scan =
        lumivox_import::load(&[torso().to_owned()], &Default::default(), silent, &never).unwrap().volume;
    let vessels = lumivox_segmentation::find_organ(&scan, Organ::LungVessels, silent, &never).unwrap();
    let histogram = lumivox_core::Histogram::new(&vessels.unwrap()).counts(256, [-1024.0, 3071.0]);
    let torso = imported(torso(), 1);
    let found = part(torso, 3);
    assert!(!found.is_null());
    assert_eq!(counts(found)[..], histogram[..]);
    assert!(counts(found) != counts(torso));
    let cube = cube();
    assert!(part(cube, 2).is_null() && part(cube, 3).is_null(), "a cube has no lungs");
    // SAFETY: live handles, freed once.
    unsafe {
        [torso, found, cube].into_iter().for_each(|handle| lumivox_volume_free(handle));
    }
}
