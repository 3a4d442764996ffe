//! Builds with and without codecs: `cargo test -p lumivox-import --no-default-features --test codecs` is one without.

#[allow(dead_code, reason = "not every test program uses all of it")]
#[path = "common/writer.rs"]
mod writer;

use lumivox_core::{CancelToken, Progress};
use lumivox_import::{ImportError, ImportOptions};
use writer::*;

#[test]
fn a_file_whose_codec_is_left_out_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    for (syntax, codec, feature, is_here) in [
        (Syntax::JpegSpectral, "JPEG", "jpeg", cfg!(feature = "jpeg")),
        (Syntax::JpegLs, "JPEG-LS", "jpeg-ls", cfg!(feature = "jpeg-ls")),
        (Syntax::Jpeg2000, "JPEG 2000", "jpeg-2000", cfg!(feature = "jpeg-2000")),
        (Syntax::JpegXl, "JPEG XL", "jpeg-xl", cfg!(feature = "jpeg-xl")),
    ] {
        let path = folder.path().join(codec);
        let mut image = image("MR", 4, 1, vec![]);
        image.set(PIXEL_DATA, "OB", Value::Fragments(vec![b"no codestream".to_vec()]));
        image.write(&path, syntax);
        let options = ImportOptions::default();
        let error =
            lumivox_import::load(&[path], &options, Progress::SILENT, &CancelToken::new()).unwrap_err();
        let said = error.to_string();
        assert!(said.contains(codec) && !said.contains("SECRET"), "{said}");
        if is_here {
            assert!(matches!(error, ImportError::Damaged { .. }), "{codec}: {error:?}");
        } else {
            assert!(matches!(error, ImportError::Unsupported { .. }), "{codec}: {error:?}");
            assert!(said.contains(&format!("compressed as {codec}, which this build")), "{said}");
            assert!(said.contains(&format!("the feature '{feature}' of lumivox-import")), "{said}");
        }
    }
}
