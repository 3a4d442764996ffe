//! Any bytes behind the preamble and prefix of a DICOM file, so that no time is lost on finding them.
#![no_main]

mod read;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let mut file = vec![0; 128];
    file.extend(b"DICM");
    file.extend(bytes.strip_prefix(&file[..]).unwrap_or(bytes));
    read::read(&file);
});
