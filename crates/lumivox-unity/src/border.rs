//! What every function of the border does: errors as text, no panic beyond it, strings.

use std::any::Any;
use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;

thread_local! {
    static LAST_ERROR: RefCell<CString> = RefCell::default();
}

/// What a function says in place of a result.
pub type Outcome<T> = Result<T, String>;

/// Keeps what went wrong for `lumivox_last_error`.
fn remember(message: String) {
    // A message ends at its first 0.
    let message = CString::new(message.replace('\0', " ")).unwrap_or_default();
    LAST_ERROR.with_borrow_mut(|last| *last = message);
}

/// Runs what a function does. Before, nothing is wrong; after an error or a panic, that is.
pub fn guard<T>(work: impl FnOnce() -> Outcome<T>) -> Option<T> {
    remember(String::new());
    // What a panic leaves half done is the caller's to free; nothing else looks at it.
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(result)) => Some(result),
        Ok(Err(message)) => {
            remember(message);
            None
        }
        Err(panic) => {
            remember(format!("a fault in Lumivox: {}", panic_message(&*panic)));
            None
        }
    }
}

/// As [`guard`], for functions that give a number: 0, or -1.
pub fn guard_status(work: impl FnOnce() -> Outcome<()>) -> i32 {
    if guard(work).is_some() { 0 } else { -1 }
}

/// As [`guard`], for functions that give a handle.
pub fn guard_handle<T>(work: impl FnOnce() -> Outcome<T>) -> *mut T {
    guard(work).map_or(std::ptr::null_mut(), |made| Box::into_raw(Box::new(made)))
}

/// As [`guard_handle`], where there may be nothing and nothing wrong.
pub fn guard_option<T>(work: impl FnOnce() -> Outcome<Option<T>>) -> *mut T {
    guard(work).flatten().map_or(std::ptr::null_mut(), |made| Box::into_raw(Box::new(made)))
}

/// As [`guard`], for functions that say nothing of errors: what went wrong before stays known. `otherwise` comes of a panic.
pub fn guard_quietly<T>(otherwise: T, work: impl FnOnce() -> T) -> T {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or(otherwise)
}

/// What a panic said.
pub fn panic_message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "it stopped".to_owned())
}

/// Frees a handle.
///
/// # Safety
/// `handle` is null, or came from this library as a handle of this type and was not freed.
pub unsafe fn free<T>(handle: *mut T) {
    if !handle.is_null() {
        // SAFETY: as the caller promises.
        let owned = unsafe { Box::from_raw(handle) };
        let _ = catch_unwind(AssertUnwindSafe(|| drop(owned)));
    }
}

/// What a handle stands for.
///
/// # Safety
/// `handle` is null, or a live handle of this type.
pub unsafe fn known<'a, T>(handle: *const T, what: &str) -> Outcome<&'a T> {
    // SAFETY: as the caller promises.
    unsafe { handle.as_ref() }.ok_or_else(|| format!("there is no {what}: it is null"))
}

/// As [`known`], to change it.
///
/// # Safety
/// As [`known`], and nobody else uses it meanwhile.
pub unsafe fn known_mut<'a, T>(handle: *mut T, what: &str) -> Outcome<&'a mut T> {
    // SAFETY: as the caller promises.
    unsafe { handle.as_mut() }.ok_or_else(|| format!("there is no {what}: it is null"))
}

/// The elements that a pointer and a count stand for.
///
/// # Safety
/// `data` points to `count` elements, or `count` is 0.
pub unsafe fn list<'a, T>(data: *const T, count: usize, what: &str) -> Outcome<&'a [T]> {
    match (count, data.is_null()) {
        (0, _) => Ok(&[]),
        (_, true) => Err(format!("there are no {what}: they are null")),
        // SAFETY: as the caller promises.
        _ => Ok(unsafe { std::slice::from_raw_parts(data, count) }),
    }
}

/// A string, or none where it is null.
///
/// # Safety
/// `text` is null, or ends with 0.
pub unsafe fn text<'a>(text: *const c_char, what: &str) -> Outcome<Option<&'a str>> {
    if text.is_null() {
        return Ok(None);
    }
    // SAFETY: as the caller promises.
    let text = unsafe { CStr::from_ptr(text) };
    text.to_str().map(Some).map_err(|_| format!("{what} is not UTF-8"))
}

/// A string that must be there.
///
/// # Safety
/// As [`text`].
pub unsafe fn needed_text<'a>(handle: *const c_char, what: &str) -> Outcome<&'a str> {
    // SAFETY: as the caller promises.
    unsafe { text(handle, what) }?.ok_or_else(|| format!("there is no {what}: it is null"))
}

/// A path that must be there.
///
/// # Safety
/// As [`text`].
pub unsafe fn path(handle: *const c_char, what: &str) -> Outcome<PathBuf> {
    // SAFETY: as the caller promises.
    match unsafe { needed_text(handle, what) }? {
        "" => Err(format!("there is no {what}: it is empty")),
        path => Ok(PathBuf::from(path)),
    }
}

/// Text of the library's, until it is freed.
pub struct LumivoxText(CString);

impl LumivoxText {
    pub(crate) fn new(text: &str) -> Self {
        Self(CString::new(text.replace('\0', " ")).unwrap_or_default())
    }
}

/// The characters of a text, UTF-8, ended by 0; an empty text for null.
///
/// # Safety
/// `text` is null, or a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_text(text: *const LumivoxText) -> *const c_char {
    // SAFETY: as the caller promises.
    guard_quietly(c"".as_ptr(), || unsafe { text.as_ref() }.map_or(c"".as_ptr(), |text| text.0.as_ptr()))
}

/// Frees a text.
///
/// # Safety
/// `text` is null, or a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_text_free(text: *mut LumivoxText) {
    // SAFETY: as the caller promises.
    unsafe { free(text) };
}

/// What went wrong in the last call of this thread, ready to be shown; empty if nothing did. Valid until its next call.
#[unsafe(no_mangle)]
pub extern "C" fn lumivox_last_error() -> *const c_char {
    guard_quietly(c"".as_ptr(), || LAST_ERROR.with_borrow(|last| last.as_ptr()))
}

/// The version of the border, see `LUMIVOX_ABI_VERSION`.
#[unsafe(no_mangle)]
pub extern "C" fn lumivox_abi_version() -> u32 {
    crate::abi::LUMIVOX_ABI_VERSION
}

/// The version of Lumivox.
#[unsafe(no_mangle)]
pub extern "C" fn lumivox_version() -> *const c_char {
    const VERSION: &CStr =
        match CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
            Ok(version) => version,
            Err(_) => panic!("a version holds no 0"),
        };
    VERSION.as_ptr()
}

/// Compares the sizes of the structs of the border, in the order in which the header has them, with those that the caller
/// knows; -1 where they differ.
///
/// # Safety
/// `sizes` points to `count` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lumivox_check_layout(sizes: *const u32, count: u32) -> i32 {
    use crate::abi::*;
    macro_rules! sizes {
        ($($name:ident),*) => { [$((stringify!($name), size_of::<$name>())),*] };
    }
    guard_status(|| {
        let own = sizes!(
            LumivoxVolumeInfo,
            LumivoxOpacityKnot,
            LumivoxColorStop,
            LumivoxSurface,
            LumivoxMedium,
            LumivoxClipShape,
            LumivoxLabel,
            LumivoxLabelStyle,
            LumivoxInstance,
            LumivoxLight,
            LumivoxEnvironment,
            LumivoxPose,
            LumivoxSavedView,
            LumivoxDeviceLimits,
            LumivoxViewFrame,
            LumivoxViewStatus,
            LumivoxSlice,
            LumivoxStep,
            LumivoxProgress,
            LumivoxImportOptions,
            LumivoxPicture
        );
        // SAFETY: as the caller promises.
        let theirs = unsafe { list(sizes, count as usize, "sizes") }?;
        if theirs.len() != own.len() {
            return Err(format!("the package knows {} structs, its library {}", theirs.len(), own.len()));
        }
        for ((name, size), theirs) in own.iter().zip(theirs) {
            if *size != *theirs as usize {
                return Err(format!("{name} has {theirs} bytes in the package and {size} in its library"));
            }
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn last_error() -> String {
        // SAFETY: it is a string of this thread's.
        unsafe { CStr::from_ptr(lumivox_last_error()) }.to_str().unwrap().to_owned()
    }

    #[test]
    fn errors_and_panics_become_text() {
        assert_eq!(guard_status(|| Err("no such file".to_owned())), -1);
        assert_eq!(last_error(), "no such file");
        assert_eq!(guard_status(|| Ok(())), 0);
        assert_eq!(last_error(), "");
        assert!(guard_handle::<u8>(|| panic!("index 3")).is_null());
        assert_eq!(last_error(), "a fault in Lumivox: index 3");
    }

    #[test]
    fn a_package_of_other_structs_is_refused() {
        // SAFETY: two numbers are there.
        assert_eq!(unsafe { lumivox_check_layout([1, 2].as_ptr(), 2) }, -1);
        assert!(last_error().contains("the package knows 2 structs"), "{}", last_error());
    }
}
