//! All jobs end before the library may be unloaded. A program of its own: it stops the jobs of other tests, too.

use lumivox_unity::*;

#[test]
fn jobs_that_nobody_holds_any_more_end_before_the_library() {
    // SAFETY: a string; a live handle, freed once.
    unsafe { lumivox_job_free(lumivox_phantom_start(c"head".as_ptr(), 256)) };
    // SAFETY: a string.
    let job = unsafe { lumivox_phantom_start(c"head".as_ptr(), 256) };
    assert!(!job.is_null());
    assert!(lumivox_jobs_running() > 0);
    lumivox_jobs_stop_all();
    assert_eq!(lumivox_jobs_running(), 0);
    // SAFETY: a live handle, freed once.
    unsafe {
        assert_eq!(
            lumivox_job_poll(job, std::ptr::null_mut()),
            lumivox_unity::abi::LumivoxJobState::Cancelled
        );
        lumivox_job_free(job);
    }
}
